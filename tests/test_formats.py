"""Formats of microscopes and others: the right image, direction, frame and scale; errors name the format."""

import contextlib
import struct
import warnings
import zipfile

import h5py
import numpy as np
import pytest

import roughxr
from roughxr.application import cli
from roughxr.files.images import formats
from roughxr.scans import ImplausibleScan, UnreadableScan, describe, open_scan

from .afm_files import (
    JPK_COUNT,
    MDT_COUNT,
    NANOMETRES_PER_COUNT,
    WRITERS,
    expected_scan,
    given,
    image_size,
    picture,
    write_h5_jpk,
    write_hdf5,
    write_jpk,
    write_jpk_pages,
    write_movie,
    write_nanoscope,
    write_nhf,
    write_sxm,
)
from .format_table import PAGE, page_with, table
from .test_scans_files import assert_same

ROWS = picture()
SIZE = image_size(ROWS)
SCAN = expected_scan(ROWS, SIZE)


@pytest.mark.parametrize(("name", "atol"), [("jpk", 1e-5), ("sxm", 1e-6), ("h5-jpk", 1e-9), ("nhf", 1e-6)])
def test_both_directions_of_an_image(name, atol, tmp_path):
    path = WRITERS[name](tmp_path, ROWS, SIZE)
    forward = open_scan(path, scan_direction="trace")
    backward = open_scan(path, scan_direction="retrace")
    assert (forward.attrs["scan_direction"], backward.attrs["scan_direction"]) == ("trace", "retrace")
    assert_same(forward, SCAN, atol)
    np.testing.assert_allclose(backward.height, -SCAN.height, rtol=0, atol=atol)
    assert open_scan(path).attrs["scan_direction"] == "trace"


def test_the_adhesion_channel_of_a_jpk_image(tmp_path):
    v, u = np.mgrid[:12, :16]
    adhesion = 10 + np.sin(u / 3) + np.cos(v / 2)  # nN
    heights = np.round(picture(12, 16) / JPK_COUNT).astype("<i4")
    counts = np.round(adhesion / JPK_COUNT).astype("<i4")
    pages = [("Height", 0, heights, ("m", JPK_COUNT * 1e-9)), ("Adhesion", 0, counts, ("N", JPK_COUNT * 1e-9))]
    path = write_jpk_pages(tmp_path / "map.jpk-qi-image", pages, (160, 120))
    measured = roughxr.open_pull_off(path)
    assert measured.channel == "Adhesion" and measured.measured_units == "N"
    np.testing.assert_allclose(measured.pull_off_force, adhesion.T.ravel(), rtol=0, atol=1e-5)  # the lowest line first
    assert (float(measured.subregion_x[0]), float(measured.subregion_y[0])) == pytest.approx((5, 5))
    assert open_scan(path).attrs["channel"] == "Height"


@pytest.mark.parametrize("reflected", [False, True])
def test_a_jpk_image_is_what_a_second_reader_makes_of_it(reflected, tmp_path):
    from SurfaceTopography.IO import open_topography

    path = write_jpk(tmp_path, ROWS, SIZE)
    if reflected:  # the tag of the grid's width becomes that of its reflection in a copy of the sizes' entries
        content = path.read_bytes()
        path.write_bytes(content.replace(struct.pack("<HHI", 0x8080, 4, 1), struct.pack("<HHI", 0x8045, 4, 1)))
    other = open_topography(str(path), format="jpk").topography()
    scan = open_scan(path)
    np.testing.assert_allclose(scan.height, np.flip(other.heights(), axis=1) * 1e9, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        [scan.attrs["source_size_x"], scan.attrs["source_size_y"]], np.array(other.physical_sizes) * 1e9
    )


@pytest.mark.parametrize("up", [True, False])
def test_nanonis_lines_in_the_order_of_time(up, tmp_path):
    path = write_sxm(tmp_path, ROWS, SIZE, up=up)
    assert_same(open_scan(path), SCAN, 1e-6)
    with pytest.raises(UnreadableScan, match=r"scan.sxm: Nanonis \(.sxm\): .*found 'Current' in units of A"):
        open_scan(path, channel="Current", scan_direction="trace")


def test_nanonis_lines_that_were_not_scanned_are_missing(tmp_path):
    rows = ROWS.copy()
    rows[:6] = np.nan
    assert_same(open_scan(write_sxm(tmp_path, rows, SIZE)), expected_scan(rows, SIZE), 1e-6)


@pytest.mark.parametrize("version", [0, 1, 2])
def test_a_frame_of_a_movie(version, tmp_path):
    frames = [ROWS, ROWS[::-1], 2 * ROWS]
    path = write_movie(tmp_path / "movie.asd", frames, SIZE, version)
    for number, rows in enumerate(frames):
        scan = open_scan(path, channel=number)
        assert_same(scan, expected_scan(rows, SIZE), 0.003)
        assert scan.attrs["channel"] == f"Topography {number + 1}"
    with pytest.warns(ImplausibleScan, match=r"3 images may be the heights .0: 'Topography 1'"):
        assert_same(open_scan(path), SCAN, 0.003)


def test_a_movie_of_very_many_frames_is_listed_in_short(tmp_path):
    path = write_movie(tmp_path / "movie.asd", [ROWS] * 200, SIZE)
    with pytest.raises(UnreadableScan, match=r"'Topography 32' .nm., … and 368 more"):
        open_scan(path, channel="Height")


def test_frames_of_jpks_movies(tmp_path):
    path = write_h5_jpk(tmp_path, ROWS, SIZE)
    with h5py.File(path, "a") as file:
        channel = file["Measurement_000/Channel_000"]
        first = channel["Height"][:]
        del channel["Height"]
        channel["Height"] = np.hstack([first, 3 * first])
    np.testing.assert_allclose(open_scan(path, channel="height 2").height, 3 * SCAN.height, atol=1e-9)


def test_pixels_that_nanosurf_did_not_measure_are_missing(tmp_path):
    path = write_nhf(tmp_path, ROWS, SIZE)
    with h5py.File(path, "a") as file:
        counts = file["measurement_0/segment_0/data_0"]
        for end in ("min", "max", "unit"):
            counts.attrs[f"signal_calibration_{end}"] = counts.attrs[f"base_calibration_{end}"]
        counts[0] = -(2**31)
    scan = open_scan(path)
    assert int(scan.height.isnull().sum()) == 1 and bool(scan.height.isnull()[0, 0])


def test_any_matrix_of_an_hdf5_file(tmp_path):
    path = write_hdf5(tmp_path, ROWS, SIZE)
    with h5py.File(path, "a") as file:
        file["scans/second"] = 2 * ROWS
        file["scans/second"].attrs["units"] = "angstrom"
        file["curve"] = np.arange(5.0)
        file["bytes"] = np.frombuffer(b"abcd", "S1").reshape(2, 2)
    stated = {"size": SIZE, "height_units": "nm"}
    for name in ("scans/first", "/scans/first"):
        assert_same(open_scan(path, channel=name, **stated), SCAN)
    np.testing.assert_allclose(open_scan(path, channel="scans/second", size=SIZE).height, 0.2 * SCAN.height)
    assert describe(path)["name"].values.tolist() == ["scans/first", "scans/second"]
    for options, message in (
        ({"channel": "scans/first"}, "height_units="),
        ({"channel": "scans/first", "height_units": "nm"}, "size="),
        ({"channel": "scans/third"}, r"found none among 0: 'scans/first' \[\?\], 1: 'scans/second' \[angstrom\]"),
    ):
        with pytest.raises(UnreadableScan, match=f"scan.h5: HDF5.*{message}"):
            open_scan(path, **options)
    measured = roughxr.open_pull_off(path, channel="scans/first", units="nN", size=SIZE, pulls="positive")
    np.testing.assert_allclose(measured.pull_off_force, SCAN.height.values.ravel())


def test_an_hdf5_file_without_a_matrix_is_refused(tmp_path):
    with h5py.File(tmp_path / "curve.h5", "w") as file:
        file["curve"] = np.arange(5.0)
    with pytest.raises(UnreadableScan, match=r"curve.h5: HDF5.*expected a matrix of numbers, found none"):
        open_scan(tmp_path / "curve.h5")


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_points_of_a_grid_in_any_order(tmp_path):
    path = WRITERS["xyz"](tmp_path, ROWS, SIZE)
    heading, *points = path.read_text().splitlines()
    mixed = [points[k] for k in np.random.default_rng(0).permutation(len(points))]
    path.write_text("\n".join([heading, *mixed, ""]))
    assert_same(open_scan(path), SCAN)
    for other in ("# x (nm)\ty (nm)\tz (nm)", "x_nm y_nm z_nm", "x [nm], y [nm], height [nm]"):
        path.write_text("\n".join([other, *mixed, ""]))
        assert_same(open_scan(path), SCAN)
    path.write_text("\n".join([*mixed, ""]))
    with pytest.raises(UnreadableScan, match="expected a lateral size, found none"):
        open_scan(path, height_units="nm")
    assert_same(open_scan(path, height_units="nm", size=SIZE), SCAN)
    path.write_text("\n".join([heading, *mixed[1:], ""]))
    with pytest.raises(UnreadableScan, match="not the points of a whole grid"):
        open_scan(path)
    rounded = np.loadtxt(points)
    rounded[:, :2] = rounded[:, :2].round()  # 2, 8, 12, 18, …: steps of 5 printed as 4 or 6
    np.savetxt(path, rounded, header=heading, comments="")
    assert open_scan(path).sizes == {"x": 24, "y": 18}


@pytest.mark.parametrize(
    "head",
    [
        "h=18 w=24",
        "h = 18, w = 24",
        "# h = 18\n# w = 24",
        "w=24\nh=18",
        "Height: 90 nm\nWidth: 120 nm",
        "h=90nm w=0.12um",
    ],
)
def test_text_that_states_its_width_and_height(head, tmp_path):
    path = tmp_path / "matrix.txt"
    matrix = "".join(" ".join(f"{height:.4f}" for height in row) + "\n" for row in ROWS)
    path.write_text(f"{head}\n{matrix}")
    assert_same(open_scan(path, height_units="nm", **({} if "nm" in head else {"size": SIZE})), SCAN)
    if "18" in head:
        path.write_text(f"{head}\n" + "".join(f"{height:.4f}\n" for height in ROWS.ravel()))
        assert_same(open_scan(path, height_units="nm", size=SIZE), SCAN)
        path.write_text(f"{head}\n" + "\n".join(matrix.splitlines()[:-3]) + "\n")
        with pytest.raises(
            UnreadableScan, match=r"expected 24 columns and 18 rows, as its header states, found .*15 rows"
        ):
            open_scan(path, height_units="nm", size=SIZE)


@pytest.mark.parametrize("corner", ["0", "", "nan"])
@pytest.mark.parametrize("separator", ["\t", ","])
def test_a_matrix_with_axes_is_no_heights(corner, separator, tmp_path):
    lines = [separator.join([corner, *(f"{5 * k + 2.5}" for k in range(24))])]
    lines += [separator.join([f"{5 * k}", *map(str, row)]) for k, row in enumerate(ROWS)]
    path = tmp_path / "axes.txt"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(
        UnreadableScan, match=r"axes.txt: text.*found coordinates in its first row and column; delete both"
    ):
        open_scan(path, size=SIZE, height_units="nm")


def test_a_plane_is_no_axes(tmp_path):
    path = tmp_path / "plane.txt"
    np.savetxt(path, np.add.outer(np.arange(8.0), 2 * np.arange(9.0)))
    assert open_scan(path, size=(90, 80), height_units="nm").sizes == {"x": 9, "y": 8}


def test_ascii_sdf(tmp_path):
    """16 × 12 points of 1e-7 m, heights in counts of 1e-9 m."""
    rows = 2.2 * picture(12, 16)
    scan = open_scan(WRITERS["sdf"](tmp_path, rows, (1600, 1200)))
    assert_same(scan, expected_scan(rows, (1600, 1200)))


@pytest.mark.parametrize("sensitivity", ["0.01 ~m/V", "0.01 \xb5m/V"])
def test_micrometres_without_their_sign(sensitivity, tmp_path):
    path = write_nanoscope(tmp_path / "scan.spm", [("Height", "Trace", np.round(ROWS / NANOMETRES_PER_COUNT))], SIZE)
    header, end, counts = path.read_bytes().partition(b"\x1a")
    header = header.replace(b"10.0 nm/V", sensitivity.encode("latin-1")).replace(
        b"Scan Size: 120 90 nm", b"Scan Size: 0.12 0.09 ~m"
    )
    path.write_bytes((header + end).ljust(8192, b"\0") + counts.lstrip(b"\0").rjust(2 * ROWS.size, b"\0"))
    assert_same(open_scan(path), SCAN, 0.04)


def test_a_title_of_one_letter(tmp_path):
    from gwyfile.objects import GwyObject

    path = WRITERS["gwy"](tmp_path, ROWS, SIZE)
    container = GwyObject.fromfile(str(path))
    container["/0/data/title"] = "Z"
    container.tofile(str(path))
    scan = open_scan(path)
    assert scan.attrs["channel"] == "Z"
    assert_same(scan, SCAN)


def test_names_of_asylums_channels_end_where_their_labels_do(tmp_path):
    path = WRITERS["igor"](tmp_path, ROWS, SIZE)
    assert roughxr.scans.describe(path).name.values.tolist() == ["HeightRetrace"]


@pytest.mark.parametrize("name", WRITERS)
def test_an_error_names_the_format(name, tmp_path):
    path = WRITERS[name](tmp_path, ROWS, SIZE)
    code = open_scan(path, **given(name, SIZE)).attrs.get("source_format", "netcdf")
    with pytest.raises(UnreadableScan) as refusal:
        open_scan(path, channel="no such channel", **given(name, SIZE))
    assert f"{path}: {formats.name_of(code)}: " in str(refusal.value)


@pytest.mark.parametrize("start", formats._NOT_READ)
def test_what_is_not_read_is_named(start, tmp_path):
    path = tmp_path / "any.dat"
    path.write_bytes(start.ljust(64, b"\1") + bytes(5000))
    if start == b"PK\3\4":  # without the list of its members an archive is cut short
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("any.bin", bytes(5000))
    with pytest.raises(
        UnreadableScan, match=r"any.dat: expected an AFM image, found a file that is not read"
    ) as refusal:
        open_scan(path)
    assert formats._NOT_READ[start] in str(refusal.value)


def test_a_missing_statement_of_a_format_is_no_key_error(tmp_path):
    path = write_sxm(tmp_path, ROWS, SIZE)
    path.write_bytes(path.read_bytes().replace(b"SCAN_PIXELS", b"SCAN_POINTS"))
    with pytest.raises(UnreadableScan, match=r"scan.sxm: Nanonis \(.sxm\): .*damaged.*it lacks 'SCAN_PIXELS'"):
        open_scan(path)
    path = write_jpk(tmp_path, ROWS, SIZE)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(UnreadableScan, match=r"scan.jpk: JPK image.*cut short"):
        open_scan(path)


def test_currents_are_no_heights(tmp_path):
    path = WRITERS["mdt"](tmp_path, ROWS, SIZE)
    nanometres, nanoamperes = (struct.pack("<2fh", 0, MDT_COUNT, code) for code in (-1, 6))
    path.write_bytes(path.read_bytes().replace(nanometres, nanoamperes))
    with pytest.raises(UnreadableScan, match=r"scan.mdt: NT-MDT \(.mdt\): expected an image of heights.*currents"):
        open_scan(path)


def holes():
    """Yield pictures that lack whole lines, or all but a few pixels."""
    for part in (np.s_[4], np.s_[:, 7], np.s_[::2], np.s_[:, 1::2], np.s_[:9], np.s_[2:, 3:], np.s_[1:]):
        rows = picture(24, 32)
        rows[part] = np.nan
        yield rows


@pytest.mark.parametrize("rows", list(holes()))
def test_missing_pixels_never_warn_in_numpys_words(rows, tmp_path):
    path = WRITERS["npy"](tmp_path, rows, SIZE)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("ignore", UserWarning)
        scan = open_scan(path, size=image_size(rows), height_units="nm")
        native = roughxr.scans.to_netcdf(scan, tmp_path / "native.nc")
        describe(native)
        for method in ("plane", "quadratic"):
            with contextlib.suppress(ValueError):  # too few pixels, in words
                roughxr.roughness(roughxr.level(scan, method=method))
        filled = roughxr.fill(scan, method="linear")
        roughxr.roughness(filled)


def test_the_page_shows_what_info_prints():
    assert page_with(table()) == PAGE.read_text(encoding="utf-8")


def test_the_listed_formats_are_those_that_open(tmp_path, capsys):
    opened = set()
    for name, write in WRITERS.items():
        with open_scan(write(tmp_path, ROWS, SIZE), **given(name, SIZE)) as scan:
            opened.add(scan.attrs.get("source_format", "netcdf"))
    assert opened == set(formats.READ)
    assert cli.main(["info", "--formats"]) == 0
    printed = capsys.readouterr().out
    assert all(
        format_read.name in printed and format_read.endings.split()[-1] in printed
        for format_read in formats.READ.values()
    )


#: Lines above the numbers as Gwyddion writes them in Russian, German, French and Japanese.
TRANSLATED = [
    ("Канал", "Ширина", "Высота", "Единицы измерения"),
    ("Kanal", "Breite", "Höhe", "Werteinheit"),
    ("Canal ", "Largeur ", "Hauteur ", "Unités de valeur "),
    ("チャンネル", "幅", "高さ", "値の単位"),
]


@pytest.mark.parametrize("names", TRANSLATED)
@pytest.mark.parametrize("comma", [False, True])
def test_gwyddions_text_is_read_in_any_of_its_languages(tmp_path, names, comma):
    values = ("Height", f"{SIZE[0] / 1e3:.6f} µm", f"{SIZE[1] / 1e3:.6f} µm", "m")
    header = "\n".join(f"# {name}: {entry.replace('.', ',') if comma else entry}" for name, entry in zip(names, values))
    rows = "\n".join("\t".join(f"{entry * 1e-9:.6e}" for entry in row) for row in ROWS)
    path = tmp_path / "scan.txt"
    path.write_text(f"{header}\n{rows}\n", encoding="utf-8")
    assert_same(open_scan(path), SCAN, 1e-5)


@pytest.mark.parametrize("upwards", [True, False])
def test_a_nexus_image_has_the_size_and_orientation_of_its_axes(tmp_path, upwards):
    path = tmp_path / "scan.nxs"
    lengths = [(np.arange(n) + 0.5) * length / n for n, length in zip(ROWS.shape, SIZE[::-1])]
    with h5py.File(path, "w") as file:
        group = file.create_group("entry/data")
        group.attrs.update({"NX_class": "NXdata", "signal": "topography", "axes": ["y", "x"]})
        group["topography"] = ROWS[::-1] * 1e-9 if upwards else ROWS * 1e-9
        group["topography"].attrs["units"] = "m"
        group["x"] = lengths[1] * 1e-3
        group["y"] = lengths[0] if upwards else lengths[0][::-1]
        group["x"].attrs["units"] = "um"
        group["y"].attrs["units"] = "nm"
    assert_same(open_scan(path), SCAN, 1e-6)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_topostats_grains_do_not_take_the_place_of_the_image(tmp_path):
    path = WRITERS["topostats"](tmp_path, ROWS, (SIZE[0], SIZE[0] / ROWS.shape[1] * ROWS.shape[0]))
    with h5py.File(path, "a") as file:
        crop = file.create_group("grain_crops/above/0")
        crop["image"] = ROWS[:8, :8]
        crop["pixel_to_nm_scaling"] = file["pixel_to_nm_scaling"][()]
    scan = open_scan(path)
    assert scan.attrs["channel"] == "image" and dict(scan.sizes) == {"x": ROWS.shape[1], "y": ROWS.shape[0]}


def rewritten_x3p(path, change):
    """Rewrite the main.xml of an X3P file."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["main.xml"] = change(members["main.xml"].decode()).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def test_an_x3p_revision_may_have_a_dash(tmp_path):
    path = WRITERS["x3p"](tmp_path, ROWS, SIZE)
    rewritten_x3p(path, lambda text: text.replace("ISO5436 - 2000", "ISO5436 – 2000"))
    assert_same(open_scan(path), SCAN, 1e-6)


@pytest.mark.parametrize("date", ["N/A", "unknown", ""])
def test_an_x3p_may_state_no_date(tmp_path, date):
    path = WRITERS["x3p"](tmp_path, ROWS, SIZE)
    rewritten_x3p(path, lambda text: text.replace("2020-01-01T00:00:00", date))
    assert_same(open_scan(path), SCAN, 1e-6)


def test_an_x3p_may_list_its_heights_in_its_index(tmp_path):
    path = WRITERS["x3p"](tmp_path, ROWS, SIZE)
    heights = "".join(f"<Datum>{height * 1e-9!r}</Datum>" for height in ROWS.ravel().tolist())
    link = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>"
    rewritten_x3p(path, lambda text: text.replace(link, f"<DataList>{heights}</DataList>"))
    assert_same(open_scan(path), SCAN, 1e-6)


def test_an_x3p_that_unpacks_to_far_more_is_refused_unread(tmp_path):
    path = WRITERS["x3p"](tmp_path, ROWS, SIZE)
    with zipfile.ZipFile(path) as archive:
        index = archive.read("main.xml")
    wide = index.replace(f"<SizeX>{ROWS.shape[1]}".encode(), b"<SizeX>1000000")
    for text, size, fault in (
        (wide, 2**23, "expected a content of at most 4 MiB, by its size, found 8 MiB"),
        (index + b" " * 2**24, ROWS.size * 8, "expected a content of at most 4 MiB, by its size, found 16 MiB"),
    ):
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("main.xml", text)
            archive.writestr("bindata/data.bin", bytes(size))
        with pytest.raises(UnreadableScan, match=fault):
            open_scan(path)


def test_files_without_heights_or_size_are_named_for_what_they_are(tmp_path):
    surface = WRITERS["sur"](tmp_path, ROWS, SIZE)
    content = surface.read_bytes()
    surface.write_bytes(content[:212] + b"%".ljust(16) + content[228:])
    compressed = tmp_path / "compressed.sur"
    compressed.write_bytes(content.replace(b"DIGITAL SURF", b"DSCOMPRESSED"))
    agilent = WRITERS["mi"](tmp_path, ROWS, SIZE)
    agilent.write_bytes(agilent.read_bytes().replace(b"xLength", b"xAbsent"))
    for path, fault in (
        (surface, "Digital Surf .*: expected heights, found another quantity, in '%'"),
        (compressed, "found compressed ones; save it without compression"),
        (agilent, "expected the size of the image, found no xLength in its header"),
    ):
        with pytest.raises(UnreadableScan, match=fault):
            open_scan(path)
