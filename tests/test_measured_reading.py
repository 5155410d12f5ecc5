"""Pull-off forces from files: units and places as the file or the caller states them, never as anyone guesses."""

import contextlib
import io
import time
import zipfile

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughxr
from roughxr.application.cli import main
from roughxr.files.curves.vendor_scales import nanoscope_scale
from roughxr.scans import UnreadableScan

from .afm_files import image_size, picture, write_bruker, write_park

TABLE = "place,x [um],y [um],adhesion [pN],remark\na,0,0,12500,ok\nb,1.5,0,,lost\nc,0,-2,9500,ok\n"


def written(tmp_path, text, name="curves.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_text(text, encoding=encoding)
    return path


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_a_table_brings_its_units_and_places(tmp_path):
    measured = roughxr.open_pull_off(written(tmp_path, TABLE))
    np.testing.assert_allclose(measured.pull_off_force, [12.5, np.nan, 9.5])
    np.testing.assert_allclose(measured.subregion_x, [0, 1500, 0])
    np.testing.assert_allclose(measured.subregion_y, [0, 0, -2000])
    assert measured.pull_off_force.units == "nN" and measured.measured == "table" and measured.channel == "adhesion"
    assert roughxr.schema.kind_of(measured) == "pull_off"
    assert "pull_off_force" in measured.contact.summary()


@pytest.mark.parametrize(
    "text",
    [
        "x [um];y [um];F [nN]\n0;0;12,5\n1,5;0;nan\n0;-2;9,5\n",
        "x [um]\ty [um]\tF [nN]\n0\t0\t12.5\n1.5\t0\tnan\n0\t-2\t9.5\n",
        "# of a colloidal probe\n# x (µm)  y (µm)  F (nN)\n0 0 12.5\n1.5 0 nan\n0 -2 9.5\n",
        'x / um, y / um, "F / N"\n0, 0, -1.25e-8\n1.5, 0, -\n0, -2, -9.5e-9\n',
        "X Position [um]\tY Position [um]\tAdhesion [N]\n0\t0\t12.5e-9\n1.5\t0\t\n0\t-2\t9.5e-9\n",
        "# Filename\tX Position (µm)\tY Position (µm)\tAdhesion [nN]\n"
        "a b.spm\t0\t0\t12.5\nc.spm\t1.5\t0\tnan\nd.spm\t0\t-2\t9.5\n",
        "x_um,y_um,adhesion_nN\n0,0,12.5\n1.5,0,\n0,-2,9.5\n",
    ],
)
def test_tables_of_other_habits_say_the_same(tmp_path, text):
    expected = roughxr.open_pull_off(written(tmp_path, TABLE))
    measured = roughxr.open_pull_off(written(tmp_path, text, "other.txt"))
    for name in ("pull_off_force", "subregion_x", "subregion_y"):
        np.testing.assert_allclose(measured[name], expected[name], rtol=1e-12)


def test_a_workbook_says_the_same_as_its_text(tmp_path):
    pytest.importorskip("openpyxl", reason="workbooks need openpyxl")
    expected = roughxr.open_pull_off(written(tmp_path, TABLE))
    pd.read_csv(io.StringIO(TABLE)).to_excel(tmp_path / "curves.xlsx", index=False)
    measured = roughxr.open_pull_off(tmp_path / "curves.xlsx")
    for name in ("pull_off_force", "subregion_x", "subregion_y"):
        np.testing.assert_allclose(measured[name], expected[name], rtol=1e-12)


def test_a_workbook_of_millions_of_cells_is_refused_unread(tmp_path):
    pytest.importorskip("openpyxl")
    path = tmp_path / "curves.xlsx"
    pd.read_csv(io.StringIO(TABLE)).to_excel(path, index=False)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/worksheets/sheet2.xml", bytes(2**25))
    with pytest.raises(UnreadableScan, match="a content of at most 4 MiB, by its size, found 32 MiB"):
        roughxr.open_pull_off(path)


@pytest.mark.parametrize("names", ["x [um],F [nN]", "Position [um],F [nN]", "y_um,F [nN]"])
def test_places_are_never_dropped_in_silence(tmp_path, names):
    with pytest.raises(UnreadableScan, match="columns x and y of places"):
        roughxr.open_pull_off(written(tmp_path, f"{names}\n1,2\n2,3\n"))


def test_what_is_written_as_a_table_opens_again(tmp_path):
    first = roughxr.open_pull_off(written(tmp_path, TABLE))
    again = roughxr.open_pull_off(first.contact.to_table(tmp_path / "again.csv"))
    xr.testing.assert_allclose(again, first)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("adhesion\n1\n2\n", {}, "give them, such as units='nN'"),
        ("adhesion [nN]\n1\n2\n", {"units": "pN"}, "leave units= out"),
        ("adhesion [kg]\n1\n2\n", {}, "expected those of a force, of a deflection, or V, found 'kg'"),
        ("adhesion [V]\n1\n2\n", {}, "expected forces, found V; state sensitivity="),
        ("adhesion [V]\n1\n2\n", {"sensitivity": 50.0}, "expected its units"),
        ("adhesion [V]\n1\n2\n", {"sensitivity": "50 nm/V"}, "state spring_constant="),
        ("deflection [nm]\n1\n2\n", {}, "state spring_constant="),
        ("adhesion [nN]\n1\n2\n", {"spring_constant": 0.2}, "spring_constant: expected none with values in nN"),
        ("adhesion [nN]\n-1\n2\n", {}, "pulls='positive' or pulls='negative'"),
        ("x [nm],y [nm],adhesion [nN]\n0,0,1\n,1,2\n", {}, "expected a place in every row"),
        ("F1 [nN],F2 [nN]\n1,2\n3,4\n", {}, "found 2 among 'F1' .nN., 'F2' .nN."),
        ("1,2\n3,4\n", {}, "expected a line of names above 2 columns"),
        ("a,F [nN]\n1,2\n3\n", {}, "line 3: expected 2 columns as named, found 1"),
        ("F [nN]\n1\n2\n3\n4x\n", {}, "line 5: expected a number in column 'F .nN.', found '4x'"),
        ("F1 [nN]\n", {}, "expected rows of numbers"),
        ("F1 [nN]\nnan\n\n", {}, "found missing values only"),
        ("F1 [nN]\n1\ninf\n", {}, "expected finite values, found infinite ones"),
        ("F1 [nN]\n1\n2\n", {"pulls": "negative"}, "expected some negative values, found only positive ones"),
        (
            "x [um],y [um],F [nN]\n0,0,1\n1,1,2\n",
            {"place_units": "nm"},
            "place_units: expected 'um', as the file states, found 'nm'",
        ),
    ],
)
def test_what_is_missing_or_damaged_is_named(tmp_path, text, options, message):
    with pytest.raises(UnreadableScan, match=message):
        roughxr.open_pull_off(written(tmp_path, text), **options)


@pytest.mark.parametrize("name", ["cumulative fraction", "pdf", "percentile", "frequency", "count", "Number of curves"])
def test_a_distribution_is_no_list_of_pull_offs(tmp_path, name):
    with pytest.raises(UnreadableScan, match=f"found a distribution with column '{name}'"):
        roughxr.open_pull_off(written(tmp_path, f"force [nN],{name}\n5,0.16\n10,0.7\n15,1\n"))


def test_a_mean_below_an_empty_line_is_no_pull_off(tmp_path):
    with pytest.raises(UnreadableScan, match="line 7: expected one table, found an empty line above"):
        roughxr.open_pull_off(written(tmp_path, "force [nN]\n5\n10\n15\n12\n\n10.5\n"))
    noted = roughxr.open_pull_off(written(tmp_path, "force [nN]\n5\n# lost\n10\n15\n", "noted.csv"))
    assert noted.pull_off_force.size == 3
    spaced = roughxr.open_pull_off(written(tmp_path, "force [nN]\n\n5\n\n10\n\n15\n", "spaced.csv"))
    assert spaced.pull_off_force.values.tolist() == [5, 10, 15]


def test_tables_with_and_without_places_are_pooled_without_them(tmp_path):
    paths = (
        written(tmp_path, "x [um],y [um],F [nN]\n0,0,1\n1,1,2\n", "a.csv"),
        written(tmp_path, "F [nN]\n3\n", "b.csv"),
    )
    measured = roughxr.open_pull_off(paths)
    assert measured.pull_off_force.values.tolist() == [1, 2, 3] and "subregion_x" not in measured.coords


def test_other_units_become_forces_by_what_is_stated(tmp_path):
    volts = written(tmp_path, "adhesion [mV]\n100\n200\n")
    by_force = roughxr.open_pull_off(volts, sensitivity="12 nN/V")
    by_deflection = roughxr.open_pull_off(volts, sensitivity="60 nm/V", spring_constant="0.2 N/m")
    np.testing.assert_allclose(by_force.pull_off_force, [1.2, 2.4])
    np.testing.assert_allclose(by_deflection.pull_off_force, [1.2, 2.4])
    assert by_deflection.spring_constant == 0.2 and by_deflection.sensitivity_units == "nm/V"
    bare = roughxr.open_pull_off(written(tmp_path, "1e-9\n3e-9\n", "bare.txt"), units="N")
    np.testing.assert_allclose(bare.pull_off_force, [1.0, 3.0])


@pytest.mark.parametrize("heading", ["x,y,adhesion [nN]", "X Position,Y Position,Adhesion [nN]"])
def test_places_without_units_are_left_out_and_this_is_said(tmp_path, heading):
    path = written(tmp_path, f"{heading}\n0,0,1\n1,1,2\n")
    with pytest.warns(UserWarning, match="places .* are left out: the file states no units; give them, place_units="):
        measured = roughxr.open_pull_off(path)
    assert measured.pull_off_force.values.tolist() == [1, 2] and "subregion_x" not in measured.coords
    stated = roughxr.open_pull_off(path, place_units="um")
    assert stated.subregion_x.values.tolist() == [0, 1000]


def test_jpks_export_has_its_adhesion_read(tmp_path):
    text = "Filename\tPosition Index\tX Position\tY Position\tBaseline [N]\tAdhesion [N]\n"
    rows = [f"c{k}.jpk-force\t{k}\t{k}e-6\t2e-6\t1e-10\t{force}e-9\n" for k, force in enumerate((12.5, 9.1, 14.2))]
    path = written(tmp_path, text + "".join(rows), "export.tsv")
    with pytest.warns(UserWarning, match="'X Position', 'Y Position' are left out"):
        measured = roughxr.open_pull_off(path)
    np.testing.assert_allclose(measured.pull_off_force, [12.5, 9.1, 14.2])
    np.testing.assert_allclose(roughxr.open_pull_off(path, place_units="m").subregion_x, [0, 1000, 2000])


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("Adhesion force (nN)\n12.5\n9.1\n14.2\n", {}),
        ("Adhesion force (nN)\n12,5\n9,1\n14,2\n", {}),
        ("Adhesion force [10^-9 N]\n12.5\n9.1\n14.2\n", {}),
        ("F (x10⁻⁹ N)\n12.5\n9.1\n14.2\n", {}),
        ("n,F [1e-9 N]\n1,12.5\n2,9.1\n3,14.2\n", {}),
        ("a0\n12.5\n9.1\n14.2\n", {"units": "nN"}),
        ("a0 12.5\na1 9.1\na2 14.2\n", {"units": "nN"}),
        ("label,force [nN]\na0,12.5\na1,9.1\na2,14.2\n", {}),
        ('n,F [nN]\n1,"12,5"\n2,"9,1"\n3,"14,2"\n', {}),
        ('F [nN]\n"12,5"\n"9,1"\n"14,2"\n', {}),
        ("n;F [nN]\n1;12,5\n2;9,1\n3;14,2\n", {}),
        ("n\tF [nN]\n1\t12,5\n2\t9,1\n3\t14,2\n", {}),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_short_tables_of_spreadsheets(tmp_path, text, options, encoding):
    measured = roughxr.open_pull_off(written(tmp_path, text, encoding=encoding), **options)
    np.testing.assert_allclose(measured.pull_off_force, [12.5, 9.1, 14.2], rtol=1e-12)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_decimal_comma_need_not_be_in_the_first_row(tmp_path, separator):
    text = "n;F [nN]\n1;12\n2;9,1\n".replace(";", separator)
    assert roughxr.open_pull_off(written(tmp_path, text)).pull_off_force.values.tolist() == [12, 9.1]


def test_noise_beside_zero_stays_where_the_sign_is_stated(tmp_path):
    path = written(tmp_path, "F [nN]\n-3\n0.1\n-2\n")
    np.testing.assert_allclose(roughxr.open_pull_off(path, pulls="negative").pull_off_force, [3, -0.1, 2])


def write_adhesion(folder, rows, units):
    """Write a picture as the second channel of a Gwyddion file, its values in units."""
    from gwyfile.objects import GwyContainer, GwyDataField

    container = GwyContainer()
    size = image_size(rows)
    sides = {"xreal": size[0] * 1e-9, "yreal": size[1] * 1e-9, "si_unit_xy": "m"}
    container["/0/data/title"] = "Height"
    container["/0/data"] = GwyDataField(rows * 1e-9, si_unit_z="m", **sides)
    container["/1/data/title"] = "Adhesion"
    container["/1/data"] = GwyDataField(rows * 1e-9, si_unit_z=units, **sides)
    container["/1/mask"] = GwyDataField((rows == rows.min()).astype(float), si_unit_z="", **sides)
    container.tofile(str(folder / "map.gwy"))
    return folder / "map.gwy"


def test_an_adhesion_image_lies_on_the_scan_of_its_file(tmp_path):
    rows = picture() + 5.0
    path = write_adhesion(tmp_path, rows, "N")
    measured = roughxr.open_pull_off(path)
    scan = roughxr.open_scan(path, channel="Height")
    assert measured.measured == "adhesion image" and measured.measured_units == "N"
    lowest = rows == rows.min()
    assert int(measured.pull_off_force.isnull().sum()) == lowest.sum()
    here = scan.height.sel(x=measured.subregion_x, y=measured.subregion_y)
    is_measured = measured.pull_off_force.notnull()
    np.testing.assert_allclose(measured.pull_off_force[is_measured], here[is_measured], rtol=1e-12)


def test_bare_numbers_are_an_image_where_size_and_units_are_stated(tmp_path):
    rows = picture() + 5.0
    np.save(tmp_path / "map.npy", rows)
    np.savetxt(tmp_path / "map.txt", rows)
    expected = roughxr.open_pull_off(write_adhesion(tmp_path, rows, "N"), channel="Adhesion")
    for name in ("map.npy", "map.txt"):
        measured = roughxr.open_pull_off(tmp_path / name, size=image_size(rows), units="nN")
        is_measured = expected.pull_off_force.notnull()
        np.testing.assert_allclose(
            measured.pull_off_force[is_measured], expected.pull_off_force[is_measured], rtol=1e-9
        )
        np.testing.assert_allclose(measured.subregion_y, expected.subregion_y)
        with pytest.raises(UnreadableScan, match="give them, such as units='nN'"):
            roughxr.open_pull_off(tmp_path / name, size=image_size(rows))


def test_an_image_in_volts_asks_for_its_sensitivity(tmp_path):
    path = write_adhesion(tmp_path, picture() + 5.0, "V")
    with pytest.raises(UnreadableScan, match="state sensitivity="):
        roughxr.open_pull_off(path)
    measured = roughxr.open_pull_off(path, sensitivity="2e9 nN/V")
    assert float(measured.pull_off_force.max()) == pytest.approx(2 * (picture() + 5.0).max())


def test_a_file_without_adhesion_says_what_it_holds(tmp_path):
    path = write_bruker(tmp_path, picture(), image_size(picture()))
    with pytest.raises(UnreadableScan, match=r"expected an image of adhesion, found none among 0: 'Height'"):
        roughxr.open_pull_off(path)


def write_peak_force(folder, rows, sensitivity, units="V"):
    """Write a Nanoscope file whose second image is adhesion, stored by a hard scale of 8 and a sensitivity."""
    path = write_bruker(folder, rows, image_size(rows))
    header, mark, body = path.read_bytes().partition(b"\x1a")
    first = header.split(b"\\*Ciao image list")[:1]
    second = header.split(b"\\*Ciao image list")[1:]
    image = second[1].replace(b"Height", b"Adhesion").replace(b"Retrace", b"Trace")
    scale = rf"\@2:Z scale: V [Sens. ForceSens] (0.000122070 {units}/LSB) 8.0 {units}".encode()
    image = b"\r\n".join(scale if b"Z scale" in line else line for line in image.split(b"\r\n"))
    start = first[0].replace(b"\\*Ciao scan list", b"\\*Ciao scan list\r\n" + sensitivity.encode())
    header = b"\\*Ciao image list".join([start, second[0], image])
    missing = path.stat().st_size - len(header) - 1 - len(body.lstrip(b"\0"))
    path.write_bytes(header + mark + b"\0" * missing + body.lstrip(b"\0"))
    return path


@pytest.mark.parametrize("stated", [True, False])
def test_a_nanoscope_image_of_forces_is_scaled_by_its_own_header(tmp_path, stated):
    rows = picture()
    path = write_peak_force(
        tmp_path, rows, r"\@Sens. ForceSens: V 2.5 nN/V" if stated else r"\@Sens. ForceSens: V 1.0 "
    )
    if not stated:
        with pytest.raises(UnreadableScan, match="found V; state sensitivity="):
            roughxr.open_pull_off(path, pulls="positive")
    measured = roughxr.open_pull_off(path, pulls="positive", **({} if stated else {"sensitivity": "2.5 nN/V"}))
    counts = -np.round(rows / (10.0 * 440.0) * 65536)[::-1].T.ravel()
    np.testing.assert_allclose(measured.pull_off_force, counts * 8.0 / 65536 * 2.5, rtol=1e-12)


@pytest.mark.parametrize(("stated", "options"), [("2.5 nN/Arb", {}), ("0.5 V/Arb", {"sensitivity": "5 nN/V"})])
def test_forces_in_arbitrary_units_are_scaled_by_their_sensitivity(tmp_path, stated, options):
    """As an instrument that maps forces writes them: nN if it is calibrated, else V."""
    rows = picture()
    path = write_peak_force(tmp_path, rows, rf"\@Sens. ForceSens: V {stated}", units="Arb")
    measured = roughxr.open_pull_off(path, pulls="positive", **options)
    counts = -np.round(rows / (10.0 * 440.0) * 65536)[::-1].T.ravel()
    np.testing.assert_allclose(measured.pull_off_force, counts * 8.0 / 65536 * 2.5, rtol=1e-12)
    path = write_peak_force(tmp_path, rows, r"\@Sens. ForceSens: V 1.0 ", units="Arb")
    with pytest.raises(UnreadableScan, match=r"unit 'Arb'|arbitrary units"):
        roughxr.open_pull_off(path, pulls="positive", sensitivity="2.5 nN/V")


def test_a_vendors_image_of_unknown_scale_is_refused(tmp_path):
    path = write_park(tmp_path, picture() + 5.0, image_size(picture()))
    path.write_bytes(path.read_bytes().replace("um".encode("utf-16-le"), "nN".encode("utf-16-le")))
    with pytest.raises(UnreadableScan):
        roughxr.open_pull_off(path, channel=0)


def test_foreign_files_are_refused(tmp_path):
    (tmp_path / "noise.bin").write_bytes(np.random.default_rng(0).bytes(3000))
    (tmp_path / "empty.csv").touch()
    for name in ("noise.bin", "empty.csv"):
        with pytest.raises(UnreadableScan):
            roughxr.open_pull_off(tmp_path / name)
    with pytest.raises(IsADirectoryError):
        roughxr.open_pull_off(tmp_path)
    xr.Dataset({"pull_off_force": ("subregion", [1.0])}).to_netcdf(tmp_path / "own.nc")
    with pytest.raises(UnreadableScan, match="write its pull-off forces as a table"):
        roughxr.open_pull_off(tmp_path / "own.nc")


def test_the_scale_of_forces_is_that_by_which_a_second_reader_scales_heights(tmp_path):
    rows = picture()
    path = write_bruker(tmp_path, rows, image_size(rows))
    units, scale = nanoscope_scale(path, 1, "Height")
    counts = np.frombuffer(path.read_bytes()[-2 * rows.size :], "<i2").reshape(rows.shape)[::-1]
    heights = roughxr.open_scan(path, channel=1).height
    assert units == "nm"
    np.testing.assert_allclose((counts * scale)[::-1].T, heights, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("heading", ["x [um],y [um],force [MN]", "x [Mm],y [um],force [nN]"])
def test_units_with_a_prefix_of_the_wrong_case_are_refused(tmp_path, heading):
    with pytest.raises(ValueError, match=r"expected values below 1 (N|m), found .* case-sensitive"):
        roughxr.open_pull_off(written(tmp_path, heading + "\n0,0,12.5\n1.5,0,9.5\n"))


def test_measured_forces_that_only_push_are_not_compared():
    predicted = xr.Dataset({"pull_off_force": ("subregion", [300.0, 350.0, 400.0])})
    with pytest.raises(ValueError, match="measured: expected at least one positive pull_off_force"):
        roughxr.compare(predicted, -predicted)
    noisy = predicted.assign(pull_off_force=("subregion", [-1.0, 350.0, 400.0]))
    assert roughxr.compare(predicted, noisy).measured.sel(statistic="mean") > 0


@pytest.mark.parametrize(
    "heading",
    [
        "adhesion [nN],Frequency (%)",
        "adhesion [nN],probability density (1/nN)",
        "adhesion [nN],Anzahl",
        "force [nN],nombre",
        "force [nN],N",
        "force [nN],Häufigkeit",
        "force [nN],度数",
    ],
)
def test_a_histogram_is_refused_by_any_name(tmp_path, heading):
    path = tmp_path / "histogram.csv"
    path.write_text(f"{heading}\n1.0,3\n2.0,7\n3.0,2\n", encoding="utf-8")
    with pytest.raises(UnreadableScan, match="found a distribution with column"):
        roughxr.open_pull_off(path)


@pytest.mark.parametrize(
    "heading", ["sample,adhesion [nN],std [nN],n", "sample,adhesion [nN],standard deviation,count"]
)
def test_a_summary_is_no_pull_offs(tmp_path, heading):
    path = tmp_path / "summary.csv"
    path.write_text(f"{heading}\nA,12.0,3.0,64\nB,15.0,4.0,64\n")
    with pytest.raises(UnreadableScan, match="found a summary with column"):
        roughxr.open_pull_off(path)


def test_a_swept_condition_keeps_its_pull_offs_apart(tmp_path, capsys):
    rng = np.random.default_rng(0)
    path = tmp_path / "loads.csv"
    rows = [f"{load},{load + force:.3f}" for load in (10, 20, 40) for force in rng.uniform(1, 2, 8)]
    path.write_text("load [nN],adhesion [nN]\n" + "\n".join(rows) + "\n")
    measured = roughxr.open_pull_off(path)
    assert measured.attrs["condition"] == "load [nN]" and set(measured.condition.values) == {10, 20, 40}
    with pytest.raises(ValueError, match=r"found 3 values of 'load \[nN\]': 10, 20, 40; select one"):
        measured.contact.answer()
    at_twenty = measured.where(measured.condition == 20, drop=True).contact.answer()
    assert 21 < float(at_twenty.pull_off_force) < 22
    capsys.readouterr()
    assert main(["measured", str(path)]) == 0
    printed = capsys.readouterr().out
    assert all(f"load [nN]: {load}" in printed for load in (10, 20, 40))


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_table_may_have_a_long_heading(delimiter, tmp_path):
    """Whatever the length of the heading, the numbers below it make a table of a text."""
    names = [f"remark {'abcdefghij'[k % 10] * 20}" for k in range(40)]
    heading = delimiter.join([*names, "force [nN]"]).replace("remark ", "remark_")
    rows = "".join(delimiter.join(["text"] * 40 + [str(force)]) + "\n" for force in (1.5, 2.5, 3.5))
    measured = roughxr.open_pull_off(written(tmp_path, f"{heading}\n{rows}"))
    assert measured["pull_off_force"].values.tolist() == [1.5, 2.5, 3.5]


HEADINGS = {
    "blanks": lambda n: "f1" + " " * n + "x,force [nN]",
    "brackets": lambda n: "a1(" + " (" * (n // 2) + ",force [nN]",
    "slashes": lambda n: "a1" + "/" * n + " x,force [nN]",
    "no delimiter": lambda n: "f1" + " " * n + "[nN] x",
    "tabulators": lambda n: "f1" + "\t \t" * (n // 3) + "[nN",
    "quotes": lambda n: '"f1' + " [" * (n // 2) + '",force [nN]',
}


@pytest.mark.parametrize("name", HEADINGS)
def test_a_heading_costs_time_in_proportion_to_its_length(name, tmp_path):
    begun = time.process_time()
    with contextlib.suppress(UnreadableScan):
        roughxr.open_pull_off(written(tmp_path, f"{HEADINGS[name](100_000)}\n1,2\n3,4\n"))
    assert time.process_time() - begun < 3


def test_a_workbook_is_one_in_any_order_of_its_members(tmp_path):
    """As other programs write them: sheets first; 4000 values, so that no other name is in the first bytes."""
    pytest.importorskip("openpyxl", reason="workbooks need openpyxl")
    forces = np.random.default_rng(0).uniform(1, 20, 4000)
    pd.DataFrame({"Adhesion force (nN)": forces}).to_excel(tmp_path / "a.xlsx", index=False)
    with zipfile.ZipFile(tmp_path / "a.xlsx") as archive, zipfile.ZipFile(tmp_path / "b.xlsx", "w") as turned:
        for name in sorted(archive.namelist(), key=lambda name: not name.startswith("xl/worksheets")):
            turned.writestr(name, archive.read(name))
    np.testing.assert_allclose(roughxr.open_pull_off(tmp_path / "b.xlsx").pull_off_force, forces)


@pytest.mark.parametrize("load", ["max_force (nN)", "setpoint_force (nN)", "Peak Force [nN]", "Trigger force [nN]"])
def test_a_load_is_no_pull_off(tmp_path, load):
    beside = roughxr.open_pull_off(written(tmp_path, f"curve,{load},force [nN]\na,10,1.2\nb,10,1.3\nc,10,1.1\n"))
    assert beside.pull_off_force.values.tolist() == [1.2, 1.3, 1.1]
    with pytest.raises(UnreadableScan, match="expected one column of pull-off forces, found none"):
        roughxr.open_pull_off(written(tmp_path, f"curve,{load}\na,10\nb,11\nc,10\n"))


def test_conditions_with_one_row_each_are_conditions(tmp_path, capsys):
    path = written(tmp_path, "humidity [%],adhesion [nN]\n10,12.5\n40,15.1\n70,24.2\n")
    measured = roughxr.open_pull_off(path)
    assert measured.condition.values.tolist() == [10, 40, 70]
    assert main(["measured", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "humidity [%]: 40\npull-off force: 15.1 nN" in printed and "values: 3 of 3" in printed


def test_a_column_of_samples_is_no_force(tmp_path):
    path = written(tmp_path, "Sample,F\n1,12.5\n1,9.1\n2,14.2\n")
    assert roughxr.open_pull_off(path, units="nN").pull_off_force.values.tolist() == [12.5, 9.1, 14.2]
