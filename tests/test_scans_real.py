"""Real files: sizes and ranges as measured by other readers, orientation as SurfaceTopography has it."""

import numpy as np
import pytest

from roughxr import asperities
from roughxr.mechanics.kernels.topography.peaks import search
from roughxr.scans import ImplausibleScan, crop, level, open_scan, roughness

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")

#: file -> pixels (x, y), size (nm), range (nm), rms about the plane and about the quadratic (nm).
MEASURED = {
    "bruker_10um_512_rough.di": ((512, 512), (10000, 10000), 123.890308, 14.32, 14.29),
    "bruker_10um_256_tilted.di": ((256, 256), (10000, 10000), 1210.130616, 35.2, 34.4),
    "gwyddion_ascii_10um_256.txt": ((256, 256), (10000, 10000), 408.83, 35.2, 34.4),
    "park_1um_512_grains.tiff": ((512, 512), (1000, 1000), 36.690366, 3.93, 3.93),
    "asylum_2um_256_film.ibw": ((256, 256), (2007.843137, 2007.843137), 6.425196, 0.64, 0.57),
    "gwyp_10um_256_pto.gwy": ((256, 256), (10039.215686, 10039.215686), 125.095312, 4.63, 4.63),
    "gsf_80um_300_chip.gsf": ((300, 300), (80000, 80000), 6980.5164, 1274.3, 1189.1),
    "digitalsurf_optical_masked.sur": ((563, 484), (1961492.12, 1686256.11), 1476.0, 17.1, 11.4),
}


def opened(path):
    if path.suffix == ".gsf":  # a chip with walls
        with pytest.warns(ImplausibleScan, match="slope exceeds 1 .* 11.4 %"):
            return open_scan(path)
    return open_scan(path)


@pytest.mark.parametrize("name", MEASURED)
def test_size_and_range(name, shared_scans):
    pixels, size, relief, plane, quadratic = MEASURED[name]
    scan = opened(shared_scans / name)
    assert (scan.sizes["x"], scan.sizes["y"]) == pixels
    widths = [scan.sizes[axis] * float(scan[axis][1] - scan[axis][0]) for axis in "xy"]
    np.testing.assert_allclose(widths, size, rtol=1e-6)
    assert float(scan["height"].max() - scan["height"].min()) == pytest.approx(relief, rel=1e-6)
    about_plane = float(roughness(scan)["s_q"])
    assert about_plane == pytest.approx(plane, rel=0.005, abs=0.005)
    assert float(level(scan, method="quadratic")["height"].std()) == pytest.approx(quadratic, rel=0.005, abs=0.005)


def test_masked_pixels_of_a_real_file(shared_scans):
    scan = open_scan(shared_scans / "digitalsurf_optical_masked.sur")
    assert int(scan["height"].isnull().sum()) == 117


@pytest.mark.parametrize("name", [n for n in MEASURED if n.rpartition(".")[2] in ("di", "tiff", "ibw", "sur", "gwy")])
def test_orientation_is_surfacetopographys(name, shared_scans):
    from SurfaceTopography import open_topography

    heights = open_topography(str(shared_scans / name)).channels[0].topography()
    expected = np.ma.filled(heights.heights(), np.nan)[:, ::-1]  # y counts downwards there
    scan = opened(shared_scans / name)["height"].values
    ratio = np.nanstd(scan) / np.nanstd(expected)
    assert np.log10(ratio) == pytest.approx(round(np.log10(ratio)), abs=1e-9)  # a unit, and no more
    np.testing.assert_allclose(scan, expected * ratio, rtol=1e-9)


def test_a_bruker_file_and_its_export_as_text_agree(shared_scans):
    binary = level(open_scan(shared_scans / "bruker_10um_256_tilted.di"))["height"]
    text = level(open_scan(shared_scans / "gwyddion_ascii_10um_256.txt"))["height"]
    np.testing.assert_allclose(text["x"], binary["x"])
    assert float(abs(text - binary).max()) < 0.01  # of 409 nm; the text has five digits


def test_channels_of_a_real_file(shared_scans):
    path = shared_scans / "bruker_10um_512_rough.di"
    trace = open_scan(path)
    retrace = open_scan(path, channel="Height", scan_direction="retrace")
    a, b = (scan["height"].values.ravel() for scan in (trace, level(retrace)))
    assert np.corrcoef(level(trace)["height"].values.ravel(), b)[0, 1] == pytest.approx(0.94, abs=0.01)
    assert np.unique(a).size == 1055


def test_asylums_size_is_the_stored_step(shared_scans):
    scan = open_scan(shared_scans / "asylum_2um_256_film.ibw")
    assert float(scan["x"][1] - scan["x"][0]) == pytest.approx(2000 / 255)
    assert scan.attrs["scan_direction"] == "retrace"


def test_a_quarter_of_a_rough_scan(shared_scans):
    scan = open_scan(shared_scans / "bruker_10um_512_rough.di")
    quarter = roughness(crop(scan, x=(0, 5000), y=("5 um", "10 um")))
    assert float(quarter["size_x"]) == 5000
    assert 13.5 < float(quarter["s_q"]) < 14.8


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@pytest.mark.parametrize(
    "name", ["bruker_10um_512_rough.di", "park_1um_512_grains.tiff", "gwyddion_ascii_10um_256.txt"]
)
def test_scans_without_long_ridges_have_a_summit_on_each_highest_pixel(name, shared_scans):
    scan = level(opened(shared_scans / name))
    assert asperities(scan, patch=3).sizes["asperity"] == search(scan.height.values).ix.size
