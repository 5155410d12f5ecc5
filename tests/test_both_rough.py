"""A rough probe on a rough surface is their composite roughness under the smooth probe, in the elastic half space."""

import numpy as np
import xarray as xr

from .surfaces import rough, scan

PIXEL, RADIUS, N = 10.0, 400.0, 49


def probe(roughness):
    """Return a sphere's face with roughness on it, as an indenter seen along the surface's axes."""
    x = (np.arange(N) - (N - 1) / 2) * PIXEL
    heights = roughness - (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)
    return xr.DataArray(heights, {"x": x, "y": x}, ("x", "y"), attrs={"units": "nm"})


def pressed(surface, indenter, **options):
    pair = surface.contact.assign_pair(indenter=indenter, contact_modulus=40.0)
    return pair.contact.direct(datum="first_contact", fields=True, **options)


def test_a_rough_probe_on_a_rough_surface_is_the_composite_under_a_smooth_one():
    own, other = rough(N, rms=1.0, seed=1), rough(N, rms=0.7, seed=2)
    delta = [1.0, 4.0, 9.0]
    both = pressed(scan(own, PIXEL), probe(other), delta=delta)
    composite = pressed(scan(own + other, PIXEL), probe(np.zeros((N, N))), delta=delta)
    assert bool((both.force > 0).all()) and bool(both.converged.all()) and bool(composite.converged.all())
    np.testing.assert_allclose(both.force, composite.force, rtol=1e-10)
    np.testing.assert_allclose(both.contact_area, composite.contact_area, rtol=1e-10)
    np.testing.assert_allclose(both.pressure, composite.pressure, rtol=0, atol=1e-9 * float(both.pressure.max()))


def test_only_the_sum_of_both_counts():
    own, other = rough(N, rms=1.0, seed=1), rough(N, rms=0.7, seed=2)
    one, turned = (
        pressed(scan(a, PIXEL), probe(b), load=[200.0, 800.0]).force for a, b in ((own, other), (other, own))
    )
    np.testing.assert_allclose(one, turned, rtol=1e-9)


def test_a_probes_roughness_takes_contact_away():
    flat = scan(np.zeros((N, N)), PIXEL)
    smooth = pressed(flat, probe(np.zeros((N, N))), load=[500.0])
    worn = pressed(flat, probe(rough(N, rms=0.7, seed=2)), load=[500.0])
    assert bool((worn.contact_area < 0.8 * smooth.contact_area).all())
