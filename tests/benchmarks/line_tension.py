"""Show where the numbers of the Griffith limit on a mesh come from, how much hangs on them, and test them elsewhere.

    python tests/benchmarks/line_tension.py [--quick]

Four numbers of ``kernels.adhesion.tuning`` enter the pull-off of every adhesive contact in the Griffith limit (a fifth,
CORE, that of contacts about to merge, and is not looked at here). What each is found from:

SOFTENING          JKR's spheres, by the spread of the pull-off over places on the grid: the slowest fall that still
                   has little spread is too wide for narrow contacts, a faster one spreads more.
LINE, NARROW       JKR's spheres of 2.5 to 16 cells: what pull-off without any line tension has too much, fitted by
                   pull/JKR = 1 + LINE/(radius + NARROW), to first order, so that what is fitted is near what is
                   shipped but not the same; then the error as shipped, and with each a tenth more and less.
LENGTHENING_POWER  JKR's ellipses (branches of least energy, B/A from 1.5 to 10): ln(dL/dA r) over ln(L/L₀).

Then the error where they were not found: spheres of other sizes, and ellipses at angles to the grid, against the
branch of least energy. The first three are fields of the law that the kernels are given, so that nothing is compiled
anew. ``--quick`` takes fewer places and sizes.
"""

import argparse

import numpy as np

FOUND_ON = (2.5, 4.0, 6.0, 10.0, 16.0)
NOT_FOUND_ON = (1.5, 3.2, 8.0, 13.0)
RATIOS, ANGLES = (2.0, 5.0, 10.0), (0.0, 20.0, 45.0)


def pull_offs(cells, places, ratio=1.0, angle=0.0, **tuned):
    """Return pull-offs over JKR's sphere's at several places on the grid."""
    from adhesive_accuracy import PLACES, pull_off

    return np.array([pull_off(cells, place, ratio, np.radians(angle), **tuned) for place in PLACES[:places]])


def measured(sizes, places, **tuned):
    """Return (size, place) pull-offs with some of the law's numbers changed."""
    return np.array([pull_offs(cells, places, **tuned) for cells in sizes])


def softening(sizes, places):
    """Print mean and spread of the pull-off by how fast the traction falls; without line tension."""
    print("SOFTENING: spread over places (largest − least), and mean, of the pull-off without line tension")
    for value in (0.58, 0.45, 0.3, 0.2):
        found = measured(sizes, places, softening=value, line=0.0)
        words = ", ".join(f"{n:g} cells {np.ptp(row):.4f} ({row.mean():.4f})" for n, row in zip(sizes, found))
        print(f"  {value:4.2f}: {words}", flush=True)


def line_and_narrow(sizes, places):
    """Fit both to pull-offs without line tension, to first order, and print them."""
    from scipy.optimize import least_squares

    sizes = np.asarray(sizes)
    too_much = measured(sizes, places, line=0.0).mean(axis=1) - 1
    fitted = least_squares(lambda p: (p[0] / (sizes + p[1]) - too_much) * sizes, (0.3, 1.0)).x
    print(f"LINE, NARROW: to first order {fitted[0]:.3f}, {fitted[1]:.2f}, from spheres of {sizes} cells", flush=True)


def sensitivity(sizes, places):
    """Print the error of the mean pull-off with each number as shipped, and a tenth more or less."""
    from roughxr.kernels.adhesion import tuning

    print("Sensitivity: error of the mean pull-off")
    variants = [{}]
    for name in ("SOFTENING", "LINE", "NARROW"):
        variants += [{name.lower(): part * getattr(tuning, name)} for part in (0.9, 1.1)]
    for changes in variants:
        errors = measured(sizes, places, **changes).mean(axis=1) - 1
        named = ", ".join(f"{name.upper()} = {value:.3g}" for name, value in changes.items()) or "as shipped"
        words = ", ".join(f"{n:g} cells {e:+.2%}" for n, e in zip(sizes, errors))
        print(f"  {named:>18}: {words}", flush=True)


def lengthening_power():
    """Print the power from JKR's ellipses near their largest pull."""
    from scipy.special import ellipe

    from roughxr.kernels.adhesion.contact_patches import lengthening
    from roughxr.kernels.asperity import elliptic_jkr

    print("LENGTHENING_POWER: ln(dL/dA r) / ln(L/L₀) at the largest pull of JKR's ellipses")
    for ratio in (1.5, 2.0, 3.0, 5.0, 10.0):
        state = elliptic_jkr.contact_at("energy", ratio, np.linspace(0.2, 0.6, 2001))
        outline = 4 * state.a * ellipe(1 - (state.b / state.a) ** 2)
        area = np.pi * state.a * state.b
        shortening = np.gradient(outline) / np.gradient(area) * np.sqrt(area / np.pi)
        k = np.argmin(state.P)
        longer = lengthening((state.b / state.a)[k])
        print(f"  B/A {ratio:4g}: b/a {(state.b / state.a)[k]:.3f}, power {np.log(shortening[k]) / np.log(longer):.3f}")


def elsewhere(places, sizes, ratios, angles):
    """Print errors where nothing was found: other spheres, and ellipses against the branch of least energy."""
    from adhesive_accuracy import least_energy

    print("Where they were not found: error of the mean pull-off, and of its extremes")
    for cells in sizes:
        errors = pull_offs(cells, places) - 1
        print(
            f"  sphere, {cells:4g} cells: {errors.mean():+.2%} ({errors.min():+.2%} … {errors.max():+.2%})", flush=True
        )
    for ratio in ratios:
        exact = least_energy(ratio)
        for angle in angles:
            errors = pull_offs(10.0, places, ratio, angle) / exact - 1
            line = f"  ellipse, B/A {ratio:g} at {angle:g}°, 10 cells: {errors.mean():+.2%}"
            print(f"{line} ({errors.min():+.2%} … {errors.max():+.2%})", flush=True)


def main():
    """Find, vary, and test elsewhere."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer places and sizes")
    quick = parser.parse_args().quick
    places, sizes = (3, FOUND_ON[:3]) if quick else (12, FOUND_ON)
    lengthening_power()
    softening(sizes, places)
    line_and_narrow(sizes, places)
    sensitivity(sizes, places)
    elsewhere(places, NOT_FOUND_ON[:2] if quick else NOT_FOUND_ON, RATIOS[:2] if quick else RATIOS, ANGLES)


if __name__ == "__main__":
    main()
