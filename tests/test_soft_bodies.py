"""Soft bodies: attraction that acts across gaps on loading, and lengths that follow the body's own."""

import time
import warnings

import numpy as np
import pytest
import xarray as xr
from scipy import special

import roughxr
from roughxr.mechanics.contact import adhesive_options, refinement
from roughxr.mechanics.contact.adhesive_options import snap_in_gap
from roughxr.mechanics.contact.estimates import median_tabor
from roughxr.mechanics.contact.mesh import UnresolvedContact
from roughxr.mechanics.contact.refinement import coarser_mesh_error
from roughxr.mechanics.kernels.adhesion import path
from roughxr.mechanics.specimen import specimen_of
from roughxr.mechanics.statistics.means import mesh_error
from tests import surfaces
from tests.closed_forms import wide_contact_pull_off

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")


def rough(seed=1, **pair):
    """Return a soft rough surface; the first contact of the first seed is one low summit at its last place."""
    made = roughxr.scans.synthetic.self_affine((64, 64), 20.0, rms=12, hurst=0.8, rolloff=640, cutoff=80, seed=seed)
    return made.contact.assign_pair(**({"sphere_radius": 2000, "contact_modulus": 0.3, "work_of_adhesion": 0.1} | pair))


@surfaces.unpressed()
def test_a_soft_body_settles_beyond_its_first_summit():
    """Without a preload it pulls off as after one; with contacts alone it pulled 7 times less."""
    place = {"subregions": ([840.0], [840.0]), "law": "jkr"}
    solution = rough().contact.adhesive(mesh=roughxr.Mesh(2, step=0.5), **place)
    pressed = rough().contact.adhesive(mesh=roughxr.Mesh(2, None, 0.5), preload=20.0, **place)
    assert solution.pull_off_force.values == pytest.approx(pressed.pull_off_force.values, rel=0.02)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_a_sphere_that_attraction_leaves_on_its_first_summit_has_a_range(monkeypatch):
    """Without attraction across gaps it ends at the pull-off after a preload, and is no error of the lower end."""
    monkeypatch.setattr(adhesive_options, "snap_in_gap", lambda length, parameter: 0.0)
    ds = rough()
    place = {"subregions": ([840.0], [840.0]), "law": "jkr"}
    with pytest.warns(UserWarning, match="1 of 1 subregions have a range .*: state a preload"):
        settled = ds.contact.adhesive(mesh=roughxr.Mesh(2, step=0.5), **place)
    pressed = ds.contact.adhesive(mesh=roughxr.Mesh(2, None, 0.5), preload=20.0, **place)
    assert float(pressed.pull_off_force[0]) > 2 * float(settled.pull_off_force[0])
    assert settled.pressed_pull_off_force.values == pytest.approx(pressed.pull_off_force.values, rel=0.05)
    assert float(settled.pull_off_error[0]) <= 0.5


@pytest.mark.filterwarnings("ignore:.*contacts with a radius below:UserWarning")
@pytest.mark.filterwarnings("ignore:1 of 1 subregions have a range:UserWarning")  # by the exponential law, too
def test_a_pull_off_that_depends_on_pressing_is_a_range_with_its_reason():
    """The exponential law leaves this sphere on its first summit by a short range, and not by a longer one.

    Pressed as hard as it holds on one summit, the sphere holds eight times more, and no more when pressed once again.
    """
    ds = rough(seed=2)
    place = {"subregions": ([1066.7], [213.3])}
    mesh = roughxr.Mesh(2, step=0.5)
    with pytest.warns(UserWarning, match="only pressing reaches: state a preload"):
        settled = ds.contact.adhesive(mesh=mesh, law="jkr", **place)
    low = float(settled.pull_off_force[0])
    high = float(settled.pressed_pull_off_force[0])
    error = float(settled.pull_off_error[0])
    summits = []
    for cells, length in ((8, 0.92), (2, 1.83)):
        ranged = ds.assign_coords(adhesion_range=length)
        with surfaces.unpressed():
            solved = ranged.contact.adhesive(law="exponential", mesh=roughxr.Mesh(cells, None, 0.5), **place)
        summits.append(float(solved.pull_off_force[0]))
    assert error <= 0.5 and high > 8 * low
    assert summits == [pytest.approx(low, rel=error), pytest.approx(high, rel=error)]
    again = ds.contact.adhesive(mesh=mesh, law="jkr", preload=high, **place)
    assert again.pull_off_force.values == pytest.approx(high, rel=0.02)


def test_an_answer_states_a_range_by_pressing_as_a_range_and_no_numerical_error():
    """Its mean is 50 nN, or 100 nN if the first place was pressed; the mesh is off by a tenth at both."""
    values = {"pull_off_force": [20.0, 80.0], "pull_off_error": [0.1, 0.1], "pressed_pull_off_force": [120.0, 82.0]}
    pull = xr.Dataset({name: ("subregion", column) for name, column in values.items()})
    answer = roughxr.answer(pull)
    assert mesh_error(pull) == pytest.approx(0.1)
    assert (float(answer.pressed_low), float(answer.pressed_high)) == (50, 100)
    assert answer.pressed_high.units == "nN"
    assert "; 50 … 100 nN, by how hard the sphere was pressed; ± 10 % numerical error)" in answer.sentence
    settled = roughxr.answer(pull.assign(pressed_pull_off_force=("subregion", [25.0, 82.0])))
    assert "pressed_low" not in settled and "how hard" not in settled.sentence


def soft_place(seed, x, y, *, rms, modulus, work, law, radius=2000):
    """Return a scan of 128 pixels under a sphere, by default of 2 µm, and the options of one place."""
    made = roughxr.scans.synthetic.self_affine((128, 128), 20.0, rms=rms, hurst=0.8, rolloff=1000, cutoff=80, seed=seed)
    pair = {"sphere_radius": radius, "contact_modulus": modulus, "work_of_adhesion": work, "adhesion_range": 0.3}
    return made.contact.assign_pair(**pair), {"subregions": ([x], [y]), "law": law}


@surfaces.unpressed()
def test_without_range_more_than_the_last_change_by_the_mesh_is_stated():
    """Cells of half the side change this pull-off by 4 %, the last mesh, its mesh error, by 2 % only."""
    ds, place = soft_place(12, 160.0, 1120.0, rms=12, modulus=0.3, work=0.1, law="jkr")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*heights between the pixels")
        solution = ds.contact.adhesive(mesh=roughxr.Mesh(step=1.0), **place)
    finer = ds.contact.adhesive(mesh=roughxr.Mesh(8, step=1.0), **place)
    change = abs(float(solution.pull_off_force[0] / finer.pull_off_force[0]) - 1)
    assert int(solution.mesh[0]) == 4
    assert 1.5 * float(solution.mesh_error[0]) < change <= float(solution.pull_off_error[0])


@pytest.mark.filterwarnings("ignore:.*heights between the pixels:UserWarning")
@pytest.mark.filterwarnings("ignore:these bodies are soft:UserWarning")
@surfaces.unpressed()
def test_a_law_that_only_the_finest_cells_can_show_has_a_stated_error():
    """Its change from cells twice as large, on which it pulls more; there is no finer mesh to compare with."""
    ds, place = soft_place(21, 160.0, 1760.0, rms=6, modulus=1.0, work=0.05, law="exponential", radius=500)
    solution = ds.contact.adhesive(**place)
    coarse = ds.contact.adhesive(mesh=roughxr.Mesh(8, None), **place)
    assert int(solution.mesh[0]) == 16
    change = float(coarse.pull_off_force[0] / solution.pull_off_force[0]) - 1
    assert 0.02 < change == pytest.approx(float(solution.mesh_error[0]), rel=1e-3)


@surfaces.unpressed()
def test_the_first_cells_fit_the_contacts_and_a_coarse_scan_is_named():
    """A real scan with pixels twice as wide as a smooth sphere's contact: finer cells do not show what lies between."""
    scan = roughxr.open_sample("rough").isel(x=slice(96), y=slice(96)).load()
    ds = scan.contact.assign_pair(sphere_radius=500, materials="glass/silicon")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = ds.contact.adhesive(subregions=(2, 2))
    messages = [str(warning.message) for warning in caught]
    assert (solution.mesh >= 8).all() and float(solution.mesh_error.median()) < 0.05
    missed = int((solution.interpolation_error > 0.05).sum())
    assert missed > 0 and any(
        f"{missed} of 4 subregions miss accuracy=0.05 since the heights between" in message for message in messages
    )


def test_the_gap_of_snapping_in_grows_with_the_range_and_vanishes_with_it():
    """As ρ^{4/7} at a fixed pair, where µ ~ 1/ρ; bodies that do not jump have no such gap."""
    lengths = np.array([1e-9, 1e-8, 1e-7, 1e-6])
    gaps = [snap_in_gap(length, 3.0 / length) for length in lengths]
    np.testing.assert_allclose(np.diff(np.log10(gaps)), 4 / 7, rtol=1e-3)
    assert snap_in_gap(0.3, float("nan")) == snap_in_gap(0.3, 0.6) == 0.0


@pytest.mark.parametrize("tabor", [1.0, 2.0, 5.0, 20.0])
def test_a_sphere_snaps_in_where_its_equations_turn_back(tabor):
    """Rings of a half space under van der Waals attraction, by Newton's method: the least gap on the way to contact.

    Lengths in z₀, radii in √(R z₀): z = 1 + D + r²/2 − µ^{3/2} G t(z), where z is z₀ more than the gap.
    """
    edges = np.linspace(0.0, 14.0, 161)
    r = 0.5 * (edges[1:] + edges[:-1])
    response = tabor**1.5 * np.diff(np.array([_sunk_under_disc(r, a) for a in edges]).T, axis=1)
    z = 20 + 0.5 * r**2
    gap = 19.0
    least = np.inf
    size = r.size
    for middle in np.geomspace(20, 1.1, 300):
        for _ in range(30):
            residual = np.append(z - 1 - gap - 0.5 * r**2 + response @ (8 / 3 * (z**-3 - z**-9)), z[0] - middle)
            slopes = np.zeros((size + 1, size + 1))
            slopes[:size, :size] = np.eye(size) + response * (8 / 3 * (9 * z**-10 - 3 * z**-4))
            slopes[:size, size] = -1.0
            slopes[size, 0] = 1.0
            change = np.linalg.solve(slopes, -residual)
            z = z + change[:size]
            gap = gap + change[size]
            if np.abs(change).max() < 1e-9:
                break
        if gap > least:
            break
        least = gap
    assert snap_in_gap(0.3, tabor) == pytest.approx(0.3 * least, rel=0.01)


def _sunk_under_disc(r, a):
    """Return the displacement at radii r under unit pressure on a disc of radius a, at unit E*."""
    inside = np.clip(r / max(a, 1e-300), 0.0, 1.0) ** 2
    outside = np.clip(a / r, 0.0, 1.0) ** 2
    beyond = r * (special.ellipe(outside) - (1 - outside) * special.ellipk(outside * (1 - 1e-15)))
    return 4 / np.pi * np.where(r <= a, a * special.ellipe(inside), beyond)


def smooth(pixels=61, pixel=20.0):
    """Return a plane under a small soft sphere, on which JKR's contact is larger than the sphere's usual steps."""
    scan = surfaces.scan(np.zeros((pixels, pixels)), pixel)
    return scan.contact.assign_pair(sphere_radius=500, contact_modulus=2e-3, work_of_adhesion=0.05)


def test_a_mesh_of_too_many_cells_names_the_finest_that_is_not():
    """It is refused before anything is solved; the named one is not."""
    ds = smooth(401, 5.0)
    with pytest.raises(ValueError, match=r"found .* with mesh=16; take mesh=\d+"):
        ds.contact.adhesive(mesh=16)


def test_a_soft_sphere_on_a_smooth_scan_is_solved_within_a_minute():
    """Law, steps and cells follow the sphere alone, JKR's displacement of 109 nm and radius of 280 nm."""
    ds = smooth()
    began = time.process_time()
    solution = ds.contact.adhesive(mesh=roughxr.Mesh(accuracy=None))
    assert time.process_time() - began < 120  # half of it to compile
    assert solution.attrs["law"] == "jkr"
    expected = wide_contact_pull_off(500.0, float(ds.contact_modulus), 0.05)
    assert float(solution.pull_off_force[0]) == pytest.approx(expected, rel=0.01)


def test_a_range_far_below_the_cells_is_refused_at_once():
    """w dx/(E* ρ²) = 350 on the finest cells, where Newton's method does not end."""
    with pytest.raises(ValueError, match=r"cells of at most .* nm .*; take law='jkr'"):
        smooth().contact.adhesive(law="exponential")


@pytest.mark.parametrize("order", [0.42, 0.5, 1.0])
def test_the_coarser_of_two_meshes_states_the_limit_of_a_slow_series(order):
    """Pull-offs of soft rough bodies rise with each halving of the cells, by an order of a half."""
    coarse, fine = (1 - 0.1 * 2 ** (-order * k) for k in (0, 1))
    change = np.array([1 - coarse / fine])
    assert 1 - coarse <= coarser_mesh_error(change, "jkr")[0]
    assert coarser_mesh_error(change, "exponential") == change


def test_a_pull_off_whose_pressed_solve_fails_has_no_stated_error(monkeypatch):
    monkeypatch.setattr(refinement, "_pressed_pull_offs", lambda place, problem, adhesion, cycles: np.array([np.nan]))
    with pytest.warns(UnresolvedContact, match="no error estimate"):
        solution = smooth().contact.adhesive(mesh=1)
    assert float(solution.pull_off_force[0]) > 0 and np.isnan(solution.pull_off_error[0])


@pytest.mark.filterwarnings("ignore:.*accuracy")
def test_a_mesh_that_does_not_converge_leaves_the_pull_off_of_the_one_before(monkeypatch):
    ground = surfaces.scan(surfaces.rough(24, seed=1)).contact.assign_pair(
        sphere_radius=500, contact_modulus=40, work_of_adhesion=0.06
    )
    solved = refinement._solved
    meshes = []

    def solved_to_the_second_mesh(place, problem, adhesion, refine, **options):
        cycles = solved(place, problem, adhesion, refine, **options)
        meshes.append(refine)
        return cycles if len(set(meshes)) < 3 else cycles._replace(events=[{}] * len(cycles.events))

    monkeypatch.setattr(refinement, "_solved", solved_to_the_second_mesh)
    cycle = ground.contact.adhesive(mesh=roughxr.Mesh(accuracy=1e-9))
    finer = sorted(set(meshes) - {1})  # the last one is that of the pixels
    assert len(finer) == 3 and float(cycle.mesh[0]) == finer[1] and meshes[-1] == 1
    assert float(cycle.pull_off_force[0]) > 0 and float(cycle.pull_off_error[0]) > 1e-9


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_loading_without_a_jump_needs_no_second_retraction(monkeypatch):
    """A sphere on one summit is pressed and released along one curve: nothing is solved again."""
    retractions = []
    retract = path.Retraction.retract
    monkeypatch.setattr(path.Retraction, "retract", lambda self: retractions.append(1) or retract(self))
    x = 4.0 * (np.arange(32) - 15.5)
    bump = surfaces.scan(-(np.hypot(x[:, None], x) ** 2) / 400.0, 4.0)
    pair = roughxr.assign_pair(bump, sphere_radius=1e5, contact_modulus=30.0, work_of_adhesion=0.05)
    solved = pair.contact.adhesive(subregions=([0.0], [0.0]), law="exponential", mesh=1)
    assert len(retractions) == 1
    assert float(solved.pressed_pull_off_force[0]) == float(solved.pull_off_force[0]) > 0


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_a_pressed_sphere_that_returns_to_known_states_holds_as_much_as_before(monkeypatch):
    """It jumps while it is pressed, and returns to where it was: other steps from there on held 2 % more."""
    retractions = []
    retract = path.Retraction.retract
    monkeypatch.setattr(path.Retraction, "retract", lambda self: retractions.append(self) or retract(self))
    surface = roughxr.scans.synthetic.self_affine((40, 40), 8.0, rms=3, hurst=0.8, rolloff=100, cutoff=30, seed=4)
    pair = surface.contact.assign_pair(sphere_radius=600, contact_modulus=3.0, work_of_adhesion=0.09)
    options = {"subregions": ([96.0], [160.0]), "law": "exponential", "mesh": roughxr.Mesh(2, None)}
    settled = pair.contact.adhesive(**options)
    first, second = retractions
    assert first.visited[-1] is second.visited[-1]
    assert settled.pressed_pull_off_force.values == pytest.approx(settled.pull_off_force.values, rel=1e-4)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_a_law_that_a_small_change_switches_is_named_in_the_answer():
    """Twice the work of adhesion gave less force: the law had switched between both calls, without a word."""
    surface = roughxr.scans.synthetic.self_affine((32, 32), 10.0, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    bodies = {"sphere_radius": 300, "contact_modulus": 1.0, "work_of_adhesion": 0.05}
    parameter = median_tabor(specimen_of(surface.contact.assign_pair(**bodies)))
    switching = []
    for wanted in (0.1, 4.0, 6.0, 50.0):
        modulus = (parameter / wanted) ** 1.5
        pair = surface.contact.assign_pair(**bodies | {"contact_modulus": modulus})
        switching.append(adhesive_options.chosen_law(specimen_of(pair), "auto")[1])
    np.testing.assert_allclose(switching, [0.1, 4.0, 6.0, 50.0], rtol=1e-6)
    assert [adhesive_options.changes_the_law(tabor) for tabor in switching] == [False, True, True, False]
    near = surface.contact.assign_pair(**bodies | {"contact_modulus": (parameter / 4.0) ** 1.5})
    solved = near.contact.adhesive(mesh=roughxr.Mesh(2, None))
    switch = "The law is 'exponential' by Tabor's parameter, 4, and 'jkr' on the other side of 5: state one law"
    assert switch in solved.contact.answer().sentence
    stated = near.contact.adhesive(mesh=roughxr.Mesh(2, None), law=solved.attrs["law"])
    assert "state one law" not in stated.contact.answer().sentence


@pytest.mark.filterwarnings("ignore:.*no error estimate:UserWarning")
def test_two_meshes_that_agree_on_an_unresolved_contact_are_not_the_last(monkeypatch):
    """Cells of a whole and of half a pixel may agree by chance: a third mesh decides where the contact is small."""
    solved_on = []
    pixels_in_radius = [0.0]
    solve = refinement._solved

    def constant(place, problem, adhesion, refine, **options):
        solved_on.append(refine)
        cycles = solve(place, problem, adhesion, 1)
        events = [events | {"pull_off_resolution": pixels_in_radius[0] * refine} for events in cycles.events]
        return cycles._replace(problem=problem._replace(refine=refine), events=events)

    monkeypatch.setattr(refinement, "_solved", constant)
    bump = surfaces.scan(-(np.hypot(*np.meshgrid(*2 * [np.linspace(-60, 60, 25)])) ** 2) / 400.0, 5.0)
    pair = roughxr.assign_pair(bump, sphere_radius=1e5, contact_modulus=30.0, work_of_adhesion=0.05)
    for radius, finest in ((2.0, 4), (3.0, 2)):
        pixels_in_radius[0] = radius
        solved_on.clear()
        pair.contact.adhesive(subregions=([0.0], [0.0]), law="exponential")
        assert max(solved_on) == finest


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_pressing_that_reaches_other_summits_makes_a_range_under_a_law_with_a_range():
    """A sphere on its first summit holds a quarter of what it holds once pressed: that was no range, and no word."""
    surface = roughxr.scans.synthetic.self_affine((40, 40), 8.0, rms=3, hurst=0.8, rolloff=100, cutoff=30, seed=2)
    pair = surface.contact.assign_pair(sphere_radius=600, contact_modulus=3.0, work_of_adhesion=0.09)
    options = {"subregions": ([32.0], [96.0]), "law": "exponential", "mesh": roughxr.Mesh(2, None)}
    with pytest.warns(UserWarning, match="1 of 1 subregions have a range and not one pull-off"):
        settled = pair.contact.adhesive(**options)
    low, high = float(settled.pull_off_force[0]), float(settled.pressed_pull_off_force[0])
    pressed = pair.contact.adhesive(preload=low, **options)
    assert high > 3 * low
    assert float(pressed.pull_off_force[0]) == pytest.approx(high, rel=0.02)


def test_a_flat_punch_with_a_cliff_rests_on_no_ripples_between_the_pixels():
    """Kendall's punch: interpolated heights ring at its rim, and the sphere of finer cells held a thousandth of it."""
    modulus, work, pixel, side = 10.0, 0.05, 10.0, 24
    axis = pixel * (np.arange(side) - 0.5 * (side - 1))
    inside = np.hypot(axis[:, None], axis) < 60.0
    surface = surfaces.scan(np.where(inside, 0.0, -30.0), pixel)
    options = {"contact_modulus": modulus, "work_of_adhesion": work, "adhesion_range": 0.3}
    pair = surface.contact.assign_pair(sphere_radius=1e6, **options)
    middle = [0.5 * side * pixel]
    with pytest.warns(UserWarning, match="did not reach accuracy"):
        solved = pair.contact.adhesive(subregions=(middle, middle), law="jkr").isel(subregion=0)
    radius = np.sqrt(inside.sum() / np.pi) * pixel
    kendall = np.sqrt(8 * np.pi * modulus * work * radius**3)
    assert abs(float(solved.pull_off_force) / kendall - 1) < float(solved.pull_off_error) < 0.6
