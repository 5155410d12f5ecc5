"""Catalogue and reconstruction with labels: what a scan of known shape must give."""

import warnings

import numpy as np
import pytest

from roughxr import Mesh, reference
from roughxr.mechanics.asperity.catalogue import asperities, poorly_fitted
from roughxr.mechanics.asperity.reconstruction import reconstruct
from roughxr.mechanics.kernels.topography.peaks import search
from roughxr.mechanics.scans.synthetic import self_affine

from .surfaces import glass_pair, rough, scan


def paraboloids(centres, n=81, pixel=5.0, flattest=0.4, curvatures=(0.002, 0.006)):
    """Return the upper envelope of equal paraboloids at the given centres (nm), 10 nm high."""
    x = (np.arange(n) - (n - 1) / 2) * pixel
    surface = np.full((n, n), -np.inf)
    for cx, cy in centres:
        u = (x[:, None] - cx) * np.cos(flattest) + (x[None, :] - cy) * np.sin(flattest)
        v = -(x[:, None] - cx) * np.sin(flattest) + (x[None, :] - cy) * np.cos(flattest)
        surface = np.maximum(surface, 10 - curvatures[0] / 2 * u**2 - curvatures[1] / 2 * v**2)
    return scan(surface, pixel=pixel)


def test_exact_paraboloids_are_recovered_to_rounding():
    centres = [(-91.3, -80.2), (83.1, 77.7), (-74.9, 92.4)]
    catalogue = asperities(paraboloids(centres), patch=5).sortby("x")
    assert catalogue.sizes["asperity"] == 3
    np.testing.assert_allclose(np.c_[catalogue.x, catalogue.y], sorted(centres), atol=1e-9)
    np.testing.assert_allclose(catalogue.height, 10, atol=1e-10)
    np.testing.assert_allclose(catalogue.curvature_min, 0.002, rtol=1e-9)
    np.testing.assert_allclose(catalogue.curvature_max, 0.006, rtol=1e-9)
    np.testing.assert_allclose(catalogue.orientation, 0.4, atol=1e-9)
    np.testing.assert_allclose(catalogue.fit_rms, 0, atol=1e-12)
    assert not (catalogue.saddle | catalogue.edge | catalogue.vertex_fixed).any()


def test_catalogue_is_labelled_and_remembers_its_scan():
    catalogue = asperities(glass_pair(scan(rough(40))), patch=5)
    for name in catalogue.variables:
        assert catalogue[name].attrs["units"], name
    assert float(catalogue.datum_height) == float(scan(rough(40)).height.max())
    assert float(catalogue.patch_radius) == pytest.approx(2.5 * 9.77)
    assert float(catalogue.sphere_radius) == 3000


def test_a_flat_scan_has_no_asperity_and_cannot_be_reconstructed():
    assert asperities(scan(np.zeros((20, 20)))).sizes["asperity"] == 0
    with pytest.raises(ValueError, match="at least one asperity"):
        reconstruct(scan(np.zeros((20, 20))))


def test_the_envelope_of_exact_paraboloids_is_the_surface():
    surface = paraboloids([(-91.3, -80.2), (83.1, 77.7)])
    envelope = reconstruct(surface)
    np.testing.assert_allclose(envelope.height, surface.height, atol=1e-8)
    assert envelope.attrs["residual_rms"] < 1e-8


def test_the_envelope_matches_peaks_and_its_residual_is_told():
    surface = scan(rough(96, smooth=3.0))
    envelope = reconstruct(surface)
    difference = (envelope.height - surface.height).values
    assert envelope.attrs["residual_rms"] == pytest.approx(np.sqrt((difference**2).mean()))
    catalogue = asperities(surface)
    peaks = surface.height.sel(x=catalogue.x, y=catalogue.y, method="nearest")
    above = envelope.height.sel(x=catalogue.x, y=catalogue.y, method="nearest") - peaks
    assert float(np.abs(above).median()) < 0.05 * float(surface.height.std())


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"patch": 4}, "odd"),
        ({"patch": 99}, "to 20"),
        ({"patch": 15.0}, "a length such as '15 nm'"),
        ({"patch": "1 nm"}, "at least 1.83 nm"),
    ],
)
def test_bad_options_are_refused_in_words(options, says):
    with pytest.raises(ValueError, match=says):
        asperities(scan(rough(20)), **options)


def wave(pixels, count=96, pixel=5.0, amplitude=1.0):
    """Return an egg box of one wavelength (pixels), its summits between the pixels, and the summits' curvature."""
    x = np.arange(count) + 0.37
    length = pixels * pixel
    height = 0.5 * amplitude * np.add.outer(np.cos(2 * np.pi * x / pixels), np.cos(2 * np.pi * (x + 0.21) / pixels))
    return scan(height, pixel=pixel), 0.5 * amplitude * (2 * np.pi / length) ** 2


@pytest.mark.parametrize("pixels", [2.7, 3.4, 4.6, 6.3, 10.7, 17.2])
def test_the_patch_follows_the_wave_and_finds_its_summits(pixels):
    """A fit over a sixth of a cosine gives its curvature to a few per cent; one over two waves does not."""
    surface, curvature = wave(pixels)
    catalogue = asperities(surface)
    assert float(catalogue.shortest_wavelength) == pytest.approx(5 * pixels, rel=0.25)
    width = 2 * float(catalogue.patch_radius)
    assert 0.08 * 5 * pixels < width <= 0.4 * 5 * pixels
    inner = catalogue.isel(asperity=np.flatnonzero(~catalogue.edge & (catalogue.height > 0)))
    blunted = 0.4 if pixels < 4 else 0.08  # more by the spline, which knows no wave between the pixels
    for name in ("curvature_min", "curvature_max"):
        assert (1 - blunted) * curvature < float(inner[name].median()) < 1.08 * curvature
    np.testing.assert_allclose(inner.height.median(), 1.0, atol=0.01 if pixels > 4 else 0.11)
    expected = (96 / pixels) ** 2
    assert 0.75 * expected < inner.sizes["asperity"] < 1.1 * expected
    if pixels < 5:
        wide = asperities(surface, patch="paper")
        assert float(wide.curvature_max.median()) < 0.6 * curvature


def egg_box(pixel=2.0, shift=0.0, count=65):
    """Return z = 1.5 nm cos cos of 32 nm, whose summits have the radius L²/(4π² 1.5 nm) = 17.29 nm."""
    x = np.cos(2 * np.pi * (np.arange(count) + shift) * pixel / 32)
    return scan(1.5 * np.multiply.outer(x, x), pixel=pixel)


RADIUS = 32**2 / (4 * np.pi**2 * 1.5)


@pytest.mark.parametrize(("pixel", "count"), [(1.0, 130), (2.0, 65), (2.0, 128), (3.3, 60)])
def test_summits_of_a_grid_have_their_radius_whatever_the_pixels(pixel, count):
    for shift in (0.0, 0.5):
        summits = asperities(egg_box(pixel, shift, count))
        radius = 1 / np.sqrt(summits.curvature_min * summits.curvature_max)[~summits.edge]
        assert float(radius.median()) == pytest.approx(RADIUS, rel=0.03)


def test_the_formula_and_the_sum_for_a_summit_of_a_grid_are_those_of_its_radius():
    """Rumpf's formula in closed form; one summit under the sphere against JKR and the simulation."""
    pair = egg_box().contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    place = {"subregions": ([0.0], [0.0])}
    formula = pair.contact.formulas(**place)
    bodies = {name: formula.attrs[name] for name in ("hamaker_constant", "closest_approach")}
    expected = reference.rumpf(asperity_radius=RADIUS, radius=500, **bodies)
    assert float(formula.pull_off_force.sel(formula="rumpf")) == pytest.approx(expected, rel=0.03)
    superposed = float(pair.contact.pull_off_map(**place).pull_off_force.squeeze())
    assert superposed == pytest.approx(1.5 * np.pi * 0.1 / (1 / RADIUS + 1 / 500), rel=0.03)
    simulated = pair.contact.adhesive(law="jkr", mesh=Mesh(8, step=0.1), **place)
    assert superposed == pytest.approx(float(simulated.pull_off_force[0]), rel=0.05)


def ridge(ratio, turn=0.5, centre=(0.0, 0.0)):
    """Return one paraboloid of this ratio of its curvatures, turned (rad), of a radius of 1000 nm on pixels of 1 nm."""
    x = np.arange(91) - 45.0
    along_x, along_y = np.meshgrid(x - centre[0], x - centre[1], indexing="ij")
    along = np.cos(turn) * along_x + np.sin(turn) * along_y
    across = np.cos(turn) * along_y - np.sin(turn) * along_x
    return scan(-(along**2 / np.sqrt(ratio) + across**2 * np.sqrt(ratio)) / 2000, pixel=1.0)


@pytest.mark.parametrize(
    ("ratio", "turn", "centre"), [(20, 0.5, (0, 0)), (50, 0.5, (0, 0)), (100, 0.5, (0, 0)), (100, 0.2, (0.3, 0.4))]
)
def test_a_ridge_across_the_pixels_counts_once(ratio, turn, centre):
    summit = asperities(ridge(ratio, turn, centre))
    assert summit.sizes["asperity"] == 1
    curvature = [float(summit[name][0]) for name in ("curvature_min", "curvature_max")]
    np.testing.assert_allclose(curvature, [ratio**-0.5 / 1000, ratio**0.5 / 1000], rtol=1e-6)
    if turn == 0.5 and ratio > 20:
        assert search(ridge(ratio, turn, centre).height.values).ix.size in (3, 5)


@pytest.mark.parametrize("ratio", [4, 25, 100])
def test_a_corrugated_surface_has_two_summits_in_each_period(ratio):
    """z = cos(au) cos(bv) turned by 0.2 rad, b = 2π/20 nm, b/a = √ratio; its highest pixels are up to thrice that."""
    x = np.arange(301) - 150.0
    along = np.cos(0.2) * x[:, None] + np.sin(0.2) * x
    across = np.cos(0.2) * x - np.sin(0.2) * x[:, None]
    lengths = 20 * ratio**0.5, 20
    height = np.cos(2 * np.pi * along / lengths[0]) * np.cos(2 * np.pi * across / lengths[1])
    count = asperities(scan(height, pixel=1.0)).sizes["asperity"]
    assert count == pytest.approx(2 * 301**2 / np.prod(lengths), rel=0.06)


def test_a_length_is_the_patch_and_splines_what_is_less_than_three_pixels():
    surface = scan(rough(64), pixel=10.0)
    for asked, width in (("57 nm", 50.0), ("30 nm", 30.0), ("48 nm", 45.0), ("16 nm", 15.0), ("0.01 um", 10.0)):
        assert 2 * float(asperities(surface, patch=asked).patch_radius) == pytest.approx(width)


def test_splined_summits_are_those_of_the_surface_in_finer_pixels():
    """Of a wave of 2.6 pixels, every summit between the pixels; a scan four times finer is the oracle."""
    fine = self_affine((512, 512), 2.5, rms=1.5, hurst=0.8, rolloff=200, cutoff=26, seed=4)
    coarse = fine.isel(x=slice(None, None, 4), y=slice(None, None, 4))
    catalogue = asperities(coarse)
    oracle = asperities(fine)
    assert float(catalogue.pixel) == 10.0
    assert catalogue.sizes["asperity"] == pytest.approx(oracle.sizes["asperity"], rel=0.05)
    for name in ("height", "curvature_min", "curvature_max", "axis_ratio"):
        assert float(catalogue[name].median()) == pytest.approx(float(oracle[name].median()), rel=0.15)
    pixels = asperities(coarse, patch=3)
    assert pixels.sizes["asperity"] < 0.85 * oracle.sizes["asperity"]


def test_the_papers_patch_is_five_pixels_with_the_vertex_at_the_peak():
    """Its curvatures are those of three coefficients fitted by NumPy, without a warning."""
    surface = scan(rough(40), pixel=10.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        catalogue = asperities(surface, patch="paper")
    assert bool(catalogue["vertex_fixed"].all()) and float(catalogue["patch_radius"]) == 25.0
    peak = surface["height"].sel(x=catalogue["x"], y=catalogue["y"])  # raises between pixels
    np.testing.assert_array_equal(catalogue["height"], peak)
    first = catalogue.isel(asperity=int(np.flatnonzero(~catalogue["edge"] & (catalogue["plateau_size"] == 1))[0]))
    around = [slice(float(first[axis]) - 20, float(first[axis]) + 20) for axis in "xy"]
    patch = surface["height"].sel(x=around[0], y=around[1])
    x, y = np.meshgrid(patch["x"] - first["x"], patch["y"] - first["y"], indexing="ij")
    depth = (first["height"] - patch).values.ravel()
    terms = np.column_stack([x.ravel() ** 2, y.ravel() ** 2, (x * y).ravel()])
    A, B, C = np.linalg.lstsq(terms, depth, rcond=None)[0]
    expected = np.linalg.eigvalsh([[2 * A, C], [C, 2 * B]])
    np.testing.assert_allclose([first["curvature_min"], first["curvature_max"]], expected, rtol=1e-9)


def test_a_paraboloid_that_is_none_is_told():
    surface = self_affine((128, 128), 10, rms=1.5, hurst=0.4, rolloff=90, cutoff=25, seed=2)
    with pytest.warns(UserWarning, match="do not fit a paraboloid on a patch of 50 nm.*take patch='auto'"):
        asperities(surface, patch=5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert poorly_fitted(asperities(surface)) < 0.2 < 0.8 < poorly_fitted(asperities(surface, patch="paper"))


def test_a_plane_and_a_level_scan_have_no_wave():
    assert asperities(scan(np.full((40, 40), 3.7))).sizes["asperity"] == 0
    tilted = asperities(scan(np.add.outer(np.arange(40.0), np.arange(40.0)) * 0.1 + 3.7))
    assert float(tilted.shortest_wavelength) == np.inf and tilted.sizes["asperity"] == 0


def test_flat_tops_stay_flat_between_the_pixels():
    height = np.round(rough(64, rms=1.0, smooth=0.9) * 2) / 2
    height[20:30, 20:30] = 9.0
    catalogue = asperities(scan(height), patch="10 nm")
    assert catalogue.sizes["asperity"] > 0 and bool(np.isfinite(catalogue.height).all())
    assert float(catalogue.datum_height) == 9.0
