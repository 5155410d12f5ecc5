"""The start of the command line: wrong words are refused before anything slow is imported, and nothing is silent."""

import json
import subprocess
import sys

import pytest

from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.scans import to_netcdf

#: What takes most of the time of an import.
SLOW = ["numba", "matplotlib", "seaborn", "scipy", "dask", "pint"]

#: What reads units, and what xarray imports with the first coordinates.
UNITS = ["dask", "pint", "scipy"]

SPHERE = ["--sphere-radius", "3000"]
GLASS = [*SPHERE, "--materials", "glass"]
ELASTIC = ["--young-modulus", "75", "--poisson-ratio", "0.22"]

#: Words that are wrong by themselves, with the refusal, and the modules that it may import. ``scan.nc`` exists.
REFUSALS = [
    (["run", "scan.nc", *SPHERE, "--materials", "glas/silicon"], "found 'glas/silicon' (did you mean glass?)", []),
    (["run", "scan.nc", *SPHERE], "expected the bodies' elastic constants, found none", []),
    (["run", "scan.nc", *GLASS, "--film", "5 nm"], "--humidity: expected one with --film, found none", []),
    (["run", "scan.nc", *GLASS, "--subregions", "2", "2", "2"], "--subregions: expected places along x and y", []),
    (["run", "scan.nc", *GLASS, "-o", "notes.md"], "--output: expected a folder or a file ending in .nc", []),
    (["run", "scan.nc", "scan.nc", *GLASS, "-o", "notes.md"], "expected a folder for several scans", []),
    (["run", "lost.nc", *GLASS], "lost.nc: no such file or directory", []),
    (["run", "scan.nc", *GLASS, "--finer", "lost.nc"], "lost.nc: no such file or directory", []),
    (["run", "scan.nc", "--indenter", "lost.nc", "--materials", "glass"], "lost.nc: no such file or directory", []),
    (["info", "lost.nc"], "lost.nc: no such file or directory", []),
    (["report", "lost"], "lost: no such file or directory", []),
    (["convert", "scan.nc", "-o", "scan.xyz"], "--output: expected one of '.nc', '.gsf', found '.xyz'", []),
    (["compare", "scan.nc", "notes.md", "--picture", "a.gif"], "a.gif's ending: expected one of '.png'", []),
    (["detach", "scan.nc", "--dem", "lamps", "a.in"], "(did you mean lammps?)", []),
    (["detach", "scan.nc", "-o", "places.txt"], "places.txt's ending: expected one of '.csv', '.xlsx'", UNITS),
    (["detach", "scan.nc", "--particle-density", "2.5 g"], "--particle-density: expected units that", UNITS),
    (["measured", "notes.md", "--spring-constant", "-1"], "--spring-constant: expected one positive number", UNITS),
    (["run", "scan.nc", "--sphere-radius", "3 J", "--materials", "glass"], "--sphere-radius: expected units", UNITS),
    (["run", "scan.nc", *GLASS, "--work-of-adhesion", "1", "2"], "--work-of-adhesion: expected one number", UNITS),
    (["run", "scan.nc", *SPHERE, *ELASTIC], "expected the adhesion of the bodies, found none", UNITS),
    (["run", "scan.nc", *GLASS, "--preload", "5 nm"], "--preload: expected units that convert to 'nN'", UNITS),
    (["run", "scan.nc", *GLASS, "--law", "jrk"], "--law: expected one of 'auto'", UNITS),
    (["run", "scan.nc", *GLASS, "--mesh", "99"], "--mesh: expected a whole number from 1 to 16", UNITS),
]

#: Prints, of each command line, its status, what it printed as an error, and the slow modules that are imported then.
_REFUSED = """if True:
    import contextlib, io, json, sys
    from roughxr.application.cli import main
    lines, slow = json.loads(sys.argv[1])
    for words in lines:
        with contextlib.redirect_stderr(io.StringIO()) as printed:
            status = main(words)
        print(json.dumps([status, printed.getvalue(), [name for name in slow if name in sys.modules]]))
"""

#: Prints the first line of progress of a run, whether its solvers were imported by then, its status, and whether dask's
#: package for clusters was imported.
_RUN = """if True:
    import contextlib, io, json, sys
    from roughxr.application.cli import main
    class Recorded(io.StringIO):
        lines = []
        def write(self, text):
            self.lines.append([text, "numba" in sys.modules])
            return len(text)
    sys.stderr = Recorded()
    with contextlib.redirect_stdout(io.StringIO()):
        status = main(sys.argv[1:])
    print(json.dumps([*Recorded.lines[0], status, "distributed" in sys.modules]))
"""


def python(program, *arguments, folder):
    """Return the lines, read as JSON, that a program of a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], cwd=folder, capture_output=True, text=True, check=True
    )
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture
def folder(tmp_path):
    """Return a folder with two files that are never read."""
    (tmp_path / "scan.nc").touch()
    (tmp_path / "notes.md").touch()
    return tmp_path


@pytest.mark.door
def test_words_that_are_wrong_by_themselves_are_refused_before_slow_imports(folder):
    lines = [command for command, *_ in REFUSALS]
    printed = python(_REFUSED, json.dumps([lines, SLOW]), folder=folder)
    for (command, refusal, allowed), (status, error, imported) in zip(REFUSALS, printed, strict=True):
        assert status == 1 and error.startswith("roughxr: ") and error.count("\n") == 1, command
        assert refusal in error, command
        assert set(imported) <= set(allowed), command
    assert sorted(path.name for path in folder.iterdir()) == ["notes.md", "scan.nc"]


@pytest.mark.door
def test_a_run_prints_a_line_before_its_solvers_are_imported_and_imports_nothing_of_clusters(tmp_path):
    made = self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    arguments = ["run", str(to_netcdf(made, tmp_path / "scan.nc")), "--sphere-radius", "300", *ELASTIC]
    arguments += ["--surface-energy", "0", "--subregions", "2", "1", "-o", str(tmp_path / "run.nc")]
    ((line, is_loaded, status, has_clusters),) = python(_RUN, *arguments, folder=tmp_path)
    assert line == "loading the package\n" and not is_loaded
    assert status == 0 and not has_clusters
