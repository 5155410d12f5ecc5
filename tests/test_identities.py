"""What must not matter does not: identities that hold for every solving verb, in any order and together.

Units are `test_units`. Results are equal to rounding, or as far as `HOW_FAR` says and why.
"""

import functools
import tempfile
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import dask
import numpy as np
import pytest
import xarray as xr
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import roughxr

from .verb_calls import QUICK, archived, named, surface

#: Verbs and their options. What is compared lies along places, or is one number for the whole scan.
VERBS = {
    "direct": {"delta": [1.0, 4.0, 7.0]},
    "direct by load": {"load": [50.0, 300.0]},
    "direct from touch": {"delta": [1.0, 3.0], "datum": "first_contact"},
    "superpose": {"delta": [-1.0, 2.0, 5.0]},
    "superpose, maugis": {"delta": [2.0], "law": "dugdale"},
    "pull_off_map": {},
    "rolling": {"directions": np.arange(8) * np.pi / 4},
    "rigid": {"delta": [-4.0, -1.0]},
    "adhesive": {"delta": [2.0, 5.0], **QUICK},
    "regime": {"mesh": 2},
    "roughness": {},
    "asperities": {},
}
OF_SCAN = ("roughness", "asperities")

#: How far results may differ, relative to the largest of each variable: solved until a tolerance, not to rounding.
HOW_FAR = {
    "direct": 1e-5,  # the force's tolerance is 1e-6, and cells next to the edge of a contact may end either way
    "direct by load": 1e-4,
    "direct from touch": 1e-5,
    "adhesive": 1e-3,  # steps end where a branch does, which rounding moves by a part of a step
}
ROUNDING = 1e-6
#: Heights in single precision are other heights, by a part in 1e7 of the largest; pulls follow them as their root.
SINGLE = 1e-4

#: Not compared: how a solve came to its end; in how many cells the smallest contact that bears a tenth of the tension
#: is wide, which one cell's last digit may decide; angles of extremes, which two directions may share; and what stands
#: for x or y, or for places in their order.
LEFT = ("iterations", "residual", "weakest_direction", "stiffest_direction", "orientation", "x", "y", "subregion")
LEFT += (
    "subregion_x",
    "subregion_y",
    "scan_x_min",
    "scan_x_max",
    "scan_y_min",
    "scan_y_max",
    "datum_height",
    "asperity",
)
LEFT += ("resolution", "pull_off_resolution")
LEFT += ("pixel_x", "pixel_y", "size_x", "size_y", "height", "direction")
LEFT += ("r_a_datum", "r_q_datum")  # about height 0
LEFT += ("s_td",)  # turns with the surface


class Setting(NamedTuple):
    """A scan, places on it, and how what is computed is read."""

    scan: xr.Dataset
    places: tuple[np.ndarray, np.ndarray]
    turned: Any = staticmethod(lambda angles: angles)  # a direction on the first scan -> on this one
    order: Any = slice(None)  # of the first places among these
    far: float = 0.0
    through: Any = staticmethod(lambda compute: compute())


def transposed(now, draw):
    ds = now.scan.rename(x="y", y="x").transpose("x", "y")
    return now._replace(scan=ds, places=now.places[::-1], turned=lambda a: np.pi / 2 - now.turned(a))


def stored_the_other_way(now, draw):
    return now._replace(scan=now.scan.transpose("y", "x"))


def mirrored(now, draw):
    ds = now.scan.assign_coords(x=-now.scan.x).isel(x=slice(None, None, -1))
    return now._replace(scan=ds, places=(-now.places[0], now.places[1]), turned=lambda a: np.pi - now.turned(a))


def raised(now, draw):
    by = draw(st.sampled_from([0.37, -1.0, 100.0, -37.3]))
    return now._replace(scan=now.scan.assign(height=now.scan.height + by))


def moved(now, draw):
    by = [draw(st.sampled_from([0.0, 1.3, -512.0, 4096.0])) for _ in "xy"]
    ds = now.scan.assign_coords(x=now.scan.x + by[0], y=now.scan.y + by[1])
    return now._replace(scan=ds, places=tuple(axis + shift for axis, shift in zip(now.places, by)))


def in_another_order(now, draw):
    order = np.array(draw(st.permutations(range(len(now.places[0])))))
    back = np.argsort(order)
    back = back[now.order] if not isinstance(now.order, slice) else back
    return now._replace(places=tuple(axis[order] for axis in now.places), order=back)


def lazy(now, draw):
    return now._replace(scan=now.scan.chunk(x=draw(st.sampled_from([24, 12, 7])), y=draw(st.sampled_from([24, 11]))))


def on_a_scheduler(now, draw):
    name = draw(st.sampled_from(["synchronous", "threads"]))
    return now._replace(through=lambda compute: _on(name, compute))


def _on(name, compute):
    with dask.config.set(scheduler=name):
        return compute().compute()


def in_single_precision(now, draw):
    return now._replace(scan=now.scan.assign(height=now.scan.height.astype("float32")), far=SINGLE)


def saved_and_loaded(now, draw):
    return now._replace(scan=archived(now.scan.compute()))


def result_saved(now, draw):
    return now._replace(through=lambda compute: archived(compute().compute()))


def in_other_units(now, draw):
    ds = now.scan
    for name, unit, size in (("height", "um", 1e-3), ("x", "m", 1e-9), ("work_of_adhesion", "mJ/m^2", 1e3)):
        if draw(st.booleans()):
            scaled_variable = (ds[name] * size).assign_attrs(units=unit).variable
            ds = ds.assign(height=scaled_variable) if name == "height" else ds.assign_coords({name: scaled_variable})
    return now._replace(scan=ds)


def resumed(now, draw):
    """Computed with checkpoints, broken off after its first solve, and gone on with."""

    def through(compute):
        with tempfile.TemporaryDirectory() as folder:
            first = [True]

            def groups():
                fresh = {"one": compute()}
                if first.pop() if first else False:
                    raise InterruptedError
                return fresh

            path = Path(folder) / "run.nc"
            scan = now.scan.compute()
            try:
                roughxr.checkpointed(groups, path, scan=scan, arguments={})
            except InterruptedError:
                return roughxr.checkpointed(groups, path, scan=scan, arguments={})["one"].load()

    return now._replace(through=through)


#: Those of the scan and its places come before the others, which hold what is computed.
OF_INPUT = [transposed, mirrored, raised, moved, in_another_order, in_single_precision]
OF_FORM = [stored_the_other_way, lazy, saved_and_loaded, in_other_units]
OF_WAY = [on_a_scheduler, result_saved, resumed]


def places(seed):
    rng = np.random.default_rng(seed)
    return tuple(rng.uniform(-70.0, 70.0, (2, 4)).round(2))


def computed(verb, now):
    """Return the result of a verb, its places and directions in the order of the first setting's."""
    options = dict(VERBS[verb])
    if "directions" in options:
        turned = now.turned(options["directions"]) % (2 * np.pi)
        turned = np.where(turned > 2 * np.pi - 1e-9, 0.0, turned)
        options["directions"] = np.sort(turned)
    if verb not in OF_SCAN:
        options["subregions"] = now.places
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = now.through(lambda: named(verb.split(",")[0].split(" ")[0])(now.scan, **options))
        result = result.compute()
    if "directions" in options:
        result = result.isel(direction=np.argsort(np.argsort(turned)))
    if "asperity" in result.dims:
        result = xr.Dataset(
            {name: ("asperity", np.sort(result[name].values)) for name in result.data_vars if result[name].dims}
        )
    return result.isel(subregion=now.order) if "subregion" in result.dims else result


@functools.cache
def at_first(verb, seed):
    return computed(verb, Setting(surface(seed), places(seed)))


def holds(verb, seed, steps, draw):
    now = Setting(surface(seed), places(seed))
    for step in steps:
        now = step(now, draw)
    expected = at_first(verb, seed)
    result = computed(verb, now)
    rtol = max(HOW_FAR.get(verb, ROUNDING), now.far)
    context = f"{verb}, seed {seed}: {', '.join(step.__name__ for step in steps)}"
    assert set(result.data_vars) == set(expected.data_vars), context
    for name in sorted(set(map(str, expected.variables)) - set(LEFT)):
        if name not in result.variables or expected[name].dtype.kind not in "fiub":
            continue
        a, b = (np.asarray(ds[name].values, float) for ds in (result, expected))
        scale = np.abs(b[np.isfinite(b)]).max(initial=0.0)
        np.testing.assert_allclose(a, b, rtol=rtol, atol=rtol * scale, err_msg=f"{context}: {name}")


#: The same draws each time, and what fails as it was drawn: a smaller case would take as long again as all of them.
HOW = {"deadline": None, "derandomize": True, "database": None, "phases": (Phase.explicit, Phase.generate)}


@st.composite
def chains(draw):
    """Return some of the changes, in an order in which they can be made."""
    steps = draw(st.lists(st.sampled_from(OF_INPUT), max_size=3, unique=True))
    steps += draw(st.lists(st.sampled_from(OF_FORM), max_size=1))
    steps += draw(st.lists(st.sampled_from(OF_WAY), max_size=1))
    return steps


@pytest.mark.parametrize("step", [*OF_INPUT, *OF_FORM, *OF_WAY], ids=lambda step: step.__name__)
@settings(max_examples=2, **HOW)
@given(verb=st.sampled_from(sorted(VERBS)), data=st.data())
def test_what_must_not_matter_does_not(step, verb, data):
    holds(verb, 3, [step], data.draw)


def scaled(ds, s, c=1.0):
    """Return a Dataset with all lengths multiplied by s and all moduli by c; forces then are by s² c."""
    new = {}
    for name in ds.variables:
        units = ds[name].attrs.get("units") or getattr(roughxr.schema.VARIABLES.get(name), "units", "")
        power, stiffness = POWERS.get(units, (0, 0))
        numbers = ds[name].dtype.kind == "f" and (power or stiffness)
        new[name] = (
            ds[name].dims,
            ds[name].data * s**power * c**stiffness if numbers else ds[name].data,
            ds[name].attrs,
        )
    names = [str(name) for name in ds.data_vars]
    return xr.Dataset({name: new.pop(name) for name in names}, new, ds.attrs)


#: Powers of s and c with which a quantity grows, by its units.
POWERS = {"nm": (1, 0), "nN": (2, 1), "nm^2": (2, 0), "nN nm": (3, 1), "1/nm": (-1, 0), "J/m^2": (1, 1), "nm^4": (4, 0)}
POWERS["GPa"] = (0, 1)


_SCALED = [(49, 40.0, 1.0), (59, 0.1, 1.0), (7, 1 / 3, 100.0)]


@pytest.mark.parametrize(
    ("seed", "s", "c", "step"),
    [(*each, step) for each in _SCALED for step in (1.0, None)] + [(14, 1 + 1e-11, 1.0, 1.0)],
)
def test_an_adhesive_cycle_scales_with_lengths_and_moduli(seed, s, c, step):
    """A given step, and the usual one: no length, force or modulus of its own decides, nor does rounding."""
    first = surface(seed)
    at = places(seed)
    here = (roughxr.Mesh(1, step=size and size * k) for size, k in ((step, 1.0), (step, s)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected, other = (
            roughxr.adhesive(ds, subregions=where, mesh=mesh, law="jkr")
            for ds, where, mesh in zip((first, scaled(first, s, c)), (at, tuple(s * a for a in at)), here)
        )
    numbers = scaled(other, 1 / s, 1 / c)
    for name in set(expected.data_vars) - {"residual", "iterations"}:
        if expected[name].dtype.kind in "fb":
            largest = float(abs(expected[name]).max()) or 1.0
            np.testing.assert_allclose(numbers[name], expected[name], 1e-3, 1e-3 * largest, err_msg=str(name))


@pytest.mark.parametrize("seed", [4, 7])
def test_cells_equally_near_to_two_contacts_belong_to_both(seed):
    """Given to one of them by the order of the pixels, they changed the stated error by half on a transposed scan."""
    holds("adhesive", seed, [transposed], None)


@pytest.mark.soak
@settings(max_examples=300, **HOW)
@given(verb=st.sampled_from(sorted(VERBS)), seed=st.integers(0, 9), steps=chains(), data=st.data())
def test_nor_do_several_together(verb, seed, steps, data):
    holds(verb, seed, steps, data.draw)
