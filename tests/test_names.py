"""The names of modules, functions and variables."""

import ast
import importlib
import importlib.util
import pkgutil
from pathlib import Path

import pytest

import roughxr

MODULES = sorted(module.name for module in pkgutil.walk_packages(roughxr.__path__, "roughxr."))

#: Names that say nothing of the quantity.
VAGUE = {"found", "told", "said", "asked", "held", "kept", "one", "those", "here", "there", "back", "well", "wet"}
VAGUE |= {"gain", "apart", "sharper", "beside", "around", "among", "tell", "say", "worth", "ground", "lands", "waves"}


def test_no_two_modules_share_a_name():
    """Modules of the three parts: a package may have the name of a module, and lists of public names stand above."""
    names = [
        module.name.rpartition(".")[2]
        for module in pkgutil.walk_packages(roughxr.__path__, "roughxr.")
        if not module.ispkg and module.name.count(".") > 1
    ]
    assert sorted(names) == sorted(set(names))


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
        if module == "roughxr.mechanics.vocabulary.refusal":  # a field of every message
            names.remove("found")
        assert not {name for name in names if name.strip("_") in VAGUE}, module
        assert not {name for name in names if name.strip("_").startswith("of_")}, module


def test_no_local_of_a_test_is_vague():
    vague = {"found", "one", "told", "known", "words", "given", "own", "most", "left", "some", "every", "few", "both"}
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        names = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        names |= {node.arg for node in nodes if isinstance(node, ast.arg)}
        assert not {name for name in names if name.strip("_") in vague}, path.name


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parent / "benchmarks").glob("[!_]*.py")), ids=lambda path: path.stem
)
def test_a_benchmark_can_be_imported(path):
    """All but those of programs that are not installed here: what they need of roughxr is there."""
    try:
        importlib.import_module(f"tests.benchmarks.{path.stem}")
    except ModuleNotFoundError as error:
        assert not error.name.startswith(("roughxr", "tests")), error
