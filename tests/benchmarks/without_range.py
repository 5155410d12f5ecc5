"""How right the Griffith limit is on a mesh: spheres and ellipses of all sizes and directions, wherever they stand.

``python tests/benchmarks/without_range.py`` prints the pull-off of JKR's sphere by the radius of its contact in cells,
over its exact value: with the steeper edge, with the wider one, and extrapolated; then that of ellipses at ten cells,
over the sphere's and beside the law of least energy.
"""

import numpy as np

from roughxr.contact.cycle import _EDGE, _SHARPER
from roughxr.kernels.adhesion import smooth_laws, smooth_path
from roughxr.kernels.asperity.laws import asperity_events, asperity_scales, law
from roughxr.kernels.halfspace.products import coefficients_for

RADIUS = 1000.0
PLACES = [(0.0, 0.0), (0.5, 0.5), (0.31, 0.17)]


def pull_offs(cells, place, ratio=1.0, angle=0.0):
    """Return the pull-off over JKR's sphere's with both edges, and extrapolated."""
    w = 8 * cells**3 / (9 * np.pi * RADIUS**2)
    half = int(1.9 * cells * ratio**0.35) + 5
    x, y = np.meshgrid(np.arange(-half, half + 1) + place[0], np.arange(-half, half + 1) + place[1], indexing="ij")
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    separation, depth = (u**2 / np.sqrt(ratio) + v**2 * np.sqrt(ratio)) / (2 * RADIUS), cells**2 / RADIUS
    pulls = []
    for part in (1.0, 0.5):
        (path,) = smooth_path.follow_smooth(
            separation,
            np.array([separation.min() + 0.1 * depth]),
            0.07 * depth,
            coefficients_for(separation.shape),
            smooth_laws.without_range(w, _EDGE * part),
            from_contact=True,
        )
        pulls.append(-path.states[path.turn :, smooth_path.FORCE].min() / (1.5 * np.pi * w * RADIUS))
    return np.array([*pulls, pulls[0] + _SHARPER["griffith"] * (pulls[0] - pulls[1])])


def least_energy(ratio):
    """Return the pull-off of the ellipse of least energy over the sphere's."""
    A, B = 0.5 / (RADIUS * np.sqrt(ratio)), 0.5 * np.sqrt(ratio) / RADIUS
    energy = law("energy")
    scales = asperity_scales(A, B, 1.0, 1.0, energy)
    return -asperity_events(scales, energy).largest_tension.P / (1.5 * np.pi * RADIUS)


def main():
    """Print one line per size, then one per ellipse and direction."""
    for cells in (2.5, 5.0, 10.0, 20.0, 40.0):
        for place in PLACES:
            print(f"sphere, {cells:4g} cells, at {place}:", *np.round(pull_offs(cells, place), 4), flush=True)
    sphere = np.mean([pull_offs(10.0, place)[2] for place in PLACES])
    for ratio in (2.0, 5.0, 10.0):
        for angle in (0.0, 20.0, 45.0):
            found = np.array([pull_offs(10.0, place, ratio, np.radians(angle))[2] for place in PLACES]) / sphere
            exact = f"by least energy {least_energy(ratio):.4f}"
            print(f"B/A {ratio:2g} at {angle:2g}°: {found.min():.4f} … {found.max():.4f}, {exact}", flush=True)


if __name__ == "__main__":
    main()
