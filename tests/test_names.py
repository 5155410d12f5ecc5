"""The names under which the package can be reached, and options that a mode does not use."""

import ast
import importlib
import importlib.util
import pkgutil
from pathlib import Path

import pytest
import xarray as xr

import roughxr

MODULES = sorted(module.name for module in pkgutil.walk_packages(roughxr.__path__, "roughxr."))

#: Names that say nothing of the quantity.
VAGUE = {"found", "told", "said", "asked", "held", "kept", "one", "those", "here", "there", "back", "well", "wet"}
VAGUE |= {"gain", "apart", "sharper", "beside", "around", "among"}


def test_no_function_hides_a_module():
    for name in MODULES:
        package, _, last = name.rpartition(".")
        module = importlib.import_module(name)
        assert getattr(importlib.import_module(package), last) is module, name


def test_no_name_is_vague():
    for module in MODULES:
        source = Path(importlib.util.find_spec(module).origin).read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(source)))
        names = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        names |= {node.arg for node in nodes if isinstance(node, ast.arg)}
        names |= {node.name for node in nodes if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
        assert not {name for name in names if name.strip("_") in VAGUE}, module


@pytest.mark.parametrize("option", [{"classes": 3}, {"poisson_ratio": 0.2}])
def test_an_option_that_a_mode_does_not_use_is_refused(option):
    pair = {"sphere_radius": 100.0, "work_of_adhesion": 0.1, "contact_modulus": 40.0}
    pull = xr.Dataset({"pull_off_force": ("subregion", [3.0, 2.0, 1.0])}, pair)
    roughxr.particles.to_dem(pull, code="rock_n_roll")
    with pytest.raises(ValueError, match=f"{next(iter(option))}: not used"):
        roughxr.particles.to_dem(pull, code="rock_n_roll", **option)


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parent / "benchmarks").glob("[!_]*.py")), ids=lambda path: path.stem
)
def test_a_benchmark_can_be_imported(path):
    """All but those of programs that are not installed here: what they need of roughxr is there."""
    try:
        importlib.import_module(f"tests.benchmarks.{path.stem}")
    except ModuleNotFoundError as error:
        assert not error.name.startswith(("roughxr", "tests")), error
