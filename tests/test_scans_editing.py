"""Fill, crop and resample: exact where they can be, lazy, and labels follow."""

import numpy as np
import pytest
import xarray as xr

from roughxr.mechanics.vocabulary import schema
from roughxr.scans import crop, fill, resample

from .surfaces import rough, scan


def stretched(ds, ratio):
    return ds.assign_coords(y=("y", ds["y"].values * ratio, {"units": "nm"}))


def plane(n=20, m=30, pixel=10.0):
    """Return the plane 0.1 x - 0.2 y."""
    ds = scan(np.zeros((n, m)), pixel)
    ds["height"] = (ds["height"] + 0.1 * ds["x"] - 0.2 * ds["y"]).assign_attrs(units="nm")
    return ds


def test_holes_in_a_plane_are_filled_exactly():
    whole = plane()
    ds = whole.copy(deep=True)
    ds["height"][4:8, 5:9] = np.nan
    ds["height"][12, 20] = np.nan
    filled = fill(ds)
    np.testing.assert_allclose(filled["height"], whole["height"], atol=1e-12)
    assert filled.filled_pixels == 17 and schema.history(filled)[-1]["operation"] == "fill"
    assert int(ds["height"].isnull().sum()) == 17  # the caller's scan is as it was


def test_holes_at_the_edge_take_the_nearest_pixel():
    ds = plane()
    ds["height"][:, 0] = np.nan
    np.testing.assert_allclose(fill(ds, method="nearest")["height"][:, 0], ds["height"][:, 1])
    assert not fill(ds)["height"].isnull().any()


def test_holes_can_be_set_to_a_height():
    ds = plane()
    ds["height"][3, 3] = np.nan
    assert float(fill(ds, method="0.5 um")["height"][3, 3]) == 500
    with pytest.raises(ValueError, match="method: expected 'linear', 'nearest' or a height"):
        fill(ds, method="guess")
    with pytest.raises(ValueError, match="expected known heights"):
        fill(ds.assign(height=ds["height"] * np.nan))


def test_a_crop_keeps_the_names_of_places():
    ds = scan(rough(40), 10.0)
    part = crop(ds, x=(-50, 50), y=("-0.1 um", "0.1 um"))
    assert part.sizes == {"x": 10, "y": 20}
    xr.testing.assert_equal(part["height"], ds["height"].sel(x=part["x"], y=part["y"]))
    assert schema.history(part)[-1]["arguments"] == {"x": [-50, 50], "y": ["-0.1 um", "0.1 um"]}
    for wrong, match in (((900, 950), "or more in -195"), ((5, -5), "lowest, highest"), (3, "expected a pair")):
        with pytest.raises(ValueError, match=match):
            crop(ds, x=wrong)


def test_resampling_makes_pixels_square_and_keeps_a_plane():
    ds = stretched(plane(), 1.5)
    square = resample(ds)
    assert schema.square_pixel(square) == pytest.approx(10)
    expected = 0.1 * square["x"] - 0.2 / 1.5 * square["y"]
    np.testing.assert_allclose(square["height"], expected, atol=1e-10)
    assert float(square["y"][-1]) <= float(ds["y"][-1])
    coarse = resample(ds, size="0.03 um")
    assert schema.pixel(coarse) == pytest.approx((30, 30))
    assert not square["height"].isnull().any() and not coarse["height"].isnull().any()
    with pytest.raises(ValueError, match="expected a pixel size below 190 nm along x"):
        resample(ds, size=1000)


@pytest.mark.parametrize("edit", [fill, lambda ds: crop(ds, x=(-40, 40)), lambda ds: resample(ds, size=7.0)])
def test_a_lazy_scan_gives_the_same(edit):
    ds = scan(rough(20), 10.0)
    ds["height"][3, 4] = np.nan
    np.testing.assert_allclose(edit(ds.chunk({"x": 6, "y": 7}))["height"], edit(ds)["height"])
