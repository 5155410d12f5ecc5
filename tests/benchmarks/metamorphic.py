"""Random trials of what must not matter, over all verbs: each chains up to six changes; every difference is printed.

The changes of `tests/test_identities.py`, and all lengths scaled at equal moduli: forces then scale as their square.

    python tests/benchmarks/metamorphic.py [--trials 500] [--seed 0]
"""

import argparse
import functools
import warnings

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import roughxr
from roughxr import scans, statistics
from tests import test_identities as identities
from tests.verb_calls import numbers, surface

SCALES = [1.0, 1.0, 0.1, 3.0, 40.0]

#: Not compared: see `test_identities`; heights about 0; what follows from gravity; the order of equal things.
LEFT = {*identities.LEFT, "r_a_datum", "r_q_datum", "critical_friction_velocity", "support_x", "support_y"}
LEFT |= {"aic", "log_likelihood", "rest_height", "in_range"}

#: Not scaled: Hamaker's forces begin at a fixed closest approach. Resting positions decide between equal pixels.
AS_IT_IS = ("rigid", "formulas", "regime")
FAR = {**identities.HOW_FAR, "fit": 1e-4}


def pulls(scan, places, **options):
    """Return the pull-offs of superposed asperities."""
    return roughxr.pull_off_map(scan, subregions=places, **options)


#: Verbs beside those of `test_identities`, of a scan, places and the scale of lengths.
MORE = {
    "resting": lambda scan, at, s: roughxr.particles.resting(scan),
    "level": lambda scan, at, s: roughxr.level(scan),
    "smooth": lambda scan, at, s: scans.smooth(scan, shortest=30.0 * s),
    "dilate": lambda scan, at, s: scans.dilate(scan, tip_radius=20.0 * s),
    "erode": lambda scan, at, s: scans.erode(scan, tip_radius=20.0 * s),
    "reconstruct": lambda scan, at, s: roughxr.reconstruct(scan),
    "power_spectrum": lambda scan, at, s: scans.power_spectrum(roughxr.level(scan)),
    "self_affine_fit": lambda scan, at, s: scans.self_affine_fit(scan),
    "tip_flags": lambda scan, at, s: scans.tip_flags(roughxr.asperities(scan), tip_radius=10.0 * s),
    "formulas": lambda scan, at, s: roughxr.formulas(scan, subregions=at, mesh=2),
    "summary": lambda scan, at, s: statistics.summary(pulls(scan, at)).drop_sel(statistic="count"),
    "reduction": lambda scan, at, s: statistics.reduction(pulls(scan, at)),
    "fit": lambda scan, at, s: statistics.fit(pulls(scan, at)),
    "pull_off": lambda scan, at, s: statistics.pull_off(
        roughxr.superpose(scan, delta=np.linspace(-4, 9, 27) * s, subregions=at)
    ),
    "critical_load": lambda scan, at, s: roughxr.particles.critical_load(
        roughxr.rolling(scan, directions=np.arange(8) * np.pi / 4, subregions=at)
    ),
    "vary": lambda scan, at, s: roughxr.vary(scan, pulls, contact_modulus=[10.0, 50.0], places=at),
}


def scaled(now, s):
    """Return a setting with all lengths, and the work of adhesion, multiplied."""
    return now._replace(scan=identities.scaled(now.scan, s), places=tuple(s * axis for axis in now.places))


def computed(verb, now, s):
    """Return the numbers of a verb's result, as for s = 1: along places, or sorted where their order is not fixed."""
    if verb in MORE:
        solution = now.through(lambda: MORE[verb](now.scan, now.places, s)).compute()
        solution = (
            solution.isel(subregion=now.order) if "subregion" in solution.dims and verb != "resting" else solution
        )
    else:
        times = {"delta": lambda delta: [s * d for d in delta], "load": lambda load: [s**2 * force for force in load]}
        times |= {"mesh": lambda mesh: roughxr.Mesh(mesh.cells, step=s * mesh.step)}
        options = {key: times.get(key, lambda value: value)(value) for key, value in identities.VERBS[verb].items()}
        with pytest.MonkeyPatch.context() as patch:
            patch.setitem(identities.VERBS, verb, options)
            solution = identities.computed(verb, now)
    ordered = "subregion" in solution.dims and verb != "resting"
    arrays = numbers(identities.scaled(solution, 1 / s), LEFT)
    return {name: array if ordered else np.sort(array.ravel()) for name, array in arrays.items()}


@functools.cache
def at_first(verb, seed):
    """Return the numbers before any change."""
    return computed(verb, identities.Setting(surface(seed), identities.places(seed)), 1.0)


def differences(verb, seed, steps, s, draw):
    """Return the names of what differs, and by how much of its largest value."""
    s = 1.0 if verb in AS_IT_IS else s
    now = scaled(identities.Setting(surface(seed), identities.places(seed)), s)
    for step in steps:
        now = step(now, draw) if (verb, step) != ("resting", identities.in_single_precision) else now
    expected = at_first(verb, seed)
    computed_again = computed(verb, now, s)
    out = {}
    rtol = max(FAR.get(verb, identities.ROUNDING), now.far)
    for name in expected.keys() & computed_again.keys():
        a = computed_again[name]
        b = expected[name]
        largest = np.abs(b[np.isfinite(b)]).max(initial=0.0)
        if a.shape != b.shape or not np.allclose(a, b, rtol, rtol * largest, equal_nan=True):
            out[name] = (
                f"{a.shape} for {b.shape}" if a.shape != b.shape else f"{np.nanmax(np.abs(a - b)) / largest:.1e}"
            )
    return out


def main():
    """Print each difference, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trials", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    done = []

    @hypothesis.seed(options.seed)
    @hypothesis.settings(identities.settings(**identities.HOW | {"derandomize": False}), max_examples=options.trials)
    @hypothesis.given(
        st.sampled_from(sorted({*MORE, *identities.VERBS})),
        *(st.integers(0, 99), identities.chains(), st.sampled_from(SCALES), st.data()),
    )
    def trial(verb, seed, steps, s, data):
        try:
            off = differences(verb, seed, steps, s, data.draw)
        except Exception as error:
            off = {type(error).__name__: str(error)[:300]}
        done.append(bool(off))
        if off:
            print(f"{verb}, seed {seed}, × {s}, {[step.__name__ for step in steps]}: {off}", flush=True)

    trial()
    print(f"{len(done)} trials of {len(MORE) + len(identities.VERBS)} verbs: {sum(done)} with a difference")


if __name__ == "__main__":
    main()
