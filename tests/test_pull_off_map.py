"""The exact pull-off against plain superposition, very fine sweeps and single asperities."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.asperity.asperity_sum import FORMULATIONS
from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.kernels.asperity import branches
from roughxr.mechanics.kernels.asperity import pull_off_search as kernel
from roughxr.mechanics.kernels.asperity.asperity_laws import Scales, law
from roughxr.mechanics.kernels.asperity.elliptic_table import LARGEST_RATIO
from roughxr.statistics import pull_off

from .surfaces import glass_pair, rough, scan
from .test_superposition import W, one_asperity

RATIOS = np.exp(np.linspace(0, np.log(LARGEST_RATIO), 25))


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(128, rms=1.5, seed=11)))


@pytest.fixture(scope="module")
def glass():
    scan = roughxr.open_sample("glass")
    return roughxr.assign_pair(scan, sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)


def unit_scales(ratio):
    """Return the scales of an asperity in its own units, P* = δ* = a* = 1."""
    from roughxr.mechanics.kernels.asperity.asperity_laws import asperity_scales

    scales = asperity_scales(1e-3, 1e-3 * ratio, 40.0, 1.0, law("energy"))
    return Scales(1.0, 1.0, 1.0, 1.0, scales.end, scales.row)


def a_line(ratio):
    scales = unit_scales(ratio)
    line = np.empty(branches.LENGTH)
    branches.collapse(law("energy").spline, scales.row, branches.P, line)
    return scales, line


def test_every_branch_is_convex_and_begins_with_a_pull():
    """On this the proof of the walk rests."""
    above_end = np.linspace(1e-4, 12, 4001) ** 2
    for ratio in RATIOS:
        _, line = a_line(ratio)
        forces = np.array([branches.line_force(line, at) for at in above_end])
        assert (np.diff(forces[:, 1]) > 0).all()
        assert forces[0, 0] < 0
    closed = np.array([branches.closed_force(d) for d in -(3.0 ** (-1 / 3)) + above_end])
    assert (np.diff(closed[:, 1]) > 0).all()
    assert closed[0, 0] < 0


def test_no_branch_falls_below_its_mark():
    """The bound uses the largest tension of an asperity from the table, increased by the table's error."""
    from roughxr.mechanics.kernels.asperity.elliptic_table import mark_at_row

    for ratio in RATIOS:
        scales, line = a_line(ratio)
        least = min(branches.line_force(line, at)[0] for at in np.linspace(0.01, 1.5, 3001) ** 2)
        assert least >= mark_at_row(law("energy").marks, scales.row, 1) * (1 + kernel._TABLE_ERROR)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_no_fine_sweep_finds_a_larger_pull(surface, formulation):
    """At the displacement found `superpose` gives that very force, and none of 12,000 displacements a lower one."""
    rng = np.random.default_rng(0)
    low = float(surface.x[0])
    high = float(surface.x[-1])
    places = rng.uniform(low, high, 30), rng.uniform(low, high, 30)
    summed = superpose(surface, delta=[0.0], subregions=places, formulation=formulation)
    deltas = np.arange(-4, 20, 0.002)
    swept = pull_off(superpose(surface, delta=deltas, subregions=places, formulation=formulation))
    excess = summed.pull_off_force - swept.pull_off_force
    assert (excess >= 0).all()
    assert (excess < 0.02 * summed.pull_off_force).all()
    np.testing.assert_allclose(summed.pull_off_delta, swept.pull_off_delta, atol=0.03)
    near = np.unique(summed.pull_off_delta.values[:, None] + np.linspace(-1e-4, 1e-4, 9))
    closer = superpose(surface, delta=near, subregions=places, formulation=formulation).force.min("delta")
    assert (summed.pull_off_force >= -closer * (1 - 1e-12)).all()


def test_the_map_is_plain_superposition_at_200_random_centres(glass):
    """To 1e-10, at every pixel's place on the map; contacts and flags too."""
    rng = np.random.default_rng(1)
    catalogue = asperities(glass)
    i, j = rng.integers(0, 512, (2, 200))
    x = glass.x.values[i]
    y = glass.y.values[j]
    mapped = pull_off_map(catalogue, subregions=(x, y))
    deltas, delta_index = np.unique(mapped.pull_off_delta, return_inverse=True)
    at_all_deltas = superpose(catalogue, delta=deltas, subregions=(x, y))
    at_own = at_all_deltas.isel(
        subregion=xr.DataArray(range(200), dims="place"), delta=xr.DataArray(delta_index, dims="place")
    )
    np.testing.assert_allclose(at_own.force, -mapped.pull_off_force, rtol=1e-10)
    for name in ("contacts", "truncated"):
        np.testing.assert_array_equal(at_own[name], mapped[name])


def test_nothing_pulls_harder_anywhere(glass):
    """The proof beyond the first look, checked by sweeping on to where the whole scan is in contact."""
    rng = np.random.default_rng(2)
    places = rng.uniform(500, 4500, 6), rng.uniform(500, 4500, 6)
    catalogue = asperities(glass)
    mapped = pull_off_map(catalogue, subregions=places)
    swept = superpose(catalogue, delta=np.arange(0, 120, 0.25), subregions=places)
    assert (-swept.force.min("delta") <= mapped.pull_off_force).all()


def test_every_pixel_lies_on_the_scan(surface):
    part = surface.isel(x=slice(20, 41), y=slice(30, 47))
    mapped = pull_off_map(part)
    assert mapped.pull_off_force.dims == ("x", "y")
    assert mapped.pull_off_force.shape == (21, 17)
    x, y = np.meshgrid(part.x, part.y, indexing="ij")
    listed = pull_off_map(part, subregions=(x.ravel(), y.ravel()))
    np.testing.assert_array_equal(mapped.pull_off_force.values.ravel(), listed.pull_off_force)
    np.testing.assert_array_equal(mapped.pull_off_delta.values.ravel(), listed.pull_off_delta)
    assert mapped.pull_off_force.units == "nN"


def test_one_sphere_pulls_off_as_jkr():
    """3/2 π w R' at δ* = −1/3, found to rounding and not to a sweep's step."""
    radius = 1 / (1 / 200 + 1 / 3000)
    ds = one_asperity(1 / 200, 1 / 200)
    summed = superpose(ds, delta=[0.0], subregions=(1, 1), formulation="self_similar")
    assert summed.pull_off_force.item() == pytest.approx(1.5 * np.pi * W * radius, rel=1e-9)
    unit = (9 * np.pi * W * radius**2 / (8 * float(ds.contact_modulus))) ** (2 / 3) / radius
    assert summed.pull_off_delta.item() == pytest.approx(-unit / 3, abs=1e-6)
    least = pull_off_map(ds, subregions=(1, 1))
    assert least.pull_off_force.item() == pytest.approx(summed.pull_off_force.item(), rel=1e-5)
    assert least.contacts.item() == 1


def test_nothing_pulls_without_adhesion(surface):
    dry = pull_off_map(surface.assign_coords(work_of_adhesion=0.0), subregions=(2, 2))
    assert dry.pull_off_force.isnull().all()
    assert dry.pull_off_delta.isnull().all()


@pytest.mark.filterwarnings("ignore:delta. 500 nm")  # so deep on purpose
@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_asperities_far_away_are_found(surface, count):
    """The look grows until it meets them, however far they lie, and stops when there is nothing else."""
    catalogue = asperities(surface)
    far_asperities = catalogue.isel(asperity=np.flatnonzero(~catalogue.saddle)[:count])
    mapped = pull_off_map(far_asperities, subregions=([float(surface.x[-1])], [float(surface.y[-1])]))
    swept = superpose(
        far_asperities, delta=np.arange(-4, 500, 0.01), subregions=([float(surface.x[-1])], [float(surface.y[-1])])
    )
    assert mapped.pull_off_force.item() >= -swept.force.min().item()
    assert mapped.pull_off_force.item() == pytest.approx(-swept.force.min().item(), rel=1e-3)


def test_a_scan_without_asperities_pulls_nowhere():
    flat = glass_pair(scan(np.tile(np.linspace(0, 1, 9), (9, 1))))
    empty = asperities(flat).isel(asperity=slice(0))
    assert pull_off_map(empty, subregions=(2, 2)).pull_off_force.isnull().all()


def test_results_do_not_depend_on_the_company(surface):
    """Each centre alone gives the very bits that it gives among others."""
    together = pull_off_map(surface, subregions=(5, 5))
    x, y = (together[name].values for name in ("subregion_x", "subregion_y"))
    alone = [pull_off_map(surface, subregions=(x[k : k + 1], y[k : k + 1])) for k in range(25)]
    np.testing.assert_array_equal(together.pull_off_force, [a.pull_off_force.item() for a in alone])
    np.testing.assert_array_equal(together.pull_off_delta, [a.pull_off_delta.item() for a in alone])


def test_a_catalogue_has_no_pixels(surface):
    with pytest.raises(ValueError, match="expected a scan, found a catalogue"):
        pull_off_map(asperities(surface))
    with pytest.raises(ValueError, match="subregions: expected one of 'every pixel'"):
        pull_off_map(surface, subregions="all")


def test_a_default_sweep_ends_though_some_places_have_no_asperity_below_the_sphere():
    summit = one_asperity(1 / 200, 1 / 200).contact.assign_pair(sphere_radius=40, materials="glass")
    swept = superpose(summit, subregions=([0.0, 120.0], [0.0, 120.0]))
    np.testing.assert_array_equal(swept.delta, superpose(summit, subregions=([0.0], [0.0])).delta)
    assert np.isfinite(swept.force).all() and (swept.force.isel(subregion=1) == 0).all()
    assert pull_off(swept).attrs["missing"].endswith("at any displacement of the exact search")
