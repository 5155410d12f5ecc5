"""One elliptic asperity under every law: the closed curve, free shapes, the table, and crowds.

The names of tests that also run quickly without compilation hold ``plain``:
``NUMBA_DISABLE_JIT=1 pytest -k plain``.
"""

import numpy as np
import pytest
from scipy import integrate, optimize, special

from roughxr.mechanics.kernels.asperity import elliptic_jkr, elliptic_table, jkr
from roughxr.mechanics.kernels.asperity.asperity_laws import ASPERITY_LAWS, asperity_contact, asperity_scales, law
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio, elliptic_integrals, hertz

from .asperity_loops import asperities_contact, asperity_events
from .asperity_tables import stable_state

# GPa, J/m²
E_STAR = 39.407
W = 1.349
ADHESIVE = ASPERITY_LAWS[1:]
FREE_SHAPE = ASPERITY_LAWS[3:]
ROW = {name: column for column, name in enumerate(ADHESIVE)}

# Pull-off relative to 3/2 π w Re, Re = 1/(2√(AB)), in the order of ADHESIVE.
PULL_OFF = {
    1.0: (1, 1, 1),
    1.5: (0.76157, 0.99773, 0.99871),
    2.0: (0.62648, 0.99348, 0.99630),
    5.0: (0.33491, 0.96796, 0.98130),
    10.0: (0.20911, 0.94088, 0.96452),
}


def asperity(ratio, Re=1000.0):
    """A and B of a paraboloid of B/A = ratio and √(R′R″) = Re."""
    return 0.5 / (Re * np.sqrt(ratio)), 0.5 * np.sqrt(ratio) / Re


def contact(name, delta, ratio, w=W, Re=1000.0):
    scales = asperity_scales(*asperity(ratio, Re), E_STAR, w, law(name))
    return asperity_contact(delta, scales, law(name).spline)


def events(name, ratio):
    return asperity_events(asperity_scales(*asperity(ratio), E_STAR, W, law(name)), law(name))


# --- the closed curve ---


@pytest.mark.parametrize(
    "a, P, delta",
    [
        (1, -1, -1 / 3),
        (3 ** (-2 / 3), -5 / 9, -(3 ** (-1 / 3))),
        (4 ** (1 / 3), 0, 0.839947),
        (2, 2.343146, 2.114382),
        ((4 / 3) ** (2 / 3), -8 / 9, 0),
    ],
)
def test_plain_points_of_the_jkr_curve(a, P, delta):
    assert jkr.load(a) == pytest.approx(P, abs=5.1e-7)
    assert jkr.displacement(a) == pytest.approx(delta, abs=5.1e-7)
    assert jkr.stable_semi_axis(jkr.displacement(a)) == pytest.approx(a, rel=1e-7)


def test_plain_stable_root_to_rounding():
    delta = np.concatenate([jkr.END_DELTA + np.logspace(-12, 0, 200), np.logspace(-0.5, 8, 200)])
    a = jkr.stable_semi_axis(delta)
    assert np.all(a >= jkr.END_A)
    np.testing.assert_allclose(jkr.displacement(a), delta, rtol=1e-14, atol=3e-15)
    assert jkr.stable_semi_axis(jkr.END_DELTA) == pytest.approx(jkr.END_A, rel=1e-15)


def test_plain_paper_sphere():
    """γ = 0.6421 J/m² on the 3 µm sphere: a_c = 101 nm, δ_c = 3.414 nm, and the JKR pull-off 3πγR."""
    unit = jkr.self_similar_units(1 / 6000, 1 / 6000, E_STAR, 2 * 0.6421)
    assert unit.a == pytest.approx(101, abs=0.5)
    assert unit.delta == pytest.approx(3.414, abs=1e-3)
    assert pytest.approx(3 * np.pi * 0.6421 * 3000) == unit.P


@pytest.mark.parametrize("name", ["published", "self_similar"])
def test_plain_closed_forms_satisfy_equations_15_and_18(name):
    """As printed with λ² (published), and with the λ of energy balance (self_similar)."""
    A, B = asperity(5.0)
    lam = axis_ratio(5.0)
    K, _ = elliptic_integrals(lam)
    beta = A + lam**2 * B
    gamma = W / 2
    power = {"published": 2, "self_similar": 1}[name]
    for delta in (-0.5, 0.0, 4.0, 30.0):
        P, a, b = contact(name, delta, 5.0)
        assert b == pytest.approx(lam * a)
        assert (beta * a**2 - delta) ** 2 == pytest.approx(8 * lam**power * K * a * gamma / E_STAR)
        tension = P - 2 * np.pi * beta * E_STAR * a**3 / (3 * K)
        assert tension**2 == pytest.approx(8 * np.pi**2 * gamma * lam**power * E_STAR * a**3 / K)


def test_self_similar_makes_the_energy_stationary():
    """Equations 12-14 with U_E = ½∫pU: ∂(U_E − wπλa²)/∂a = 0 at fixed δ and λ."""
    A, B = asperity(3.0)
    lam = axis_ratio(3.0)
    K, _ = elliptic_integrals(lam)
    beta = A + lam**2 * B
    delta = 2.0

    def energy(a):
        bracket = beta**2 * a**4 / 5 - 2 / 3 * beta * delta * a**2 + delta**2
        return np.pi * a * E_STAR / (2 * K) * bracket - W * np.pi * lam * a**2

    a = contact("self_similar", delta, 3.0).a
    minimum = optimize.minimize_scalar(energy, bounds=(0.8 * a, 1.3 * a), method="bounded", options={"xatol": 1e-8})
    assert minimum.x == pytest.approx(a, rel=1e-6)


def test_plain_strain_energy_of_equation_8():
    """½∫pU over the ellipse is πab{…}: half of what is printed as πa²{…} on the circle."""
    a = 2.0
    b = 1.0
    p0 = 1.0
    p1 = -0.3
    K, _ = elliptic_integrals(b / a)
    height = p0 * b * K  # A a² + B b² by eq. 10, with E* = 1; p1 alone adds 2 p1 b K (eq. 11)
    lam = b / a
    B_by_A = lambda_ratio(lam)
    A = height / (a**2 + B_by_A * b**2)

    def pressure_times_displacement(t, r):  # x = a r cos t, y = b r sin t, r = sin s: edge singularity removed
        s = r
        r = np.sin(r)
        x = a * r * np.cos(t)
        y = b * r * np.sin(t)
        U = height + 2 * p1 * b * K - A * x**2 - B_by_A * A * y**2
        return (p0 * np.cos(s) ** 2 + p1) * U * a * b * r

    energy = integrate.dblquad(pressure_times_displacement, 0, np.pi / 2, 0, 2 * np.pi)[0] / 2
    braces = b * K * (p0**2 / 3 + 5 / 3 * p0 * p1 + 2 * p1**2) - height * (p0 / 15 + p1 / 3)
    assert energy == pytest.approx(0.632323, abs=5.1e-7)
    assert energy == pytest.approx(np.pi * a * b * braces)


def lambda_ratio(lam):
    """B/A of equation 7 from SciPy's integrals."""
    K = special.ellipkm1(lam**2)
    E = special.ellipe(1 - lam**2)
    return (E - lam**2 * K) / (lam**2 * (K - E))


# --- ellipses of free shape ---


def boussinesq(c, k, x, y):
    """∫∫p/r over the ellipse a = 1, b = k: Gauss-Chebyshev along chords through (x, y), quad over angles."""

    def chord(angle):
        dx = np.cos(angle)
        dy = np.sin(angle)
        q2 = dx**2 + (dy / k) ** 2
        q1 = x * dx + y * dy / k**2
        q0 = 1 - x**2 - (y / k) ** 2
        t = np.cos((np.arange(8) + 0.5) * np.pi / 8) * np.sqrt(q1**2 + q2 * q0) / q2 - q1 / q2
        strength = c[0] + c[1] * (x + t * dx) ** 2 + c[2] * ((y + t * dy) / k) ** 2
        return np.mean(strength) * np.pi / np.sqrt(q2)

    return integrate.quad(chord, 0, np.pi, epsabs=1e-12)[0]


@pytest.mark.parametrize("k", [1.0, 0.999, 0.4, 0.05])
@pytest.mark.parametrize("c", [(1, 0, 0), (0, 1, 0), (0, 0, 1)])
def test_plain_displacement_of_the_ansatz(c, k):
    u0, u_x, u_y = elliptic_jkr.displacement(*c, k)
    for x, y in ((0, 0), (0.6, 0), (0, 0.5 * k), (0.3, -0.7 * k)):
        expected = boussinesq(c, k, x, y) / np.pi
        assert u0 - u_x * x**2 - u_y * y**2 == pytest.approx(expected, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("ratio", [1.5, 10.0])
def test_energy_is_stationary_in_both_axes(ratio):
    """Vary a and b of U = U_E − wπab at fixed δ, with U_E from the ansatz fitted on any ellipse."""
    state = stable_state(ratio, 0.2)
    unit = jkr.self_similar_units(1.0, ratio, 1.0, 1.0)
    a = state.a * unit.a
    b = state.b * unit.a
    delta = state.delta * unit.delta

    def total_energy(a, b):
        fit = elliptic_jkr.fit(b / a, ratio)
        c0 = (delta / a**2 - fit.delta_fit) / fit.delta_c0
        c1 = fit.mean + fit.d
        c2 = fit.mean - fit.d
        P, P_x, P_y = moments(c0, c1, c2)
        return np.pi * a**4 * b * (P * delta / a**2 - P_x - P_y * ratio * (b / a) ** 2) - np.pi * a * b

    h = 1e-4
    tolerance = 1e-6 * 2 * h * np.pi * a * b  # one millionth of the surface energy's own change
    assert total_energy(a * (1 + h), b) == pytest.approx(total_energy(a * (1 - h), b), rel=0, abs=tolerance)
    assert total_energy(a, b * (1 + h)) == pytest.approx(total_energy(a, b * (1 - h)), rel=0, abs=tolerance)


def moments(c0, c1, c2):
    """½∫p, ½∫p x², ½∫p y² over the unit disc of x/a, y/b, divided by π."""
    return c0 + (c1 + c2) / 3, c0 / 3 + (3 * c1 + c2) / 15, c0 / 3 + (c1 + 3 * c2) / 15


# --- pull-off ---


@pytest.mark.parametrize("ratio", PULL_OFF)
@pytest.mark.parametrize("name", ADHESIVE)
def test_plain_pull_off(name, ratio):
    pull_off = -events(name, ratio).largest_tension.P / (1.5 * np.pi * W * 1000)
    assert pull_off == pytest.approx(PULL_OFF[ratio][ROW[name]], abs=1.6e-5)


@pytest.mark.parametrize("ratio, b_by_a", [(1.5, 0.817), (2.0, 0.707), (5.0, 0.448), (10.0, 0.317)])
def test_ellipse_of_least_energy_is_rounder_than_hertz(ratio, b_by_a):
    state = events("energy", ratio).largest_tension
    assert state.b / state.a == pytest.approx(b_by_a, abs=2e-3)
    assert state.b / state.a > axis_ratio(ratio)


@pytest.mark.parametrize("ratio", [1.0, 2.7, 40.0])
@pytest.mark.parametrize("name", ADHESIVE)
def test_events_lie_on_the_branch(name, ratio):
    largest_tension, branch_end, touch = events(name, ratio)
    for state in (largest_tension, touch):
        there = contact(name, state.delta, ratio)
        np.testing.assert_allclose(there, state[:3], rtol=1e-5, atol=0)
    assert contact(name, branch_end.delta - 1e-9, ratio) == (0, 0, 0)
    inside = contact(name, branch_end.delta + 1e-9, ratio)
    np.testing.assert_allclose(inside, branch_end[:3], rtol=1e-3)
    delta = np.linspace(branch_end.delta, 0, 2001)
    P = np.array([contact(name, d, ratio).P for d in delta])
    assert np.min(P) == pytest.approx(largest_tension.P, rel=1e-5)


# --- the table ---


def test_table_against_direct_solution(tolerance=1e-6):
    rng = np.random.default_rng(20)
    table = elliptic_table.table()
    for ratio in elliptic_table.LARGEST_RATIO ** rng.uniform(0, 1, 40):
        lam = axis_ratio(ratio)
        row = elliptic_table.table_row(ratio)
        s_end = elliptic_jkr.branch_end(ratio)
        end = elliptic_jkr.contact_at(ratio, s_end)
        assert elliptic_table.mark_at_row(table.marks, row, 0) == pytest.approx(end.delta, abs=tolerance)
        pull_off = elliptic_jkr.contact_at(ratio, elliptic_jkr.largest_tension(ratio))
        assert elliptic_table.mark_at_row(table.marks, row, 1) == pytest.approx(pull_off.P, abs=tolerance)
        for q in 10 ** rng.uniform(-3, 2, 4):
            P, a, b = elliptic_table.lookup(table.spline, row, q**2)
            state = stable_state(ratio, end.delta + q**2, s_end)
            assert pytest.approx(state.P, abs=tolerance * (1 + q) ** 3) == P
            assert a == pytest.approx(state.a, abs=tolerance * (1 + q))
            assert b == pytest.approx(state.b / lam, abs=tolerance * (1 + q))


@pytest.mark.parametrize("name", FREE_SHAPE)
def test_flatter_than_the_table_keeps_its_last_curve(name):
    last, beyond = (events(name, ratio).largest_tension for ratio in (1e4, 3e4))
    unit, unit_beyond = (jkr.self_similar_units(*asperity(ratio), E_STAR, W) for ratio in (1e4, 3e4))
    assert pytest.approx(last.P / unit.P, rel=1e-12) == beyond.P / unit_beyond.P


# --- limits, scaling, continuity ---


@pytest.mark.parametrize("name", ADHESIVE)
@pytest.mark.parametrize("delta", [-1.0, 0.0, 2.0, 50.0])
def test_plain_sphere_limit(name, delta):
    sphere = contact("self_similar", delta, 1.0)
    np.testing.assert_allclose(contact(name, delta, 1.0), sphere, rtol=2e-5)
    np.testing.assert_allclose(contact(name, delta, 1 + 1e-7), sphere, rtol=2e-5)


@pytest.mark.parametrize("name", ASPERITY_LAWS)
@pytest.mark.parametrize("delta", [-1.0, 0.0, 0.3, 20.0])
def test_plain_no_adhesion_is_exactly_hertz(name, delta):
    P, a, b = contact(name, delta, 3.0, w=0.0)
    assert (P, a, b) == contact("hertz", delta, 3.0)
    expected = hertz(delta, *asperity(3.0), E_STAR)
    np.testing.assert_allclose((P, a, b), expected[:3], rtol=1e-14)


@pytest.mark.parametrize("name", ADHESIVE)
@pytest.mark.parametrize("ratio", [1.0, 4.0, 300.0])
def test_weak_adhesion_and_large_load_tend_to_hertz(name, ratio):
    expected = contact("hertz", 10.0, ratio)
    error = [abs(contact(name, 10.0, ratio, w=w).P / expected.P - 1) for w in (1e-4, 1e-6)]
    assert error[1] < 1e-5
    far = contact(name, 1e6, ratio)
    np.testing.assert_allclose(far, contact("hertz", 1e6, ratio), rtol=2e-4)
    assert pytest.approx(contact("hertz", 1e6, ratio).P, rel=2e-6) == far.P


@pytest.mark.parametrize("name", ADHESIVE)
def test_plain_scaling_laws(name):
    """With R → tR and w → tw, lengths grow as t and loads as t²."""
    small = contact(name, 1.5, 6.0, w=0.2, Re=100.0)
    large = contact(name, 4.5, 6.0, w=0.6, Re=300.0)
    np.testing.assert_allclose(large, np.array(small) * [9, 3, 3], rtol=1e-12)


@pytest.mark.parametrize("name", ADHESIVE)
@pytest.mark.parametrize("ratio", [1.0, 1.7, 25.0, 2000.0])
def test_branch_is_continuous_and_stable(name, ratio):
    """From its end on, contact grows without jumps and the load changes without kinks."""
    scales = asperity_scales(*asperity(ratio), E_STAR, W, law(name))
    q = np.linspace(0, 6, 3001)
    delta = (scales.end + q**2) * scales.delta
    delta[0] += 1e-12 * scales.delta
    P, a, b = (np.array(x) for x in zip(*(asperity_contact(d, scales, law(name).spline) for d in delta)))
    assert np.all(np.diff(a) > 0)
    assert np.all(np.diff(b) > 0)
    assert np.max(np.abs(np.diff(P, 2)) / scales.P) < 2e-3


@pytest.mark.parametrize("name", ASPERITY_LAWS)
def test_plain_no_peak_gives_nan(name):
    no_peak = asperity_scales(-0.01, 0.02, E_STAR, W, law(name))
    assert np.isnan(no_peak).all()
    assert np.isnan(asperity_contact(1.0, no_peak, law(name).spline)).all()
    assert np.isnan(asperity_events(no_peak, law(name))).all()


# --- crowds ---


def gaussian_mean(f, separation, lowest, steps=20000):
    """∫f(z − h) φ(z) dz over z − h ≥ lowest, by a variable in which the square root at the end is regular."""
    t = (np.arange(steps) + 0.5) / steps * np.sqrt(9.0)
    x = lowest + t**2
    weight = np.exp(-((x + separation) ** 2) / 2) / np.sqrt(2 * np.pi) * 2 * t * (t[1] - t[0])
    return np.sum(f(x) * weight)


@pytest.mark.parametrize("h, expected", [(0, 0.430020), (1, 0.07566818), (2, 6.648178e-3)])
def test_greenwood_williamson_integrals(h, expected):
    scales = asperity_scales(0.01, 0.01, E_STAR, 0.0, law("hertz"))

    def force(x):
        return asperities_contact(x[None] * scales.delta, many(scales), law("hertz").spline).P[0] / scales.P

    assert gaussian_mean(force, h, 0.0) == pytest.approx(expected, rel=2e-6)


def many(scales):
    return type(scales)(*(np.array([field]) for field in scales))


@pytest.mark.parametrize("name", ["self_similar", "energy"])
@pytest.mark.parametrize("sigma, h, pull", [(0.25, 0.82, 0.8981), (1.0, 0.54, 0.3021), (2.0, 1.49, 0.03646)])
def test_fuller_tabor(name, sigma, h, pull):
    """Equal spheres, Gaussian heights of deviation σδ_c, displacement control down to the branch's end."""
    scales = asperity_scales(0.01, 0.01, E_STAR, W, law(name))

    def force(x):
        return asperities_contact(x[None] * sigma * scales.delta, many(scales), law(name).spline).P[0] / scales.P

    def net_pull(separation):
        return -gaussian_mean(force, separation, scales.end / sigma)

    best = optimize.minimize_scalar(lambda s: -net_pull(s), bounds=(h - 1, h + 1), method="bounded")
    assert -best.fun == pytest.approx(pull, abs=0.6 * 10 ** np.floor(np.log10(pull) - 3))
    assert best.x == pytest.approx(h, abs=0.011)
