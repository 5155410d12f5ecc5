"""Rolling off: the moment that asperities hold, against closed forms of one, two and many of them."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

import roughxr
from roughxr.mechanics.asperity import moments
from roughxr.mechanics.contact import levers
from roughxr.mechanics.contact.adhesion import adhesive_and_moments
from roughxr.mechanics.kernels.asperity import jkr, maugis
from roughxr.mechanics.kernels.topography import interpolation

from .surfaces import glass_pair, rough, scan, unpressed
from .test_identities import places
from .verb_calls import surface

#: A flat sphere over asperities of this radius: its own curvature changes theirs by 1e-7.
SPHERE = 1e9
RADIUS = 100.0


def ground(x, y, *, height=0.0, w=0.1, modulus=39.4):
    """Return a catalogue of equal spherical asperities."""
    x = np.atleast_1d(x).astype(float)
    y = np.atleast_1d(y).astype(float)
    curvature = np.full(x.size, 1 / RADIUS - 1 / SPHERE)
    edge = np.ptp(np.r_[x, y]) + 1.0
    values = {
        "height": np.broadcast_to(np.asarray(height, float), x.shape),
        "curvature_min": curvature,
        "curvature_max": curvature,
        "orientation": np.zeros(x.size),
    }
    scalars = {"sphere_radius": SPHERE, "contact_modulus": modulus, "work_of_adhesion": w, "patch_radius": 50.0}
    scalars |= {"datum_height": float(np.max(height)), "scan_x_min": -edge, "scan_x_max": edge}
    scalars |= {"scan_y_min": -edge, "scan_y_max": edge}
    coords = {"x": ("asperity", x), "y": ("asperity", y), **scalars}
    return xr.Dataset({name: ("asperity", array) for name, array in values.items()}, coords)


def at_origin(catalogue, **options):
    """Roll a sphere off asperities about its axis."""
    return roughxr.rolling(catalogue, subregions=([0.0], [0.0]), **options).isel(subregion=0)


def units(w=0.1, modulus=39.4):
    return jkr.self_similar_units(0.5 / RADIUS, 0.5 / RADIUS, modulus, w)


def test_one_asperity_holds_what_a_jkr_sphere_holds_at_its_edge():
    unit = units()
    held = at_origin(ground(0, 0))
    closed = 15 / 16 * 1.25 ** (2 / 3)
    np.testing.assert_allclose(held.resisting_moment / (unit.P * unit.a), closed, rtol=2e-4)
    np.testing.assert_allclose(held.hinge_distance / unit.a, 1.25 ** (2 / 3), rtol=0.02)
    np.testing.assert_allclose(held.lever / unit.a, closed, rtol=2e-4)
    np.testing.assert_allclose(held.tipping_force / unit.P, 1.0, rtol=2e-4)  # pulled at its middle it lets go at P_c
    np.testing.assert_allclose(held.tipping_hinge_distance / unit.a, 1.0, rtol=0.03)


def test_two_asperities_hold_the_textbook_lever():
    held = at_origin(ground([-5000, 5000], [0, 0]), directions=[0.0, np.pi / 2])
    along, across = held.resisting_moment.values / units().P
    assert along == pytest.approx(10_000, rel=2e-3)  # the rear one's pull times their distance, and the front contact's
    assert across == pytest.approx(2 * 1.087872 * units().a, rel=1e-3)  # side by side: twice one
    assert float(held.stiffest_direction) == 0.0 and float(held.weakest_direction) == np.pi / 2


def test_many_equal_asperities_on_a_ring():
    """The same turn done as an integral over the ring, of JKR's closed form."""
    n = 240
    ring = 1e5
    angle = 2 * np.pi * np.arange(n) / n
    held = at_origin(ground(ring * np.cos(angle), ring * np.sin(angle)), directions=[0.0])
    start = jkr.displacement(2 ** (2 / 3))

    def moment(turn):
        def integrand(at):
            delta = start - turn * (1 - np.cos(at))
            return -jkr.load(jkr.stable_semi_axis(delta)) * (1 - np.cos(at)) if delta > jkr.END_DELTA else 0.0

        last = np.arccos(np.clip(1 - (start - jkr.END_DELTA) / turn, -1, 1))
        return quad(integrand, 0, last)[0] / np.pi

    largest_moment = -minimize_scalar(lambda turn: -moment(turn), bounds=(0.4, 0.9), method="bounded").fun
    assert 0.75 < largest_moment < 1.0  # brittle springs, a constant pull
    assert float(held.resisting_moment[0]) / (n * units().P * ring) == pytest.approx(largest_moment, rel=3e-3)


def test_without_adhesion_it_tips_about_the_edges_of_the_support_polygon():
    load = 2.0
    corners = np.array([[600.0, 0.0], [-300.0, 500.0], [-300.0, -500.0]])
    held = at_origin(ground(*corners.T, modulus=1e6, w=0.0), normal_force=load, directions=72)
    e = np.stack([np.cos(held.direction), np.sin(held.direction)])
    support = (corners @ e).max(axis=0)
    np.testing.assert_allclose(held.resisting_moment / load, support, atol=1.0)
    assert held.lever.isnull().all() and np.isnan(held.pull_off_force)


def test_weight_and_adhesion_add():
    far = ground([-5000, 5000], [0, 0])
    without, with_load = (at_origin(far, directions=[0.0], normal_force=load) for load in (0.0, 3.0))
    gained = float(with_load.resisting_moment[0] - without.resisting_moment[0])
    assert gained == pytest.approx(3.0 * 5000, rel=5e-3)  # and a load widens the front contact, by its part of 5000 nm


def test_a_turned_ground_turns_its_rose():
    surface = glass_pair(scan(rough(64, seed=3), pixel=20.0))
    places = ([0.0, 100.0], [50.0, -100.0])
    held = surface.contact.rolling(directions=8, subregions=places)
    turned = surface.assign(height=surface.height.copy(data=np.rot90(surface.height.values)))
    x, y = np.array(places)
    rose = turned.contact.rolling(directions=8, subregions=(-y, x)).resisting_moment
    np.testing.assert_allclose(np.roll(held.resisting_moment, 2, axis=1), rose, rtol=1e-6)


def test_rounding_does_not_decide_whether_an_asperity_at_the_end_of_its_branch_holds():
    """Heights raised by 0.37 nm moved the tipping force of one place from 195 to 158 nN."""
    pulls = []
    for by in (0.0, 0.37, -1.0):
        ds = surface(46).assign(height=surface(46).height + by)
        pulls.append(roughxr.rolling(ds, directions=8, subregions=places(46)).tipping_force.values)
    for other in pulls[1:]:
        np.testing.assert_allclose(other, pulls[0], rtol=1e-6)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_isotropic_ground_has_an_isotropic_rose_and_a_stretched_one_has_not():
    roses = []
    for stretch in (1, 6):
        height = np.repeat(rough(96, rms=1.0, seed=5), stretch, axis=0)[:96]
        surface = glass_pair(scan(height, pixel=10.0), sphere_radius=1000.0)
        moment = surface.contact.rolling(directions=8, subregions=(6, 6)).resisting_moment
        moment = moment / moment.mean("direction")
        mean = moment.mean("subregion")
        error = moment.std("subregion") / np.sqrt(36)
        roses.append(float(np.abs((mean - 1) / error).max()))
    assert roses[0] < 3.5
    assert roses[1] > roses[0]


def test_the_pull_off_is_that_of_the_map_and_nothing_is_nan():
    surface = glass_pair(scan(rough(48, seed=1)))
    held = surface.contact.rolling(directions=4, subregions=(2, 2))
    expected = surface.contact.pull_off_map(subregions=(2, 2))
    xr.testing.assert_allclose(held.pull_off_force.drop_attrs(), expected.pull_off_force.drop_attrs())
    pushed = surface.contact.rolling(directions=4, subregions=(2, 2), normal_force=500.0)
    for at_rest, load in ((held, 0.0), (pushed, 500.0)):
        swept = surface.contact.superpose(delta=[float(at_rest.rest_delta[0])], subregions=(2, 2))
        assert float(swept.force[0, 0]) == pytest.approx(load, abs=1e-3 * float(held.pull_off_force[0]))
        assert int(swept.contacts[0, 0]) == int(at_rest.contacts[0])
    lazy = surface.chunk(x=16).contact.rolling(directions=4, subregions=(2, 2))
    assert lazy.chunks  # which places are on debris is known of heights in memory only
    xr.testing.assert_allclose(lazy.compute(), held.drop_vars(["on_debris", "debris_share"]))


@pytest.mark.parametrize("pixel, cells, error", [(10.0, 48, 0.02), (5.0, 96, 0.03)])
def test_states_of_the_simulation_hold_a_jkr_spheres_moment(pixel, cells, error):
    """The front of the contact lies within a cell of where it is found; states stand half a nanometre apart."""
    surface = glass_pair(scan(np.zeros((cells, cells)), pixel=pixel))
    deltas = [-6.0, -2.0, -1.0, -0.5, 0.0, 1.0]  # at the first it has come off
    states = surface.contact.adhesive(delta=deltas, mesh=roughxr.Mesh(1, step=1.0), law="jkr", fields=True)
    held = states.contact.rolling(directions=8).isel(subregion=0)
    pair = {name: float(surface[name]) for name in roughxr.schema.PAIR}
    pull, a = reference_sphere(**pair)
    ratio = held.resisting_moment / (pull * a)
    assert float(ratio.mean()) == pytest.approx(1.0879, rel=error)
    assert (abs(ratio - 1.0879) < pixel / a).all()
    assert (held.lever > 0).all()
    symmetric = ratio.values.reshape(4, 2)  # by symmetry every second direction is the same, but for rounding
    np.testing.assert_allclose(symmetric, np.broadcast_to(symmetric[0], (4, 2)), rtol=1e-6)
    assert bool(held.weakest_ties) and bool(held.stiffest_ties)
    ends = np.deg2rad([0.0, 45.0])
    assert {float(held.weakest_direction), float(held.stiffest_direction)} == set(ends)  # the first of those that tie
    back = states.sel(branch="retraction").isel(subregion=0)
    assert back.contact_area[0] == 0 == back.force[0]  # the nearest to no load, but no rest
    touching = back.isel(delta=slice(1, None))
    assert float(held.contact_area) == float(touching.contact_area[int(np.abs(touching.force.values).argmin())])


@unpressed()
def simulated_levers(ds, law, cells):
    """Return the moments of the simulation at the middle of a scan, from the pull-off on one mesh."""
    middle = ([float(ds.x.mean())], [float(ds.y.mean())])
    mesh = roughxr.Mesh(cells, accuracy=None)
    return adhesive_and_moments(ds, subregions=middle, law=law, mesh=mesh, directions=24)[1]


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.parametrize("preload", [0.0, 300.0])
def test_moments_do_not_change_the_pull_off_nor_its_change_by_pressing(preload):
    how = {"subregions": (2, 1), "mesh": 2, "preload": preload}
    ground = glass_pair(scan(rough(48, rms=3.0), 20.0), 500)
    alone = ground.contact.adhesive(**how)
    solved, moments = adhesive_and_moments(ground, directions=6, **how)
    xr.testing.assert_equal(solved, alone)
    np.testing.assert_allclose(moments.resisting_moment, moments.lever * alone.pull_off_force, rtol=1e-12)
    assert (moments.lever_error > 0).all()


def test_moments_are_of_one_preload():
    with pytest.raises(ValueError, match="preload: expected one number"):
        adhesive_and_moments(glass_pair(scan(rough(48))), directions=6, preload=[0.0, 5.0])
    with pytest.raises(ValueError, match="directions"):
        adhesive_and_moments(glass_pair(scan(rough(48))), directions=0)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.parametrize(
    ("pixel", "cells", "others"),
    [(15.0, 8, [(4, True)]), (15.0, 2, [(8, False), (4, True)]), (1.0, 2, [(1, False)]), (1.0, 1, [(2, False)])],
)
def test_the_error_of_a_lever_takes_one_other_solution(monkeypatch, pixel, cells, others):
    """Cells and whether by splines: of twice the size, after finer ones where the pull-off's are too large."""
    solved = []

    def counted(surface, problem, *options, **how):
        solved.append((problem.refine, problem.splined))
        return cycles_on(surface, problem, *options, **how)

    cycles_on = levers.cycles_on
    monkeypatch.setattr(levers, "cycles_on", counted)
    simulated_levers(bump(pixel), "auto", cells)
    assert solved == others


def bump(pixel, *, part=(0.0, 0.0), half=30.0, radius=100.0, modulus=40.0, work=0.06, **pair):
    """Return one summit under a plane, its middle off a pixel's by parts of it."""
    n = 2 * int(half / pixel) + 25
    x, y = (pixel * (np.arange(n) - n // 2 - along) for along in part)
    surface = scan(np.maximum(-(x[:, None] ** 2 + y**2) / (2 * radius), -20.0), pixel)
    return surface.contact.assign_pair(sphere_radius=1e6, contact_modulus=modulus, work_of_adhesion=work, **pair)


@pytest.mark.parametrize(("cells", "part"), [(2, (0.0, 0.0)), (3, (0.3, 0.4))])
def test_the_lever_of_a_contact_without_range_is_that_of_a_jkr_sphere(cells, part):
    """So many pixels of two cells to the contact's radius."""
    radius = (9 * np.pi * 0.1 * 1000**2 / (8 * 1.0)) ** (1 / 3)
    surface = bump(radius / cells, part=part, half=2.5 * radius, radius=1000.0, modulus=1.0, work=0.1)
    moments = simulated_levers(surface, "jkr", 2)
    lever = moments.lever / (1.087872 * radius)
    np.testing.assert_allclose(lever, 1.0, atol=0.06)
    on_cells = cells * int(moments.mesh[0])
    assert abs(float(lever.mean()) - 1) < min(0.2 / on_cells, float(moments.lever_error[0]))


@pytest.mark.parametrize(("parameter", "cells"), [(0.3, 4), (1.0, 8)])
def test_the_lever_of_a_contact_with_a_range_is_that_of_maugis_and_dugdale(parameter, cells):
    """The largest −P a along the branch in closed form."""
    radius = 300.0
    modulus = 40.0
    work = 0.1
    unit = jkr.self_similar_units(0.5 / radius, 0.5 / radius, modulus, work)
    strength = 0.5 * parameter * (np.pi * work * (4 / 3 * modulus) ** 2 / radius) ** (1 / 3)
    force, contact, _ = maugis.contact_at(parameter, maugis.ratios())
    expected = unit.a * (-force * contact).max() / -force.min()
    options = {"half": 2.5 * unit.a, "radius": radius, "work": work, "adhesion_range": work / strength}
    moments = simulated_levers(bump(2 * unit.a / cells, part=(0.3, 0.4), **options), "dugdale", 2)
    assert float(moments.lever.mean()) == pytest.approx(expected, rel=0.05)
    np.testing.assert_allclose(moments.lever[0], expected, atol=float(moments.lever_error[0]) * expected)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_levers_of_a_summit_depend_neither_on_the_pixels_nor_on_its_place_on_them_beyond_their_errors():
    """Between DMT's lever, the largest (2πwR − 4E*a³/3R) a over 2πwR, and JKR's; pixels wider than the contact."""
    reference = simulated_levers(bump(1.0), "auto", 2)
    expected = float(reference.lever.mean())
    dmt = 0.75 * (3 * np.pi * 0.06 * 100**2 / (8 * 40)) ** (1 / 3)
    assert dmt < expected < 1.087872 * (9 * np.pi * 0.06 * 100**2 / (8 * 40)) ** (1 / 3)
    cases = [(4.0, 2, (0.0, 0.0)), (4.0, 2, (0.5, 0.0)), (7.6, 1, (0.0, 0.0)), (7.6, 8, (0.0, 0.0))]
    for pixel, cells, part in cases:
        moments = simulated_levers(bump(pixel, part=part), "auto", cells)
        error = float(moments.lever_error[0])
        assert error < 0.5
        np.testing.assert_allclose(moments.lever[0], expected, rtol=error + float(reference.lever_error[0]))


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_places_that_lie_unequally_on_the_pixels_resist_as_each_alone():
    surface = glass_pair(scan(np.zeros((41, 41)), pixel=10.0))
    x = np.array([200.0, 203.0])
    y = np.array([200.0, 198.0])
    options = {"delta": [-1.0, 0.0, 1.0], "mesh": roughxr.Mesh(1, step=1.0), "law": "jkr", "fields": True}
    together = surface.contact.adhesive(subregions=(x, y), **options).contact.rolling(directions=4)
    for k in range(2):
        alone = surface.contact.adhesive(subregions=(x[k : k + 1], y[k : k + 1]), **options).contact.rolling(
            directions=4
        )
        np.testing.assert_allclose(together.hinge_distance[k], alone.hinge_distance[0], rtol=1e-9)
        np.testing.assert_allclose(together.resisting_moment[k], alone.resisting_moment[0], rtol=1e-6)


def test_an_even_load_on_cells_resists_as_on_the_area_that_they_cover():
    """A line of n cells that pull with P each: about the front of a single cell, P times the radius of its disc."""
    cell = 4.0
    pull = 3.0
    angles = [0.0, np.pi / 2]
    for n in (1, 3):
        push = np.full((n, 1), -pull)
        footprint = moments.footprint(push, push < 0, cell * np.arange(n), np.zeros(1), cell, angles)
        resisting = np.array([[-np.inf], [np.nan], [-np.inf], [np.nan]]) * np.ones(2)
        radius = cell / np.sqrt(np.pi)
        moments._include_state(footprint, angles, 0.0, resisting)
        along = quad(lambda u: u, 0.0, n * cell)[0] * pull / cell  # squares end to end, about the end of the line
        front = radius * n ** (-1 / 6)
        expected = [along + n * pull * (front - cell / 2), n * pull * front]
        np.testing.assert_allclose(resisting[0], expected, rtol=1e-12)


def test_directions_that_tie_are_told_whatever_the_rounding():
    lone = at_origin(ground(0, 0), directions=8)
    assert bool(lone.weakest_ties) and bool(lone.stiffest_ties) and float(lone.weakest_direction) == 0.0
    three = at_origin(ground([600.0, -300.0, -200.0], [0.0, 500.0, -450.0]), directions=[0.0, 1.0, 2.5])
    assert not three.weakest_ties and not three.stiffest_ties
    rounded = np.array([2.0, 1.0, 3.0, 1.0]) * (1 + 1e-12 * np.random.default_rng(0).normal(size=(20, 4)))
    assert (moments.weakest(rounded)[0] == 1).all() and moments.weakest(rounded)[1].all()


def test_the_state_at_rest_is_the_first_of_the_retraction_and_not_a_last_thread():
    """Forces on the way out, from the deepest (last) on: rest lies between 8 and −9; near its end a thread pulls −1."""
    area = np.array([0.0, 5.0, 60.0, 80.0, 90.0])
    force = np.array([0.0, -1.0, -9.0, 8.0, 30.0])
    assert moments._state_at_rest(area, force, 0.0) == 3
    assert moments._state_at_rest(area, force, -6.0) == 2
    assert moments._state_at_rest(area, force, 50.0) == 4  # never as heavy
    assert moments._state_at_rest(0 * area, 0 * force, 0.0) is None


def reference_sphere(sphere_radius, contact_modulus, work_of_adhesion):
    """Return JKR's P_c (nN) and a_c (nm) of a sphere on a flat."""
    unit = jkr.self_similar_units(0.5 / sphere_radius, 0.5 / sphere_radius, contact_modulus, work_of_adhesion)
    assert unit.P == pytest.approx(1.5 * np.pi * work_of_adhesion * sphere_radius)
    return unit.P, unit.a


def test_a_place_without_contact_is_missing_and_says_why():
    far = ground([-5000, 5000], [0, 0], w=0.0)
    with pytest.raises(ValueError, match="expected a positive force"):
        at_origin(far)
    saddles = ground(0, 0).assign(curvature_min=("asperity", [-1.0]), curvature_max=("asperity", [-1.0]))
    held = at_origin(saddles)
    assert np.isnan(held.resisting_moment).all() and np.isnan(held.weakest_direction) and held.contacts == 0
    assert "NaN where nothing is in contact" in held.attrs["missing"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"directions": 0}, "directions: expected a whole number of at least 1"),
        ({"directions": 24.0}, "directions: expected their number, a whole one"),
        ({"directions": "24"}, "directions: expected their number, a whole one"),
        ({"directions": [1.0, 0.0]}, "directions: expected ascending"),
        ({"normal_force": np.nan}, "normal_force: expected finite"),
    ],
)
def test_bad_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        at_origin(ground(0, 0), **options)


def test_a_solution_without_fields_is_refused():
    surface = glass_pair(scan(rough(32, seed=1)))
    with pytest.raises(ValueError, match="fields=True"):
        surface.contact.superpose(delta=[0.0, 1.0]).contact.rolling()
    with pytest.raises(ValueError, match="fields=True"):
        surface.contact.superpose(delta=[0.0, 1.0]).contact.pull_off().contact.rolling()


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@unpressed()
def test_the_error_of_a_lever_contains_the_heights_between_the_pixels(monkeypatch):
    """On roughness as fine as the pixels, other heights between them move a lever by most of its mean."""
    surface = roughxr.scans.synthetic.self_affine((80, 80), 16.0, rms=2, hurst=0.8, rolloff=400, cutoff=18, seed=51)
    pair = surface.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0.06)
    options = {"subregions": (3, 1), "mesh": 2, "directions": 12}
    _, moments = adhesive_and_moments(pair, **options)
    monkeypatch.setattr("roughxr.mechanics.contact.problem.band_limited", interpolation.splined)
    _, splined = adhesive_and_moments(pair, **options)
    change = abs(splined.lever - moments.lever).max("direction") / abs(moments.lever).mean("direction")
    assert (moments.lever_error > 0.75 * change).all() and float(change.max()) > 0.7
