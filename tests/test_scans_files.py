"""Every format opens with the right heights, sizes, orientation and units, or is refused with the reason."""

import hashlib
import json
import os
import pickle
import re
import sys
import warnings

import numpy as np
import pytest
import xarray as xr

from roughxr import archive
from roughxr.mechanics.vocabulary import schema
from roughxr.scans import ImplausibleScan, RoughxrBackend, UnreadableScan, describe, open_scan, to_netcdf

from .afm_files import (
    ROUNDING,
    WRITERS,
    expected_scan,
    given,
    image_size,
    picture,
    write_bruker,
    write_cf,
    write_gsf,
    write_gwy,
    write_nanoscope,
    write_native,
    write_npy,
    write_surfacetopography,
    write_text,
)

LABELLED = ("native", "surfacetopography", "cf")


def assert_same(scan, expected, atol=1e-9):
    schema.validate(scan, "scan")
    for axis in "xy":
        np.testing.assert_allclose(scan[axis], expected[axis], rtol=1e-6)
        assert scan[axis].attrs["units"] == "nm"
    np.testing.assert_allclose(scan["height"], expected["height"], rtol=0, atol=atol)
    assert scan["height"].attrs["units"] == "nm" and scan["height"].dtype == float


@pytest.mark.door
@pytest.mark.parametrize("name", WRITERS)
def test_a_picture_without_symmetry_keeps_its_top_and_its_left(name, tmp_path):
    rows = picture()
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    scan = open_scan(path, **given(name, image_size(rows)))
    assert_same(scan, expected_scan(rows, image_size(rows)), ROUNDING.get(name, 1e-9))
    marked = scan["height"].isel(x=0, y=-1)  # the picture's top left corner is at the largest y
    assert float(marked) == pytest.approx(rows[0, 0], abs=ROUNDING.get(name, 1e-9))


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "topostats"])  # which states one length
def test_pixels_that_are_not_square_are_carried_and_remarked(name, tmp_path):
    rows = picture()
    size = image_size(rows, (5.0, 8.0))
    path = WRITERS[name](tmp_path, rows, size)
    if name == "text":  # a cut file looks like this: the size must be said once more
        with pytest.raises(UnreadableScan, match=r"24 columns and 18 rows.*cut short"):
            open_scan(path)
        with pytest.warns(ImplausibleScan, match="not square"):
            scan = open_scan(path, size=size)
    else:
        with pytest.warns(ImplausibleScan, match="not square: 5 x 8 nm"):
            scan = open_scan(path, **given(name, size))
    assert_same(scan, expected_scan(rows, size), ROUNDING.get(name, 1e-9))
    with pytest.raises(ValueError, match="square pixels"):
        schema.square_pixel(scan)


@pytest.mark.parametrize("name", ["gsf", "gwy", "text", "npy", *LABELLED])
def test_missing_pixels_stay_visible(name, tmp_path):
    rows = picture()
    rows[3:5, 7] = np.nan
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    scan = open_scan(path, **given(name, image_size(rows)))
    assert_same(scan, expected_scan(rows, image_size(rows)), 1e-6)
    assert int(scan["height"].isnull().sum()) == 2


def test_a_mask_of_surfacetopographys_is_honoured(tmp_path):
    rows = picture()
    path = write_surfacetopography(tmp_path, rows, image_size(rows))
    ds = xr.load_dataset(path, engine="scipy")
    ds["mask"] = (("x", "y"), np.zeros(ds["heights"].shape, dtype="i1"))
    ds["mask"][2, 0] = 1  # y counts downwards from the top there
    ds.to_netcdf(tmp_path / "masked.nc", engine="scipy", format="NETCDF3_64BIT")
    missing = open_scan(tmp_path / "masked.nc")["height"].isnull()
    assert int(missing.sum()) == 1 and bool(missing[2, -1])


def test_what_a_file_says_is_kept(tmp_path):
    rows = picture()
    path = write_bruker(tmp_path, rows, image_size(rows))
    scan = open_scan(path)
    assert scan.attrs["source_file"] == "scan.spm"
    assert scan.attrs["source_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (scan.attrs["channel"], scan.attrs["scan_direction"]) == ("Height", "trace")
    assert "raw_metadata.scan size: 120 90 nm" in scan.attrs["header"].splitlines()
    assert [step["operation"] for step in schema.history(scan)] == ["open_scan"]
    assert str(tmp_path) not in json.dumps(scan.attrs)


def test_channels_are_chosen_by_name_number_and_direction(tmp_path):
    rows = picture()
    path = write_bruker(tmp_path, rows, image_size(rows))
    forward = open_scan(path)
    backward = open_scan(path, scan_direction="retrace")
    assert backward.attrs["scan_direction"] == "retrace"
    np.testing.assert_allclose(forward["height"], -backward["height"])
    for options in ({"channel": 1}, {"channel": "height", "scan_direction": "retrace"}):
        xr.testing.assert_equal(open_scan(path, **options), backward)
    with pytest.raises(UnreadableScan, match="channel 'Phase', found none among 0: 'Height' trace"):
        open_scan(path, channel="Phase")
    with pytest.raises(ValueError, match="expected one of 'trace', 'retrace', found 'forward'"):
        open_scan(path, scan_direction="forward")


def nanoscope(folder, *names):
    """Write a file with an image of 1000 counts for the last name, and shallower ones for the names before it."""
    v, u = np.mgrid[:64, :64]
    deformation = 20 * np.cos(u / 3) + 30
    heights = 300 * np.sin(u / 5) + 200 * np.cos(v / 6)
    images = [(name, "Trace", deformation) for name in names[:-1]] + [(names[-1], "Trace", heights)]
    return write_nanoscope(folder / "map.spm", images, (640, 640))


@pytest.mark.parametrize("before", ["Deformation", "Indentation", "Background", "Contact Point", "Adhesion"])
@pytest.mark.parametrize("heights", ["Height", "ZSensor"])
def test_heights_are_chosen_by_what_they_are_and_not_by_their_place(before, heights, tmp_path):
    scan = open_scan(nanoscope(tmp_path, before, heights))
    assert scan.attrs["channel"] == heights
    assert float(np.ptp(scan["height"].values)) == pytest.approx(67.13, abs=0.08)  # of 1000 counts of 4400/65536 nm


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_images_that_may_be_the_heights_as_well_are_listed(tmp_path):
    path = nanoscope(tmp_path, "Topography", "Height")
    tie = "2 images may be the heights"
    with pytest.warns(ImplausibleScan, match=f"{tie} .0: 'Topography' .*, 1: 'Height' .*; .*channel="):
        open_scan(path)
    with warnings.catch_warnings(record=True) as caught:
        open_scan(path, channel="Height")
        open_scan(nanoscope(tmp_path, "Height", "Height Sensor"))  # the same movement, recorded twice
    assert not any(tie in str(warning.message) for warning in caught)


def test_a_channel_of_no_length_is_no_scan(tmp_path):
    rows = picture()
    path = write_gwy(tmp_path, rows, image_size(rows))
    with pytest.raises(UnreadableScan, match="found 'Phase' in units of deg; choose one, channel=, of 0: 'Height'"):
        open_scan(path, channel="Phase")


def test_units_come_from_the_file_or_from_the_caller_and_never_from_nowhere(tmp_path):
    rows = picture()
    path = write_npy(tmp_path, rows, image_size(rows))
    with pytest.raises(
        UnreadableScan, match=r"expected an image of heights, found none among 0: 'scan' \[\?\]; .*height_units="
    ):
        open_scan(path, size=image_size(rows))
    with pytest.raises(UnreadableScan, match=r"lateral size, found none.*size="):
        open_scan(path, height_units="nm")
    with pytest.raises(ValueError, match="size: expected two positive lengths"):
        open_scan(path, height_units="nm", size="120 nm")  # which of two unequal sides would that be?
    with pytest.raises(ValueError, match="height_units: expected units of a length"):
        open_scan(path, height_units="deg", size=image_size(rows))
    scan = open_scan(path, height_units="angstrom", size=("0.12 um", 90))
    np.testing.assert_allclose(scan["height"], 0.1 * expected_scan(rows, image_size(rows))["height"])


def test_a_size_that_the_file_states_is_not_overruled(tmp_path):
    rows = picture()
    path = write_gsf(tmp_path, rows, image_size(rows))
    with pytest.raises(ValueError, match=r"as .* states"):
        open_scan(path, size=(100, 100))
    with pytest.raises(ValueError, match="leave height_units= out"):
        open_scan(path, height_units="nm")
    with pytest.raises(ValueError, match="leave size= out"):
        open_scan(write_native(tmp_path, rows, image_size(rows)), size=(100, 100))


@pytest.mark.parametrize("separator", ["\t", ",", ", ", "; ", "  "])
@pytest.mark.parametrize("comma", [False, True])
def test_text_in_all_its_dialects(separator, comma, tmp_path):
    if comma and "," in separator:
        pytest.skip("a comma cannot be both")
    rows = picture()
    lines = [separator.join(f"{height:.4f}" for height in row) for row in rows]
    path = tmp_path / "matrix.csv"
    path.write_text("\n".join(line.replace(".", ",") if comma else line for line in lines) + "\n")
    assert_same(open_scan(path, size=(120, 90), height_units="nm"), expected_scan(rows, (120, 90)))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "latin-1"])
def test_text_in_other_encodings(encoding, tmp_path):
    rows = picture()
    path = write_text(tmp_path, rows, image_size(rows))
    path.write_text(path.read_text(encoding="utf-8"), encoding=encoding)
    assert_same(open_scan(path), expected_scan(rows, image_size(rows)))


def test_older_programs_text_in_a_gwyddion_file(tmp_path):
    from gwyfile.objects import GwyContainer, GwyObject

    rows = picture()
    path = write_gwy(tmp_path, rows, image_size(rows))
    container = GwyObject.fromfile(str(path))
    container["/0/meta"] = GwyContainer({"Scan size": "10 ~~"})
    container.tofile(str(path))
    path.write_bytes(path.read_bytes().replace(b"~~", b"\xb5\xb5"))
    scan = open_scan(path)
    assert_same(scan, expected_scan(rows, image_size(rows)))
    assert "Scan size: 10 µµ" in scan.attrs["header"].splitlines()


def test_text_that_is_no_matrix_is_refused(tmp_path):
    rows = picture()
    path = write_text(tmp_path, rows, image_size(rows))
    whole = path.read_text(encoding="utf-8")
    path.write_text(whole[: whole.rindex("\t")] + "\n", encoding="utf-8")
    with pytest.raises(UnreadableScan, match="number of columns changed"):
        open_scan(path)
    path.write_text("\n".join(whole.splitlines()[:-4]) + "\n", encoding="utf-8")
    with pytest.raises(UnreadableScan, match=r"24 columns and 14 rows.*cut short"):
        open_scan(path)
    path.write_text(whole[:-1], encoding="utf-8")
    with pytest.warns(UserWarning, match="last line has no line end"):
        open_scan(path)
    path.write_text("1 2 3\n" * 9)
    with pytest.raises(UnreadableScan, match="three columns that are not the points of a whole grid"):
        open_scan(path, size=(1, 1), height_units="nm")


def test_cf_files_that_lack_a_label_are_refused(tmp_path):
    rows = picture()
    ds = xr.load_dataset(write_cf(tmp_path, rows, image_size(rows)))

    def refused(changed, match):
        changed.to_netcdf(tmp_path / "changed.nc", engine="netcdf4")
        with pytest.raises(UnreadableScan, match=match):
            open_scan(tmp_path / "changed.nc")

    without = ds.copy(deep=True)
    del without["x"].attrs["units"]
    refused(without, "x: expected 'units' of a length, found none")
    refused(ds.drop_vars("y"), "y: expected a coordinate with units")
    refused(ds.assign(other=ds["topography"]), "expected one variable of heights.*topography.*other")
    refused(ds.rename(x="lon", y="lat"), "expected dimensions x and y")
    bent = ds.assign_coords(x=ds["x"] ** 1.1)
    bent["x"].attrs["units"] = "um"
    refused(bent, "x: expected uniform, ascending pixel centres, found steps from")
    ds["topography"].attrs["units"] = "V"
    refused(ds, "expected one variable of heights with units of length.*topography")


def test_our_own_file_comes_back_as_it_was(tmp_path):
    rows = picture()
    scan = expected_scan(rows, image_size(rows)).assign_coords(sphere_radius=((), 3000.0, {"units": "nm"}))
    scan = schema.record(schema.label(scan), "made", seed=3).assign_attrs(note="mine")
    again = open_scan(to_netcdf(scan, tmp_path / "own.nc"))
    xr.testing.assert_identical(again.load(), scan.assign_attrs(Conventions="CF-1.11"))


def test_the_scan_of_an_archive_opens(tmp_path):
    rows = picture()
    scan = schema.label(expected_scan(rows, image_size(rows)))
    path = archive.save({"scan": scan, "solutions/direct": xr.Dataset()}, tmp_path / "run.nc")
    assert_same(open_scan(path), scan)


@pytest.mark.parametrize("name", LABELLED)
def test_netcdf_is_read_only_where_it_is_looked_at(name, tmp_path):
    rows = picture()
    expected = expected_scan(rows, image_size(rows))
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    with warnings.catch_warnings(action="ignore"):  # that these chunks are not the file's
        lazy = open_scan(path, chunks={"x": 7, "y": 5})
    assert lazy.chunks["y"] == (5, 5, 5, 3)
    part = pickle.loads(pickle.dumps(lazy)).isel(x=slice(3, 20, 4), y=slice(None, None, -2))
    np.testing.assert_allclose(part["height"], expected["height"][3:20:4, ::-2], atol=1e-9)
    unread = open_scan(path)
    assert not unread["height"].variable._in_memory
    assert float(unread["height"][5, -2]) == pytest.approx(float(expected["height"][5, -2]), abs=1e-9)
    assert_same(lazy.compute(scheduler="threads"), expected)


@pytest.mark.door
def test_the_engine_is_xarrays(tmp_path):
    rows = picture()
    path = write_gsf(tmp_path, rows, image_size(rows))
    direct = xr.open_dataset(path, engine=RoughxrBackend)
    xr.testing.assert_identical(direct, open_scan(path))
    assert "height" not in xr.open_dataset(path, engine=RoughxrBackend, drop_variables="height")
    with pytest.raises(TypeError):
        xr.open_dataset(path, engine=RoughxrBackend, chanel="Height")
    if "roughxr" in xr.backends.list_engines():
        xr.testing.assert_identical(xr.open_dataset(path, engine="roughxr"), direct)
        xr.testing.assert_identical(xr.open_dataset(path), direct)


@pytest.mark.parametrize("name", WRITERS)
def test_only_files_of_microscopes_and_gwyddions_text_are_claimed_without_an_engine(name, tmp_path):
    rows = picture()
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    shared = {"xyz", "npy", "tiff", "native", "surfacetopography", "cf", "hdf5", "topostats", "h5-jpk", "nhf"}
    assert RoughxrBackend().guess_can_open(path) == (name not in shared)


def test_pixels_and_heights_smaller_than_atoms_are_refused(tmp_path):
    rows = picture()
    with pytest.raises(UnreadableScan, match=r"expected pixels of at least 0\.001 nm"):
        open_scan(write_gwy(tmp_path, rows, (1e-3, 1e-3)))
    with pytest.raises(UnreadableScan, match=r"expected heights over at least 0\.001 nm"):
        open_scan(write_gwy(tmp_path, 1e-9 * rows, image_size(rows)))


@pytest.mark.parametrize("name", WRITERS)
def test_the_content_decides(name, tmp_path):
    rows = picture()
    path = WRITERS[name](tmp_path, rows, image_size(rows)).rename(tmp_path / "renamed.jpg")
    with open_scan(path, **given(name, image_size(rows))) as scan:
        assert_same(scan, expected_scan(rows, image_size(rows)), ROUNDING.get(name, 1e-9))


def test_what_is_no_readable_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="absent"):
        open_scan(tmp_path / "absent.spm")
    with pytest.raises(IsADirectoryError, match="found a folder"):
        open_scan(tmp_path)
    with pytest.raises(TypeError, match="expected the name of a file, found bytes"):
        open_scan(b"GWYP")
    (tmp_path / "empty.ibw").touch()
    with pytest.raises(UnreadableScan, match=r"empty.ibw: .* empty"):
        open_scan(tmp_path / "empty.ibw")
    for name, content in (("a.jpg", b"\xff\xd8\xff\xe0" + bytes(900)), ("a.md", b"# A heading\n\nProse. 1\n")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(UnreadableScan, match=name):
            open_scan(tmp_path / name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.spm")
    with pytest.raises(UnreadableScan, match="found a pipe"):
        open_scan(tmp_path / "pipe.spm")


@pytest.mark.parametrize("height", [np.inf, 1e30])
def test_heights_that_no_scan_has_are_refused(height, tmp_path):
    rows = picture()
    rows[2, 2] = height
    for name in ("npy", "cf"):
        path = WRITERS[name](tmp_path, rows, image_size(rows))
        with pytest.raises(UnreadableScan, match="expected heights that suit a scan"):
            open_scan(path, **given(name, image_size(rows))).load()


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"factor": 1e3}, "heights range over 4.*, more than the lateral"),
        ({"factor": 100}, "the slope exceeds 1 "),
        ({"pixel": 1.0}, "one pixel is exactly 1 nm along x"),
        ({"factor": 0}, "all heights are equal"),
        ({"pixel": 3500.0}, "pixels of 3500 nm are too coarse"),
    ],
)
def test_doubts_come_with_numbers(change, match, tmp_path):
    rows = picture() * change.get("factor", 1)
    pixel = change.get("pixel", 5.0)
    path = write_npy(tmp_path, rows, (0, 0))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        open_scan(path, size=image_size(rows, (pixel, pixel)), height_units="nm")
    assert any(re.search(match, str(warning.message)) for warning in caught if warning.category is ImplausibleScan)


def test_a_description_lists_every_channel(tmp_path):
    rows = picture()
    channels = describe(write_gwy(tmp_path, rows, image_size(rows)))
    assert channels["name"].values.tolist() == ["Height", "Phase"]
    assert channels["units"].values.tolist() == ["m", "deg"]
    np.testing.assert_allclose(channels["size_x"], 120)
    assert float(channels["highest"][0] - channels["lowest"][0]) == pytest.approx(np.ptp(rows))
    assert np.isnan(channels["s_q"][1])
    native = describe(write_native(tmp_path, rows, image_size(rows)))
    assert float(native["size_y"][0]) == pytest.approx(90)
    several = xr.load_dataset(write_cf(tmp_path, rows, image_size(rows)))
    several["topography2"] = several["topography"] * 2
    several["topography2"].attrs = several["topography"].attrs
    several.to_netcdf(tmp_path / "several.nc")
    channels = describe(tmp_path / "several.nc")
    assert channels["name"].values.tolist() == ["topography", "topography2"]
    np.testing.assert_allclose(channels["highest"], [rows.max(), 2 * rows.max()])
    assert float(open_scan(tmp_path / "several.nc", channel="topography2")["height"].max()) > rows.max()


@pytest.mark.parametrize("name", WRITERS)
def test_without_the_extra_the_core_formats_open_and_the_others_name_it(name, tmp_path, monkeypatch):
    rows = picture()
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    for module in ("SurfaceTopography", "SurfaceTopography.IO", "gsffile"):
        monkeypatch.setitem(sys.modules, module, None)
    core = ("gwy", "text", "xyz", "npy", "tiff", "jpk", "sxm", "asd", "topostats", "h5-jpk", "nhf", "hdf5", *LABELLED)
    if name in core:
        scan = open_scan(path, **given(name, image_size(rows)))
        assert_same(scan, expected_scan(rows, image_size(rows)), ROUNDING.get(name, 1e-9))
    else:
        with pytest.raises(ImportError, match=r'pip install \w+, .*pip install "\.\[afm\]"'):
            open_scan(path)
