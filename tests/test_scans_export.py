"""What is written opens elsewhere with the same numbers, and is written whole or not at all."""

import netCDF4
import numpy as np
import pytest
import xarray as xr

from roughxr.scans import level, open_scan, to_file, to_netcdf

from .afm_files import expected_scan, image_size, picture

pytestmark = pytest.mark.filterwarnings("ignore:.*not square")


@pytest.fixture
def holed():
    """Return a scan that is neither square nor whole."""
    rows = picture()
    rows[2, 5:8] = np.nan
    return expected_scan(rows, image_size(rows, (5.0, 8.0)))


def test_gsffile_opens_its_file_with_the_same_numbers(holed, tmp_path):
    from gsffile import read_gsf

    rows, header = read_gsf(to_file(holed, tmp_path / "scan.gsf"))
    np.testing.assert_allclose(rows * 1e9, holed["height"].values.T[::-1], rtol=1e-6)
    assert (header["XReal"], header["YReal"]) == pytest.approx((120e-9, 144e-9))
    assert (header["XYUnits"], header["ZUnits"]) == ("m", "m")
    with pytest.raises(ValueError, match=r"path's ending: expected one of '\.gsf'"):
        to_file(holed, tmp_path / "scan.txt")


WRITTEN = pytest.mark.parametrize(("write", "name"), [(to_netcdf, "scan.nc"), (to_file, "scan.gsf")])


@WRITTEN
def test_there_and_back(write, name, holed, tmp_path):
    path = write(level(holed), tmp_path / name)
    with open_scan(path) as again:
        xr.testing.assert_allclose(again["height"], level(holed)["height"], rtol=1e-6, atol=1e-6)


@WRITTEN
def test_a_lazy_scan_is_written_alike(write, name, holed, tmp_path):
    paths = [write(ds, tmp_path / f"{i}-{name}") for i, ds in enumerate((holed, holed.chunk({"x": 7})))]
    first, second = (open_scan(path).load() for path in paths)
    xr.testing.assert_equal(first, second)


@WRITTEN
def test_a_failure_leaves_no_file_behind(write, name, holed, tmp_path):
    def fails(block):
        raise RuntimeError("half way")

    broken = holed.assign(height=xr.map_blocks(fails, holed["height"].chunk(), template=holed["height"].chunk()))
    path = tmp_path / name
    path.write_text("what was there before")
    with pytest.raises(RuntimeError, match="half way"):
        write(broken, path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_text() == "what was there before"


def test_a_flipped_height_in_our_own_file_is_noticed(holed, tmp_path):
    path = to_netcdf(holed, tmp_path / "scan.nc")
    content = bytearray(path.read_bytes())
    place = content.find(holed["height"].values[10].tobytes())
    content[place + 3] ^= 1
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"scan\.nc: NetCDF .* expected heights that can be read, found damaged ones"):
        open_scan(path).load()


def test_heights_larger_than_memory_are_not_called_damaged(tmp_path):
    """Chunks that were never written take no space: 800 TB of heights in some MB."""
    path = tmp_path / "large.nc"
    with netCDF4.Dataset(path, "w") as file:
        for name in ("x", "y"):
            file.createDimension(name, 10**7)
            file.createVariable(name, "f4", (name,))[:] = np.arange(10**7)
            file[name].units = "nm"
        file.createVariable("height", float, ("x", "y"), chunksizes=(1000, 1000)).units = "nm"
    with pytest.raises(
        ValueError, match=r"large\.nc: expected a content of at most .* by its size, found 7.63e\+08 MiB"
    ):
        open_scan(path).load()


def test_a_map_that_is_not_there_is_refused(holed, tmp_path):
    with pytest.raises(ValueError, match="name: expected one of 'height', found 'pull_off_force'"):
        to_file(holed, tmp_path / "pull.gsf", name="pull_off_force")
