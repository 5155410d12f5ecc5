"""The way down and up that all kinds of contact share: problem, places, surfaces, records."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import adhesive, assign_pair, direct, pull_off, pull_off_map, superpose
from roughxr.mechanics.vocabulary import schema
from roughxr.statistics import pdf, summary

from .surfaces import glass_pair, rough, scan, unpressed

PAIR = {"contact_modulus": 40.0, "work_of_adhesion": 0.5}


def flat(size=41, dx=10.0):
    axis = (np.arange(size) - size // 2) * dx
    height = (("x", "y"), np.zeros((size, size)), {"units": "nm"})
    return schema.label(xr.Dataset({"height": height}, coords={"x": axis, "y": axis}))


def sphere_map(radius, half, dx=10.0):
    axis = np.arange(-half, half + dx / 2, dx)
    r2 = axis[:, None] ** 2 + axis**2
    return xr.DataArray(np.sqrt(radius**2 - r2), dims=("x", "y"), coords={"x": axis, "y": axis}, attrs={"units": "nm"})


@pytest.mark.parametrize("kind", ["direct", "adhesive"])
def test_a_missing_pixel_anywhere_on_a_lazy_scan_stops_the_solve(kind):
    flat_scan = assign_pair(flat(), sphere_radius=1000.0, **PAIR)
    flat_scan["height"][0, 0] = np.nan
    solve = {"direct": direct, "adhesive": adhesive}[kind]
    for chunks in (10, 41):
        with pytest.raises(ValueError, match="missing pixels"):
            solve(flat_scan.chunk(chunks), delta=[2.0], datum="highest_peak", subregions=([0.0], [0.0]))


def test_contact_at_the_rim_of_a_map_is_truncated():
    flat_scan = flat()
    pairs = {half: assign_pair(flat_scan, indenter=sphere_map(1000.0, half), **PAIR) for half in (60, 150)}
    solved = {half: direct(pair, delta=[1.0, 6.0]) for half, pair in pairs.items()}
    assert solved[60].truncated.values.tolist() == [[False, True]]  # the map ends 1.8 nm above its lowest point
    assert not solved[150].truncated.any()
    np.testing.assert_allclose(solved[60].force[0, 0], solved[150].force[0, 0], rtol=1e-12)
    assert solved[60].force[0, 1] < 0.99 * solved[150].force[0, 1]  # part of the contact is missing


@pytest.mark.parametrize("wrong", [2.7, -5, 0, True, "many"])
def test_refinements_are_whole_numbers(wrong):
    flat_scan = assign_pair(flat(), sphere_radius=1000.0, **PAIR)
    with pytest.raises(ValueError, match=r"mesh: expected .*a whole number from 1 to 16"):
        adhesive(flat_scan, delta=[2.0], mesh=wrong)


def test_default_displacements_from_the_highest_peak_suit_the_scan():
    """Whatever the heights' scale, half of the displacements touch half of the places, and the last touches all."""
    for rms in (0.5, 20.0):
        surface = glass_pair(scan(rough(96, rms=rms)))
        solved = direct(surface, subregions=(4, 4), datum="highest_peak")
        touched = (solved.force > 0).mean("subregion")
        assert solved.sizes["delta"] == 16 and float(touched[-1]) == 1.0 and float(touched[8]) >= 0.5


def test_default_displacements_of_adhering_bodies_press_by_some_times_the_pull_off():
    """On a smooth flat by ten times JKR's; on coarse pixels farther, to a contact that they resolve within the scan."""
    smooth_scan = assign_pair(flat(), sphere_radius=3000, materials="glass")
    pull = 1.5 * np.pi * float(smooth_scan.work_of_adhesion * smooth_scan.sphere_radius)
    assert float(direct(smooth_scan).force[0, -1]) == pytest.approx(10 * pull, rel=0.03)  # whole cells
    surface = assign_pair(roughxr.open_sample("rough"), sphere_radius=500, materials="glass")
    solved = direct(surface, subregions=(8, 8))
    last = solved.isel(delta=-1)
    assert solved.attrs["datum"] == "first_contact" and not solved.truncated.any()
    assert float(last.contact_area.median()) > 10 * 19.53**2  # cells
    hertz = 4 / 3 * float(surface.contact_modulus) * np.sqrt(500 * float(last.delta) ** 3)
    assert 0.1 * hertz < float(last.force.min()) and float(last.force.max()) < 2 * hertz  # it conforms to hollows
    np.testing.assert_array_equal(direct(surface.chunk(128), subregions=(8, 8)).force, solved.force)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_a_superposition_knows_its_exact_pull_off_whatever_its_displacements():
    surface = glass_pair(scan(rough(96)))
    exact = pull_off_map(surface, subregions=(4, 4))
    for delta in (None, [0.0], np.linspace(-2, 3, 11)):
        summed = superpose(surface, delta=delta, subregions=(4, 4))
        np.testing.assert_array_equal(summed.pull_off_force, exact.pull_off_force)
        np.testing.assert_array_equal(pull_off(summed).pull_off_delta, exact.pull_off_delta)
    sweep = superpose(surface, subregions=(4, 4))
    assert (sweep.delta[0] < exact.pull_off_delta).all() and (exact.pull_off_delta < sweep.delta[-1]).all()
    part = pull_off(sweep.drop_vars("pull_off_force")).pull_off_force / exact.pull_off_force
    assert float(part.max()) <= 1 + 1e-12 and float(part.min()) > 0.9


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_what_speaks_for_some_places_says_so():
    surface = glass_pair(scan(rough(96)))
    summed = superpose(surface, subregions=(4, 4))
    middle = float(summed.pull_off_delta.median())
    short = superpose(surface, delta=[middle - 2.0, middle - 1.0], subregions=(4, 4))
    with pytest.warns(UserWarning, match="too short for .* of 16 places"):
        by_steps = pull_off(short.drop_vars("pull_off_force"))
    with pytest.warns(UserWarning, match=r"computed from \d+ of 16 samples, the others are missing"):
        pdf(by_steps, "pull_off_force")
    with pytest.warns(UserWarning, match=r"computed from \d+ of 16 samples, the others are missing"):
        summary(by_steps)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.RoughxrWarning")  # of one cell a pixel
@pytest.mark.parametrize("kind", [adhesive, direct, superpose, pull_off_map, roughxr.rigid])
@unpressed()
def test_a_sphere_wider_than_the_scan_is_refused_with_the_width_that_it_needs(kind):
    """1 mm on 0.6 µm: every place touched the scan's highest peak, and others beyond the scan were not shown."""
    surface = scan(rough(64, rms=2.0))
    options = {"delta": [1.0], "datum": "first_contact"} if kind is direct else {}
    if kind is roughxr.rigid:
        options = {"delta": [0.0]}
    if kind is adhesive:
        options = {"mesh": 1}
    with pytest.raises(ValueError, match=r"sphere_radius: .* the scan's 625 nm, .* over 4000 nm; take a scan"):
        kind(glass_pair(surface, 1e6), subregions=(1, 1), **options)
    assert kind(glass_pair(surface), subregions=(1, 1), **options).sizes


def test_a_wide_sphere_on_a_single_bump_touches_nothing_beyond_the_scan():
    axis = 10.0 * (np.arange(41) - 20)
    bump = scan(30.0 * (np.hypot(axis[:, None], axis) < 100.0), 10.0)
    assert direct(glass_pair(bump, 1e6), delta=[0.1], subregions=([205.0], [205.0])).force.item() > 0
