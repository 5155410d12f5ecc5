"""What enters without units, or in a container that unfolds to far more than it holds, is not taken in silence."""

import json
import warnings
import zipfile

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.scans import open_container
from roughxr.scans.channel import UnreadableScan

from .surfaces import rough, scan


def test_a_scan_without_units_is_taken_as_nm_with_a_warning_that_states_its_size():
    axis = np.arange(8) * 1e-8
    bare = xr.Dataset({"height": (("x", "y"), 1e-9 * rough(8))}, {"x": axis, "y": axis})
    with pytest.warns(UserWarning, match="found none; taken as nm, a scan of 8e-08 x 8e-08 nm"):
        roughxr.roughness(bare)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        roughxr.roughness(scan(rough(8)))


def test_a_container_that_unfolds_to_far_more_is_refused(tmp_path):
    path = tmp_path / "bomb.zip"
    one = {"name": "a", "size": [1.0, 1.0], "unit": "um", "datafile": {"original": "a.txt"}}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", "0 " * 25_000_000)
        archive.writestr("index.json", json.dumps({"surfaces": [{"topographies": [one]}]}))
    with pytest.raises(UnreadableScan, match="content of at most 4 MiB, found 47"):
        open_container(path)
