"""Superposed asperities that yield: the tables found again, and the sums against direct and adhesive simulation."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.kernels.asperity.flattening import flattened

from .surfaces import rough, scan
from .test_yielding import E, H, paraboloid, solve, yield_depth, yield_load

RADIUS = 1000.0


@pytest.mark.parametrize("times", [1.3, 3.5, 20.0])
def test_the_tables_are_those_of_the_half_space(times):
    """Force and area where it turned, and curvature and depth of the elastic displacement in the middle."""
    depth = yield_depth(RADIUS)
    delta = times * depth
    dx = np.sqrt(1.6 * RADIUS * delta) / 60
    found = solve(paraboloid(delta, dx, RADIUS), delta, dx)
    stiffness, contact = 4 / 3 * E * np.sqrt(RADIUS), np.pi * RADIUS
    curvature, drop = flattened(np.array([delta]), stiffness, contact, H)
    force = stiffness / np.sqrt(curvature) * (delta - drop) ** 1.5
    assert force.item() == pytest.approx(found.force, rel=5e-3)
    assert (contact / curvature * (delta - drop)).item() == pytest.approx(found.area, rel=1.5e-2)

    curvature, drop = flattened(np.array([delta]), stiffness, contact, H, middle=True)
    middle = np.array(found.displacement.shape) // 2
    x = (np.arange(found.displacement.shape[0]) - middle[0]) * dx
    near = np.abs(x) < 0.25 * np.sqrt(found.area / np.pi)
    _, second, sunk = np.polyfit(x[near] ** 2, found.displacement[near, middle[1]], 2)
    assert curvature.item() == pytest.approx(-2 * second * RADIUS, rel=0.03)
    assert (delta - drop).item() == pytest.approx(sunk, rel=0.01)


def test_an_asperity_is_elastic_up_to_first_yield():
    depth = yield_depth(RADIUS)
    stiffness, contact = 4 / 3 * E * np.sqrt(RADIUS), np.pi * RADIUS
    for middle in (False, True):
        curvature, drop = flattened(np.array([-1.0, 0.0, 0.5, 1.0]) * depth, stiffness, contact, H, middle=middle)
        np.testing.assert_allclose(curvature, 1.0)
        np.testing.assert_allclose(drop, 0.0, atol=1e-12 * depth)
        after, _ = flattened(np.array([1.01, 2.0, 9.0]) * depth, stiffness, contact, H, middle=middle)
        assert (np.diff([1.0, *after]) <= 0).all() and after[2] < 0.5
    assert stiffness * depth**1.5 == pytest.approx(yield_load(RADIUS))


def test_pressed_deep_all_of_the_contact_lies_at_its_hardness():
    """Then it has the area of the plane through it; its middle recovers as a disc under H does, to radius E* a/H."""
    delta = np.array([1e8]) * yield_depth(RADIUS)
    stiffness, contact = 4 / 3 * E * np.sqrt(RADIUS), np.pi * RADIUS
    curvature, drop = flattened(delta, stiffness, contact, H)
    force, area = stiffness / np.sqrt(curvature) * (delta - drop) ** 1.5, contact / curvature * (delta - drop)
    assert area.item() == pytest.approx(2 * contact * delta.item(), rel=2e-3)
    assert force.item() == pytest.approx(H * area.item(), rel=2e-3)
    middle, sunk = flattened(delta, stiffness, contact, H, middle=True)
    assert RADIUS / middle.item() == pytest.approx(E * np.sqrt(area.item() / np.pi) / H, rel=2e-3)
    assert sunk.item() == pytest.approx(delta.item(), rel=1e-3)
    none = flattened(np.array([-np.inf, -3.0]), stiffness, contact, H)
    np.testing.assert_array_equal(none, [[1.0, 1.0], [0.0, 0.0]])


def summit(hardness):
    """Return one paraboloid of 200 nm on a flat, under a sphere so large that it is none."""
    x = (np.arange(81) - 40) * 2.0
    surface = scan(np.maximum(40 - (x[:, None] ** 2 + x**2) / 400, 0.0), pixel=2.0)
    pair = {"sphere_radius": 1e6, "contact_modulus": E, "work_of_adhesion": 0.05}
    return roughxr.assign_pair(surface, hardness=hardness, **pair)


def test_a_single_summit_presses_as_the_direct_simulation():
    deltas = [2, 5, 8, 12.0]
    superposed, direct = (
        function(summit(2.0), delta=deltas, **options)
        for function, options in ((roughxr.superpose, {"law": "hertz"}), (roughxr.direct, {}))
    )
    assert superposed.force.dims == ("subregion", "branch", "delta")
    for way, within in (("loading", 3e-3), ("retraction", 0.08)):
        off = superposed.force.sel(branch=way) - direct.force.sel(branch=way)
        assert float(np.abs(off).max()) < within * float(direct.force.max())
    loading = [ds.contact_area.sel(branch="loading") for ds in (superposed, direct)]
    np.testing.assert_allclose(*loading, rtol=0.03)


@pytest.mark.parametrize("preload", [1000.0, 5000.0, pytest.param(30000.0, marks=pytest.mark.soak)])
def test_a_single_summit_pulls_as_the_adhesive_simulation(preload):
    superposed = roughxr.superpose(summit(2.0), delta=[1, 30.0], preload=preload)
    near = summit(2.0).assign_coords(adhesion_range=0.1)
    adhesive = roughxr.adhesive(near, preload=preload, mesh=roughxr.Mesh(1, step=0.1), law="exponential")
    elastic = roughxr.superpose(summit(2.0).drop_vars("hardness"), delta=[1, 30.0])
    assert superposed.pull_off_force.item() == pytest.approx(adhesive.pull_off_force.item(), rel=0.2)
    assert superposed.preload_delta.item() == pytest.approx(adhesive.preload_delta.item(), rel=0.03)
    assert (superposed.pull_off_force.item() > 2 * elastic.pull_off_force.item()) == (preload > 1000)
    assert superposed.force.sel(branch="retraction", delta=30.0).isnull().all()  # beyond where it turned
    assert roughxr.pull_off(superposed).pull_off_force.item() == superposed.pull_off_force.item()


def test_asperities_that_never_yield_are_summed_as_elastic_ones():
    surface = scan(rough(64, smooth=1.5, seed=4), pixel=10.0)
    pair = {"sphere_radius": 500, "contact_modulus": 40, "work_of_adhesion": 0.05}
    options = {"delta": np.linspace(-1, 5, 25), "subregions": (2, 2)}
    elastic = roughxr.superpose(roughxr.assign_pair(surface, **pair), **options)
    hard = roughxr.superpose(roughxr.assign_pair(surface, hardness=500.0, **pair), **options)
    np.testing.assert_array_equal(hard.pull_off_force, elastic.pull_off_force)
    for way in ("loading", "retraction"):
        for name in ("force", "contact_area", "contacts"):
            np.testing.assert_allclose(hard[name].sel(branch=way), elastic[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("preload", [None, 200.0])
def test_lazy_heights_yield_as_those_in_memory(preload):
    surface = scan(rough(64, smooth=1.5, seed=4), pixel=10.0)
    pair = {"sphere_radius": 500, "contact_modulus": 40, "work_of_adhesion": 0.05, "hardness": 1.0}
    options = {"delta": np.linspace(-1, 5, 13), "subregions": (2, 2), "preload": preload}
    lazy = roughxr.superpose(roughxr.assign_pair(surface.chunk(x=17, y=40), **pair), **options)
    eager = roughxr.superpose(roughxr.assign_pair(surface, **pair), **options)
    assert lazy.force.chunks is not None and eager.force.chunks is None
    xr.testing.assert_equal(lazy.compute(), eager)
    elastic = roughxr.assign_pair(surface, **pair).drop_vars("hardness")
    elastic = roughxr.superpose(elastic, **(options | {"preload": None}))
    assert eager.force.sel(branch="loading", delta=5.0).sum() < 0.6 * elastic.force.sel(delta=5.0).sum()


def test_what_does_not_go_together_is_refused():
    elastic = roughxr.assign_pair(scan(rough(64, seed=4)), sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05)
    with pytest.raises(ValueError, match="preload: expected asperities that yield"):
        roughxr.superpose(elastic, preload=10.0)
