"""What resisting moments cost, from scan to critical flow, and how exact they are.

    python tests/benchmarks/rolling.py [--repeat 5] [--places 8]

Processor time on one thread, both sides alternating in one process; medians of the ratios. 1. Moments at places of the
glass twin from its catalogue, over their exact pull-offs alone (`pull_off_map`) and over a sweep of 401 displacements
(`superpose`); and how their cost grows with directions and places. 2. What `critical_load`, `resuspension` and its
bootstrap add. 3. The error of the largest moment against closed forms: one JKR asperity, and a ring of many. 4. Moments
from pressures of the adhesive simulation over those of the superposed asperities at the same pull-off, on a few places.
"""

import argparse
import os
import statistics
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import dask
import numpy as np
import xarray as xr

import roughxr
from roughxr import particles
from roughxr.mechanics.particles.force_balance import with_pull_off

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}

#: Largest moments in closed form: of one JKR asperity over P_c a_c, of a ring of many over N P_c ρ.
ONE = 15 / 16 * 1.25 ** (2 / 3)
RING = 0.8770


def spent(function):
    """Return the processor time of one call, s."""
    begun = time.process_time()
    function()
    return time.process_time() - begun


def ratio(other, baseline, repeat):
    """Return the median ratio of the times of two functions called in turn, and the median time of the first."""
    times = [(spent(other), spent(baseline)) for _ in range(repeat + 1)][1:]  # the first compiles
    return statistics.median(a / b for a, b in times), statistics.median(a for a, _ in times)


def against_others(catalogue, places, repeat):
    """Print the cost of moments over that of other answers from the same catalogue."""
    grid = {"subregions": (places, places)}
    sweep = np.linspace(-5, 25, 401)

    def moments(directions=24, subregions=(places, places)):
        return catalogue.contact.rolling(directions=directions, subregions=subregions)

    over_map, seconds = ratio(moments, lambda: catalogue.contact.pull_off_map(**grid), repeat)
    over_sweep, _ = ratio(moments, lambda: catalogue.contact.superpose(delta=sweep, **grid), repeat)
    print(
        f"{places}² places, 24 directions: {1e3 * seconds / places**2:.2f} ms a place, {over_map:.2f} x pull_off_map,"
    )
    print(f"  {over_sweep:.2f} x superpose at 401 displacements")
    for directions in (1, 6, 12, 48):
        more, _ = ratio(lambda n=directions: moments(n), moments, repeat)
        print(f"  {directions:2d} directions: {more:.2f} x the cost of 24")
    half, _ = ratio(lambda: moments(subregions=(places // 2, places // 2)), moments, repeat)
    print(f"  a quarter of the places: {half:.2f} x")
    return moments()


def afterwards(held, repeat):
    """Print what follows from the moments over what they cost at the same places."""
    speeds = np.geomspace(0.1, 100, 40)
    steps = {
        "critical flow": lambda: held.contact.critical_load(),
        "fraction left at 40 speeds, 399 resamples": lambda: held.contact.resuspension(friction_velocity=speeds),
        "parameters of other codes": lambda: particles.parameters(held),
    }
    for label, step in steps.items():
        step()
        took = statistics.median(spent(step) for _ in range(repeat))
        print(f"{label}: {took:.3f} s of {held.sizes['subregion']} places")


def asperities_at(x, y, radius=100.0, sphere=1e9):
    """Return a catalogue of equal spherical asperities under a sphere so flat that its curvature does not count."""
    curvature = np.full(x.size, 1 / radius - 1 / sphere)
    edge = np.ptp(np.r_[x, y]) + 1.0
    values = {"height": np.zeros(x.size), "curvature_min": curvature, "curvature_max": curvature}
    values["orientation"] = np.zeros(x.size)
    scalars = {"sphere_radius": sphere, "contact_modulus": 39.4, "work_of_adhesion": 0.1, "patch_radius": 50.0}
    scalars |= {"datum_height": 0.0, "scan_x_min": -edge, "scan_x_max": edge, "scan_y_min": -edge, "scan_y_max": edge}
    coords = {"x": ("asperity", x), "y": ("asperity", y), **scalars}
    return xr.Dataset({name: ("asperity", array) for name, array in values.items()}, coords)


def accuracy():
    """Print the errors of the largest moment."""
    pull = 1.5 * np.pi * 0.1 * 100.0
    contact = (9 * np.pi * 0.1 * 100.0**2 / (8 * 39.4)) ** (1 / 3)
    centre = {"subregions": ([0.0], [0.0])}
    single = asperities_at(np.zeros(1), np.zeros(1)).contact.rolling(directions=8, **centre)
    print(f"one asperity: off by {float(abs(single.resisting_moment / (ONE * pull * contact) - 1).max()):.1e}")
    for count in (12, 60, 240):
        angle = 2 * np.pi * np.arange(count) / count
        ring = asperities_at(1e5 * np.cos(angle), 1e5 * np.sin(angle))
        moment = float(ring.contact.rolling(directions=[0.0], **centre).resisting_moment[0, 0])
        print(f"{count:3d} asperities on a ring: off by {moment / (RING * count * pull * 1e5) - 1:+.1e}")


def from_pressures(scan):
    """Print moments of the simulation's states over those of superposed asperities with the same pull-off."""
    places = ([1562.5, 2812.5, 3437.5, 937.5], [1562.5, 2187.5, 3437.5, 2187.5])
    pair = scan.contact.assign_pair(sphere_radius=3000, contact_modulus=39.4, work_of_adhesion=0.5)
    deltas = np.arange(-3.0, 3.5, 0.25)
    how = {"law": "exponential", "mesh": 2, "datum": "first_contact"}
    states = pair.contact.adhesive(delta=deltas, fields=True, subregions=places, **how)
    by_pressures = states.contact.rolling()
    superposed = pair.contact.rolling(subregions=places)
    summed = with_pull_off(superposed, states)
    print("moments of the simulation's states over superposed ones at its pull-off, median of directions:")
    ratios = (by_pressures.resisting_moment / summed.resisting_moment).median("direction").values
    for k, ratio_of_place in enumerate(ratios):
        cells = float(by_pressures.contact_area[k]) / (float(scan.x[1] - scan.x[0]) / 2) ** 2
        contacts = int(superposed.contacts[k])
        print(f"  {ratio_of_place:5.2f} where {contacts:2d} asperities are superposed, {cells:.0f} cells touch")


def main():
    """Run all rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--places", type=int, default=8)
    options = parser.parse_args()
    scan = roughxr.open_sample("glass")
    catalogue = roughxr.asperities(scan.contact.assign_pair(**PAIR))
    with dask.config.set(scheduler="synchronous"):
        held = against_others(catalogue, options.places, options.repeat)
        afterwards(held, options.repeat)
        accuracy()
        from_pressures(scan)


if __name__ == "__main__":
    main()
