"""A rough probe on a rough surface is their composite roughness under the smooth probe, in the elastic half space."""

import numpy as np
import pytest
import xarray as xr

import roughxr

from .surfaces import rough, scan

PIXEL = 10.0
RADIUS = 400.0
N = 49


def probe(roughness):
    """Return a sphere's face with roughness on it, as an indenter seen along the surface's axes."""
    x = (np.arange(N) - (N - 1) / 2) * PIXEL
    heights = roughness - (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)
    return xr.DataArray(heights, {"x": x, "y": x}, ("x", "y"), attrs={"units": "nm"})


def pressed(surface, indenter, **options):
    pair = surface.contact.assign_pair(indenter=indenter, contact_modulus=40.0)
    return pair.contact.direct(datum="first_contact", fields=True, **options)


def test_a_rough_probe_on_a_rough_surface_is_the_composite_under_a_smooth_one():
    surface_heights = rough(N, rms=1.0, seed=1)
    other = rough(N, rms=0.7, seed=2)
    delta = [1.0, 4.0, 9.0]
    both_rough = pressed(scan(surface_heights, PIXEL), probe(other), delta=delta)
    composite = pressed(scan(surface_heights + other, PIXEL), probe(np.zeros((N, N))), delta=delta)
    assert bool((both_rough.force > 0).all()) and bool(both_rough.converged.all()) and bool(composite.converged.all())
    np.testing.assert_allclose(both_rough.force, composite.force, rtol=1e-10)
    np.testing.assert_allclose(both_rough.contact_area, composite.contact_area, rtol=1e-10)
    np.testing.assert_allclose(
        both_rough.pressure, composite.pressure, rtol=0, atol=1e-9 * float(both_rough.pressure.max())
    )


def test_a_probes_roughness_takes_contact_away():
    flat = scan(np.zeros((N, N)), PIXEL)
    smooth = pressed(flat, probe(np.zeros((N, N))), load=[500.0])
    worn = pressed(flat, probe(rough(N, rms=0.7, seed=2)), load=[500.0])
    assert bool((worn.contact_area < 0.8 * smooth.contact_area).all())


WIDTH = N * PIXEL


@pytest.fixture(scope="module")
def ensemble():
    """Return the roughness of a probe, and spheres of it as they may land."""
    roughness = scan(rough(2 * N, rms=0.7, seed=3), PIXEL)
    return roughness, roughxr.placements(roughness, sphere_radius=RADIUS, width=WIDTH, count=4, seed=5)


def turned_patch(roughness, member):
    """Return the part of a roughness that a placement says faces the surface, by its own coordinates."""
    half = (N - 1) / 2 * PIXEL
    near = {axis: slice(member[f"patch_{axis}"] - half - 1e-6, member[f"patch_{axis}"] + half + 1e-6) for axis in "xy"}
    facing = roughness.height.sel(near).values[:, ::-1]
    return np.rot90(facing, int(np.rint(float(member.rotation) / (np.pi / 2))))


def test_every_placement_is_the_composite_single_rough_surface(ensemble):
    roughness, indenters = ensemble
    surface_heights = rough(N, rms=1.0, seed=1)
    delta = [1.0, 4.0]
    pair = scan(surface_heights, PIXEL).contact.assign_pair(sphere_radius=RADIUS, contact_modulus=40.0)
    both_rough = pair.contact.vary(roughxr.direct, indenter=indenters, delta=delta, datum="first_contact")
    assert both_rough.force.dims == ("placement", "subregion", "delta") and bool(both_rough.converged.all())
    assert np.unique(indenters.rotation).size > 1
    for k in range(indenters.sizes["placement"]):
        sum_of_both = surface_heights + turned_patch(roughness, indenters.isel(placement=k))
        smooth = scan(sum_of_both, PIXEL).contact.assign_pair(sphere_radius=RADIUS, contact_modulus=40.0)
        composite = smooth.contact.direct(delta=delta, datum="first_contact")
        np.testing.assert_allclose(both_rough.force.isel(placement=k), composite.force, rtol=1e-9)
        np.testing.assert_allclose(both_rough.contact_area.isel(placement=k), composite.contact_area, rtol=1e-9)


def test_placements_vary_with_the_other_parameters(ensemble):
    _, indenters = ensemble
    pair = scan(rough(N, seed=1), PIXEL).contact.assign_pair(sphere_radius=RADIUS, contact_modulus=40.0)
    options = {"indenter": indenters.isel(placement=[0, 2]), "delta": [2.0], "datum": "first_contact"}
    varied = pair.contact.vary(roughxr.direct, contact_modulus=[20.0, 40.0], **options)
    assert varied.force.dims[:2] == ("placement", "contact_modulus")
    np.testing.assert_allclose(
        varied.force.sel(contact_modulus=40), 2 * varied.force.sel(contact_modulus=20), rtol=1e-9
    )
    with pytest.raises(ValueError, match="sphere_radius: expected none with an indenter"):
        pair.contact.vary(roughxr.direct, sphere_radius=[300.0], **options)
    with pytest.raises(ValueError, match="expected a Dataset from `placements`"):
        pair.contact.vary(roughxr.direct, indenter=pair, delta=[2.0])
    with pytest.raises(ValueError, match="found the height map of an indenter"):
        pair.contact.vary(roughxr.superpose, indenter=options["indenter"], delta=[2.0])


def test_the_same_seed_lands_alike_and_a_scan_too_small_is_refused(ensemble):
    roughness, indenters = ensemble
    again = roughness.contact.placements(sphere_radius=RADIUS, width=WIDTH, count=4, seed=5)
    xr.testing.assert_identical(again, indenters)
    for width in (3 * WIDTH, PIXEL):
        with pytest.raises(ValueError, match="width: expected at least 40 nm"):
            roughxr.placements(roughness, sphere_radius=RADIUS, width=width)


def face(radius, top, rms, n=101, seed=0):
    """Return the scan of a rough sphere's face whose apex lies at ``top`` from the middle."""
    x = (np.arange(n) - (n - 1) / 2) * PIXEL
    r2 = (x[:, None] - top[0]) ** 2 + (x[None, :] - top[1]) ** 2
    roughness = rough(n, rms=rms, seed=seed)
    return scan(np.sqrt(radius**2 - r2) + roughness, PIXEL), roughness


@pytest.mark.parametrize(("radius", "top"), [(2000.0, (0.0, 0.0)), (900.0, (80.0, -150.0)), (20000.0, (300.0, 0.0))])
def test_a_sphere_is_fitted_and_taken_out(radius, top):
    ds, roughness = face(radius, top, rms=0.5)
    fitted = roughxr.fit_sphere(ds)
    assert float(fitted.fitted_radius) == pytest.approx(radius, rel=0.01 + radius * 3e-6)
    assert float(fitted.apex_tilt) == pytest.approx(np.hypot(*top) / radius, rel=0.05, abs=3e-3)
    assert float(fitted.fit_rms) < 0.5 * 1.001
    smooth, _ = face(radius, top, rms=1e-9)
    exact = roughxr.fit_sphere(smooth)
    assert float(exact.fitted_radius) == pytest.approx(radius, rel=1e-5)
    assert (float(exact.apex_x), float(exact.apex_y)) == pytest.approx(top, abs=1e-2)
    assert float(abs(exact.height).max()) < 1e-5
    assert np.corrcoef(fitted.height.values.ravel(), roughness.ravel())[0, 1] > 0.93  # its longest waves are curvature


def test_a_probes_own_face_lands_as_its_sphere_and_its_roughness():
    ds, _ = face(2000.0, (0.0, 0.0), rms=0.5)
    fitted = roughxr.fit_sphere(ds)
    whole = roughxr.placements(fitted, sphere_radius=float(fitted.fitted_radius), width=101 * PIXEL, count=1)
    facing = np.rot90(ds.height.values[:, ::-1], round(float(whole.rotation[0]) / (np.pi / 2)))
    off = whole.indenter_height.isel(placement=0).values - facing
    assert np.ptp(off - off.mean()) < 0.5  # but for where the fitted apex lies


@pytest.mark.parametrize(
    ("height", "message"),
    [
        (rough(41, seed=1), "expected part of a sphere"),
        (np.linspace(0, 1, 41)[:, None] ** 2 * np.ones(41) * 100, "that do not fall off"),
        (np.full((41, 41), np.nan), "expected at least 10 heights"),
    ],
)
def test_what_is_no_sphere_is_refused(height, message):
    with pytest.raises(ValueError, match=message):
        roughxr.fit_sphere(scan(height, PIXEL))


def test_missing_pixels_of_a_probe_are_left_out():
    ds, _ = face(2000.0, (50.0, 0.0), rms=0.1)
    holed = ds.assign(height=ds.height.where(ds.height < ds.height.quantile(0.98)).transpose("x", "y"))
    fitted = roughxr.fit_sphere(holed)
    assert float(fitted.fitted_radius) == pytest.approx(2000.0, rel=0.01)
    np.testing.assert_array_equal(fitted.height.isnull(), holed.height.isnull())
