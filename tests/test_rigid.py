"""Rigid bodies: against closed forms, against themselves place by place, and against what theory says of roughness."""

import itertools

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import reference
from roughxr.mechanics.kernels.adhesion import potentials
from roughxr.mechanics.kernels.adhesion import rigid as kernels
from roughxr.mechanics.scans.synthetic import self_affine

from .closed_forms import rigid_sphere, sphere_attraction
from .surfaces import rotated, scan

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

RADIUS = 3000.0
LAWS = ("hamaker", "lennard_jones", "exponential", "dugdale")


def pair(ds, **options):
    glass = {"sphere_radius": RADIUS, "contact_modulus": 40.0, "work_of_adhesion": 0.1}
    return ds.contact.assign_pair(**(glass | options))


def of_length(ds, law, length):
    """Return a pair whose law has a length (nm), by its range of adhesion or its Hamaker constant."""
    if law != "hamaker":
        return ds.assign_coords(adhesion_range=length)
    return ds.assign_coords(hamaker_constant=12 * np.pi * length**2 * float(ds.work_of_adhesion))


@pytest.fixture(scope="module")
def rough():
    return pair(self_affine((96, 96), 9.77, rms=2, hurst=0.6, rolloff=300, cutoff=25, seed=4))


@pytest.mark.parametrize("law", LAWS)
def test_on_a_plane_it_is_the_closed_form_of_the_true_sphere(law):
    """On fine pixels, the window's edges and all beyond them."""
    flat = of_length(pair(scan(np.zeros((161, 161)), 1.0), sphere_radius=200.0), law, 0.3)
    delta = [-5.0, -1.0, -0.4]
    pulled = flat.contact.rigid(delta=delta, law=law)
    exact = rigid_sphere([0.4, 1.0, 5.0], radius=200, work_of_adhesion=0.1, length=0.3, law=law)
    tolerance = 2e-2 if law == "dugdale" else 5e-6  # its force ends within a ring of pixels
    assert pulled.force.values[0] == pytest.approx(exact[::-1], rel=tolerance, abs=1e-9)


@pytest.mark.parametrize("law", ["hamaker", "lennard_jones"])
def test_what_the_pixels_miss_vanishes_with_them(law):
    """The midpoint rule on a smooth integrand: far finer than second order once pixels resolve √(2R·gap)."""
    exact = float(rigid_sphere([0.3], radius=RADIUS, work_of_adhesion=0.1, length=0.3, law=law)[0])
    off = []
    for n, pixel in ((33, 36.0), (49, 24.0), (73, 16.0), (145, 8.0)):
        pulled = of_length(pair(scan(np.zeros((n, n)), pixel)), law, 0.3).contact.rigid(delta=[-0.3], law=law)
        off.append(abs(float(pulled.force[0, 0]) / exact - 1))
    assert off[0] > 3e-3 and off[-1] < 1e-6 and all(b < a / 2.25 for a, b in itertools.pairwise(off))


@pytest.mark.parametrize("law", LAWS)
def test_a_large_sphere_on_a_plane_pulls_with_2_pi_w_R_by_any_law(law):
    flat = of_length(pair(scan(np.zeros((201, 201)), 0.5), sphere_radius=2e4), law, 0.5)
    pulled = flat.contact.rigid(law=law, delta=[-1.0])
    tolerance = 0.03 if law == "dugdale" else 5e-4
    assert float(pulled.pull_off_force[0]) == pytest.approx(2 * np.pi * 0.1 * 2e4, rel=tolerance)


def test_largest_pull_of_lennard_jones_stands_at_its_length():
    flat = pair(scan(np.zeros((81, 81)), 5.0))
    pulled = flat.assign_coords(adhesion_range=0.4).contact.rigid(law="lennard_jones", delta=[-1.0])
    assert float(pulled.pull_off_delta[0]) == pytest.approx(-0.4, abs=1e-4)
    assert float(pulled.pull_off_force[0]) == pytest.approx(2 * np.pi * 0.1 * RADIUS, rel=2e-4)


@pytest.mark.parametrize(("law", "length"), [("hamaker", 0.165), ("lennard_jones", 0.3), ("exponential", 2.0)])
def test_what_lies_beyond_nothing_is_all_of_the_sphere(law, length):
    attraction = potentials.potential(law, 0.1, length)
    gaps = np.array([0.2, 1.0, 30.0])
    for rectangle in ((1e-9,) * 4, (40.0, 90.0, 55.0, 20.0)):
        beyond = kernels.force_outside(gaps, attraction, 700.0, rectangle)
        x, y = (fine(low, high) for low, high in (rectangle[:2], rectangle[2:]))
        rise = _rise(x[0][:, None] ** 2 + y[0] ** 2, 700.0)
        inside = [float(x[1] @ tractions(gap + rise, attraction) @ y[1]) for gap in gaps]
        assert beyond + inside == pytest.approx(sphere_attraction(gaps, 700.0, attraction), rel=2e-6)


def fine(low, high, n=400):
    """Return Gauss's nodes from −low to high, crowded in the middle, and weights."""
    t, w = np.polynomial.legendre.leggauss(n)
    parts = [
        (sign * side * ((1 + t) / 2) ** 3, side * w * 1.5 * ((1 + t) / 2) ** 2) for sign, side in ((-1, low), (1, high))
    ]
    return [np.concatenate(pair) for pair in zip(*parts)]


def _rise(r2, radius):
    return r2 / (radius + np.sqrt(radius**2 - r2))


def tractions(g, law):
    return potentials.tractions(g.ravel(), law).reshape(g.shape)


@pytest.mark.parametrize(("sigma", "tolerance"), [(0.1, 0.01), (0.5, 0.1)])
def test_work_left_over_gaussian_heights_is_the_mean_of_the_potential(sigma, tolerance):
    """A large sphere over some 50 000 heights, cut at 4σ: 2πR W_eff within the sampling error."""
    heights = np.random.default_rng(7).standard_normal(401 * 401 + 100)
    heights = sigma * 0.3 * heights[np.abs(heights) < 4][: 401 * 401].reshape(401, 401)
    ground = pair(scan(heights, 2.0), sphere_radius=1e5)
    pull_off = float(ground.contact.rigid(law="lennard_jones", delta=[-1.0]).pull_off_force[0])
    work = reference.gaussian_work(rms=sigma * 0.3, length=0.3, work_of_adhesion=0.1)
    assert pull_off / (2 * np.pi * 1e5 * work) == pytest.approx(1, abs=tolerance)


def test_force_falls_with_the_distance_and_ends_where_bodies_touch(rough):
    approach = rough.contact.rigid(subregions=(2, 2))
    force = approach.force.transpose("subregion", "delta").values
    touch = approach.touch_delta.values
    for curve, t in zip(force, touch):
        is_apart = np.isfinite(curve)
        assert (np.diff(curve[is_apart]) < 0).all() and (curve[is_apart] < 0).all()
        assert (is_apart == (approach.delta.values <= t - 0.165 + 1e-9)).all()
    assert (approach.pull_off_force.values >= -np.nanmin(force, axis=1) - 1e-9).all()
    assert ((approach.share_beyond_contact > 0) & (approach.share_beyond_contact < 1)).all()


def test_a_moved_scan_pulls_alike_and_a_turned_one_too(rough):
    moved = rough.assign(height=rough.height + 7.0)
    moved["height"].attrs = rough.height.attrs
    pulls = [ds.contact.rigid(delta=[-1.0]).pull_off_force.values for ds in (rough, moved, rotated(rotated(rough)))]
    np.testing.assert_allclose(pulls[1], pulls[0], rtol=1e-9)
    np.testing.assert_allclose(pulls[2], pulls[0], rtol=1e-9)


def test_an_indenter_given_as_a_map_of_the_sphere_pulls_as_the_sphere():
    ground = self_affine((64, 64), 5.0, rms=1, hurst=0.6, rolloff=100, cutoff=20, seed=4)
    x = np.arange(-160, 160.1, 5.0)
    r2 = x[:, None] ** 2 + x**2
    cap = xr.DataArray(np.sqrt(RADIUS**2 - r2) - RADIUS, {"x": x, "y": x}, ("x", "y"), attrs={"units": "nm"})
    bodies = {"contact_modulus": 40.0, "work_of_adhesion": 0.1}
    middle = [ground.x.values[32]], [ground.y.values[32]]
    by_map = ground.contact.assign_pair(indenter=cap, **bodies).contact.rigid(delta=[-1.0], subregions=middle)
    by_sphere = pair(ground).contact.rigid(delta=[-1.0], subregions=middle)
    assert float(by_map.touch_delta[0]) == pytest.approx(float(by_sphere.touch_delta[0]), abs=1e-6)
    assert float(by_map.pull_off_force[0]) == pytest.approx(float(by_sphere.pull_off_force[0]), rel=2e-2)


def test_fields_are_tractions_whose_sum_is_the_force():
    ground = pair(self_affine((64, 64), 9.77, rms=2, hurst=0.6, rolloff=300, cutoff=25, seed=4), sphere_radius=300.0)
    pulled = ground.contact.rigid(delta=[-2.0, -1.0], law="exponential", fields=True)
    total = pulled.pressure.sum(["x", "y"]) * 9.77**2
    np.testing.assert_allclose(total, pulled.force, rtol=1e-9)
    assert float(pulled.gap.min()) > 0


def test_retardation_weakens_what_is_far(rough):
    plain, late = (ds.contact.rigid(delta=[-30.0, -1.0]) for ds in (rough, pair(rough, retardation="0.1 um")))
    ratio = (late.force / plain.force).values[0]
    assert 0.1 < ratio[0] < 0.4 < ratio[1] < 1


def test_hamaker_constant_and_work_of_adhesion_go_together():
    ground = scan(np.zeros((81, 81)), 4.0)
    named = ground.contact.assign_pair(sphere_radius=RADIUS, materials="glass/alumina")
    assert float(named.hamaker_constant) == pytest.approx(np.sqrt(0.065 * 0.152))
    assert named.hamaker_constant.units == "nN nm"
    pulled = named.contact.rigid(delta=[-1.0])
    assert pulled.attrs["closest_approach"] == pytest.approx(0.165)
    assert float(pulled.hamaker_constant) == float(named.hamaker_constant)
    stated_both = pair(ground, hamaker_constant="1e-19 J", work_of_adhesion=0.05)
    z0 = np.sqrt(0.1 / (12 * np.pi * 0.05))
    assert stated_both.contact.rigid(delta=[-1.0]).attrs["closest_approach"] == pytest.approx(z0)
    same = [float(stated_both.contact.rigid(delta=[-9.0], law=law).force[0, 0]) for law in ("hamaker", "lennard_jones")]
    assert same[0] == pytest.approx(same[1], rel=1e-6)
    closed = 2 * 0.1 * RADIUS**3 / (3 * 9.0**2 * (9.0 + 2 * RADIUS) ** 2)
    assert -same[0] == pytest.approx(closed, rel=1e-4)
    with pytest.warns(roughxr.mechanics.bodies.pair.ImplausiblePair, match="closest approach of 0.0"):
        pair(ground, hamaker_constant=0.065, work_of_adhesion=1.35)
    across = roughxr.reference.hamaker_constant("glass", medium="water")
    water = ground.contact.assign_pair(sphere_radius=RADIUS, materials="glass", hamaker_constant=across)
    assert float(water.work_of_adhesion) == pytest.approx(across / (12 * np.pi * 0.165**2))


def test_what_is_wrong_is_said(rough):
    with pytest.raises(ValueError, match="law: expected one of"):
        rough.contact.rigid(law="jkr")
    with pytest.raises(ValueError, match="work_of_adhesion"):
        pair(rough, work_of_adhesion=0).contact.rigid()


def test_smaller_cells_converge_and_coarse_ones_warn(rough):
    with pytest.warns(UserWarning, match="single cell at closest approach"):
        rough.contact.rigid(delta=[-1.0])
    pulls = [float(rough.contact.rigid(delta=[-1.0], mesh=n).pull_off_force[0]) for n in (8, 16, 24)]
    assert abs(pulls[2] / pulls[1] - 1) < 0.02 and abs(pulls[2] / pulls[0] - 1) < 0.1


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
def test_the_adhesive_simulation_of_stiff_bodies_is_rigid():
    """Of diamond's stiffness ten times over: summits hardly bend, and two wholly different solvers agree within 1 %."""
    ground = self_affine((96, 96), 4.0, rms=1.0, hurst=0.7, rolloff=150, cutoff=40, seed=4)
    stiff = pair(ground, sphere_radius=500, contact_modulus=4e3, work_of_adhesion=0.06, adhesion_range=0.4)
    places = {"subregions": ([190.0, 150.0], [190.0, 230.0])}
    rigid = stiff.contact.rigid(law="exponential", delta=[0.0], mesh=2, **places).pull_off_force
    for step in (0.3, 0.1):
        bending = stiff.contact.adhesive(law="exponential", mesh=roughxr.Mesh(2, step=step), **places).pull_off_force
        np.testing.assert_allclose(bending, rigid, rtol=0.01)


@pytest.mark.parametrize("pixel", [0.5, 0.25])
def test_the_error_of_the_cells_is_stated(pixel):
    """A sphere of 10 nm over a flat, its lowest point at a cell's corner and elsewhere: 2πwR once it is divided out."""
    n = round(24 / pixel)
    flat = scan(np.zeros((n, n)), pixel)
    pair = {"sphere_radius": 10.0, "contact_modulus": 40.0, "work_of_adhesion": 0.06}
    flat = flat.contact.assign_pair(**pair)
    middle = float(flat.x[n // 2])
    shifts = np.array([0.0, 0.5, 0.5, 0.3]) * pixel, np.array([0.0, 0.0, 0.5, 0.2]) * pixel
    places = middle + shifts[0], middle + shifts[1]
    pulled = flat.contact.rigid(subregions=places, delta=[-1.0])
    fine = flat.contact.rigid(subregions=places, delta=[-1.0], mesh=16)
    stated = pulled.cell_error.values
    true = (pulled.pull_off_force / fine.pull_off_force - 1).values
    np.testing.assert_allclose(stated, true, atol=0.1 * true.max())
    assert stated[2] == stated.max() > 0.005 and stated[0] < 1e-3
    assert np.isnan(flat.contact.rigid(subregions=places, law="lennard_jones", delta=[-1.0]).cell_error).all()


@pytest.mark.parametrize(("rms", "least", "greatest"), [(0.0, 0.0085, 0.0095), (0.5, 0.01, 0.04), (3.0, 0.1, 0.3)])
def test_what_a_cut_at_eleven_lengths_leaves_out_grows_with_roughness(rms, least, greatest):
    """The share of the pull across gaps of more than 11 z0 from contact: what `adhesive` says of its own law."""
    ds = self_affine((192, 192), 2.0, rms=1.0, hurst=0.8, rolloff=100, cutoff=15, seed=1)
    pair = {"sphere_radius": 500, "contact_modulus": 40, "work_of_adhesion": 0.06, "adhesion_range": 0.3}
    ds = ds.assign(height=rms * ds.height).contact.assign_pair(**pair)
    place = {"law": "lennard_jones", "subregions": ([192.0], [192.0])}
    rotated = float(ds.contact.rigid(delta=[-20.0], **place).pull_off_delta[0])
    pulled = ds.contact.rigid(delta=[rotated], fields=True, **place)
    near = -pulled.pressure.where(pulled.gap < 12 * 0.3).sum()  # the gap counts from z0 within the potential
    assert least < 1 - float(near) * 2.0**2 / float(pulled.pull_off_force[0]) < greatest


def test_the_simulation_says_where_its_lennard_jones_law_is_cut():
    flat = scan(np.zeros((32, 32)), 0.25)
    flat = flat.contact.assign_pair(sphere_radius=5.0, contact_modulus=500.0, work_of_adhesion=0.06, adhesion_range=0.3)
    with pytest.warns(UserWarning, match=r"is cut off at a gap of 3\.3 nm"):
        simulated = flat.contact.adhesive(law="lennard_jones", subregions=(1, 1), mesh=1)
    assert simulated.attrs["cut_off_nm"] == pytest.approx(3.3)
