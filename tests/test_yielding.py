"""Contacts that yield at a hardness, against limits, identities and a dense solver: kernels and direct simulation."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from roughxr.mechanics.bodies.pair import assign_pair
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.kernels.halfspace import working_set
from roughxr.mechanics.kernels.halfspace.yielding import residual_heights

from . import half_space as kalker
from .half_space import loaded
from .surfaces import rough, scan, sphere_gap
from .test_halfspace import printed_coefficients

E = 39.4
H = 6.0


def yield_depth(radius, hardness=H):
    """Displacement at which Hertz's largest pressure on a sphere is the hardness."""
    return radius * (np.pi * hardness / (2 * E)) ** 2


def yield_load(radius):
    return np.pi**3 * radius**2 * H**3 / (6 * E**2)


def paraboloid(deepest, dx, radius, ratio=1.0):
    """Separation of a paraboloid of curvatures 1/radius and 1/(ratio radius), as wide as it overlaps."""
    half_x, half_y = (int(np.sqrt(2 * r * deepest) / dx) + 2 for r in (radius, ratio * radius))
    x, y = ((np.arange(2 * half + 1) - half) * dx for half in (half_x, half_y))
    return x[:, None] ** 2 / (2 * radius) + y[None, :] ** 2 / (2 * ratio * radius)


def solve(separation, delta, dx, hardness=H, **options):
    return kalker.solve(separation, delta, dx, E, hardness=kalker.Hardness(hardness), **options)


def pressed_paraboloid(times, cells, radius=1000.0):
    """Solve a paraboloid pressed ``times`` as deep as where it first yields, so many cells in its contact's radius."""
    depth = yield_depth(radius)
    contact = np.sqrt({1: 1.0, 2: 2.07, 5: 6.08}.get(times, 2 * times) * radius * depth)
    dx = contact / cells
    return solve(paraboloid(times * depth, dx, radius), times * depth, dx, tolerance=1e-8), radius, depth


# Force over that of first yield and area over πRδ_Y, from axisymmetric rings and from squares on a plane alike.
FORCES = {1: 1.0, 2: 2.7204, 5: 9.0327}
AREAS = {2: 2.07, 5: 6.08}


def test_what_is_left_is_the_closed_gap_where_the_hardness_bears():
    """Gaps of −0.5, 0.5, −2 and −2 nm at δ = 3 and 1 nm more at δ = 2; the last cell presses a little less than H."""
    separation = np.array([[1.0, 2.0, 0.5, 0.5]])
    displacement = np.array([[[1.5, 1.5, 0.5, 0.5]]] * 2)
    pressure = np.array([[[H, H, H * (1 - 1e-12), 0.999 * H]]] * 2)
    residual = residual_heights(pressure, displacement, separation, [3.0, 2.0], H)
    np.testing.assert_allclose(residual, [[[-0.5, 0.0, -2.0, 0.0]], [[0.0, 0.0, -1.0, 0.0]]])


@pytest.mark.parametrize("times", [1, 2, 5])
def test_a_paraboloid_that_yields(times):
    contact, radius, depth = pressed_paraboloid(times, 50)
    assert contact.converged
    assert contact.force == pytest.approx(FORCES[times] * yield_load(radius), rel=2e-4)
    if times > 1:
        assert contact.area == pytest.approx(AREAS[times] * np.pi * radius * depth, rel=1e-2)  # a staircase of cells


@pytest.mark.parametrize("times", [2, 5])
def test_its_error_falls_with_the_cell(times):
    """More than 3.5-fold per halving on average, over several places of the contact's rim on the grid."""
    exact = FORCES[times] * yield_load(1000.0)
    errors = [
        np.mean([abs(pressed_paraboloid(times, n * part)[0].force / exact - 1) for part in (1, 1.07, 1.13, 1.21, 1.3)])
        for n in (8, 32)
    ]
    assert (errors[0] / errors[1]) ** 0.5 >= 3.5


@pytest.mark.parametrize("ratio", [1.0, 4.0])
def test_deep_indentations_bear_the_hardness_on_what_they_displace(ratio):
    """P → HA and A → 2π √(R₁R₂) δ, what is wanting as the root of the depth: the elastic part of it grows as that."""
    radius = 1000.0
    bears = []
    covers = []
    for times in (300, 3000):
        delta = times * yield_depth(radius)
        dx = np.sqrt(2 * radius * delta) / 40
        contact = solve(paraboloid(delta, dx, radius, ratio), delta, dx)
        bears.append(1 - contact.force / (H * contact.area))
        covers.append(1 - contact.area / (2 * np.pi * radius * np.sqrt(ratio) * delta))
    if ratio == 1.0:  # of this circle of cells every one bears the hardness
        assert bears == pytest.approx([0.0, 0.0], abs=1e-12)
    else:
        assert 0 < bears[1] < min(1e-3, bears[0])
    assert 0 < covers[1] < 0.03
    assert covers[0] / covers[1] == pytest.approx(np.sqrt(10), rel=0.1)


def test_scaling_laws_of_an_ellipse_that_yields():
    separation = paraboloid(150.0, 10.0, 500.0, ratio=3.0)
    delta = 150.0
    dx = 10.0
    once = solve(separation, delta, dx, tolerance=1e-9)
    assert 0.1 < once.hard_area / once.area < 0.95
    larger = solve(4 * separation, 4 * delta, 4 * dx, tolerance=1e-9)
    assert larger.force == pytest.approx(16 * once.force, rel=1e-8)
    assert larger.dent == pytest.approx(64 * once.dent, rel=1e-6)
    steeper = solve(3 * separation, 3 * delta, dx, 3 * H, tolerance=1e-9)
    assert steeper.force == pytest.approx(3 * once.force, rel=1e-8)
    stiffer = kalker.solve(separation, delta, dx, 2 * E, hardness=kalker.Hardness(2 * H), tolerance=1e-9)
    assert stiffer.force == pytest.approx(2 * once.force, rel=1e-8)


def window(n, seed, **options):
    z = rough(n, seed=seed, **options)
    return z.max() - z + sphere_gap(n, 9.77)


def bounded_least_squares(separation, delta, dx, hardness):
    """Return the pressures by bounded least squares on the Cholesky factor: exact, dense, another method."""
    i, j = np.indices(separation.shape).reshape(2, -1)
    table = printed_coefficients(max(separation.shape)) * dx / E
    factor = np.linalg.cholesky(table[abs(i[:, None] - i), abs(j[:, None] - j)])
    target = np.linalg.solve(factor, delta - separation.ravel())
    minimum = lsq_linear(factor.T, target, bounds=(0.0, hardness), method="bvls", tol=1e-14)
    return minimum.x.reshape(separation.shape)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("delta", "hardness"), [(2.0, 0.5), (8.0, 2.0), (40.0, 8.0), (40.0, 1.0)])
def test_equals_a_dense_solver_on_small_grids(seed, delta, hardness):
    separation = window(12, seed, smooth=1.0)
    contact = solve(separation, delta, 9.77, hardness, tolerance=1e-11)
    expected = bounded_least_squares(separation, delta, 9.77, hardness)
    np.testing.assert_allclose(contact.pressure, expected, atol=1e-7 * expected.max(initial=1e-300))


def assert_yields(contact, separation, delta, dx, hardness):
    """Hold the conditions against an independent sum."""
    gap = plain_gap(contact, separation, delta, dx)
    small = 1e-6 * delta
    hard = contact.pressure >= hardness
    assert contact.converged
    assert 0 <= contact.pressure.min() and contact.pressure.max() <= hardness
    assert gap[~hard].min() >= -small
    assert np.abs(gap[(contact.pressure > 0) & ~hard]).max(initial=0) <= small
    assert gap[hard].max(initial=0) <= small
    assert contact.hard_area == pytest.approx(hard.sum() * dx**2)
    assert contact.dent == pytest.approx(-gap[hard].sum() * dx**2, rel=1e-4, abs=small * dx**2)


def plain_gap(contact, separation, delta, dx):
    table = printed_coefficients(max(separation.shape)) * dx / E
    gap = separation - delta
    for k, m in zip(*np.nonzero(contact.pressure)):
        rows, columns = (abs(np.arange(size) - at) for size, at in zip(separation.shape, (k, m)))
        gap = gap + contact.pressure[k, m] * table[rows[:, None], columns]
    return gap


@pytest.mark.parametrize("hardness", [0.3, 2.0, 8.0])
@pytest.mark.parametrize("delta", [4.0, 12.0, 25.0])
@pytest.mark.parametrize("smooth", [0.7, 3.0])
def test_conditions_hold_on_rough_windows(delta, smooth, hardness):
    separation = window(48, 3, smooth=smooth)
    assert_yields(solve(separation, delta, 9.77, hardness), separation, delta, 9.77, hardness)


@pytest.mark.parametrize("delta", [1.0, 4.0, 12.0, 20.0])
def test_misleading_guesses_lead_to_the_same_contact(delta):
    separation = window(48, 5)
    unit = 9.77 / E
    wrong = kalker.solve(separation, 20.0, 9.77, E).pressure * unit  # far above the hardness
    cold = solve(separation, delta, 9.77, 3.0, tolerance=1e-8).pressure * unit
    guess = working_set.Guess(wrong, wrong > 0, wrong > 0)
    misled = working_set.solve_in_box(delta - separation, guess, 0.5e-8, 5000, 3.0 * unit)
    assert misled.pressure.sum() == pytest.approx(cold.sum(), rel=1e-7)
    np.testing.assert_array_equal(misled.pressure >= 3.0 * unit * (1 - 1e-12), cold >= 3.0 * unit * (1 - 1e-12))


def test_without_a_limit_all_is_elastic():
    separation = window(64, 6)
    for delta in (3.0, 15.0):
        elastic = kalker.solve(separation, delta, 9.77, E)
        for hardness in (np.inf, 1e6):
            hard = solve(separation, delta, 9.77, hardness)
            np.testing.assert_allclose(hard.pressure, elastic.pressure, rtol=1e-9)
            assert hard.force == pytest.approx(elastic.force, rel=1e-12)
            assert hard.hard_force == hard.hard_area == hard.dent == 0


@pytest.mark.parametrize(("load", "hardness"), [(1.0, 0.5), (1e3, 0.5), (3e4, 0.5), (3e4, 2.0), (4e5, 2.0), (4e5, 8.0)])
def test_load_control_finds_the_displacement(load, hardness):
    separation = window(65, 8, rms=1.0)
    ((delta, contact),) = loaded(separation, [load], 9.77, E, hardness=kalker.Hardness(hardness))
    assert contact.converged and contact.pressure.max() <= hardness
    assert contact.force == pytest.approx(load, rel=1e-6)
    assert solve(separation, delta, 9.77, hardness, tolerance=1e-9).force == pytest.approx(load, rel=4e-6)


def test_the_shape_that_is_left_bears_the_same_pressures_elastically():
    separation = window(48, 9)
    contact = solve(separation, 15.0, 9.77, 3.0, tolerance=1e-9)
    residual = residual_heights(contact.pressure[None], contact.displacement[None], separation, [15.0], 3.0)[0]
    assert residual.min() < -0.1 and (residual[contact.pressure < 3.0] == 0).all()
    again = kalker.solve(separation - residual, 15.0, 9.77, E, tolerance=1e-9)
    np.testing.assert_allclose(again.pressure, contact.pressure, atol=1e-6 * 3.0)


def test_what_has_yielded_goes_on_yielding():
    """Pressures only grow, and dents only deepen, so that loading leaves what its deepest displacement says."""
    separation = window(48, 12, smooth=1.0)
    deltas = np.linspace(2, 20, 30)
    contacts = kalker.sweep(separation, deltas, 9.77, E, hardness=kalker.Hardness(3.0), tolerance=1e-9)
    for before, after in pairwise(contacts):
        assert (after.pressure - before.pressure).min() >= -1e-6
        assert (after.pressure[before.pressure >= 3.0] >= 3.0).all()


# ---------------------------------------------------------------- the direct simulation


def glass(height, **options):
    pair = {"sphere_radius": 3000.0, "contact_modulus": E, "hardness": "6 GPa"}
    return assign_pair(scan(height), **(pair | options))


@pytest.fixture(scope="module")
def surface():
    return glass(rough(96, smooth=1.2, seed=11))


def test_fields_meet_the_conditions(surface):
    solution = direct(surface, delta=[6, 12], subregions=(2, 2), fields=True)
    np.testing.assert_allclose(solution.pressure.sum(("x", "y")) * 9.77**2, solution.force, rtol=1e-7)
    small = 1e-6 * 12
    assert 0 <= float(solution.pressure.min()) and float(solution.pressure.max()) <= 6.0 * (1 + 1e-6)
    assert float(solution.gap.min()) >= -small
    assert float(np.abs(solution.gap.where(solution.pressure > 0)).max()) <= small
    loading = solution.sel(branch="loading")
    yielded = loading.residual_height < 0
    assert yielded.any() and (loading.pressure.where(yielded) >= 6.0).where(yielded, True).all()
    np.testing.assert_allclose(yielded.sum(("x", "y")) * 9.77**2, loading.yielded_area, rtol=0.02)
    volume = -loading.residual_height.sum(("x", "y")) * 9.77**2
    np.testing.assert_allclose(loading.plastic_work, 6.0 * volume, rtol=1e-6)


def test_a_cycle_dissipates_the_plastic_work(surface):
    """The work of the force around the loop, against the hardness times the volume that gave way."""
    deltas = np.linspace(0.05, 15, 300)
    cycle = direct(surface, delta=deltas, datum="first_contact").isel(subregion=0)
    work = cycle.force.integrate("delta")
    lost = work.sel(branch="loading") - work.sel(branch="retraction")
    assert float(lost) > 0.01 * float(work.sel(branch="loading"))
    assert float(lost) == pytest.approx(float(cycle.plastic_work[0, -1]), rel=2e-3)


def test_retraction_begins_with_the_elastic_stiffness_and_is_retraced(surface):
    """As stiff as a punch of the contact's shape; loading what is left again takes the same way back."""
    deepest = 12.0
    deltas = [6.0, 9.0, deepest - 1e-3, deepest]
    cycle = direct(surface, delta=deltas, fields=True).isel(subregion=0)
    last = cycle.sel(branch="loading", delta=deepest)
    i, j = np.nonzero(last.pressure.values)
    table = printed_coefficients(max(last.pressure.shape)) * 9.77 / E
    stiffness = np.linalg.solve(table[abs(i[:, None] - i), abs(j[:, None] - j)], np.ones(i.size)).sum() * 9.77**2
    back = cycle.force.sel(branch="retraction").values
    assert (back[3] - back[2]) / 1e-3 == pytest.approx(stiffness, rel=5e-3)
    forth = cycle.force.sel(branch="loading").values
    assert (back[:2] < forth[:2]).all()

    dented = surface.copy(deep=True)
    residual = last.residual_height.dropna("x", how="all").dropna("y", how="all")
    rows, columns = (
        np.searchsorted(surface[a], float(residual[a][0]) + float(cycle[f"subregion_{a}"]) - 1) for a in "xy"
    )
    at = {"x": slice(rows, rows + residual.sizes["x"]), "y": slice(columns, columns + residual.sizes["y"])}
    dented["height"][at] = dented["height"][at] + residual.values
    rise = float(surface.height.max() - dented.height.max())
    again = direct(dented, delta=np.asarray(deltas) - rise).isel(subregion=0)
    np.testing.assert_allclose(again.force.sel(branch="loading"), back, rtol=1e-5)
    assert (again.plastic_work < 1e-3 * cycle.plastic_work[0, -1]).all()


def test_a_load_yields_as_its_displacement_does(surface):
    loads = [500.0, 8000.0]
    by_load = direct(surface, load=loads, subregions=(2, 2))
    assert by_load.delta.dims == ("subregion", "branch", "load") and by_load.converged.all()
    np.testing.assert_allclose(by_load.force, np.broadcast_to(loads, (4, 2, 2)), rtol=1e-6)
    for k in range(4):
        deltas = by_load.delta.sel(branch="loading")[k].values
        back = direct(surface, delta=deltas, subregions=(2, 2)).isel(subregion=k)
        np.testing.assert_allclose(back.force.sel(branch="loading"), loads, rtol=1e-5)
        np.testing.assert_allclose(back.plastic_work, by_load.plastic_work[k], rtol=1e-3, atol=1e-6)
    loading, retraction = (by_load.delta.sel(branch=way)[:, 0].values for way in ("loading", "retraction"))
    yielded = by_load.plastic_work[:, 0, -1].values > 0
    assert yielded.any() and (retraction[yielded] > loading[yielded] + 1e-3).all()
    np.testing.assert_allclose(retraction[~yielded], loading[~yielded], atol=1e-5)


def test_elastic_results_tell_what_lies_above_the_hardness(surface):
    elastic = direct(surface.rename(hardness="hardness_estimate"), delta=[6, 12], fields=True)
    assert elastic.force.dims == ("subregion", "delta")
    above = elastic.pressure.where(elastic.pressure >= 6.0)
    np.testing.assert_allclose(elastic.yielded_fraction, above.sum(("x", "y")) * 9.77**2 / elastic.force, rtol=1e-9)
    area = above.count(("x", "y")) * 9.77**2
    np.testing.assert_allclose(elastic.yielded_area_fraction, area / elastic.contact_area, rtol=1e-12)
    assert float(elastic.yielded_fraction[0, -1]) > 0.05
    bare = direct(glass(surface.height.values, hardness=None), delta=[6, 12])
    np.testing.assert_array_equal(bare.force, elastic.force)
    assert "yielded_fraction" not in bare


def test_named_materials_bring_an_estimate_at_which_nothing_yields():
    height = rough(64, smooth=1.2, seed=11)
    named = assign_pair(scan(height), sphere_radius=3000, materials="glass/gold")
    assert float(named.hardness_estimate) == 1.0 and "hardness" not in named.coords
    solution = direct(named, delta=[6, 12])
    assert solution.force.dims == ("subregion", "delta") and float(solution.yielded_fraction[0, -1]) > 0.5
    measured = assign_pair(scan(height), sphere_radius=3000, materials="glass/gold", hardness=1.5)
    assert "hardness_estimate" not in measured.coords and float(measured.hardness) == 1.5


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"hardness": 0}, "hardness: expected one positive number in GPa"),
        ({"hardness": -6}, "hardness: expected one positive number in GPa"),
        ({"hardness": "6 nm"}, "hardness"),
        ({"hardness": 6e9}, "hardness: .* as bodies have, found 6e\\+09 GPa"),
        (
            {"hardness": 1.0, "work_of_adhesion": 1.35, "adhesion_range": 0.3},
            "hardness: expected more than the adhesive traction w/rho = 4.5 GPa",
        ),
    ],
)
def test_bad_hardness_is_refused(options, says):
    with pytest.raises(ValueError, match=says):
        glass(np.zeros((32, 32)), **options)
