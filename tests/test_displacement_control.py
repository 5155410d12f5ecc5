"""The active set against Hertz, brute force and the conditions that define a contact."""

import numpy as np
import pytest
from scipy.optimize import nnls

from roughxr.mechanics.kernels.halfspace import active_set, working_set
from roughxr.mechanics.kernels.halfspace.products import operator, surface_displacement

from . import half_space as kalker
from .half_space import loaded
from .surfaces import rough, sphere_gap
from .test_halfspace import printed_coefficients

E = 39.407
R = 3000.0


def hertz(delta):
    return 4 / 3 * E * np.sqrt(R) * delta**1.5


def independent_gap(solution, separation, delta, dx):
    """Return the gap by a plain sum over the printed coefficients: none of the solver's own operators."""
    n, m = separation.shape
    table = printed_coefficients(max(n, m)) * dx / E
    i, j = np.nonzero(solution.pressure)
    gap = separation - delta
    for k, l, p in zip(i, j, solution.pressure[i, j]):
        gap = gap + p * table[abs(np.arange(n) - k)[:, None], abs(np.arange(m) - l)[None, :]]
    return gap


def assert_contact(solution, separation, delta, dx):
    gap = independent_gap(solution, separation, delta, dx)
    touching = solution.pressure > 0
    assert solution.converged
    assert solution.pressure.min() >= 0
    assert np.abs(gap[touching]).max(initial=0) <= 1e-6 * delta
    assert gap.min() >= -1e-6 * delta
    assert solution.force == pytest.approx(solution.pressure.sum() * dx**2, rel=1e-12)
    assert solution.area == pytest.approx(touching.sum() * dx**2, rel=1e-12)


def brute_force(separation, delta, dx):
    """Return the pressures by non-negative least squares on the Cholesky factor: exact, dense, another method."""
    i, j = np.indices(separation.shape).reshape(2, -1)
    table = printed_coefficients(max(separation.shape)) * dx / E
    factor = np.linalg.cholesky(table[abs(i[:, None] - i), abs(j[:, None] - j)])
    target = np.linalg.solve(factor, delta - separation.ravel())
    return nnls(factor.T, target)[0].reshape(separation.shape)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("delta", [2.0, 8.0, 40.0])
def test_equals_brute_force_on_small_grids(seed, delta):
    z = rough(12, seed=seed, smooth=1.0)
    separation = z.max() - z + sphere_gap(12, 9.77)
    solution = kalker.solve(separation, delta, 9.77, E, tolerance=1e-11)
    expected = brute_force(separation, delta, 9.77)
    np.testing.assert_allclose(solution.pressure, expected, atol=1e-8 * expected.max(initial=1e-300))


@pytest.mark.parametrize("delta", [5.0, 5.08, 10.0, 15.0])
def test_smooth_sphere_is_hertz_within_a_thousandth_at_the_papers_pixel(delta):
    solution = kalker.solve(sphere_gap(65, 9.77), delta, 9.77, E)
    assert solution.force == pytest.approx(hertz(delta), rel=1e-3)


def test_error_falls_with_the_pixel():
    """At least 3.5-fold per halving on average, over three halvings, for several places on the grid."""
    errors = []
    for halving in range(4):
        n = 32 * 2**halving
        dx = 640.0 / (32 * 2**halving)
        forces = [
            kalker.solve(sphere_gap(n, dx), d, dx, E, tolerance=1e-9).force / hertz(d) - 1 for d in (9, 11, 13, 15)
        ]
        errors.append(np.abs(forces).mean())
    assert (errors[0] / errors[3]) ** (1 / 3) >= 3.5


def test_elliptic_hertz():
    from roughxr.mechanics.kernels.asperity.ellipse import hertz as elliptic

    A = 1 / 6000
    B = 5 / 6000
    dx = 5.0
    n = 140
    delta = 12.0
    x = (np.arange(n) - (n - 1) / 2) * dx
    separation = A * x[:, None] ** 2 + B * x[None, :] ** 2
    solution = kalker.solve(separation, delta, dx, E)
    expected = elliptic(delta, A, B, E)
    assert solution.force == pytest.approx(expected.P, rel=5e-3)
    assert solution.area == pytest.approx(expected.area, rel=2e-2)  # the rim is a staircase of cells


def guess(pressure):
    """Return a bad guess: it leaves out every cell that does not touch yet."""
    return working_set.Guess(pressure, pressure > 0, pressure > 0)


@pytest.mark.parametrize("delta", [1.0, 4.0, 12.0, 25.0])
@pytest.mark.parametrize("smooth", [0.7, 2.0, 5.0])
def test_conditions_hold_on_rough_windows(delta, smooth):
    z = rough(48, seed=3, smooth=smooth)
    separation = z.max() - z + sphere_gap(48, 9.77)
    assert_contact(kalker.solve(separation, delta, 9.77, E), separation, delta, 9.77)


@pytest.mark.parametrize("smooth", [0.7, 2.0])
def test_a_bad_guess_leads_to_the_same_contact(smooth):
    z = rough(48, seed=3, smooth=smooth)
    separation = z.max() - z + sphere_gap(48, 9.77)
    deltas = (9.6, 12.0)
    before, wanted = (kalker.solve(separation, delta, 9.77, E, tolerance=1e-9).pressure * 9.77 / E for delta in deltas)
    contact = working_set.solve_in_box(deltas[1] - separation, guess(before), 1e-9, 5000, np.inf)
    assert contact.outcome.status == active_set.CONVERGED
    np.testing.assert_allclose(contact.pressure, wanted, atol=1e-7 * wanted.max())


def test_the_force_meets_its_tolerance_near_first_touch_too():
    z = rough(48, seed=7)
    separation = z.max() - z + sphere_gap(48, 9.77)
    touch = separation.min()
    for depth in (1e-9, 1e-3, 0.1, 0.5, 2.0, 10.0):
        loose = kalker.solve(separation, touch + depth, 9.77, E, tolerance=1e-6).force
        tight = kalker.solve(separation, touch + depth, 9.77, E, tolerance=1e-11).force
        assert loose == pytest.approx(tight, rel=1e-6)


@pytest.mark.parametrize("load", [1e-3, 1.0, 1e3, 32950.0, 2e5])
def test_load_control_finds_the_displacement(load):
    z = rough(65, seed=8, rms=1.0)
    separation = z.max() - z + sphere_gap(65, 9.77)
    ((delta, solution),) = loaded(separation, [load], 9.77, E)
    assert solution.converged
    assert solution.force == pytest.approx(load, rel=1e-6)
    assert kalker.solve(separation, delta, 9.77, E, tolerance=1e-9).force == pytest.approx(load, rel=2e-6)


@pytest.mark.parametrize("kind", ["spike", "terraces", "sphere"])
def test_load_control_survives_bad_guesses(kind):
    """Profiles on which force grows nothing like a sphere's, over nine decades of load, up and from cold."""
    profiles = {
        "spike": np.where(np.hypot(*np.mgrid[-30:31, -30:31]) < 1, 0.0, 40.0) + sphere_gap(61, 9.77),
        "terraces": np.floor(sphere_gap(61, 9.77) / 8) * 8,
        "sphere": sphere_gap(61, 9.77),
    }
    separation = profiles[kind]
    loads = 10.0 ** np.arange(-3, 6)
    rising = list(loaded(separation, loads, 9.77, E))
    for load, (delta, solution) in zip(loads, rising):
        ((cold, _),) = loaded(separation, [load], 9.77, E)
        assert solution.converged
        assert cold == pytest.approx(delta, rel=1e-5)
        assert kalker.solve(separation, delta, 9.77, E, tolerance=1e-9).force == pytest.approx(load, rel=2e-6)


@pytest.mark.parametrize("size", [24, 65], ids=["few cells", "many cells"])
def test_the_residual_is_the_worst_gap_over_the_deepest_overlap(size):
    """Under a load as at its displacement, wherever the surface stands; of loose solutions, so that there is some."""
    z = rough(size, seed=3)
    separation = z.max() - z + sphere_gap(size, 9.77) + 7.0
    ((delta, under_load),) = loaded(separation, [3e3], 9.77, E, tolerance=1e-2)
    for solution in (under_load, kalker.solve(separation, delta, 9.77, E, tolerance=1e-2)):
        gap = separation + solution.displacement - delta
        worst = np.nanmax(np.where(solution.pressure > 0, np.abs(gap), -gap)) / (delta - separation.min())
        assert 1e-7 < worst <= 0.5e-2
        assert solution.residual == pytest.approx(worst, rel=1e-2)


def test_nothing_to_press_on_carries_no_load():
    ((delta, solution),) = loaded(np.full((30, 30), np.inf), [5.0], 9.77, E)
    assert np.isnan(delta) and not solution.converged and solution.force == 0


def test_scaling_laws():
    z = rough(32, seed=9)
    separation = z.max() - z + sphere_gap(32, 9.77)
    force = kalker.solve(separation, 10.0, 9.77, E, tolerance=1e-9).force
    assert kalker.solve(separation, 10.0, 9.77, 3 * E, tolerance=1e-9).force == pytest.approx(3 * force, rel=1e-8)
    assert kalker.solve(2 * separation, 20.0, 2 * 9.77, E, tolerance=1e-9).force == pytest.approx(4 * force, rel=1e-8)
    assert kalker.solve(5 * separation, 50.0, 9.77, E, tolerance=1e-9).force == pytest.approx(5 * force, rel=1e-8)


# ---------------------------------------------------------------- degenerate cases


def one_cell_force(delta, dx):
    return delta * E / (printed_coefficients(1)[0, 0] * dx) * dx**2


def test_one_cell():
    separation = np.full((9, 9), 50.0)
    separation[4, 4] = 0.0
    solution = kalker.solve(separation, 3.0, 9.77, E)
    assert solution.converged and np.count_nonzero(solution.pressure) == 1
    assert solution.force == pytest.approx(one_cell_force(3.0, 9.77), rel=1e-12)


@pytest.mark.parametrize("apart", [1, 3])
def test_two_equal_cells(apart):
    separation = np.full((9, 9), 50.0)
    separation[4, 2] = separation[4, 2 + apart] = 0.0
    table = printed_coefficients(4) * 9.77 / E
    expected = 2 * 3.0 / (table[0, 0] + table[0, apart]) * 9.77**2
    assert kalker.solve(separation, 3.0, 9.77, E).force == pytest.approx(expected, rel=1e-6)


def test_no_contact_is_no_force():
    separation = 1.0 + sphere_gap(16, 9.77)
    for delta in (-5.0, 0.0, 1.0 - 1e-12, float(separation.min())):
        solution = kalker.solve(separation, delta, 9.77, E)
        assert solution.converged and solution.force == 0 and solution.area == 0


def test_just_past_first_touch():
    separation = sphere_gap(17, 9.77)
    solution = kalker.solve(separation, 1e-12, 9.77, E)
    assert solution.converged
    assert solution.force == pytest.approx(one_cell_force(1e-12, 9.77), rel=1e-6)


@pytest.mark.parametrize("shape", [(1, 1), (1, 12), (20, 20), (30, 7)])
def test_a_flat_punch_touches_everywhere(shape):
    separation = np.zeros(shape)
    solution = kalker.solve(separation, 2.0, 9.77, E, tolerance=1e-9)
    assert solution.converged and (solution.pressure > 0).all()
    np.testing.assert_allclose(surface_displacement(solution.pressure, 9.77, E), 2.0, rtol=1e-8)


def test_plateaus_and_checkerboards():
    plateau = np.where(np.hypot(*np.mgrid[-10:11, -10:11]) < 6, 0.0, 5.0)
    checkerboard = np.indices((20, 20)).sum(0) % 2 * 4.0
    for separation in (plateau, checkerboard):
        for delta in (1.0, 6.0, 30.0):
            assert_contact(kalker.solve(separation, delta, 9.77, E), separation, delta, 9.77)


def test_cells_out_of_reach_are_left_alone():
    separation = sphere_gap(33, 9.77)
    holes = separation.copy()
    holes[separation > 8.0] = np.inf
    whole, cut = (kalker.solve(s, 6.0, 9.77, E).force for s in (separation, holes))
    assert cut == whole


def test_an_exhausted_solve_says_so():
    """Its residual is that of the contact conditions, recomputed, and its status not a finished solve's."""
    separation = sphere_gap(65, 9.77)
    delta = 15.0
    solution, whole = (kalker.solve(separation, delta, 9.77, E, max_iterations=iterations) for iterations in (3, 5000))
    assert whole.converged and not solution.converged
    assert solution.iterations < whole.iterations
    gap = independent_gap(solution, separation, delta, 9.77)
    touching = solution.pressure > 0
    violation = max(np.abs(gap[touching]).max(), -gap.min())
    assert solution.residual == pytest.approx(violation / delta, rel=1e-6)
    assert solution.residual > 1e3 * whole.residual


@pytest.mark.parametrize("dense", [False, True])
def test_cells_exchanged_one_at_a_time_reach_the_same_contact(dense):
    """The safeguard against rounds without progress: entered at once here, it must come to the same end."""
    z = rough(16, seed=4, smooth=1.0)
    separation = z.max() - z + sphere_gap(16, 9.77)
    rows, columns = map(np.ascontiguousarray, np.nonzero(separation < 10.0))
    depth = 10.0 - separation[rows, columns]
    cells = operator(rows, columns, dense=dense)
    for patience in (0, active_set.PATIENCE):
        pressure = np.zeros(depth.size + 1)
        gap = -np.append(depth, 0.0)
        contact = np.append(depth > 0.5 * depth.max(), False)
        goal = 1e-9 * depth.max()
        if not dense:
            goal = 1e-6 * depth.max()  # of single precision
        outcome = active_set.solve(cells, depth, pressure, gap, contact, goal, 5000, 0.0, np.inf, patience)
        assert outcome[0] == active_set.CONVERGED
        force = pressure.sum() * E * 9.77
        assert force == pytest.approx(kalker.solve(separation, 10.0, 9.77, E, tolerance=1e-9).force, rel=20 * goal)


def test_the_preconditioner_is_the_inverse_of_the_coefficients():
    from roughxr.mechanics.kernels.halfspace.love import love_coefficients

    index = np.minimum(np.arange(128), 128 - np.arange(128))
    inverse = np.fft.ifft2(1 / np.fft.fft2(love_coefficients(65, 65)[np.ix_(index, index)])).real
    np.testing.assert_allclose(active_set.STENCIL, (inverse[0, 0], inverse[0, 1], inverse[1, 1]), atol=1e-4)
