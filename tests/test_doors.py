"""No output replaces a file that is read, or a file of another kind, whatever its name and the command."""

import json
import os
import shutil
import zipfile

import h5py
import netCDF4
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughxr
from roughxr import report
from roughxr.application import archive, tables
from roughxr.application.cli import main
from roughxr.application.runs import analysis, several
from roughxr.files import doors
from roughxr.files.doors import kind_of
from roughxr.files.images.hdf5 import hdf5_channels
from roughxr.files.images.netcdf import unread, variable_names
from roughxr.measured import open_pull_off
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.scans import open_container, open_scan, to_file, to_netcdf

from .surfaces import bare_runs

PAIR = {"sphere_radius": 300, "young_modulus": 70, "poisson_ratio": 0.2, "work_of_adhesion": 0.1}
QUICK = {"subregions": (2, 1), "law": "jkr", "mesh": 1, "budget": 0}


def small_scan():
    """A scan that its pixels resolve."""
    return self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The archive of a small run, and its folder."""
    folder = tmp_path_factory.mktemp("outputs") / "run"
    surface = roughxr.assign_pair(small_scan(), **PAIR)
    with bare_runs("extrapolated", "curves", "superposition"):
        analysis.run(surface, folder, **QUICK)
    return folder / "run.nc"


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    """A folder with a file of each kind that a user may have."""
    folder = tmp_path_factory.mktemp("originals")
    surface = small_scan()
    to_netcdf(surface, folder / "scan.nc")
    to_file(surface, folder / "scan.gsf")
    archive.save({"scan": surface}, folder / "other.nc")
    with h5py.File(folder / "data.h5", "w") as file:
        file["Height"] = np.eye(4)
    with netCDF4.Dataset(folder / "classic.nc", "w", format="NETCDF3_CLASSIC") as file:
        file.createDimension("x", 4)
    pd.DataFrame({"force [nN]": [1.0, 2.0, 3.0]}).to_csv(folder / "forces.csv", index=False)
    pd.DataFrame({"force [nN]": [1.0, 2.0, 3.0]}).to_excel(folder / "forces.xlsx", index=False)
    texts = {"notes.txt": "notes\n", "page.html": "<!DOCTYPE html>\n<html>", "in.lammps": "# my own input\nunits si\n"}
    texts |= {"scan.ibw": "\5\0wave", "drawing.svg": "<svg/>", "data.json": "{}", "photo.jpg": "\xff\xd8\xff\xe1photo"}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="latin-1")
    return folder


@pytest.fixture
def own_files(originals, tmp_path):
    """Files of each kind in the test's folder."""
    shutil.copytree(originals, tmp_path, dirs_exist_ok=True)
    return sorted(path for path in tmp_path.iterdir() if path.is_file())


#: Commands that write to OUT.
COMMANDS = {
    "report": ["report", "RUN", "-o", "OUT"],
    "explore": ["explore", "RUN", "-o", "OUT"],
    "detach": ["detach", "RUN", "-o", "OUT"],
    "parameters": ["detach", "RUN", "--parameters", "OUT"],
    "lammps": ["detach", "RUN", "--dem", "lammps", "OUT"],
    "map": ["detach", "RUN", "--picture", "OUT"],
    "measured": ["measured", "forces.csv", "-o", "OUT"],
    "measured as a workbook": ["measured", "forces.xlsx", "-o", "OUT"],
    "convert": ["convert", "scan.nc", "-o", "OUT"],
    "picture": ["info", "scan.nc", "--picture", "OUT"],
    "compare": ["compare", "RUN", "forces.csv", "--picture", "OUT"],
}

#: Endings of their outputs other than .csv.
ENDINGS = {"report": "html", "explore": "html", "convert": "nc", "picture": "svg"}
ENDINGS |= {"compare": "pdf", "measured as a workbook": "xlsx"}


def words_of(name, run, output):
    """Return a command with the paths of a run and of its output."""
    return [{"RUN": str(run), "OUT": str(output)}.get(word, word) for word in COMMANDS[name]]


#: Files of a user that resemble the outputs of commands most, without those that a command reads.
ALIKE = {"report": ["page.html"], "explore": ["page.html"], "detach": ["forces.csv"], "parameters": ["forces.xlsx"]}
ALIKE |= {"lammps": ["in.lammps"], "convert": ["scan.gsf", "other.nc"]}


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_replaces_a_users_file(name, finished, own_files, tmp_path, monkeypatch, capsys):
    """Each command is led to files that resemble its output, to all that it reads, and to another.

    None of them changes but a scan that becomes a scan. Which kinds differ: `test_kinds_are_told_by_content`.
    """
    monkeypatch.chdir(tmp_path)
    names = {*ALIKE.get(name, []), *COMMANDS[name], "scan.ibw"}
    files = [path for path in own_files if path.name in names]
    before = {path: path.read_bytes() for path in files}
    archived = finished.read_bytes()
    for path in [*files, finished]:
        command = words_of(name, finished, path)
        replaces_scan = name == "convert" and path.name == "scan.gsf"  # the output of an earlier conversion
        assert main(command) == (0 if replaces_scan else 1), (command, capsys.readouterr())
        error = capsys.readouterr().err.removeprefix("loading the package\n")
        assert replaces_scan or (error.startswith("roughxr: ") and error.count("\n") == 1 and "make room" not in error)
        before.pop(path, None) if replaces_scan else None
    assert {path: path.read_bytes() for path in before} == before
    assert finished.read_bytes() == archived


@pytest.mark.parametrize("name", [name for name in COMMANDS if COMMANDS[name][0] != "detach"])
@pytest.mark.usefixtures("own_files")
def test_a_command_replaces_its_own_earlier_output(name, finished, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / f"output.{ENDINGS.get(name, 'csv')}"
    command = words_of(name, finished, path)
    path.touch()  # an empty file has no content to lose
    with bare_runs():
        for _ in range(2):
            assert main(command) == 0, capsys.readouterr()
    assert path.stat().st_size > 40


def test_detach_replaces_all_its_own_earlier_outputs(finished, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = ["detach", str(finished), "-o", "places.csv", "--parameters", "parameters.csv", "--picture", "map.png"]
    command += ["--dem", "lammps", "in.lammps", "--dem", "rock_n_roll", "rocks.csv"]
    outputs = [tmp_path / word for word in command[2:] if "." in word]
    for path in outputs:
        path.touch()
    for _ in range(2):
        assert main(command) == 0, capsys.readouterr()
    assert len(outputs) == 5 and all(path.stat().st_size > 40 for path in outputs)


@pytest.mark.parametrize("name", ["report", "picture", "convert", "measured"])
@pytest.mark.parametrize(
    ("place", "says"), [("folder", "a folder"), ("pipe", "a pipe or device"), ("below", "a file, ")]
)
@pytest.mark.usefixtures("own_files")
def test_what_is_no_place_of_a_file_is_refused_in_words(name, place, says, finished, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / f"out.{ENDINGS.get(name, 'csv')}"
    if place == "folder":
        path.mkdir()
    elif place == "pipe":
        os.mkfifo(path)
    else:
        path = tmp_path / "notes.txt" / path.name
    assert main(words_of(name, finished, path)) == 1
    error = capsys.readouterr().err
    assert f"found {says}" in error and "make room" not in error


@pytest.mark.parametrize("name", ["places.csv", "report.html", "table.txt", "places.xlsx", "overview.png"])
def test_a_run_into_a_folder_with_files_of_its_names_is_refused_before_it_begins(name, tmp_path):
    surface = roughxr.assign_pair(small_scan(), **PAIR)
    (tmp_path / name).write_text("mine")
    with pytest.raises(ValueError, match=f"output: expected a folder .* found {name}"):
        roughxr.run(surface, tmp_path, **QUICK)
    assert [file.name for file in tmp_path.iterdir()] == [name] and (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize("name", ["places.csv", "index.html", "places.xlsx", "[1].csv"])
def test_a_batch_into_a_folder_with_files_of_its_names_is_refused(name, tmp_path):
    folder = tmp_path / "[1]"
    folder.mkdir()
    (folder / name).write_text("<!DOCTYPE html>\nmine")
    with pytest.raises(ValueError, match="output: expected a folder of an earlier run"):
        several.scan_folders(["a.nc", "b.nc"], folder)
    (folder / "index.html").write_text('<!DOCTYPE html>\n<meta name="generator" content="roughxr">')
    assert len(several.scan_folders(["a.nc", "b.nc"], folder)) == 2


def test_a_run_replaces_its_own_files(finished, tmp_path):
    """A finished run that is called again writes its pages anew, whatever the columns of its tables were."""
    surface = roughxr.assign_pair(small_scan(), **PAIR)
    for name in ("places.csv", "report.html", "table.txt", "overview.png"):
        (finished.parent / name).write_text("of an earlier version")
    with bare_runs("extrapolated", "curves", "superposition"):
        roughxr.run(surface, finished.parent, **QUICK)
    assert (finished.parent / "places.csv").read_text().startswith("scan,")


@pytest.mark.parametrize("place", ["pipe", "pipe/run.nc", "scan.nc", "scan.nc/run.nc", "data.h5", "other.nc"])
@pytest.mark.usefixtures("own_files")
def test_a_run_is_written_to_a_place_of_its_own(place, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    surface = roughxr.assign_pair(open_scan(tmp_path / "scan.nc"), **PAIR)
    before = (tmp_path / "scan.nc").read_bytes(), (tmp_path / "other.nc").read_bytes()
    with pytest.raises(ValueError, match="expected"):
        roughxr.run(surface, tmp_path / place, **QUICK)
    assert before == ((tmp_path / "scan.nc").read_bytes(), (tmp_path / "other.nc").read_bytes())


@pytest.mark.usefixtures("own_files")
def test_python_replaces_neither_the_source_of_a_dataset_nor_another_kind(finished, tmp_path):
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    forces = open_pull_off(tmp_path / "forces.csv")
    surface = open_scan(tmp_path / "scan.gsf")
    for write, ds, name in (
        (tables.to_table, forces, "forces.csv"),
        (tables.to_table, forces, "forces.xlsx"),
        (to_file, surface, "scan.gsf"),
        (to_netcdf, surface, "scan.gsf"),
        (to_netcdf, surface, "other.nc"),
        (to_netcdf, surface, "forces.csv"),
        (lambda ds, path: archive.save({"scan": ds}, path), surface, "scan.nc"),
        (lambda ds, path: archive.save({"scan": ds}, path), surface, "classic.nc"),
        (lambda _, path: report.write_report(finished, path), None, "page.html"),
        (lambda _, path: report.write_explorer(finished, path), None, "scan.nc"),
    ):
        with pytest.raises(ValueError, match=r"expected (a new name|another name)"):
            write(ds, tmp_path / name)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.usefixtures("own_files")
def test_kinds_are_told_by_content(tmp_path):
    kinds = {path.name: kind_of(path) for path in tmp_path.iterdir()}
    alike = {"data.h5", "scan.nc"}
    assert len(set(kinds.values())) == len(kinds) - len(alike) + 1
    written = tables.to_table(xr.Dataset({"force": ("subregion", [1.0])}), tmp_path / "own.xlsx")
    assert kind_of(written) != kinds["forces.xlsx"]


def external(path, name, private):
    """Write an HDF5 file whose data lie in another file, in one of the ways that HDF5 has."""
    with h5py.File(path, "w") as file:
        if name == "storage":
            file.create_dataset("heights", shape=(8,), dtype="u1", external=[(str(private), 0, 8)])
        elif name == "storage of an axis":
            file.create_dataset("x", shape=(8,), dtype="u1", external=[(str(private), 0, 8)])
        elif name == "link":
            file["scan"] = h5py.ExternalLink(str(private), "/scan")
        elif name == "virtual":
            layout = h5py.VirtualLayout((8, 8), "f8")
            layout[:] = h5py.VirtualSource(str(private), "scan/height", (8, 8))
            file.create_virtual_dataset("group/height", layout)
        file.attrs["_NCProperties"] = "version=2,netcdf=4.9.2,hdf5=1.14"


@pytest.mark.parametrize("name", ["storage", "storage of an axis", "link", "virtual"])
def test_no_door_reads_hdf5_that_takes_data_from_another_file(name, tmp_path, capsys):
    private = tmp_path / "private.nc"
    archive.save({"scan": small_scan()}, private)
    path = tmp_path / "line.nc"
    external(path, name, private)
    doors = [
        archive.load,
        archive.root_attributes,
        open_scan,
        open_pull_off,
        report.write_report,
        report.write_explorer,
    ]
    for door in [*doors, unread, variable_names, hdf5_channels, container_of]:
        with pytest.raises(ValueError, match="data in the file itself"):
            door(path)
    for command in (["info"], ["convert", "-o", str(tmp_path / "out.gsf")], ["detach"], ["report"], ["measured"]):
        assert main([*command, str(path)]) == 1
        assert "data in the file itself" in capsys.readouterr().err


def container_of(path):
    """Open a published container whose one member, a line by its metadata, is a file."""
    packed = path.with_suffix(".zip")
    topography = {
        "name": "a",
        "size": [64.0],
        "unit": "nm",
        "datafile": {"squeezed-netcdf": "l.nc", "original": "l.nc"},
    }
    with zipfile.ZipFile(packed, "w") as file:
        file.write(path, "l.nc")
        file.writestr("index.json", json.dumps({"surfaces": [{"topographies": [topography]}]}))
    return open_container(packed)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.usefixtures("own_files")
def test_no_command_waits_for_a_pipe(tmp_path, monkeypatch, capsys):
    """Each command and each option that reads a file, led to a pipe into which nobody writes, and to a device."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("run.nc")
    sphere = ["--sphere-radius", "100", "--materials", "glass"]
    for pipe in ("run.nc", "/dev/zero", "."):  # the last is a folder with a pipe as its archive
        commands = [["report", pipe], ["explore", pipe], ["detach", pipe], ["compare", pipe, "forces.csv"]]
        commands += [["fit", pipe, "forces.csv"]]
        commands += [["info", pipe], ["convert", pipe, "-o", "a.gsf"], ["measured", pipe], ["run", pipe, *sphere]]
        commands += [["run", "scan.nc", *sphere, "--finer", pipe]]
        commands += [["run", "scan.nc", "--materials", "glass", "--indenter", pipe]]
        for command in commands:
            assert main(command) == 1
            error = capsys.readouterr().err
            assert any(text in error for text in ("an ordinary file", "found a folder", "one archive")), (
                command,
                error,
            )


def test_an_archive_of_another_process_is_searched_once_however_often_it_is_read(tmp_path, monkeypatch):
    """One that this process wrote is not searched, under its final name, too; a changed file is searched anew."""
    searched = []
    foreign_data = doors._foreign_data
    monkeypatch.setattr(doors, "_foreign_data", lambda file: searched.append(file.filename) or foreign_data(file))
    path = archive.save({"scan": small_scan()}, tmp_path / "run.nc")
    archive.load(path)
    assert not searched
    other = shutil.copy(path, tmp_path / "other.nc")
    for _ in range(2):
        archive.load(other)
    assert len(searched) == 1
    with h5py.File(path, "a") as file:
        file["elsewhere"] = h5py.ExternalLink("other.nc", "/height")
    with pytest.raises(ValueError, match="another file"):
        archive.load(path)
