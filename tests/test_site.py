"""The documentation's sources: nothing public is left out, and what they show of the command line is there.

Building them is a command of its own (.github/CONTRIBUTING.md), in which every warning is an error.
"""

import re
import shlex
import warnings
from pathlib import Path

import matplotlib
import numpy as np
import pandas
import pytest
import xarray as xr

import roughxr
from roughxr import figures
from roughxr.accessor import ContactAccessor
from roughxr.application.cli.options import command_line
from roughxr.mechanics.bodies.substances import MATERIALS

from . import force_curves
from .surfaces import bare_runs

matplotlib.use("Agg")

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "notebooks" / "site"


def entries(page: Path) -> set[str]:
    """Return what a page's lists of functions name."""
    return set(re.findall(r"^   ([A-Za-z_0-9.]+)$", page.read_text(encoding="utf-8"), re.MULTILINE))


def test_every_public_function_has_its_page():
    public = {name for name in roughxr.__all__ if callable(getattr(roughxr, name))}
    assert public <= entries(PAGES / "api.rst")


def test_every_verb_of_the_accessor_has_its_page():
    verbs = {name for name in vars(ContactAccessor) if name[0] != "_"}
    assert verbs <= {name.rpartition(".")[2] for name in entries(PAGES / "api.rst")}


def test_every_figure_function_has_its_page():
    assert {f"figures.{name}" for name in figures.__all__} <= entries(PAGES / "api.rst")


def test_the_papers_two_methods_print_what_the_readme_shows():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    code, printed = re.search(r"```python\n([^`]*\.direct\(delta=[^`]*)```\n\n```text\n([^`]*)```", text).groups()
    *statements, direct, superposed = code.strip().splitlines()
    names: dict = {}
    exec("\n".join(statements), names)
    assert [repr(eval(line, names)) for line in (direct, superposed)] == printed.splitlines()


def test_the_finished_report_of_the_site_is_that_of_the_readmes_run():
    (command,) = re.findall(r'^_README_RUN = "(.*)"$', (ROOT / "notebooks" / "conf.py").read_text(), re.MULTILINE)
    commands = re.findall(r"roughxr run .*", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert shlex.split(command) in [shlex.split(line) for line in commands]


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted(PAGES.glob("*.md"))], ids=lambda page: page.name)
def test_python_that_pages_show_is_python(page):
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        compile(block, str(page), "exec")


def test_the_page_of_five_commands_and_five_verbs_names_those_that_exist():
    text = (PAGES / "five-and-five.md").read_text(encoding="utf-8")
    commands = re.findall(r"^\| `roughxr (.*?)` \|", text, re.MULTILINE)
    assert len(commands) == 5
    for command in commands:
        assert command_line().parse_args(shlex.split(command))  # it ends for unknown commands and options
    verbs = re.findall(r"^\| `\w+\.contact\.(\w+)\(", text, re.MULTILINE)
    assert len(verbs) == 5 and set(verbs) <= set(vars(ContactAccessor))


HOW_TO = "".join(page.read_text(encoding="utf-8") for page in sorted(PAGES.glob("how-to*.md")))
RECIPES = re.findall(r"```python\n(.*?)```", HOW_TO, re.DOTALL)


@pytest.fixture(scope="module")
def readers_files(tmp_path_factory):
    """The files that the recipes take for a reader's own, in one folder."""
    from SurfaceTopography import Topography
    from SurfaceTopography.Container.IO import write_containers
    from SurfaceTopography.Container.SurfaceContainer import InMemorySurfaceContainer

    folder = tmp_path_factory.mktemp("reader")
    scan = roughxr.open_sample("rough")
    part = scan.isel(x=slice(0, 64), y=slice(0, 64))
    for name in ("first", "second", "third"):
        roughxr.scans.to_file(part, folder / f"{name}.gsf")
    x = part.x.values - part.x.values.mean()
    cap = part.height.values - np.add.outer(x**2, x**2) / 6000
    roughxr.scans.to_file(part.assign(height=(("x", "y"), cap)), folder / "probe.gsf")
    maps = [scan.height.coarsen(x=pixels, y=pixels).mean().values for pixels in (1, 2, 4)]
    topographies = [Topography(heights, (5000.0, 5000.0), unit="nm") for heights in maps]
    write_containers([InMemorySurfaceContainer(topographies)], str(folder / "container.zip"))
    random = np.random.default_rng(1)
    forces = random.lognormal(3.5, 0.4, 30)
    x, y = random.uniform(0, 4000, (2, 30))
    measured = pandas.DataFrame({"x [nm]": x, "y [nm]": y, "pull-off force [nN]": forces})
    measured.to_csv(folder / "pull-offs.csv", index=False)
    moved = pandas.DataFrame({"landing_share": 1 / 30, "pull_off_force [nN]": forces})
    moved.to_csv(folder / "moved.csv")
    force_curves.write_afmformats(folder / "curves.h5", count=1)
    ends = xr.Dataset({"pull_off_mean": 38.0, "pull_off_low": 13.0, "pull_off_high": 113.0})
    (folder / "run").mkdir()
    roughxr.archive.save({"statistics/extrapolated": ends}, folder / "run" / "run.nc")
    return folder


def test_the_page_names_all_materials():
    names = re.search(r"Named materials are (.*?);", HOW_TO, re.DOTALL)[1]
    assert set(re.split(r", | and ", names)) == set(MATERIALS)


def _with_few_places(recipe: str) -> str:
    """Return a recipe on a part of the scan, at few places and on coarse cells, which takes seconds."""
    part = 'open_sample("rough").isel(x=slice(0, 64), y=slice(0, 64))'
    if "lens" not in recipe:  # its contact needs all of the film, and takes a second
        recipe = recipe.replace('open_sample("rough")', part)
        recipe = re.sub(r"contact\.adhesive\((?![^)]*mesh)", "contact.adhesive(mesh=1, ", recipe)
    recipe = recipe.replace("extrapolated()", "extrapolated(subregions=(3, 2), mesh=1, places=1)")
    recipe = recipe.replace("error_budget(", "error_budget(mesh=1, places=1, ")
    recipe = recipe.replace("vary(roughxr.adhesive, ", "vary(roughxr.adhesive, mesh=1, ")
    recipe = recipe.replace('run(scan, "long-run"', 'run(scan, "long-run", mesh=1')
    return recipe.replace("(8, 8)", "(2, 1)").replace("(4, 4)", "(2, 1)").replace("count=16", "count=2")


@pytest.mark.filterwarnings("ignore:.*expected units")
@pytest.mark.parametrize("number", range(len(RECIPES)))
def test_each_recipe_runs_from_its_first_line(number, readers_files, monkeypatch):
    monkeypatch.chdir(readers_files)
    with warnings.catch_warnings(), bare_runs("extrapolated", "budget", "curves", "rigid", "superposition"):
        warnings.simplefilter("ignore")
        exec(compile(_with_few_places(RECIPES[number]), "how-to.md", "exec"), {})
