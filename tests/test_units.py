"""One door: whatever enters a verb, in whatever units, is what it says; what cannot be converted is refused."""

import functools
import re

import numpy as np
import pint
import pytest
import xarray as xr
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import roughxr
from roughxr import reference
from roughxr.mechanics.vocabulary import schema, units
from roughxr.mechanics.vocabulary.table import VARIABLES

from .verb_calls import (
    CALLS,
    NOT_CALLED,
    PLACES,
    QUICK,
    WRITES,
    assert_same,
    call,
    kinds_read,
    made,
    named,
    public_verbs,
    unlabelled,
)

#: Other units of the table's, three for each.
OTHERS = {
    "nm": ("um", "m", "angstrom"),
    "nN": ("uN", "N", "pN"),
    "GPa": ("Pa", "MPa", "N mm-2"),
    "J/m^2": ("mJ/m^2", "erg cm-2", "N/m"),
    "1/nm": ("um-1", "1/m", "mm-1"),
    "nm^2": ("um2", "m**2", "angstrom^2"),
    "nN nm": ("J", "aJ", "uN um"),
    "nN/nm": ("N/m", "mN m-1", "pN/nm"),
    "rad": ("degree", "mrad", "arcmin"),
    "nm^4": ("um4", "m4", "angstrom4"),
    "m/s": ("cm/s", "um s-1", "km/h"),
    "s": ("ms", "min", "us"),
}
EVERY = [(verb, k) for verb, calls in CALLS.items() for k in range(len(calls))]

#: How far results may differ: rounding, but for iterative solves, which end a little elsewhere.
SOLVED = {"adhesive": 1e-6, "direct": 1e-6, "rigid": 1e-6, "fit_curve": 1e-3, "fit_pair": 1e-6}
#: Not compared: how a solve came to its end, directions of extremes, which opposite ones may share, and the difference
#: of two pull-offs, each of which is compared. Text rounds.
LEFT = ("iterations", "residual", "weakest_direction", "stiffest_direction")
TEXT = 1e-5


#: The same draws each time, and what fails as it was drawn: a smaller case would take as long again as all of them.
HOW = {"deadline": None, "derandomize": True, "database": None, "phases": (Phase.explicit, Phase.generate)}


def changed(array, unit, *, as_pint):
    """Return the same physical values in another unit."""
    package_unit = schema.VARIABLES[array.name].units
    values = array.values / units.factor(unit, package_unit)
    if as_pint and array.name not in array.dims:
        other_attributes = {key: value for key, value in array.attrs.items() if key != "units"}
        return xr.Variable(array.dims, units._registry().Quantity(values, unit), other_attributes)
    return xr.Variable(array.dims, values, {**array.attrs, "units": unit})


def convertible(ds):
    """Return the names of a Dataset's variables that have other units."""
    names = [name for name in ds.variables if name in schema.VARIABLES and ds[name].dtype.kind == "f"]
    return sorted(name for name in names if schema.VARIABLES[name].units in OTHERS)


@functools.cache
def expected(verb, k):
    return call(verb, *CALLS[verb][k], made())


def in_units(ds, draw):
    """Return a Dataset with some variables in other units, or without any where they have the table's."""
    for name in convertible(ds):
        choice = draw(st.sampled_from((*OTHERS[schema.VARIABLES[name].units], None, None)))
        if choice is None:
            continue
        quantity_in_unit = changed(ds[name], choice, as_pint=draw(st.booleans()))
        ds = ds.assign_coords({name: quantity_in_unit}) if name in ds.coords else ds.assign({name: quantity_in_unit})
    return ds


@pytest.fixture(scope="module", autouse=True)
def _no_verb_changes_what_it_is_given():
    before = {kind: ds.copy(deep=True) for kind, ds in made().items()}
    yield
    for kind, ds in before.items():
        xr.testing.assert_identical(made()[kind], ds)


@pytest.mark.parametrize(("verb", "k"), EVERY)
def test_every_name_of_a_result_has_its_row_with_units_and_words(verb, k):
    result = expected(verb, k)
    assert unlabelled(result.to_dataset() if isinstance(result, xr.DataArray) else result) == []


def holds(verb, k, draw):
    kinds, options = CALLS[verb][k]
    datasets = made() | {kind: in_units(made()[kind], draw) for kind in kinds_read(kinds, options)}
    rtol = TEXT if verb in WRITES else SOLVED.get(verb, 1e-7)
    assert_same(call(verb, kinds, options, datasets), expected(verb, k), rtol=rtol, leave=LEFT, context=verb)


@pytest.mark.parametrize(("verb", "k"), EVERY)
@settings(max_examples=1, **HOW)
@given(data=st.data())
def test_results_are_the_same_whatever_the_units_of_what_enters(verb, k, data):
    holds(verb, k, data.draw)


def test_no_verb_is_forgotten():
    verbs = public_verbs()
    assert verbs.keys() - CALLS.keys() - NOT_CALLED.keys() == set()


def quantity(value, unit, kind):
    """Return an option's value in another unit, as a quantity, as text or as a DataArray."""
    if kind == "quantity":
        return units._registry().Quantity(np.asarray(value, float) if np.ndim(value) else value, unit)
    if kind == "text":
        return [f"{number!r} {unit}" for number in value] if np.ndim(value) else f"{value!r} {unit}"
    return xr.DataArray(value, dims=["n"][: np.ndim(value)], attrs={"units": unit})


#: Options that have units: verb, on what, option, its value in the table's units, further options.
OPTIONS = [
    ("direct", "scan", "delta", [1.0, 4.0], {"subregions": PLACES}),
    ("direct", "scan", "load", [50.0, 300.0], {"subregions": PLACES}),
    ("adhesive", "scan", "preload", 40.0, {"subregions": ([0.0], [0.0]), **QUICK}),
    ("rolling", "scan", "directions", [0.0, 1.0, 2.0], {"subregions": PLACES}),
    ("rolling", "scan", "normal_force", 20.0, {"subregions": PLACES, "directions": 3}),
    ("asperities", "scan", "patch", 60.0, {}),
    ("crop", "scan", "x", (-40.0, 40.0), {}),
    ("resample", "scan", "size", 12.0, {}),
    ("dilate", "scan", "tip_radius", 20.0, {}),
    ("smooth", "scan", "shortest", 30.0, {}),
    ("fill", "scan", "method", 1.0, {}),
    ("placements", "scan", "sphere_radius", 500.0, {"count": 2}),
    ("tip_flags", "catalogue", "tip_radius", 10.0, {}),
    ("curves_pull_off", "curves", "spring_constant", 0.5, {}),
    ("pdf", "pulls", "bins", [0.0, 50.0, 100.0, 400.0], {"name": "pull_off_force"}),
    ("critical_load", "held", "direction", 0.5, {}),
    ("critical_load", "held", "particle_density", 2500.0, {"cause": "vibration"}),
    ("critical_load", "held", "shear_strength", 1.0, {}),
    ("resuspension", "held", "friction_velocity", [1.0, 5.0], {}),
    ("resuspension", "held", "time", 2.0, {"friction_velocity": [1.0]}),
    ("vary", "scan", "sphere_radius", [500.0, 900.0], {"solve": roughxr.pull_off_map, "subregions": PLACES}),
    ("vary", "scan", "contact_modulus", [20.0, 40.0], {"solve": roughxr.pull_off_map, "subregions": PLACES}),
    ("vary", "scan", "work_of_adhesion", [0.1, 0.3], {"solve": roughxr.pull_off_map, "subregions": PLACES}),
    ("assign_pair", "scan", "hardness", 4.0, {"sphere_radius": 800, "contact_modulus": 3, "work_of_adhesion": 0.05}),
]
TABLE = {
    "directions": "rad",
    "bins": "nN",
    "normal_force": "nN",
    "spring_constant": "nN/nm",
    "particle_density": "kg/m^3",
    "shear_strength": "GPa",
}
MORE = {"kg/m^3": ("g/cm^3",), "m/s^2": ("km/s^2",), "m^2/s": ("cm^2/s",)}


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.parametrize(("verb", "of", "name", "value", "others"), OPTIONS)
def test_every_option_with_a_unit_takes_quantities(verb, of, name, value, others):
    table_unit = TABLE.get(name) or (VARIABLES[name].units if name in VARIABLES else "nm")
    unit = (OTHERS.get(table_unit) or MORE[table_unit])[0]
    scaled = (np.asarray(value) / units.factor(unit, table_unit)).tolist()
    others = {key: made().get(option, option) if isinstance(option, str) else option for key, option in others.items()}
    function = functools.partial(named(verb), made()[of], **{k: v for k, v in others.items() if k != name})
    plain = f"{value} nm" if name in ("patch", "method") else value
    expected = function(**{name: plain})
    for kind in ("quantity", "text", "array"):
        scaled_quantity = quantity(scaled, unit, kind)
        scaled_quantity = tuple(scaled_quantity) if name == "x" and kind == "text" else scaled_quantity
        # a bin's edge, written in other units, may be beside a sample by rounding: all else follows its numbers
        call = f"{verb}({name}) as {kind}"
        assert_same(
            function(**{name: scaled_quantity}), expected, rtol=SOLVED.get(verb, 1e-7), leave=LEFT, context=call
        )


@pytest.mark.parametrize("kind", ["quantity", "text", "array", "dataset"])
def test_places_take_quantities(kind):
    ground = made()["scan"]
    expected = roughxr.pull_off_map(made()["scan"], subregions=PLACES)
    if kind == "dataset":
        axes = (("subregion", np.asarray(axis) / 1000, {"units": "um"}) for axis in PLACES)
        centres = xr.Dataset(coords=dict(zip(("subregion_x", "subregion_y"), axes)))
    else:
        centres = tuple(quantity((np.asarray(axis) / 1000).tolist(), "um", kind) for axis in PLACES)
    assert_same(roughxr.pull_off_map(ground, subregions=centres), expected, rtol=1e-9)
    single_place = roughxr.pull_off_map(ground, subregions=("-0.031 um", "12 nm"))
    np.testing.assert_allclose(single_place.pull_off_force, expected.pull_off_force[:1])


def test_what_cannot_be_converted_is_refused_in_words():
    ground = made()["scan"]
    for name, unit in (("height", "V"), ("sphere_radius", "nN"), ("x", "pixel things"), ("work_of_adhesion", "J")):
        wrong = ground.copy()
        wrong[name].attrs["units"] = unit
        with pytest.raises(ValueError, match=rf"{name}: expected units that convert to '.*', found '{unit}'; correct"):
            roughxr.pull_off_map(wrong)
    with pytest.raises(ValueError, match="delta"):
        roughxr.direct(ground, delta="5 nN")
    with pytest.raises(ValueError, match="subregions"):
        roughxr.direct(ground, delta=[5.0], subregions=(["1 V"], ["2 nm"]))


def test_the_door_costs_nothing_where_units_agree_and_stays_lazy():
    ground = made()["scan"]
    assert schema.in_package_units(ground) is ground
    lazy = (ground * 1).assign(height=(ground.height / 1000).assign_attrs(units="um").chunk(x=12))
    assert schema.in_package_units(lazy).height.chunks == lazy.height.chunks
    single = ground.assign(height=ground.height.astype("float32").assign_attrs(units="um"))
    assert schema.in_package_units(single).height.dtype == np.float32
    alike = ground.assign(height=ground.height.assign_attrs(units="nanometer"))
    assert (
        schema.in_package_units(alike).height.values is ground.height.values
        and schema.in_package_units(alike).height.units == "nm"
    )


@pytest.mark.filterwarnings("ignore:.*expected units")
def test_what_states_no_units_is_in_the_tables():
    bare = made()["scan"].copy()
    for name in bare.variables:
        bare[name].attrs.clear()
    bare_result = roughxr.direct(bare, delta=[4.0], subregions=PLACES)
    assert_same(bare_result, roughxr.direct(made()["scan"], delta=[4.0], subregions=PLACES), rtol=1e-12)


def test_a_decimal_comma_is_refused_by_its_name():
    with pytest.raises(ValueError, match="sphere_radius: expected a decimal point, found a comma in '0,5 um'"):
        units.magnitude("0,5 um", "nm", "sphere_radius")


@pytest.mark.parametrize("flag", [True, np.True_, [False, True]])
def test_a_flag_is_no_quantity(flag):
    with pytest.raises(ValueError, match="surface_energy: expected a number in J/m\\^2, found"):
        units.magnitude(flag, "J/m^2", "surface_energy")


@pytest.mark.parametrize("text", [".065 nN nm", "+6.5e-20 J", " 6.5e-20 J", "65 zJ"])
def test_a_hamaker_constant_in_words_is_a_number_however_it_is_written(text):
    assert reference.hamaker_constant(text) == pytest.approx(0.065)


def test_units_in_files_are_read_alike_by_pint_and_udunits():
    plain = pint.UnitRegistry()
    for name, variable in VARIABLES.items():
        assert not re.search(r"[A-Za-z]-?\d", variable.units), f"{name}: {variable.units} is a power to UDUNITS only"
        plain.Quantity(1.0, variable.units)


def test_heights_in_metres_that_state_no_units_are_refused_where_the_pair_is_assigned():
    axes = {axis: (axis, np.arange(64) * 1e-8, {"units": "m"}) for axis in ("x", "y")}
    heights = xr.Dataset({"height": (("x", "y"), 1e-9 * np.random.default_rng(1).normal(0.0, 5.0, (64, 64)))}, axes)
    with pytest.raises(ValueError, match="height: expected units and heights over at least"):
        heights.contact.assign_pair(sphere_radius=500, materials="glass")


@pytest.mark.parametrize("units", ["nm", None])
@pytest.mark.parametrize("door", [roughxr.scans.level, roughxr.roughness, roughxr.asperities, roughxr.scans.to_netcdf])
def test_heights_in_metres_that_are_called_nanometres_are_refused(door, units, tmp_path):
    axes = {axis: (axis, np.arange(64) * 10.0, {"units": "nm"}) for axis in ("x", "y")}
    heights = 1e-9 * np.random.default_rng(1).normal(0.0, 500.0, (64, 64))
    surface = xr.Dataset({"height": (("x", "y"), heights, {"units": units} if units else {})}, axes)
    options = {"path": tmp_path / "scan.nc"} if door is roughxr.scans.to_netcdf else {}
    with pytest.raises(
        ValueError, match=r"height: expected units and heights over at least .* found (nm|no units) and"
    ):
        door(surface, **options)


@pytest.mark.parametrize("text", ["2020-01-01", "3 um + 2 um", "300 nm*1000", "2**3 um", "1/3 um", "3 um 2"])
def test_arithmetic_is_no_quantity(text):
    with pytest.raises(ValueError, match="a: expected a"):
        units.magnitude(text, "nm", "a")


@pytest.mark.parametrize(
    ("text", "value"), [("3um", 3e3), (" -1.5e-3 mm", -1500), (".5 µm", 500), ("7", 7), ("2 Å", 0.2)]
)
def test_a_quantity_is_a_number_and_its_units(text, value):
    assert units.magnitude(text, "nm", "a") == pytest.approx(value, rel=1e-12)
