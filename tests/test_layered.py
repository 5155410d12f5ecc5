"""A layer bonded to the surface's half space: its coefficients, and what the verbs make of it."""

import numpy as np
import pytest
from scipy import special

from roughxr.mechanics.kernels.halfspace import products
from roughxr.mechanics.kernels.halfspace.displacement_control import AREA, FORCE, STATUS, sweep_arrays
from roughxr.mechanics.kernels.halfspace.layered import Film, compliance, influence_coefficients
from roughxr.mechanics.kernels.halfspace.love import love_coefficients

from . import bonded_layer

#: μ₁/μ₂, ν₁, ν₂: oxide on silicon, rubber on glass, on a rigid base compressible and not, stiff on soft.
FILMS = {
    "oxide": (0.61, 0.17, 0.28),
    "rubber": (3e-5, 0.495, 0.22),
    "rigid": (0.0, 0.3, 0.3),
    "incompressible": (0.0, 0.5, 0.3),
    "stiff": (30.0, 0.2, 0.4),
}
films = pytest.mark.parametrize("kind", FILMS)


@films
@pytest.mark.parametrize("s", [0.05, 0.3, 1.0, 3.0, 8.0])
def test_compliance_solves_the_boundary_value_problem(kind, s):
    assert compliance(s, *FILMS[kind]) == pytest.approx(bonded_layer.compliance(s, *FILMS[kind]), rel=1e-9)


@pytest.mark.parametrize("mismatch", [1e-3, 0.6, 30.0])
def test_compliance_ends_at_the_film_and_at_its_base(mismatch):
    # E*, at a shear modulus of 1 below
    film = 2 * mismatch * 1.17 / (1 - 0.17**2)
    base = 2 * 1.28 / (1 - 0.28**2)
    assert compliance(40.0, mismatch, 0.17, 0.28) == pytest.approx(1.0, rel=1e-12)
    for s in (0.0, 1e-9):
        assert compliance(s, mismatch, 0.17, 0.28) == pytest.approx(film / base, rel=1e-6)


@films
def test_squares_are_the_double_integral_of_the_hankel_transform(kind):
    """At ten offsets, from the square itself to far beyond all that is interpolated."""
    share = 0.7
    for thickness in (0.6, 5.0):
        table = influence_coefficients(300, 300, Film(thickness, share, *FILMS[kind]))
        for i, j in [(0, 0), (1, 0), (1, 1), (3, 2), (7, 0), (20, 12), (23, 23), (24, 0), (60, 31), (299, 150)]:
            remainder = share / np.pi / thickness * _mean_over_square(kind, thickness, i, j)
            expected = love_coefficients(300, 300)[i, j] + remainder
            assert table[i, j] == pytest.approx(expected, abs=3e-8 * max(1.0, compliance(0.0, *FILMS[kind]))), (i, j)


def _mean_over_square(kind, thickness, i, j):
    """Return the mean over a square of ∫ (F(s) − 1) J₀(s r/h) ds, by quadrature of J₀ along s."""
    x, weight = np.polynomial.legendre.leggauss(12)
    r = np.hypot(i + 0.5 * x[:, None], j + 0.5 * x) / thickness
    pieces = int(20 * r.max() / np.pi) + 200
    s, ds = np.polynomial.legendre.leggauss(8)
    ends = np.linspace(0, 20, pieces + 1)
    s = (ends[:-1, None] + (ends[1] - ends[0]) * 0.5 * (s + 1)).ravel()
    ds = np.tile(0.5 * (ends[1] - ends[0]) * ds, pieces)
    integrand = ds * (compliance(s, *FILMS[kind]) - 1)
    mean = np.array([integrand @ special.j0(s * distance) for distance in r.ravel()]).reshape(r.shape)
    return 0.25 * weight @ mean @ weight


@films
def test_thick_and_thin_films_are_their_half_spaces(kind):
    love = love_coefficients(64, 64)
    share = 0.7
    thick, thin = (influence_coefficients(64, 64, Film(h, share, *FILMS[kind])) for h in (1e11, 1e-8))
    np.testing.assert_allclose(thick, love, rtol=1e-6)
    whole = 1 - share + share * compliance(0.0, *FILMS[kind])
    np.testing.assert_allclose(thin, whole * love, rtol=1e-6)


@films
@pytest.mark.parametrize("thickness", [0.3, 3.0, 30.0])
def test_coefficients_are_positive_definite(kind, thickness):
    """Also those between cells of a box, as products by transforms take them; so energies are not negative."""
    film = Film(thickness, 1.0, *FILMS[kind])
    rows, columns = (index.ravel() for index in np.indices((24, 24)))
    matrix = products.matrix_between(rows, columns, influence_coefficients(24, 24, film))
    smallest, *_, largest = np.linalg.eigvalsh(matrix)
    assert smallest > 1e-6 * largest
    pressure = np.random.default_rng(1).standard_normal((24, 24))
    np.testing.assert_allclose(products.displaced(pressure, film).ravel(), matrix @ pressure.ravel(), atol=1e-11)


def _paraboloid(film, depth, *, radius=2000.0, cells=128):
    """Return the columns of a solve and the gaps of the window; lengths in cells, E* = 1."""
    x = np.arange(cells) - 0.5 * (cells - 1)
    separation = (x[:, None] ** 2 + x**2) / (2 * radius)
    states, _, displacement = sweep_arrays(separation, [depth], 1.0, 1.0, film, keep=1)
    return states[0], displacement[0] + separation - depth


@films
@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 2.0, 5.0, 10.0])
def test_sphere_on_a_layer(kind, ratio):
    """Force and contact radius at a/h from 0.1 to 10 by dual integral equations, to 4e-4 at 32 cells in radius."""
    radius = 2000.0
    a = 32.0
    force, depth = bonded_layer.response(1.0, (1 / ratio, *FILMS[kind]))
    states, gap = _paraboloid(Film(a / ratio, 1.0, *FILMS[kind]), depth * a**2 / radius)
    assert states[STATUS] == 0
    assert states[FORCE] == pytest.approx(force * a**3 / radius, rel=4e-4)
    assert states[AREA] == pytest.approx(np.pi * a**2, rel=0.02)
    if kind in ("rubber", "incompressible") and ratio >= 2:  # the layer bulges, and touches beyond the overlap
        assert states[AREA] > 1.05 * 2 * np.pi * depth * a**2
    assert np.nanmin(gap) > -1e-5 * depth * a**2 / radius


def test_thin_layers_follow_their_limits():
    """F = πM a⁴/(4 R h), δ = a²/2R with the oedometric modulus M; incompressible F = πE a⁶/(96 R h³), δ = a²/4R.

    Both by dual integrals, whose forces the package meets up to a/h = 10; the limits are reached as h/a → 0.
    """
    for ratio, power, limit, depth in [
        (0.3, 4, np.pi / 4 * 0.7**2 / 0.4, 0.5),  # M/E* = (1 − ν)²/(1 − 2ν)
        (0.5, 6, np.pi / 96 * 0.75, 0.25),  # E/E* = 1 − ν²
    ]:
        layers = [(1 / n, 0.0, ratio, 0.3) for n in (10, 20, 40)]
        forces, depths = np.array([bonded_layer.response(1.0, layer) for layer in layers]).T
        off = forces / (limit * np.array([10.0, 20.0, 40.0]) ** (power - 3)) - 1
        assert (np.diff(off) < 0).all() and off[-1] > 0
        assert 2 * off[2] - off[1] == pytest.approx(0.0, abs=0.03 * power)  # of first order in h/a
        assert 2 * depths[2] - depths[1] == pytest.approx(depth, rel=0.02)


@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.4])
def test_published_series_for_a_sphere_on_an_incompressible_layer(ratio):
    """Garcia & Garcia, Biophys. J. 114 (2018) 2923: F/F_Hertz at χ = √(Rδ)/h; coefficients were not looked up again.

    That of first order is Dimitriadis et al.'s, too (Biophys. J. 82 (2002) 2798, eq. 12), whose second one is 1.283.
    """
    force, depth = bonded_layer.response(1.0, (1 / ratio, *FILMS["incompressible"]))
    chi = np.sqrt(depth) * ratio
    series = 1 + 1.133 * chi + 1.497 * chi**2 + 1.469 * chi**3 + 0.755 * chi**4
    assert force / (4 / 3 * depth**1.5) == pytest.approx(series, rel=4e-3)


#: κ by a/h and ν: Hayes et al., J. Biomech. 5 (1972) 541, table of the plane-ended indenter; not looked up again.
HAYES = {
    0.30: {0.2: 1.207, 0.4: 1.472, 0.6: 1.784, 0.8: 2.124, 1.0: 2.480, 1.5: 3.400, 2.0: 4.336},
    0.50: {0.2: 1.281, 0.4: 1.683, 0.6: 2.211, 0.8: 2.855, 1.0: 3.609, 1.5: 5.970, 2.0: 9.069},
}


@pytest.mark.parametrize("ratio", HAYES)
def test_published_table_for_a_flat_punch(ratio):
    """F = 2 E* a δ κ: dual integrals to 0.9 %, 0.3 % up to a/h = 1, the solver to what the rim of cells leaves."""
    for relative, kappa in HAYES[ratio].items():
        layer = (1 / relative, 0.0, ratio, 0.3)
        assert bonded_layer.punch(layer) == pytest.approx(kappa, rel=0.01)
    x = np.arange(64) - 31.5
    disk = np.where(np.hypot(x[:, None], x) < 24.0, 0.0, np.inf)
    area = np.sqrt(np.isfinite(disk).sum() / np.pi)
    (state,), *_ = sweep_arrays(disk, [1.0], 1.0, 1.0, Film(area, 1.0, 0.0, ratio, 0.3))
    assert state[FORCE] / (2 * area) == pytest.approx(HAYES[ratio][1.0], rel=0.015)
