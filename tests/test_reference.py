"""Closed forms against numbers derived apart from them."""

import itertools

import numpy as np
import pytest
from scipy import special
from scipy.integrate import quad

from roughxr import reference
from roughxr.mechanics.asperity.asperity_sum import FORMULATIONS
from roughxr.mechanics.kernels.adhesion import potentials
from roughxr.mechanics.kernels.asperity import asperity_laws

from .closed_forms import maugis_pull_off, potential, rigid_sphere, sphere_attraction

W = 0.1
R = 100.0
MAUGIS = [(0.1, 1.95059), (0.5, 1.71825), (1, 1.60073), (2, 1.53460), (5, 1.50635)]


def test_paper_sphere():
    contact = reference.hertz([5.08, 15.4], radius="3 um", contact_modulus=39.407)
    assert contact.force.values / 1000 == pytest.approx([32.95, 173.9], rel=5e-4)
    assert contact.force.units == "nN"


def test_jkr_sphere_at_the_points_of_its_curve():
    sphere = {"radius": R, "contact_modulus": 40, "work_of_adhesion": W}
    a_c = (9 * np.pi * W * R**2 / (8 * 40)) ** (1 / 3)
    P_c = 1.5 * np.pi * W * R
    delta_c = a_c**2 / R
    delta = np.array([-(3 ** (-1 / 3)) * (1 - 1e-12), -1 / 3, 0.839947, 2.114382])
    contact = reference.jkr_sphere(delta * delta_c, **sphere)
    assert contact.force.values / P_c == pytest.approx([-5 / 9, -1, 0, 2.343146], abs=2e-6)
    assert contact.semi_axis_a.values / a_c == pytest.approx([3 ** (-2 / 3), 1, 4 ** (1 / 3), 2], rel=2e-6)
    assert np.isnan(reference.jkr_sphere([-0.7 * delta_c], **sphere).force).all()
    assert reference.jkr_pull_off(radius=R, work_of_adhesion=W) == pytest.approx(P_c, rel=1e-12)


# --- the generalized JKR contact of a paraboloid ---

ELLIPTIC = {"contact_modulus": 40.0, "work_of_adhesion": W}

#: Pull-off over 3/2 π w Re at ratios B/A of the curvatures.
PULL_OFF = [
    (1.5, {"published": 0.76157, "self_similar": 0.99773, "energy": 0.99871}),
    (2, {"published": 0.62648, "self_similar": 0.99348, "energy": 0.99630}),
    (5, {"published": 0.33491, "self_similar": 0.96796, "energy": 0.98130}),
    (10, {"published": 0.20911, "self_similar": 0.94088, "energy": 0.96452}),
]


def paraboloid(ratio, delta_star, formulation):
    """Return the contact at displacements δ/δ_c of a paraboloid of curvatures 0.01 nm⁻¹ and ``ratio`` times that."""
    shape = {"curvature_min": 0.01, "curvature_max": 0.01 * ratio, "formulation": formulation, **ELLIPTIC}
    unit = float(reference.jkr_paraboloid([0.0], **shape).unit_delta)
    return reference.jkr_paraboloid(np.asarray(delta_star) * unit, **shape)


@pytest.mark.parametrize(("ratio", "expected"), PULL_OFF)
def test_elliptic_pull_off_by_every_formulation(ratio, expected):
    sphere = 1.5 * np.pi * W / (0.01 * ratio**0.5)
    for formulation, pull_off_ratio in expected.items():
        pull_off = reference.jkr_pull_off(
            work_of_adhesion=W, curvature_min=0.01, curvature_max=0.01 * ratio, formulation=formulation
        )
        assert pull_off / sphere == pytest.approx(pull_off_ratio, abs=2e-5)
        contact = paraboloid(ratio, np.linspace(-0.45, -0.25, 401), formulation)
        assert -float(contact.force.sel(branch="stable").min()) == pytest.approx(pull_off, rel=1e-6)


@pytest.mark.parametrize("formulation", ["published", "self_similar"])
def test_both_branches_of_a_similar_ellipse_are_the_papers_curve(formulation):
    """Equations 20-24, with λ² for λ in the published units; figures 2-4."""
    end = 3 ** (-1 / 3)
    contact = paraboloid(5.0, [-end * (1 + 1e-12), -end * (1 - 1e-12), -1 / 3, -1e-3, 0.0, 0.839947], formulation)
    K = special.ellipk(1 - float(contact.axis_ratio) ** 2)
    lam = float(contact.axis_ratio)
    beta = 0.005 + lam**2 * 0.025
    lam_printed = lam**2 if formulation == "published" else lam
    assert float(contact.unit_semi_axis) ** 3 == pytest.approx(9 * W / 2 * lam_printed * K / (2 * beta**2 * 40))
    assert float(contact.unit_delta) == pytest.approx(beta * float(contact.unit_semi_axis) ** 2)
    assert float(contact.unit_force) == pytest.approx(3 * np.pi * W / 2 * lam_printed / beta)
    a = contact.semi_axis_a / contact.unit_semi_axis
    delta = contact.delta / contact.unit_delta
    P = contact.force / contact.unit_force
    assert np.allclose(((delta - a**2) ** 2 - 16 / 9 * a).fillna(0), 0, atol=1e-12)
    assert np.allclose(((P - a**3) ** 2 - 4 * a**3).fillna(0), 0, atol=1e-12)
    assert np.allclose(contact.semi_axis_b.fillna(0), lam * contact.semi_axis_a.fillna(0), rtol=1e-14)
    assert a.sel(branch="stable").values == pytest.approx(
        [np.nan, end**2, 1, 1.2108, (4 / 3) ** (2 / 3), 4 ** (1 / 3)], rel=2e-4, nan_ok=True
    )
    root = min(x.real for x in np.roots([1, 1, 1, -1 / 3]) if x.imag == 0)  # of √a* at δ* = −1/3, besides 1
    assert a.sel(branch="unstable").values == pytest.approx(
        [np.nan, end**2, root**2, (0.75e-3) ** 2, 0, np.nan], rel=2e-4, abs=1e-9, nan_ok=True
    )
    assert contact.branch_end == pytest.approx(-end * float(contact.unit_delta), rel=1e-14)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_nearly_round_paraboloid_is_the_jkr_sphere(formulation):
    delta = np.linspace(-0.69, 30, 40)
    nearly_round = paraboloid(1 + 1e-6, delta, formulation)
    sphere = reference.jkr_sphere(nearly_round.delta.values, radius=R, **ELLIPTIC)
    for name in ("force", "semi_axis_a", "contact_area"):
        assert nearly_round[name].sel(branch="stable").values == pytest.approx(sphere[name].values, rel=2e-5)
    by_radius = reference.jkr_paraboloid(sphere.delta.values, radius=R, formulation=formulation, **ELLIPTIC)
    assert by_radius.force.sel(branch="stable").values == pytest.approx(sphere.force.values, rel=1e-14)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_stable_branch_is_what_superposed_asperities_follow(formulation):
    contact = paraboloid(5.0, np.linspace(-0.65, 20, 25), formulation)
    law = asperity_laws.law(formulation)
    scales = asperity_laws.asperity_scales(0.005, 0.025, 40.0, W, law)
    summed = np.array([asperity_laws.asperity_contact(delta, scales, law.spline) for delta in contact.delta.values])
    for column, name in enumerate(("force", "semi_axis_a", "semi_axis_b")):
        values = contact[name].sel(branch="stable").values
        assert values == pytest.approx(summed[:, column], rel=1e-5, abs=1e-5 * values.max())


@pytest.mark.parametrize("ratio", [1.2, 10, 1000])
def test_branches_of_an_ellipse_of_free_shape_meet_and_end(ratio):
    end = paraboloid(ratio, [0.0], "energy").branch_end / float(paraboloid(ratio, [0.0], "energy").unit_delta)
    contact = paraboloid(ratio, [1.001 * end, end * (1 - 1e-10), -1e-9, 0.1], "energy")
    stable, unstable = (contact.sel(branch=branch) for branch in ("stable", "unstable"))
    assert np.isfinite(stable.force).values.tolist() == [False, True, True, True]
    assert np.isfinite(unstable.force).values.tolist() == [False, True, True, False]
    for name in ("force", "semi_axis_a", "semi_axis_b"):
        assert float(stable[name][1]) == pytest.approx(float(unstable[name][1]), rel=2e-4)
    assert float(unstable.semi_axis_a[2] / contact.unit_semi_axis) < 1e-6
    assert (stable.semi_axis_b / stable.semi_axis_a > contact.axis_ratio)[1:].all()


def test_gilmans_surface_energy_and_the_papers_smooth_pull_off():
    """18.16 µN with E; the printed 19.1 µN with E/(1 − ν²)."""
    by_modulus = {0.0: 18.16, 0.22: 19.08}
    for poisson_ratio, pull_off in by_modulus.items():
        gamma = reference.gilman_surface_energy(young_modulus=75, poisson_ratio=poisson_ratio)
        sphere = reference.jkr_pull_off(radius=3000, work_of_adhesion=2 * gamma)
        assert sphere / 1000 == pytest.approx(pull_off, abs=5e-3)
    wider = reference.gilman_surface_energy(young_modulus="75 GPa", atomic_radius="2.6 Å")
    assert wider == pytest.approx(4 * 0.64212, rel=1e-5)


@pytest.mark.parametrize(("lam", "expected"), MAUGIS)
def test_maugis_pull_off(lam, expected):
    modulus = 40.0
    distance = 1.157 * (R * W**2 / modulus**2) ** (1 / 3) / lam  # λ = 1.157 μ
    sphere = {"radius": R, "contact_modulus": modulus, "work_of_adhesion": W, "adhesion_range": distance}
    assert reference.tabor_parameter(**sphere) == pytest.approx(lam / 1.157)
    assert maugis_pull_off(**sphere) / (np.pi * W * R) == pytest.approx(expected, abs=1e-5)


def hamaker_sphere(distance, radius, constant):
    """Return Hamaker's pull of a sphere on a half space, Physica 4 (1937) 1058."""
    return 2 * constant * radius**3 / (3 * distance**2 * (distance + 2 * radius) ** 2)


def test_hamaker_sphere_is_the_published_number_and_the_surface_integral():
    w = 0.1 / (12 * np.pi * 0.3**2)
    force = rigid_sphere([0.3, 10, 3000], radius=1000, work_of_adhesion=w, length=0.3)
    assert -force == pytest.approx([hamaker_sphere(z, 1000, 0.1) for z in (0.3, 10, 3000)], rel=1e-12)
    assert -force[0] == pytest.approx(185.1296, abs=5e-5)


LAWS = [("hamaker", None), ("hamaker", 100.0), ("lennard_jones", None), ("exponential", None), ("dugdale", None)]


@pytest.mark.parametrize(("law", "wavelength"), LAWS)
def test_work_is_the_integral_of_traction_and_a_sphere_that_of_its_surface(law, wavelength):
    law_of_gap = potential(law, W, 0.3, wavelength or np.inf)
    start = 0.3 if law_of_gap.closest != 0 else 0.0
    ends = [start, 0.3 + start] if law == "dugdale" else [start, start + 1, start + 30, 1e3, 1e6]

    def over(f, points=ends):
        return sum(quad(f, *pair, epsabs=0, epsrel=1e-11, limit=400)[0] for pair in itertools.pairwise(points))

    assert over(lambda g: potentials.traction(g, law_of_gap)) == pytest.approx(W, rel=1e-7)
    for g in (start, start + 0.1, 2.0):
        points = np.unique([g, *[e for e in ends if e > g]])
        expected = over(lambda u: potentials.traction(u, law_of_gap), points) if points.size > 1 else 0.0
        assert float(potentials.energy(g, law_of_gap)) == pytest.approx(expected, rel=1e-6, abs=1e-13)
    radius = 50.0
    z = start + 0.05
    rings = [0, 0.24, 1, 10, 2 * radius]
    direct = over(lambda S: 2 * np.pi * (radius - S) * potentials.traction(z + S, law_of_gap), rings)
    assert float(sphere_attraction(z, radius, law_of_gap)) == pytest.approx(direct, rel=1e-6)


def test_retardation_is_gregorys():
    """Sphere and plate: A R/(6D²) [1 − (5.32 D/λ) ln(1 + λ/(5.32 D))], half of the plain force at D = 0.11 λ or so."""
    law = potentials.potential("hamaker", W, 0.165, 100.0)
    A = 12 * np.pi * 0.165**2 * W
    for D in (0.2, 5.0, 40.0):
        x = 5.32 * D / 100
        expected = A * 1e6 / (6 * D**2) * (1 - x * np.log(1 + 1 / x))
        assert float(sphere_attraction(D, 1e6, law)) == pytest.approx(expected, rel=3e-4)


def test_largest_traction_of_lennard_jones():
    law = potentials.potential("lennard_jones", W, 0.3)
    g = np.linspace(0.3, 0.5, 200001)
    t = potentials.tractions(g, law)
    assert t.max() == pytest.approx(1.026400 * W / 0.3, rel=1e-6)
    assert g[t.argmax()] == pytest.approx(3 ** (1 / 6) * 0.3, abs=2e-6)


@pytest.mark.parametrize(("sigma", "share"), [(0.1, 0.92277), (0.5, 0.25257), (1, 0.079487), (2, 0.0226641)])
def test_work_over_gaussian_heights(sigma, share):
    assert reference.gaussian_work(rms=sigma * 0.3, length=0.3, work_of_adhesion=W) / W == pytest.approx(
        share, rel=3e-4
    )


def test_formulas_for_rough_surfaces_have_the_limits_that_their_papers_name():
    sphere = {"radius": 1000.0, "hamaker_constant": 0.1, "closest_approach": 0.3}
    smooth = 0.1 * 1000 / (6 * 0.09)
    assert reference.rumpf(asperity_radius=1e-9, **sphere) == pytest.approx(smooth, rel=1e-6)
    assert reference.rumpf(asperity_radius=1e9, **sphere) == pytest.approx(smooth, rel=1e-5)
    assert reference.rabinovich(rms=1e-9, wavelength=1e3, **sphere) == pytest.approx(2 * smooth, rel=1e-6)
    two = reference.rabinovich(rms=1, wavelength=50, long_rms=1e-12, long_wavelength=1e9, **sphere)
    assert two == pytest.approx(reference.rabinovich(rms=1, wavelength=50, **sphere), rel=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reference.hertz([1], contact_modulus=1), "expected either radius"),
        (lambda: reference.jkr_pull_off(work_of_adhesion=1, curvature_min=2, curvature_max=1), "at most curvature_max"),
        (lambda: reference.gaussian_work(rms=1, length=1, law="jkr"), "law: expected one"),
        (lambda: reference.jkr_paraboloid([0], radius=1, formulation="hertz", **ELLIPTIC), "formulation: expected one"),
        (lambda: reference.jkr_paraboloid([0], curvature_min=1, **ELLIPTIC), "either radius, or curvature_min"),
        (
            lambda: reference.rabinovich(radius=1, rms=1, wavelength=1, hamaker_constant=1, long_rms=1),
            "both or neither",
        ),
        (lambda: reference.rumpf(radius=1, hamaker_constant=1), "asperity_radius or rms, found none"),
        (lambda: reference.rumpf(radius=1, hamaker_constant=1, rms=1, asperity_radius=1), "found both"),
        (lambda: reference.jkr_pull_off(radius="3 GPa", work_of_adhesion=1), "radius"),
    ],
)
def test_what_is_wrong_is_said(call, message):
    with pytest.raises(ValueError, match=message):
        call()
