"""Curves in microscopes' files are what was written, by the file's calibration or the caller's and by no other."""

import importlib.util
import zipfile

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.application.cli import main
from roughxr.files.curves import curve_reader
from roughxr.scans import UnreadableScan

from . import force_curves as made

pytest.importorskip("afmformats", reason="microscopes' curves need the extra roughxr[curves]")

GIVEN = {"sensitivity": "50 nm/V", "spring_constant": f"{made.STIFFNESS} N/m"}
CURRENT = GIVEN | {"sensitivity": "50 nm/nA"}


@pytest.fixture(scope="module")
def volume(tmp_path_factory):
    """Return the path of a map of nine curves, and what was written."""
    path = tmp_path_factory.mktemp("volume") / "map.h5"
    return path, made.write_afmformats(path, 9)


def test_a_force_volume_is_what_was_written(volume):
    path, cycles = volume
    curves = roughxr.measured.open_curves(path)
    assert dict(curves.force.sizes) == {"subregion": 9, "branch": 2, "sample": 800}
    for k, cycle in enumerate(cycles):
        for branch, (piezo, force) in zip(curves.branch.values, cycle):
            recorded = curves.sel(subregion=k, branch=branch)
            np.testing.assert_allclose(recorded.piezo, piezo, atol=1e-9)
            np.testing.assert_allclose(recorded.force, force, rtol=1e-12)
    assert curves.spring_constant == made.STIFFNESS and curves.sensitivity == 50.0
    np.testing.assert_allclose(curves.subregion_x, np.repeat([0, 500, 1000], 3))


def test_pull_offs_of_a_volume_lie_within_their_stated_error(volume):
    measured = roughxr.open_pull_off(volume[0])
    assert roughxr.schema.kind_of(measured) == "pull_off" and measured.measured == "force-distance curves"
    off = (measured.pull_off_force - made.PULL) / measured.pull_off_standard_error
    assert float(np.abs(off).max()) < 4 and float((np.abs(off) < 2).mean()) > 0.7
    assert set(measured.reason.values) == {""} and "map.h5" in measured.source_file
    assert measured.spring_constant == made.STIFFNESS
    np.testing.assert_allclose(measured.subregion_y, np.tile([0, 500, 1000], 3))


def test_only_so_many_curves_are_in_memory_at_a_time(volume, monkeypatch):
    whole = roughxr.open_pull_off(volume[0])
    monkeypatch.setattr(roughxr.files.curves.opening, "_CURVES_IN_MEMORY", 4)
    xr.testing.assert_identical(roughxr.open_pull_off(volume[0]), whole)


def test_recorded_forces_less_their_baselines_are_the_spheres(volume):
    curves = roughxr.measured.open_curves(volume[0])
    measured = roughxr.measured.curves_pull_off(curves)
    drawn = curves.sel(branch="retraction")
    fine = np.linspace(150.0, -800.0, 100_000)
    assert measured.contact_point.mean() == pytest.approx(fine[np.flatnonzero(made.sphere(fine) > 0)[-1]], abs=1.0)
    sphere_force = (
        drawn.force - measured.baseline_offset - measured.baseline_tilt * (drawn.piezo - measured.contact_point)
    )
    away = abs(drawn.piezo.values[0] - fine[np.argmin(made.sphere(fine))]) > 25  # else before or after the detachment
    off = sphere_force.mean("subregion") - made.sphere(drawn.piezo.values[0])
    assert float(abs(off[away]).quantile(0.99)) < 5.0


WRITERS = {
    "map.h5": (lambda path, cycle: made.write_afmformats(path, 1), {}),
    "one.tab": (lambda path, cycle: made.write_afmformats(path, 1, "tab"), {}),
    "volts.csv": (made.write_workshop, GIVEN),
    "forces.csv": (
        lambda path, cycle: made.write_workshop(path, cycle, volts=False),
        {"spring_constant": made.STIFFNESS},
    ),
    "nova.txt": (made.write_nt_mdt, CURRENT),
    "asylum.ibw": (made.write_asylum, {}),
    "map.jpk-force-map": (lambda path, cycle: made.write_jpk(path, [cycle]), {}),
    "bare.jpk-force-map": (lambda path, cycle: made.write_jpk(path, [cycle], stated=False), GIVEN),
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_tells_the_same_whatever_its_name(tmp_path, name):
    cycle = made.cycle(np.random.default_rng(0))
    write, options = WRITERS[name]
    expected = roughxr.measured.curves_pull_off(
        xr.Dataset({n: ("sample", v, {"units": u}) for n, v, u in zip(("piezo", "force"), cycle[1], ("nm", "nN"))}),
        spring_constant=made.STIFFNESS,
    )
    write(tmp_path / name, cycle)
    (tmp_path / name).rename(tmp_path / "renamed.dat")
    measured = roughxr.open_pull_off(tmp_path / "renamed.dat", **options)
    for variable in (
        "pull_off_force",
        "pull_off_standard_error",
        "pull_off_distance",
        "contact_slope",
        "baseline_tilt",
    ):
        np.testing.assert_allclose(measured[variable], expected[variable], rtol=2e-4, atol=1e-6)


def test_a_jpk_map_brings_its_places(tmp_path):
    rng = np.random.default_rng(2)
    cycles = [made.cycle(rng) for _ in range(11)]
    places = [(100.0 * k, -50.0 * k) for k in range(11)]
    made.write_jpk(tmp_path / "map.jpk-force-map", cycles, places)
    measured = roughxr.open_pull_off(tmp_path / "map.jpk-force-map")
    np.testing.assert_allclose(measured.subregion_x, 100.0 * np.arange(11))
    np.testing.assert_allclose(measured.subregion_y, -50.0 * np.arange(11))
    off = (measured.pull_off_force - made.PULL) / measured.pull_off_standard_error
    assert float(np.abs(off).max()) < 4 and "JPK Instruments" in measured.source_format
    made.write_jpk(tmp_path / "bare.jpk-force", cycles[:1], stated=False)
    with pytest.raises(
        UnreadableScan, match=r"deflections without spring_constant and sensitivity; give spring_constant='0.2 N/m'"
    ):
        roughxr.open_pull_off(tmp_path / "bare.jpk-force")


def test_what_a_file_lacks_is_asked_for(tmp_path):
    cycle = made.cycle(np.random.default_rng(0))
    made.write_workshop(tmp_path / "volts.csv", cycle)
    with pytest.raises(
        UnreadableScan, match="deflections without sensitivity and spring_constant; give sensitivity='50 nm/V'"
    ):
        roughxr.open_pull_off(tmp_path / "volts.csv")
    with pytest.raises(UnreadableScan, match=r"deflections without spring_constant; give spring_constant='0.2 N/m'"):
        roughxr.open_pull_off(tmp_path / "volts.csv", sensitivity="50 nm/V")
    with pytest.raises(UnreadableScan, match="sensitivity: expected its units"):
        roughxr.open_pull_off(tmp_path / "volts.csv", sensitivity=50, spring_constant=1)
    made.write_nt_mdt(tmp_path / "nova.txt", cycle)
    with pytest.raises(UnreadableScan, match="for a force curve of NT-MDT give sensitivity= in nm/nA"):
        roughxr.open_pull_off(tmp_path / "nova.txt")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"spring_constant": "2 N/m"},
            "spring_constant: expected 1, as the file states, found '2 N/m'; leave .* out; if the file",
        ),
        (
            {"sensitivity": "60 nm/V"},
            "sensitivity: expected 5e-08, as the file states, found '60 nm/V'; leave sensitivity= out",
        ),
        ({"sensitivity": "60 nm/V", "spring_constant": "2 N/m"}, "sensitivity: expected 5e-08, as the file states"),
        ({"units": "nN"}, "leave units= out"),
        ({"pulls": "negative"}, "leave pulls= out"),
    ],
)
def test_what_a_file_states_is_not_said_again(volume, options, message):
    with pytest.raises(UnreadableScan, match=message):
        roughxr.open_pull_off(volume[0], **options)


def test_several_files_are_one(tmp_path):
    rng = np.random.default_rng(1)
    paths = [tmp_path / f"curve{k}.ibw" for k in range(3)]
    for path in paths:
        made.write_asylum(path, made.cycle(rng))
    measured = roughxr.open_pull_off(paths)
    assert measured.file.values.tolist() == [path.name for path in paths]
    assert measured.source_file == "curve0.ibw and 2 more" and measured.sizes["subregion"] == 3
    for k, path in enumerate(paths):
        assert float(measured.pull_off_force[k]) == float(roughxr.open_pull_off(path).pull_off_force[0])
    (tmp_path / "table.csv").write_text("adhesion [nN]\n1\n2\n")
    with pytest.raises(ValueError, match="expected files of one kind, found force-distance curves, table"):
        roughxr.open_pull_off([paths[0], tmp_path / "table.csv"])
    with pytest.raises(ValueError, match="found no file"):
        roughxr.open_pull_off([])


@pytest.mark.parametrize("name", ["map.h5", "one.tab", "volts.csv", "asylum.ibw", "map.jpk-force-map"])
@pytest.mark.parametrize("keep", [0.02, 0.97])
def test_a_file_cut_short_is_refused_or_its_curve_is_short(tmp_path, name, keep):
    cycle = made.cycle(np.random.default_rng(0))
    write, options = WRITERS[name]
    path = tmp_path / name
    write(path, cycle)
    whole = roughxr.open_pull_off(path, **options)
    path.write_bytes(path.read_bytes()[: int(keep * path.stat().st_size)])
    try:
        shortened = roughxr.open_pull_off(path, **options)
    except UnreadableScan as error:
        assert str(path) in str(error)
    else:  # a text that ends between two samples of the baseline is whole
        assert name.endswith((".tab", ".csv", ".txt"))
        np.testing.assert_allclose(shortened.pull_off_force, whole.pull_off_force, rtol=0.05)


@pytest.mark.parametrize("read", [roughxr.open_pull_off, roughxr.measured.open_curves, roughxr.open_scan])
def test_an_archive_cut_short_is_copied_again(tmp_path, read):
    path = tmp_path / "map.jpk-force-map"
    WRITERS[path.name][0](path, made.cycle(np.random.default_rng(0)))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(UnreadableScan, match="found none in 2,000 bytes: cut short; copy the whole file again"):
        read(path)


def test_foreign_files_are_refused(tmp_path):
    (tmp_path / "archive.zip").write_bytes(b"PK\x03\x04" + np.random.default_rng(0).bytes(500))
    xr.Dataset({"a": ("x", [1.0])}, attrs={"software": "afmformats"}).to_netcdf(tmp_path / "other.h5")
    (tmp_path / "empty.tab").write_text("# afmformats 0.18\n#\n# BEGIN METADATA\n# {}\n# END METADATA\n")
    (tmp_path / "head.csv").write_text("Force-Distance Curve\nFile Format:\t3\n")
    for name in ("archive.zip", "other.h5", "empty.tab", "head.csv"):
        for read in (roughxr.open_pull_off, roughxr.measured.open_curves):
            with pytest.raises(UnreadableScan, match=name):
                read(tmp_path / name)


def test_curves_opened_as_a_scan_are_told_for_what_they_are(tmp_path, volume, capsys):
    cycle = made.cycle(np.random.default_rng(0))
    WRITERS["map.jpk-force-map"][0](tmp_path / "map.jpk-force-map", cycle)
    WRITERS["asylum.ibw"][0](tmp_path / "asylum.ibw", cycle)
    WRITERS["volts.csv"][0](tmp_path / "volts.csv", cycle)
    for name in ("map.jpk-force-map", "asylum.ibw", "volts.csv"):
        with pytest.raises(UnreadableScan, match=f"{name}: .*found force-distance curves .*roughxr measured"):
            roughxr.open_scan(tmp_path / name)
        assert main(["info", str(tmp_path / name)]) == 1 and "roughxr measured" in capsys.readouterr().err
    made.write_nanoscope_curves(tmp_path / "nano.spm", [cycle])
    with pytest.raises(UnreadableScan, match=r"found force-distance curves \(nanoscope\)"):
        roughxr.open_scan(tmp_path / "nano.spm")


def test_without_afmformats_the_extra_is_named(volume, monkeypatch):
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "afmformats" else find_spec(name))
    with pytest.raises(ImportError, match=r'pip install afmformats, .*pip install "\.\[curves\]"'):
        roughxr.open_pull_off(volume[0])


def test_a_detector_that_ends_before_the_pull_is_no_measurement(volume):
    curves = roughxr.measured.open_curves(volume[0])
    force = curves.force.where(curves.force > curves.force.min("sample") + 20, curves.force.min("sample") + 20)
    measured = roughxr.measured.curves_pull_off(curves.assign(force=force.assign_attrs(units="nN")))
    assert set(measured.reason.values) == {"the detector's range ends before the largest pull"}
    assert measured.pull_off_force.isnull().all() and measured.contact_point.notnull().all()


def test_a_slope_that_no_spring_has_is_said(volume):
    curves = roughxr.measured.open_curves(volume[0])
    with pytest.warns(roughxr.measured.ImplausibleCurves, match="times the spring constant: the sensitivity"):
        roughxr.measured.curves_pull_off(curves.assign_attrs(spring_constant=0.5))


def test_the_command_line_tells_what_became_of_the_curves(volume, tmp_path, capsys):
    assert main(["measured", str(volume[0]), "-o", str(tmp_path / "pulls.csv")]) == 0
    said = capsys.readouterr().out
    assert "measured: force-distance curves" in said and "curves: 9 used" in said and "places: known" in said
    again = roughxr.open_pull_off(tmp_path / "pulls.csv")
    exact = roughxr.open_pull_off(volume[0])
    assert (abs(again.pull_off_force - exact.pull_off_force) < 0.2 * exact.pull_off_standard_error).all()
    assert main(["measured", str(volume[0]), "--spring-constant", "3"]) == 1
    assert "--spring-constant: expected 1, as the file states" in capsys.readouterr().err


def test_one_curve_prints_its_force(tmp_path, capsys):
    made.write_asylum(tmp_path / "one.ibw", made.cycle(np.random.default_rng(0)))
    assert main(["measured", str(tmp_path / "one.ibw")]) == 0
    out, err = capsys.readouterr()
    (line,) = [line for line in out.splitlines() if line.startswith("pull-off force:")]
    force, error = map(float, line.removeprefix("pull-off force:").removesuffix("nN").split("±"))
    assert abs(force - made.PULL) < 3 * error < 10 and not err.strip("\r ").count("Mean of empty slice")


def test_a_wave_needs_no_notes_but_its_stiffness(tmp_path, monkeypatch):
    cycle = made.cycle(np.random.default_rng(0))
    made.write_asylum(tmp_path / "whole.ibw", cycle)
    monkeypatch.setattr(made, "_NOTE", {"SpringConstant": made.STIFFNESS})
    made.write_asylum(tmp_path / "bare.ibw", cycle)
    whole, bare = (roughxr.open_pull_off(tmp_path / f"{name}.ibw") for name in ("whole", "bare"))
    np.testing.assert_array_equal(bare.pull_off_force, whole.pull_off_force)
    monkeypatch.setattr(made, "_NOTE", {"InvOLS": 5e-8})
    made.write_asylum(tmp_path / "unknown.ibw", cycle)
    with pytest.raises(UnreadableScan, match=r"deflections without spring_constant; give spring_constant='0.2 N/m'"):
        roughxr.open_pull_off(tmp_path / "unknown.ibw")
    with_stiffness = roughxr.open_pull_off(tmp_path / "unknown.ibw", spring_constant=made.STIFFNESS)
    np.testing.assert_array_equal(with_stiffness.pull_off_force, whole.pull_off_force)


def test_two_waves_are_a_curve(tmp_path):
    """Each of a map's curves is two files; a list of all of them has each curve once, at its place."""
    rng = np.random.default_rng(5)
    places = [(0.0, 0.0), (500.0, 250.0)]
    cycles = [made.cycle(rng) for _ in places]
    waves = [
        made.write_asylum_pair(tmp_path, f"Line0000Point000{number}", cycle, place)
        for number, (cycle, place) in enumerate(zip(cycles, places))
    ]
    together = roughxr.open_pull_off(sorted(tmp_path.glob("*.ibw")))
    assert together.file.values.tolist() == [path.name for path in waves]
    np.testing.assert_allclose(np.c_[together.subregion_x, together.subregion_y], places)
    for number, cycle in enumerate(cycles):
        made.write_asylum(tmp_path / "one.ibw", cycle)
        alone = roughxr.open_pull_off(tmp_path / "one.ibw")
        np.testing.assert_allclose(together.pull_off_force[number], alone.pull_off_force[0], rtol=1e-3)
    curve = roughxr.measured.open_curves(tmp_path / "Line0000Point0001ZSnsr.ibw")
    assert curve.sizes["sample"] == cycles[0][0][0].size  # without the pause
    waves[0].unlink()
    with pytest.raises(UnreadableScan, match=r"found no Line0000Point0000Defl\.ibw"):
        roughxr.open_pull_off(tmp_path / "Line0000Point0000ZSnsr.ibw")


@pytest.mark.parametrize("write", [made.write_chiaro, made.write_workshop])
def test_texts_in_an_archive_are_its_curves(tmp_path, write):
    rng = np.random.default_rng(3)
    options = GIVEN if write is made.write_workshop else {}
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        archive.writestr("notes/readme.txt", "no curve")
        for k in (1, 2, 10):
            write(tmp_path / f"curve {k}.txt", made.cycle(rng))
            archive.write(tmp_path / f"curve {k}.txt", f"curve {k}.txt")
    together = roughxr.open_pull_off(tmp_path / "all.zip", **options)
    alone = [roughxr.open_pull_off(tmp_path / f"curve {k}.txt", **options).pull_off_force for k in (1, 2, 10)]
    np.testing.assert_array_equal(together.pull_off_force, np.concatenate(alone))


def test_the_names_of_an_archive_are_searched_once(tmp_path, monkeypatch):
    """afmformats searches them for each curve: 128 × 128 curves would take an hour."""
    cycle = made.cycle(np.random.default_rng(0), n=60)
    searched = []
    namelist = zipfile.ZipFile.namelist
    monkeypatch.setattr(zipfile.ZipFile, "namelist", lambda self: searched.append(1) or namelist(self))
    counts = []
    for number in (5, 40):
        made.write_jpk(tmp_path / f"{number}.jpk-qi-data", [cycle] * number)
        searched.clear()
        read = curve_reader.read(str(tmp_path / f"{number}.jpk-qi-data"), "zip", {}, {}, 0, number)
        assert len(read["samples"]) == number
        counts.append(len(searched))
    assert counts[0] == counts[1]


def test_calibrations_that_a_jpk_map_shares_are_those_of_each_curve(tmp_path):
    cycle = made.cycle(np.random.default_rng(0))
    made.write_jpk(tmp_path / "own.jpk-force-map", [cycle] * 3)
    with (
        zipfile.ZipFile(tmp_path / "own.jpk-force-map") as archive,
        zipfile.ZipFile(tmp_path / "shared.jpk-force-map", "w") as shared,
    ):
        common = {}
        for name in archive.namelist():
            text = archive.read(name)
            if name.endswith("segment-header.properties"):
                lines = text.decode().splitlines()
                for k, channel in enumerate(("measuredHeight", "vDeflection")):
                    stem = f"channel.{channel}.conversion-set."
                    common |= {f"lcd-info.{k}.{line.partition(f'{channel}.')[2]}": 0 for line in lines if stem in line}
                    lines = [line for line in lines if stem not in line] + [f"channel.{channel}.lcd-info.*={k}"]
                text = "\n".join(lines).encode()
            shared.writestr(name, text)
        shared.writestr("shared-data/header.properties", "\n".join(common))
    repeated, other = (roughxr.open_pull_off(tmp_path / f"{name}.jpk-force-map") for name in ("own", "shared"))
    np.testing.assert_array_equal(repeated.pull_off_force, other.pull_off_force)
