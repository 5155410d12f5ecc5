"""The examples of the documentation run as a reader pastes them: each in an empty namespace."""

import doctest
import importlib
import inspect
import pkgutil
import types
import warnings

import matplotlib
import pytest

import roughxr

matplotlib.use("Agg")

from matplotlib import pyplot


def public_objects(module: types.ModuleType = roughxr, prefix: str = "roughxr") -> dict[str, object]:
    """Return the public functions and classes of the package by their names for a reader."""
    objects = {}
    for name in getattr(module, "__all__", []):
        attribute = getattr(module, name)
        if inspect.ismodule(attribute):
            objects |= public_objects(attribute, f"{prefix}.{name}")
        elif callable(attribute) and getattr(attribute, "__module__", "").startswith("roughxr"):
            objects[f"{prefix}.{name}"] = attribute
    return objects


#: Each object once, by its shortest name.
OBJECTS = {value: name for name, value in sorted(public_objects().items(), key=lambda item: -len(item[0]))}


FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.fixture(autouse=True)
def closed_figures():
    with warnings.catch_warnings():
        yield
    pyplot.close("all")


def assert_runs(examples: doctest.DocTest) -> None:
    """Raise with what was printed if an example prints anything else than it states."""
    printed: list[str] = []
    failed = doctest.DocTestRunner(optionflags=FLAGS).run(examples, out=printed.append).failed
    assert failed == 0, "".join(printed)


@pytest.mark.parametrize("public", OBJECTS, ids=OBJECTS.values())
def test_the_example_of_a_public_name_runs_when_pasted(public):
    examples = doctest.DocTestParser().get_doctest(inspect.getdoc(public) or "", {}, OBJECTS[public], None, 0)
    assert examples.examples, "without an example"
    assert_runs(examples)


def test_examples_of_other_functions_run_in_their_modules():
    public = [inspect.unwrap(documented) for documented in OBJECTS]
    count = 0
    for entry in pkgutil.walk_packages(roughxr.__path__, "roughxr."):
        module = importlib.import_module(entry.name)
        for examples in doctest.DocTestFinder(exclude_empty=True).find(module):
            name = examples.name.removeprefix(f"{entry.name}.")
            if examples.examples and inspect.unwrap(getattr(module, name, None)) not in public:
                assert_runs(examples)
                count += 1
    assert count > 5
