"""How right the Griffith limit is on a mesh: spheres and ellipses of all sizes and directions, wherever they stand.

``python tests/benchmarks/adhesive_accuracy.py`` prints the pull-off of JKR's sphere by the radius of its contact in
cells, over its exact value, and that of ellipses at ten cells, over the sphere's and beside the law of least energy.
"""

import numpy as np

from roughxr.kernels.adhesion import cohesive_laws as cohesion
from roughxr.kernels.adhesion import path as adhesive_contact
from roughxr.kernels.asperity.laws import asperity_events, asperity_scales, law

RADIUS = 1000.0
PLACES = [(0.0, 0.0), (0.5, 0.5), (0.0, 0.5), (0.25, 0.25), *np.random.default_rng(1).uniform(0, 0.5, (12, 2))]


def pull_off(cells, place, ratio=1.0, angle=0.0, **tuned):
    """Return the pull-off over JKR's sphere's, at so many cells to the sphere's contact radius.

    ``tuned`` are numbers of `cohesive_laws.griffith` in place of the shipped ones.
    """
    w = 8 * cells**3 / (9 * np.pi * RADIUS**2)
    half = int(1.9 * cells * ratio**0.35) + 5
    x, y = np.meshgrid(np.arange(-half, half + 1) + place[0], np.arange(-half, half + 1) + place[1], indexing="ij")
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    separation = (u**2 / np.sqrt(ratio) + v**2 * np.sqrt(ratio)) / (2 * RADIUS)
    depth = cells**2 / RADIUS
    path = adhesive_contact.follow(
        separation,
        np.array([separation.min() + 0.1 * depth]),
        0.07 * depth,
        cohesion.griffith(w, **tuned),
        w,
        tolerance=1e-7,
        max_iterations=1000,
        max_cells=8000,
    )
    return -path.states[path.turn :, adhesive_contact.FORCE].min() / (1.5 * np.pi * w * RADIUS)


def least_energy(ratio):
    """Return the pull-off of the ellipse of least energy over the sphere's."""
    A, B = 0.5 / (RADIUS * np.sqrt(ratio)), 0.5 * np.sqrt(ratio) / RADIUS
    energy = law("energy")
    scales = asperity_scales(A, B, 1.0, 1.0, energy)
    return -asperity_events(scales, energy).largest_tension.P / (1.5 * np.pi * RADIUS)


def main():
    """Print one line per size, then one per ellipse and direction."""
    for cells in (1.0, 2.5, 4.0, 6.0, 10.0, 16.0):
        found = np.array([pull_off(cells, place) for place in PLACES])
        print(f"sphere, {cells:4g} cells: mean {found.mean():.4f}, {found.min():.4f} … {found.max():.4f}", flush=True)
    sphere = np.mean([pull_off(10.0, place) for place in PLACES])
    for ratio in (2.0, 5.0, 10.0):
        exact = least_energy(ratio)
        for angle in (0.0, 15.0, 30.0, 45.0):
            found = np.array([pull_off(10.0, place, ratio, np.radians(angle)) for place in PLACES]) / sphere
            print(
                f"B/A {ratio:2g} at {angle:2g}°: mean {found.mean():.4f}, {found.min():.4f} … {found.max():.4f}"
                f", by least energy {exact:.4f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
