from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from datasets import make_glass
from datasets.make_glass import glass, particle_centres, write_glass
from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.kernels.topography.random_surface import uniform
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.vocabulary import schema

SHIPPED = Path(__file__).parents[1] / "datasets" / "glass.nc"
PINNED = [0.6369616873214543, 0.26978671376387037]
GIVEN = {"rms": 1.5, "hurst": 0.6, "rolloff": 300.0, "seed": 3}


@pytest.fixture(scope="module")
def twin():
    return glass()


def test_same_seed_same_surface_other_seed_another():
    first, again = (self_affine((64, 48), 10, **GIVEN) for _ in range(2))
    other = self_affine((64, 48), 10, **{**GIVEN, "seed": 4})
    assert first.height.values.tobytes() == again.height.values.tobytes()
    assert abs(np.corrcoef(first.height.values.ravel(), other.height.values.ravel())[0, 1]) < 0.3


def test_raw_bits_are_those_of_any_numpy():
    """Two numbers written down once: a change would make every seed another surface."""
    assert uniform(2, 0, 0) == pytest.approx(np.array(PINNED), abs=1e-15)


def test_rms_mean_labels_and_units():
    scan = schema.validate(self_affine((64, 48), "10 nm", **{**GIVEN, "rms": "0.0015 um"}), "scan")
    assert float(scan.height.std()) == pytest.approx(1.5, rel=1e-12)
    assert abs(float(scan.height.mean())) < 1e-12
    assert dict(scan.sizes) == {"x": 64, "y": 48}
    assert [scan[name].attrs["units"] for name in ("height", "x", "y")] == ["nm"] * 3
    assert scan.x.values[:2].tolist() == [5.0, 15.0]
    assert scan.attrs["synthetic"] == "yes" and scan.attrs["hurst"] == 0.6 and "cutoff" not in scan.attrs
    assert schema.history(scan)[-1]["operation"] == "self_affine"


@pytest.mark.parametrize("hurst", [0.2, 0.8])
def test_spectrum_falls_with_the_hurst_exponent(hurst):
    pixel = 10.0
    rolloff = 1000.0
    scan = self_affine((512, 512), pixel, rms=1, hurst=hurst, rolloff=rolloff, seed=1)
    density = np.abs(np.fft.fft2(scan.height.values)) ** 2
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(512, pixel)] * 2))
    edges = np.geomspace(5 / rolloff, 0.5 / pixel, 12)
    rings = np.digitize(frequency, edges)
    mean = [density[rings == k].mean() for k in range(1, edges.size)]
    slope = np.polyfit(np.log(np.sqrt(edges[1:] * edges[:-1])), np.log(mean), 1)[0]
    assert slope == pytest.approx(-2 * (1 + hurst), abs=0.08)


def test_spectrum_is_flat_above_the_rolloff():
    density = np.abs(np.fft.fft2(self_affine((512, 512), 10, **{**GIVEN, "rolloff": 10}).height.values)) ** 2
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(512, 10.0)] * 2))
    bands = (0.001, 0.005), (0.005, 0.01)
    coarse, fine = (density[(frequency > low) & (frequency < high)].mean() for low, high in bands)
    assert coarse == pytest.approx(fine, rel=0.15)


def test_nothing_is_left_below_the_cutoff():
    scan = self_affine((128, 128), 10, cutoff=50, **GIVEN)
    density = np.abs(np.fft.fft2(scan.height.values)) ** 2
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(128, 10.0)] * 2))
    assert density[frequency > 1 / 50 + 1e-9].max() < 1e-18 * density.max()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"shape": (64,)}, "shape: expected two whole numbers"),
        ({"hurst": 1.2}, "hurst: expected a number from 0 to 1, found 1.2"),
        ({"cutoff": 1e6}, "cutoff: expected at most the scan's length"),
        ({"seed": -1}, "seed: expected a whole number"),
    ],
)
def test_bad_input_is_named(wrong, message):
    options = {"shape": (16, 16), "pixel": 10, **GIVEN, **wrong}
    with pytest.raises(ValueError, match=message):
        self_affine(options.pop("shape"), options.pop("pixel"), **options)


def test_glass_is_a_scan_of_the_published_size(twin):
    schema.validate(twin, "scan")
    assert dict(twin.sizes) == {"x": 512, "y": 512}
    assert schema.square_pixel(twin) == 9.765625
    assert twin.attrs["synthetic"] == "yes" and "unpublished" in twin.attrs["comment"]
    assert schema.history(twin)[-1]["operation"] == "glass"


def test_glass_heights_are_tenths_in_the_published_range(twin):
    height = twin.height.values
    assert np.array_equal(height, np.round(height, 1))
    assert 3 < height.min() < 5 and height.max() == 27.0
    assert height.mean() == pytest.approx(12.84, abs=0.01)
    assert 1.5 < height.std() < 2.0


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_six_tiles_hold_a_peak_near_27_nm(seed):
    peaks = asperities(glass(seed=seed))
    high = peaks.isel(asperity=peaks.height.values > 22)
    tiles = set(zip((high.x.values // 625).tolist(), (high.y.values // 625).tolist()))
    assert tiles == {tuple(tile) for tile in (particle_centres(seed=seed) // 625).tolist()}
    assert len(tiles) == 6


def test_shipped_file_is_what_is_made(tmp_path, twin, monkeypatch):
    monkeypatch.setattr(make_glass, "glass", lambda: twin)
    write_glass(tmp_path / "glass.nc")
    with xr.open_dataset(tmp_path / "glass.nc") as made, xr.open_dataset(SHIPPED) as shipped:
        for ds in (made, shipped):
            assert schema.height_hash(ds) == schema.height_hash(twin)
        made_attrs, shipped_attrs = ({k: v for k, v in ds.attrs.items() if k != "history"} for ds in (made, shipped))
        np.testing.assert_equal(made_attrs, shipped_attrs)
