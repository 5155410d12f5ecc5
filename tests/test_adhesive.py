"""Adhesive direct simulation: JKR, ellipses, Maugis, and the limits in between."""

import warnings
from functools import partial

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.contact.adhesion import adhesive
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.kernels.asperity import jkr, maugis
from roughxr.mechanics.kernels.halfspace import displacement_control
from tests import surfaces

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = [
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair"),
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact"),
]

#: The limit without range on the pixels as they are.
by_cells = partial(adhesive, law="jkr", mesh=1)

PIXEL = 9.77
RADIUS = 3000.0
W = 2 * 0.6747
PULL = 1.5 * np.pi * W * RADIUS


def flat(pixel=PIXEL, n=85):
    return surfaces.glass_pair(surfaces.scan(np.zeros((n, n)), pixel))


def units(ds):
    a = (9 * np.pi * W * RADIUS**2 / (8 * float(ds.contact_modulus))) ** (1 / 3)
    return a, a * a / RADIUS


def exact(delta, scale):
    return PULL * np.array([jkr.load(jkr.stable_semi_axis(d / scale)) for d in delta])


#: Parts of a pixel. Both the middle and a corner of a pixel are corners of cells of half a pixel.
CENTRES = {"on a corner of cells": (0.0, 0.0), "elsewhere": (0.31, 0.17)}

#: Largest error of force, in pull-offs: a front that crosses whole rows on four sides at once jerks.
ERRORS = {(0.0, 0.0): 0.02, (0.31, 0.17): 0.01}


def at(offset, pixel):
    return [offset[0] * pixel], [offset[1] * pixel]


@pytest.fixture(scope="module", params=CENTRES, ids=list(CENTRES))
def cycle(request):
    """A sphere on cells of half a pixel: on whole pixels forces are off by 2.1 % of the pull-off."""
    ds = flat(n=65)
    delta = np.arange(-2.0, 4.01, 0.25)
    centre = at(CENTRES[request.param], PIXEL)
    largest_error = ERRORS[CENTRES[request.param]]
    return ds, by_cells(ds, delta=delta, subregions=centre, mesh=2), largest_error


def test_sphere_pulls_off_as_jkr(cycle):
    ds, solution, _ = cycle
    assert bool(solution.converged.all())
    assert float(solution.pull_off_force[0]) == pytest.approx(PULL, rel=0.02)
    _, scale = units(ds)
    assert float(solution.detachment_delta[0]) == pytest.approx(jkr.END_DELTA * scale, abs=0.2)


def test_sphere_follows_jkr_on_retraction(cycle):
    ds, solution, largest_error = cycle
    retraction = solution.sel(branch="retraction")
    _, scale = units(ds)
    error = retraction.force.values[0] - exact(solution.delta.values, scale)
    assert np.abs(error).max() < largest_error * PULL


def test_sphere_loads_on_the_same_branch(cycle):
    ds, solution, _ = cycle
    loading = solution.sel(branch="loading", delta=slice(0.5, None))
    _, scale = units(ds)
    error = loading.force.values[0] - exact(loading.delta.values, scale)
    assert np.abs(error).max() < 0.03 * PULL
    snap_in = float(solution.snap_in_delta[0])
    assert 0 <= snap_in <= 0.25  # within one step
    assert -float(solution.snap_in_force[0]) == pytest.approx(exact([snap_in], scale)[0], abs=0.02 * PULL)
    assert not solution.sel(branch="loading", delta=slice(None, -0.5)).force.any()


def test_sphere_has_the_contact_area_of_jkr(cycle):
    """Within 2 % up to the largest pull, where its slope over displacement is finite, and 5 % beyond it."""
    ds, solution, _ = cycle
    a, scale = units(ds)
    retraction = solution.sel(branch="retraction")
    expected = np.pi * a**2 * np.array([jkr.stable_semi_axis(d / scale) for d in solution.delta.values]) ** 2
    error = np.abs(retraction.contact_area.values[0] / expected - 1)
    fine = np.linspace(-3.0, 0.0, 301)
    up_to = solution.delta.values > fine[np.nanargmin(exact(fine, scale))]  # of so flat a minimum cells move the place
    assert error[up_to].max() < 0.02 and error.max() < 0.05 and np.median(error) < 0.008


def test_a_cycle_loses_what_jumps_free(cycle):
    _, solution, _ = cycle
    lost = float(solution.hysteresis[0])
    final = float(solution.dissipated.sel(branch="retraction")[0].max())
    # the reversible branch between snap-in and pull-off frees next to nothing
    back = solution.dissipated.sel(branch="retraction").values[0]
    assert abs(back.max() - back.min()) < 0.03 * lost
    assert 0 < final < lost


#: Where on its pixel a paraboloid's apex lies: on a corner of cells of half a pixel, and elsewhere.
OFFSETS = [(0.0, 0.0), (0.31, 0.17)]


def pulls_of_ellipse(ratio, n=101):
    """Pull-off of one paraboloid, its apex at each of OFFSETS, by the indenter's own being flat.

    On cells of half a pixel: on whole pixels, ten to the contact's radius, single places lie up to 0.014 too high.
    """
    A = 1 / (2 * RADIUS) / np.sqrt(ratio)
    B = np.sqrt(ratio) / (2 * RADIUS)
    pulls = []
    for offset in OFFSETS:
        x, y = ((np.arange(n) - (n - 1) / 2 + part) * PIXEL for part in offset)
        ds = surfaces.glass_pair(surfaces.scan(-(A * x[:, None] ** 2 + B * y[None, :] ** 2), PIXEL), 1e9)
        solution = by_cells(
            ds.isel(x=slice(10, -10), y=slice(10, -10)), delta=[0.25], subregions=([0.0], [0.0]), mesh=2
        )
        pulls.append(float(solution.pull_off_force[0]))
    return np.array(pulls)


@pytest.fixture(scope="module")
def round_pulls():
    return pulls_of_ellipse(1)


@pytest.mark.parametrize("ratio, expected", [(5, 0.981), (10, 0.966)])
def test_ellipses_relative_to_the_sphere(round_pulls, ratio, expected):
    relative = pulls_of_ellipse(ratio) / round_pulls
    np.testing.assert_allclose(relative, expected, atol=0.01)


@pytest.mark.parametrize("parameter, refine", [(0.5, 1), (1.0, 2), (2.0, 4)])
def test_dugdale_pulls_off_as_maugis(parameter, refine):
    ds = flat(1.6 * PIXEL, 53)
    K = 4 / 3 * float(ds.contact_modulus)
    strength = parameter / 2 * (np.pi * W * K**2 / RADIUS) ** (1 / 3)
    solution = by_cells(
        ds.assign_coords(adhesion_range=W / strength),
        delta=[-1, 0.3],
        subregions=at((0.31, 0.17), PIXEL),
        law="dugdale",
        mesh=refine,
    )
    expected = np.pi * W * RADIUS * maugis.pull_off(parameter)
    assert float(solution.pull_off_force[0]) == pytest.approx(expected, rel=0.02)


#: Largest pull, GPa.
STRENGTH = 0.8


def test_exponential_law_lies_between_the_limits():
    ds = flat(3 * PIXEL, 31).assign_coords(adhesion_range=W / STRENGTH)
    solution = by_cells(ds, delta=[-1, 0.3], law="exponential", mesh=roughxr.Mesh(1, step=0.5))
    pull = float(solution.pull_off_force[0]) / (np.pi * W * RADIUS)
    assert 1.5 < pull < 2.0


def test_energy_is_kept_but_in_jumps():
    ds = flat(3 * PIXEL, 31).assign_coords(adhesion_range=W / STRENGTH)
    delta = np.arange(-4, 4.01, 0.125)
    solution = by_cells(
        ds,
        delta=delta,
        law="exponential",
        datum="first_contact",
        mesh=roughxr.Mesh(1, step=0.125),
        fields=True,
    )
    back = solution.isel(subregion=0).sel(branch="retraction").sortby("delta", ascending=False)
    elastic = 0.5 * (back.pressure * back.displacement).sum(("x", "y")) * (3 * PIXEL) ** 2
    dx = float(ds.x[1] - ds.x[0])
    w = float(ds.work_of_adhesion)
    surface_energy = w * np.exp(-STRENGTH * back.gap.clip(min=0) / w) * dx**2
    energy = (elastic - surface_energy.where(back.gap.notnull()).sum(("x", "y"))).values
    work = np.append(0.0, np.cumsum(0.5 * (back.force.values[1:] + back.force.values[:-1]) * np.diff(back.delta)))
    lost = work - (energy - energy[0])
    turnover = np.ptp(energy)
    held = back.contact_area.values > 0
    assert 20 < held.sum() < held.size  # it ends within the sweep
    np.testing.assert_allclose(lost[held], 0, atol=0.01 * turnover)
    np.testing.assert_allclose(lost, back.dissipated.values - back.dissipated.values[0], atol=0.01 * turnover)


@pytest.mark.parametrize("law", [{}, {"law": "dugdale"}])
def test_without_adhesion_it_is_the_elastic_contact(law, monkeypatch):
    ds = surfaces.glass_pair(surfaces.scan(surfaces.rough(64, rms=2.0), PIXEL))
    ds["work_of_adhesion"] = 0.0
    delta = [3.0, 6.0, 9.0]
    adhering = by_cells(ds, delta=delta, mesh=roughxr.Mesh(1, step=1.0), **law).force
    monkeypatch.setitem(displacement_control.sweep_arrays.__kwdefaults__, "tolerance", 1e-9)
    elastic = direct(ds, delta=delta).force
    for branch in ("loading", "retraction"):
        np.testing.assert_allclose(adhering.sel(branch=branch), elastic, rtol=1e-6, atol=1e-6)


@pytest.fixture(scope="module")
def ground():
    return surfaces.glass_pair(surfaces.scan(surfaces.rough(80, rms=1.0, smooth=5.0, seed=3), PIXEL))


def quiet(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return by_cells(*arguments, **options)


@pytest.mark.parametrize("step", [0.5, 0.25, 0.1])
@pytest.mark.parametrize("modulus", [40, 300])
def test_a_stiff_summit_loses_nothing_and_snaps_in_with_its_pull_off_at_any_step(modulus, step):
    x = (np.arange(33) - 16) * 2.0
    summit = surfaces.scan(-(x[:, None] ** 2 + x**2) / 200.0, 2.0)
    pair = summit.contact.assign_pair(sphere_radius=500, contact_modulus=modulus, work_of_adhesion=0.06)
    cycle = adhesive(pair, law="exponential", mesh=roughxr.Mesh(2, step=step))
    assert 0 <= float(cycle.hysteresis[0]) < 0.01 * float(cycle.work_of_separation[0])
    assert float(cycle.snap_in_force[0]) == pytest.approx(float(cycle.pull_off_force[0]), rel=0.01)


def test_rough_contact_keeps_its_order_of_events(ground):
    solution = quiet(ground, delta=np.arange(0.0, 9.0), subregions=(2, 1))
    assert (solution.detachment_delta <= solution.pull_off_delta).all()
    assert (solution.detachment_delta <= solution.snap_in_delta).all()
    assert (solution.hysteresis > 0).all()
    assert (solution.work_of_separation > 0).all()
    excess = solution.force.sel(branch="retraction") - solution.force.sel(branch="loading")
    assert float(excess.max()) < 0.02 * PULL


def bump(shift=0, n=61, pixel=6.0, radius=500.0):
    """One asperity, all heights moved by so many pixels against axes that stay."""
    x = (np.arange(n) - (n - 1) / 2) * pixel
    height = -((x - shift * pixel)[:, None] ** 2 + x[None, :] ** 2) / (2 * radius)
    return surfaces.glass_pair(surfaces.scan(height, pixel))


@surfaces.unpressed()
@pytest.mark.parametrize("material", [{"work_of_adhesion": 1.35, "contact_modulus": 39.4}, {"materials": "glass"}])
def test_the_step_does_not_decide_the_pull_off(material):
    """Contacts let go within a small part of a step: the largest pull is found all the same.

    Retraction must not be content with what the approach pulled, nor with the first state beyond a contact's end.
    """
    glass = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, adhesion_range=0.3, **material)
    places = ([833.0, 2500.0], [833.0, 4167.0])
    meshes = roughxr.Mesh(2, step=0.4), roughxr.Mesh(2, step=0.1)
    pulls = [glass.contact.adhesive(subregions=places, mesh=mesh).pull_off_force for mesh in meshes]
    np.testing.assert_allclose(*pulls, rtol=0.03)


@surfaces.unpressed()
@pytest.mark.parametrize("step", [0.25, 0.4])
def test_without_range_a_preload_between_two_steps_is_met(step):
    """A smooth sphere settles at JKR's displacement of no load, and pulls off as JKR's, whatever the step.

    By the larger step it pulls 2.1, 1.0 and 0.7 % too much on cells of a half, a third and a quarter of a pixel.
    """
    flat = surfaces.scan(np.zeros((64, 64)), 8.0).contact.assign_pair(
        sphere_radius=1500, contact_modulus=40, work_of_adhesion=0.2
    )
    middle = ([float(flat.x[32])], [float(flat.y[32])])
    cycle = flat.contact.adhesive(subregions=middle, law="jkr", mesh=roughxr.Mesh(4, step=step))
    radius = (6 * np.pi * 0.2 * 1500**2 / (4 / 3 * 40)) ** (1 / 3)  # of the contact without load, 6πwR² = K a³
    assert bool(cycle.complete[0])
    assert float(cycle.preload_delta[0]) == pytest.approx(radius**2 / (3 * 1500), rel=0.03)
    assert float(cycle.pull_off_force[0]) == pytest.approx(1.5 * np.pi * 0.2 * 1500, rel=0.01)


def test_a_rough_scan_moved_turned_or_larger_is_the_same():
    height = surfaces.rough(90, rms=1.0, smooth=5.0, seed=3)

    def pull(part, x=0.0, y=0.0):
        ds = surfaces.glass_pair(surfaces.scan(part, PIXEL))
        ds["height"] = ds.height - height.max()
        solution = quiet(ds, delta=[2.0], subregions=([x * PIXEL], [y * PIXEL]), datum="first_contact")
        return float(solution.pull_off_force[0])

    plain = pull(height[10:-10, 10:-10])
    assert pull(height[11:-9, 10:-10], x=-1) == pytest.approx(plain, rel=0.01)
    assert pull(np.rot90(height[10:-10, 10:-10])) == pytest.approx(plain, rel=0.01)
    assert pull(height) == pytest.approx(plain, rel=0.01)


@pytest.mark.parametrize("refine", [1, 2])
def test_fields_hold_the_contact(refine):
    """Forces beside fields are their sums, by the steeper edge: 6 % (4 % on half pixels) from the extrapolated ones."""
    ds = bump(n=31)
    centres = ([0.0, 9.0], [0.0, 4.0])
    options = {"delta": [0.0, 0.5], "subregions": centres, "mesh": roughxr.Mesh(refine, step=0.5)}
    cycle = quiet(ds, **options, fields=True)
    bare = quiet(ds, **options)
    off = (abs(cycle.force - bare.force) / bare.pull_off_force).max(("branch", "delta"))
    assert 0 < float(off.max()) < 0.07
    for name in ("pull_off_force", "pull_off_error", "hysteresis"):
        np.testing.assert_array_equal(cycle[name], bare[name])
    dx = float(cycle.x[1] - cycle.x[0])
    assert dx == pytest.approx(6.0 / refine)
    np.testing.assert_allclose(cycle.pressure.sum(("x", "y")) * dx**2, cycle.force, rtol=1e-9)
    assert float(cycle.gap.min()) > -5e-6
    pressed = cycle.pressure.values > 1e-3
    assert pressed.any()
    np.testing.assert_allclose(cycle.gap.values[pressed], 0, atol=5e-6)
    lazy = quiet(ds.chunk(x=12, y=20), **options, fields=True)
    xr.testing.assert_allclose(lazy.compute().drop_attrs(), cycle.drop_attrs())


def test_refining_finds_the_sphere_again():
    # an asperity whose contact is a pixel wide, as the scan itself: splines carry its shape to finer cells
    n = 21
    radius = 100.0
    x = (np.arange(n) - (n - 1) / 2 + 0.31) * PIXEL
    ds = surfaces.glass_pair(surfaces.scan(-(x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius), PIXEL), 1e9)
    pull = 1.5 * np.pi * W * radius
    error = {}
    for refine in (1, 8):
        solution = quiet(ds, delta=[-1.0, 0.1], mesh=refine, datum="first_contact")
        error[refine] = abs(float(solution.pull_off_force[0]) / pull - 1)
    assert solution.attrs["interpolation"] == "band-limited"
    assert error[8] < 0.02
    assert error[8] < error[1]


def test_poor_resolution_is_said():
    ds = surfaces.glass_pair(surfaces.scan(surfaces.rough(64, rms=3.0, smooth=1.0), PIXEL))
    with pytest.warns(UserWarning, match="mesh"):
        by_cells(ds, delta=[5.0], mesh=roughxr.Mesh(1, step=1.0))


def test_too_many_cells_are_said(ground, monkeypatch):
    monkeypatch.setattr("roughxr.mechanics.contact.cycle.MOST_CELLS", 50)
    with pytest.warns(UserWarning, match="needed more than .* cells"):
        solution = by_cells(ground, delta=[8.0], mesh=roughxr.Mesh(1, step=1.0))
    assert not bool(solution.complete[0])
    assert np.isnan(solution.pull_off_force[0])
    assert np.isnan(solution.force.sel(branch="retraction")).all()


@pytest.mark.parametrize(
    "options, message",
    [
        ({"law": "hertz"}, "law: expected one of 'auto', .*found 'hertz'; only superpose"),
        ({"law": "dugdale"}, "cells of at most .* take law='exponential'"),
        ({"mesh": 0}, "mesh"),
        ({"mesh": 1.5}, "mesh"),
        ({"datum": "lowest"}, "datum"),
    ],
)
def test_what_is_refused(ground, options, message):
    with pytest.raises(ValueError, match=message):
        by_cells(ground, delta=[1.0], **options)


@pytest.mark.parametrize("options", [{"step": -1.0}, {"accuracy": 2.0}, {"cells": "fine"}])
def test_a_mesh_is_refused_where_it_is_made(options):
    with pytest.raises(ValueError, match=r"step|accuracy|mesh"):
        roughxr.Mesh(**options)


def test_work_of_adhesion_is_needed(ground):
    with pytest.raises(ValueError, match="work_of_adhesion"):
        by_cells(ground.drop_vars("work_of_adhesion"), delta=[1.0])


@surfaces.unpressed()
@pytest.mark.filterwarnings("ignore::roughxr.IncompleteResult")
def test_warnings_count_places_and_not_their_preloads():
    ds = surfaces.glass_pair(surfaces.scan(surfaces.rough(64, seed=1)), sphere_radius=500.0)
    with pytest.warns(roughxr.UnresolvedContact, match="of 3 subregions have contacts with a radius below 2"):
        adhesive(ds, preload=[0, 5], subregions=(1, 3), mesh=1, law="jkr")
