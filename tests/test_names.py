"""The names under which the package can be reached."""

import importlib
import pkgutil

import pytest

import roughxr

MODULES = sorted(module.name for module in pkgutil.walk_packages(roughxr.__path__, "roughxr."))


@pytest.mark.parametrize("name", MODULES)
def test_no_function_hides_a_module(name):
    package, _, last = name.rpartition(".")
    module = importlib.import_module(name)
    assert getattr(importlib.import_module(package), last) is module
