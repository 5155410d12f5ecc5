"""Superposition against single asperities, the published formulas by hand, and itself under dask."""

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr.catalogue import asperities
from roughxr.contact.asperity_sum import FORMULATIONS
from roughxr.contact.elastic import direct
from roughxr.contact.superposition import superpose
from roughxr.kernels.asperity.ellipse import axis_ratio, elliptic_integrals
from roughxr.materials import contact_modulus

from .surfaces import glass_pair, rough, scan
from .test_direct import refuse

E, W, R = contact_modulus(75, 0.22), 2 * 0.6747, 3000.0


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(96, rms=1.5, seed=11)))


def one_asperity(curvature_x, curvature_y, height=10.0, at=(0.0, 0.0)):
    x = (np.arange(65) - 32) * 5.0
    z = height - curvature_x / 2 * (x[:, None] - at[0]) ** 2 - curvature_y / 2 * (x[None, :] - at[1]) ** 2
    return glass_pair(scan(z, pixel=5.0))


def test_a_spherical_asperity_is_jkr_of_the_composite_radius():
    """Pull-off of a cap of R = 200 nm under the sphere: 3/2 π w R' with 1/R' = 1/200 + 1/3000, at its displacement."""
    radius = 1 / (1 / 200 + 1 / 3000)
    deltas = np.arange(-3, 1, 0.001)
    for formulation in ("self_similar", "johnson_greenwood", "energy"):
        force = superpose(one_asperity(1 / 200, 1 / 200), delta=deltas, formulation=formulation).force[0]
        assert -force.min().item() == pytest.approx(1.5 * np.pi * W * radius, rel=1e-5)
        unit = (9 * np.pi * W * radius**2 / (8 * E)) ** (2 / 3) / radius
        assert float(force.delta[force.argmin("delta")]) == pytest.approx(-unit / 3, abs=2e-3)
        branch_end = float(force.delta[(force < 0).argmax("delta")])
        assert branch_end == pytest.approx(-(3 ** (-1 / 3)) * unit, abs=2e-3)


def published_by_hand(A, B, delta):
    """Eqs. 20–24 as printed, their cubic solved by NumPy."""
    lam = axis_ratio(B / A)
    K, _ = elliptic_integrals(lam)
    beta, gamma = A + lam**2 * B, W / 2
    a_c = (9 * gamma * lam**2 * K / (2 * beta**2 * E)) ** (1 / 3)
    s = np.roots([1, 0, 0, -4 / 3, -delta / (beta * a_c**2)])  # a* = s², δ* = s⁴ − (4/3) s
    a = max(root.real for root in s if abs(root.imag) < 1e-9 and root.real > 0) ** 2
    return 3 * np.pi * gamma * lam**2 / beta * (a**3 - 2 * a**1.5)


@pytest.mark.parametrize("delta", [-0.5, 0.0, 1.0, 6.0])
def test_published_is_the_paper_to_the_letter(delta):
    found = superpose(one_asperity(1 / 300, 1 / 100), delta=[delta], formulation="published").force.item()
    assert found == pytest.approx(published_by_hand(1 / 600, 1 / 200, delta), rel=1e-9)


def test_displacement_follows_the_sign_of_equation_35():
    """An asperity off the axis, and below the highest point, is reached later by S₀ and by its depth."""
    r, depth = 100.0, 4.0
    z = one_asperity(1 / 200, 1 / 200, at=(r, 0.0))
    z["height"][0, 0] = z.height.max() + depth  # a spike at the edge sets the datum and is no peak
    late = depth + r**2 / (R + np.sqrt(R**2 - r**2))
    options = {"formulation": "published", "law": "hertz"}
    shifted = superpose(z, delta=np.array([3.0, 5.0]) + late, subregions=([0.0], [0.0]), **options).force.values
    centred = superpose(one_asperity(1 / 200, 1 / 200), delta=[3.0, 5.0], **options).force.values
    np.testing.assert_allclose(shifted, centred, rtol=1e-9)


def test_hertz_agrees_with_the_direct_simulation_of_one_asperity():
    asperity = one_asperity(1 / 200, 1 / 200)
    summed = superpose(asperity, delta=[2.0, 4.0], law="hertz").force
    solved = direct(asperity, delta=[2.0, 4.0]).force
    np.testing.assert_allclose(summed, solved, rtol=2e-2)  # a contact of 20–28 nm on 5 nm pixels


def test_zero_adhesion_is_hertz(surface):
    dry = asperities(surface.assign_coords(work_of_adhesion=0.0))
    for formulation in FORMULATIONS:
        options = {"delta": [5.0, 10.0], "formulation": formulation}
        np.testing.assert_allclose(superpose(dry, **options).force, superpose(dry, law="hertz", **options).force)


def test_the_sum_is_over_all_asperities(surface):
    catalogue = asperities(surface)
    whole = superpose(catalogue, delta=[8.0], subregions=(2, 2)).force
    halves = [
        superpose(catalogue.isel(asperity=slice(k, None, 2)), delta=[8.0], subregions=(2, 2)).force for k in (0, 1)
    ]
    np.testing.assert_allclose(halves[0] + halves[1], whole, rtol=1e-12)


def test_scan_and_catalogue_give_the_same(surface):
    options = {"delta": [2.0, 8.0], "subregions": (2, 3)}
    np.testing.assert_array_equal(superpose(surface, **options).force, superpose(asperities(surface), **options).force)


def test_large_contacts_are_counted():
    found = superpose(asperities(one_asperity(1 / 400, 1 / 400), patch=5), delta=[0.01, 1.0], law="hertz")
    assert found.contacts.values.tolist() == [[1, 1]]
    assert found.contacts_beyond_patch.values.tolist() == [[0, 1]]  # a = √(δR') = 2 and 19 nm; the patch has 12.5 nm
    two = scan(np.maximum(*(one_asperity(1 / 100, 1 / 100, at=(x, 0.0)).height.values for x in (-20, 20))), pixel=5.0)
    found = superpose(asperities(glass_pair(two), patch=5), delta=[4.0, 4.5], law="hertz")
    assert found.contacts_overlapping.values.tolist() == [[0, 2]]  # a = 19.5 and 20.7 nm, their centres 40 nm apart


def test_saddles_are_left_out_and_counted(surface):
    catalogue = asperities(surface)
    assert int(superpose(catalogue, delta=[5.0], formulation="published").excluded_asperities) == int(
        catalogue.saddle.sum()
    )


@pytest.mark.parametrize("scheduler", ["synchronous", "threads", "processes"])
def test_lazy_and_on_every_scheduler_the_same(surface, scheduler):
    options = {"delta": np.arange(-2, 10, 1.0), "subregions": (3, 3)}
    with dask.config.set(scheduler="synchronous"):
        expected = superpose(surface, **options)
    with dask.config.set(scheduler=refuse):
        lazy = superpose(surface.chunk(x=17, y=40), **options)
    with dask.config.set(scheduler=scheduler):
        xr.testing.assert_equal(lazy.compute(), expected)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"delta": [1.0], "formulation": "hertz"}, "formulation"),
        ({"delta": [1.0], "law": "dmt"}, "law"),
        ({"delta": []}, "at least one"),
        ({"delta": [3, 1]}, "ascending"),
    ],
)
def test_bad_options_are_refused_in_words(surface, options, says):
    with pytest.raises(ValueError, match=says):
        superpose(surface, **options)


def test_adhesion_must_be_assigned(surface):
    with pytest.raises(ValueError, match="work_of_adhesion"):
        superpose(surface.drop_vars("work_of_adhesion"), delta=[1.0])
