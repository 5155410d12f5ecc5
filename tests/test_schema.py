"""The door: what is no map of heights is refused before anything is computed with it."""

import dask.array as da
import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import level, roughness
from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.particles.force_balance import fluid_of
from roughxr.mechanics.vocabulary import schema

from .surfaces import glass_pair, rough, scan

N = 48


@pytest.mark.parametrize("kind", [bool, complex, object, str, "timedelta64[ns]", "datetime64[ns]"])
@pytest.mark.parametrize("lazy", [False, True])
def test_heights_that_are_no_real_numbers_are_refused(kind, lazy):
    surface = glass_pair(scan(rough(N, seed=2)))
    values = surface["height"].values.astype(int).astype(kind)
    wrong = surface.assign(height=(("x", "y"), values, {"units": "nm"}))
    wrong = wrong.chunk(x=20) if lazy else wrong
    calls = [level, roughness, asperities]
    calls += [lambda ds: direct(ds, delta=[5.0]), lambda ds: superpose(ds, delta=[5.0])]
    for call in calls:
        with pytest.raises(ValueError, match="height: expected real numbers, found values of type"):
            call(wrong)


@pytest.mark.parametrize("kind", ["int16", "float32", "uint8", ">f4"])
def test_heights_of_any_real_type_are_taken(kind):
    whole = np.round(rough(N, rms=40.0, seed=2))
    whole -= whole.min()  # squares are beyond what small integers hold
    assert 180 < whole.max() < 256
    surface = scan(whole)
    typed = surface.assign(height=(("x", "y"), whole.astype(kind), {"units": "nm"}))
    expected = roughness(surface)
    xr.testing.assert_allclose(roughness(typed), expected, rtol=1e-5)


def test_a_lazy_masked_array_means_what_one_in_memory_does():
    height = rough(N, seed=2)
    mask = np.zeros(height.shape, bool)
    mask[20:23, 30:32] = True
    masked = np.ma.masked_array(np.where(mask, -9999.0, height), mask)
    here = scan(height).assign(height=(("x", "y"), masked, {"units": "nm"}))
    later = here.assign(height=(("x", "y"), da.from_array(masked, chunks=16), {"units": "nm"}))
    xr.testing.assert_allclose(roughness(later).compute(), roughness(here))
    xr.testing.assert_allclose(level(later).compute(), level(here), atol=1e-9)


def test_a_catalogue_that_holds_asperities_twice_is_refused():
    catalogue = asperities(glass_pair(scan(rough(N, seed=2))))
    once = superpose(catalogue, delta=[5.0])
    xr.testing.assert_equal(superpose(catalogue.isel(asperity=slice(None, None, -1)), delta=[5.0]).force, once.force)


@pytest.mark.parametrize("name", sorted(schema._SIZES))
@pytest.mark.parametrize(
    ("wrong", "message"), [(-1.0, "found -1"), (np.nan, "found nan"), ([1.0, 2.0], "one value, found 2")]
)
def test_a_pair_that_was_changed_after_it_was_assigned_is_refused(name, wrong, message):
    pair = glass_pair(scan(rough(N, seed=2)))
    changed = pair.assign_coords({name: ("case", wrong) if np.ndim(wrong) else wrong})
    for call in (superpose, lambda ds: superpose(asperities(ds), delta=[5.0])):
        with pytest.raises(ValueError, match=f"{name}: expected .*{message}"):
            call(changed)


def test_infinite_heights_are_refused():
    axes = {axis: (axis, [0.0, 1.0, 2.0]) for axis in "xy"}
    scan = xr.Dataset({"height": (("x", "y"), np.array([[0, np.inf, 1], [0, 2, -np.inf], [0.0, 1, 2]]))}, axes)
    with pytest.raises(ValueError, match=r"expected finite heights, found 2 infinite ones; .*contact\.fill"):
        schema.validate(scan, "scan")


def test_a_scan_without_units_is_taken_as_nm_with_a_warning_that_states_its_size():
    axis = np.arange(8) * 10.0
    bare = xr.Dataset({"height": (("x", "y"), rough(8))}, {"x": axis, "y": axis})
    with pytest.warns(UserWarning, match="found none; taken as nm, a scan of 80 x 80 nm"):
        roughness(bare)


def test_a_scan_in_metres_without_units_is_refused():
    metres = np.arange(8) * 1e-8
    nanometres = {axis: (axis, np.arange(8) * 10.0, {"units": "nm"}) for axis in "xy"}
    heights = 1e-9 * rough(8)
    with pytest.raises(ValueError, match=r"x: expected pixels of at least 0\.001 nm, found 1e-08 nm"):
        roughness(xr.Dataset({"height": (("x", "y"), heights)}, {"x": metres, "y": metres}))
    with pytest.raises(ValueError, match=r"height: expected units and heights over at least 0\.001 nm"):
        roughness(xr.Dataset({"height": (("x", "y"), heights)}, nanometres))


@pytest.mark.parametrize("wrong", [rough(8), "scan.gsf", None], ids=["array", "path", "nothing"])
@pytest.mark.parametrize(
    "call",
    [
        lambda heights: roughxr.assign_pair(heights, sphere_radius=500, materials="glass"),
        lambda heights: roughxr.vary(heights, roughxr.adhesive, sphere_radius=[500]),
        *(roughxr.level, roughxr.adhesive, roughxr.superpose, roughxr.pull_off_map, roughxr.rolling),
        lambda heights: roughxr.fit_pair(heights, xr.Dataset()),
        *(roughxr.reference.tabor, roughxr.scans.regions.centres, roughxr.scans.regions.extent),
    ],
)
def test_heights_that_are_no_dataset_are_refused_with_the_way_to_make_one(call, wrong):
    with pytest.raises(ValueError, match=r"expected an xarray.Dataset.*xr.Dataset\(\{'height'"):
        call(wrong)


def test_labels_convert_what_states_other_units_of_its_quantity():
    metres = {axis: (axis, np.arange(8) * 1e-8, {"units": "m"}) for axis in "xy"}
    scan = xr.Dataset({"height": (("x", "y"), 1e-9 * rough(8), {"units": "m"})}, metres)
    labelled = schema.label(scan)
    np.testing.assert_allclose(labelled["height"], rough(8))
    np.testing.assert_allclose(labelled["x"], np.arange(8) * 10.0)
    assert labelled["height"].units == labelled["x"].units == "nm"


@pytest.mark.parametrize(
    "verb",
    [
        roughxr.answer,
        roughxr.certificate,
        roughxr.level,
        roughxr.pull_off,
        roughxr.statistics.bootstrap,
        roughxr.statistics.cdf,
        roughxr.statistics.fit,
        roughxr.statistics.pdf,
        roughxr.statistics.summary,
        roughxr.particles.critical_load,
    ],
)
def test_a_verb_refuses_an_array_and_says_what_to_pass(verb):
    with pytest.raises(ValueError, match=r"expected an xarray\.Dataset of kind .*, found ndarray; (pass|open) "):
        verb(np.zeros((4, 4)))


def test_a_verb_validates_its_dataset_and_takes_it_by_name():
    surface = scan(rough(24, seed=1))
    in_micrometres = surface.assign(height=(surface.height * 1e-3).assign_attrs(units="um"))
    xr.testing.assert_allclose(roughxr.level(ds=in_micrometres), roughxr.level(surface))
    with pytest.raises(ValueError, match="moments: expected a variable 'resisting_moment', found height; pass"):
        surface.contact.critical_load()


def test_what_code_reads_of_a_result_is_no_text_of_its_history():
    surface = glass_pair(scan(rough(48, seed=1)))
    levelled = surface.contact.level().contact.assign_pair(sphere_radius=500, materials=("glass", "silicon"))
    assert (levelled.levelling, levelled.materials) == ("plane", "glass/silicon")
    assert "materials" not in levelled.contact.assign_pair(sphere_radius=500, contact_modulus=40).attrs
    moments = surface.contact.rolling(directions=8, subregions=(1, 1))
    helium = roughxr.particles.Flow(density=0.166, viscosity=1.18e-4)
    critical = moments.contact.critical_load(flow=helium)
    del critical.attrs["history"]
    assert fluid_of(critical) == helium
    with pytest.raises(ValueError, match=r"expected a result of critical_load, .*, found none of .*viscosity"):
        fluid_of(moments)


def test_the_history_states_the_verb_and_every_option_that_is_not_the_default():
    surface = glass_pair(scan(rough(24, seed=1)))
    flags = surface.height > 0
    levelled = surface.contact.level(exclude=flags)
    solved = levelled.contact.superpose(delta=np.linspace(0, 9, 80), subregions=(2, 2))
    fitted = roughxr.statistics.fit(solved.contact.pull_off(), laws=["normal"], simulations=0)
    steps = [(step["operation"], step["arguments"]) for step in schema.history(fitted)]
    assert steps[-4:] == [
        ("level", {"exclude": "DataArray (x: 24, y: 24)"}),
        ("superpose", {"delta.first": 0.0, "delta.last": 9.0, "delta.size": 80, "subregions": [2, 2]}),
        ("pull_off", {}),
        ("fit", {"laws": ["normal"], "simulations": 0}),
    ]


def test_a_stack_of_scans_is_refused_with_its_dimension():
    image = scan(rough(8))
    stack = xr.concat([image, image], "frame")
    for verb in (level, roughness, direct, asperities):
        with pytest.raises(roughxr.Refusal, match=r"found \(frame, x, y\); take one image, ds.isel\(frame=0\)"):
            verb(stack)


def test_refusals_show_six_digits():
    assert str(roughxr.Refusal("load", "positive loads", 1 / 3)) == "load: expected positive loads, found 0.333333"
    assert "found [0.333333, 2]" in str(roughxr.Refusal("load", "one load", [1 / 3, 2]))
    with pytest.raises(ValueError, match=r"sphere_radius: expected one positive number in nm, found -0\.3$"):
        scan(rough(8)).contact.assign_pair(sphere_radius=-(0.1 + 0.2), materials="glass")


def test_each_warning_of_the_package_has_its_class():
    names = [name for name in roughxr.__all__ if isinstance(getattr(roughxr, name), type)]
    warnings_of_the_package = {name for name in names if issubclass(getattr(roughxr, name), roughxr.RoughxrWarning)}
    assert {"ImplausibleScan", "ImplausiblePair", "IncompleteResult", "UnresolvedContact"} <= warnings_of_the_package
    assert issubclass(roughxr.UnreadableScan, roughxr.Refusal)
