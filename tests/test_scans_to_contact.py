"""Scans that are masked or not square end in a contact solution or in a clear refusal."""

import numpy as np
import pytest

from roughxr import direct
from roughxr.scans import fill, open_scan, resample, to_file

from .surfaces import glass_pair, rough, scan


@pytest.fixture
def bumpy(tmp_path):
    """Return a function that writes a scan of given pixels to a file and opens it again."""

    def opened(height, ratio=1.0):
        ds = scan(height, 8.0)
        ds = ds.assign_coords(y=("y", ds["y"].values * ratio, {"units": "nm"}))
        return glass_pair(open_scan(to_file(ds, tmp_path / "scan.gsf")))

    return opened


def pressed(ds, y=160.0):
    return float(direct(ds, delta=[3.0], subregions=([160.0], [y]))["force"].squeeze().compute())


def test_a_masked_scan_is_refused_until_it_is_filled(bumpy):
    height = rough(40)
    whole = pressed(bumpy(height))
    height[20:22, 20] = np.nan
    holed = bumpy(height)
    with pytest.raises(ValueError, match="2 missing pixels"):
        pressed(holed)
    assert pressed(fill(holed)) == pytest.approx(whole, rel=0.05)


@pytest.mark.filterwarnings("ignore:.*not square")
def test_pixels_that_are_not_square_are_resampled_to_their_finer_side(bumpy):
    """A surface of long waves only, which splines between its pixels restore."""
    height = rough(40, smooth=6.0, seed=1)
    oblong = bumpy(height[:, ::2], ratio=2.0)
    mended = resample(oblong, size="8 nm")  # its rows lie between the first scan's: the datum differs by 0.05 of 3 nm
    with pytest.warns(UserWarning, match="pixels of 8 × 16 nm are not square: heights are interpolated to 8 nm"):
        assert pressed(oblong, y=164.0) == pytest.approx(pressed(mended, y=164.0), rel=1e-9)
    assert pressed(mended, y=164.0) == pytest.approx(pressed(bumpy(height)), rel=0.04)
