"""Verbs load the heights of a lazy scan, with the same result; solves stay lazy along ``subregion``."""

import numpy as np
import pytest
import xarray as xr

from roughxr.mechanics.asperity.catalogue import asperities

from .surfaces import glass_pair, rough, scan


@pytest.mark.parametrize("options", [{}, {"patch": "20 nm"}], ids=str)
def test_the_same_for_a_lazy_scan(options):
    surface = glass_pair(scan(np.round(rough(52, smooth=1.5)[:48] / 0.5) * 0.5, title="a scan"))
    xr.testing.assert_identical(asperities(surface.chunk(x=7, y=11), **options), asperities(surface, **options))


@pytest.mark.parametrize("dims", [("x", "y"), ("y", "x")])
def test_other_units_and_numbers_are_converted(dims):
    surface = scan(np.round(rough(40, smooth=1.5) * 4))
    counts = (surface.height.transpose(*dims).astype("int16") * 1000).assign_attrs(units="pm")
    surface = surface.assign(height=counts)
    xr.testing.assert_identical(asperities(surface.chunk(x=11, y=17)), asperities(surface))


def test_pixels_finer_than_memory_allows_are_refused():
    with pytest.raises(ValueError, match=r"patch: expected at most .* heights, found .*; take a wider patch"):
        asperities(scan(np.zeros((2000, 2000))), patch="2 nm")


def test_missing_pixels_are_refused_in_the_same_words():
    height = rough(40)
    height[3, 4] = height[30, 30] = np.nan
    for surface in (scan(height), scan(height).chunk(x=20, y=10)):
        with pytest.raises(ValueError, match="2 missing pixels of 1600; fill them first"):
            asperities(surface)
