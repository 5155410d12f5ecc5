"""What is released: the source archive holds what its tests read, the wheel what runs and nothing else."""

import importlib.metadata
import re
import runpy
import sys
import tomllib
from pathlib import Path

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

import roughxr

ROOT = Path(__file__).parents[1]

#: Endings of what programs leave behind: never released, and compiled kernels crash where others compiled them.
_LEFT_BEHIND = {".pyc", ".nbi", ".nbc"}


def released(builder):
    """Return where an archive's files lie in it."""
    return {Path(file.distribution_path).as_posix() for file in builder(str(ROOT)).recurse_included_files()}


def written(folder):
    """Return the files below a folder of the top level that somebody wrote."""
    files = (path.relative_to(ROOT) for path in (ROOT / folder).rglob("*") if path.is_file())
    kept = (file for file in files if file.suffix not in _LEFT_BEHIND and "generated" not in file.parts)
    return {file.as_posix() for file in kept if not any(part.startswith(".") for part in file.parts)}


@pytest.mark.parametrize("folder", ["roughxr", "tests", "notebooks", "datasets"])
def test_the_source_archive_holds_what_its_tests_read(folder):
    files = released(SdistBuilder)
    assert written(folder) and written(folder) <= files
    assert "README.md" in files
    assert not [name for name in files if Path(name).suffix in _LEFT_BEHIND]


def test_the_wheel_holds_what_runs_and_nothing_else():
    files = released(WheelBuilder)
    assert files == written("roughxr") | {f"roughxr/{name}" for name in written("datasets")}
    assert {"roughxr/py.typed", "roughxr/LICENSE", "roughxr/application/report/web/explorer.js"} <= files


def test_python_runs_the_package_as_the_command_does(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["roughxr", "--version"])
    monkeypatch.delitem(sys.modules, "roughxr.__main__", raising=False)  # walks through the package import it
    with pytest.raises(SystemExit, match=r"^0$"):
        runpy.run_module("roughxr", run_name="__main__")
    assert capsys.readouterr().out.startswith(f"roughxr {roughxr.__version__};")


def test_the_version_stands_in_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "version" in project["dynamic"] and "version" not in project
    assert importlib.metadata.version("roughxr") == roughxr.__version__


def test_contributors_read_the_order_of_parts_and_rooms_that_is_checked():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layers = {contract["containers"][0]: contract["layers"] for contract in contracts if "containers" in contract}
    page = (ROOT / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
    listed = page.partition("```text\n")[2].partition("```")[0].splitlines()
    parts = [line.split()[0] for line in listed if not line.startswith(" ")]
    assert ["accessor", *parts] == layers["roughxr"]
    for part, following in zip(parts, [*parts[1:], None]):
        end = next((number for number, line in enumerate(listed) if line.split()[0] == following), None)
        start = next(number for number, line in enumerate(listed) if line.split()[0] == part)
        rooms = [re.split(r",\s*", line.strip().split("  ")[0]) for line in listed[start + 1 : end]]
        checked = [re.split(r"\s*\|\s*", layer) for layer in layers[f"roughxr.{part}"]]
        assert list(map(sorted, rooms)) == list(map(sorted, checked))


def test_every_dependency_is_imported_and_stands_below_its_use():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    project = tomllib.loads(text)["project"]
    sources = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "roughxr").rglob("*.py"))
    modules = {"pyyaml": "yaml", "pillow": "PIL", "rocket-fft": "rocket_fft"}
    for line in project["dependencies"]:
        name = re.match(r"[\w-]+", line).group()
        assert re.search(rf"^ *(import|from) {modules.get(name, name)}\b", sources, re.MULTILINE), line
    block = text.partition("dependencies = [\n")[2].partition("\n]")[0]
    assert block.lstrip().startswith("#")
