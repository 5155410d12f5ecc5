"""The types that the public surface states."""

import ast
import inspect
import typing
from importlib import resources

import pytest

import roughxr

FUNCTIONS = [name for name in roughxr.__all__ if inspect.isfunction(getattr(roughxr, name))]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_public_functions_state_the_types_of_all_they_take_and_return(name):
    function = getattr(roughxr, name)
    assert typing.get_type_hints(function)  # every name in them is one that exists
    signature = inspect.signature(function)
    missing = [key for key, one in signature.parameters.items() if one.annotation is one.empty]
    assert not missing and signature.return_annotation is not signature.empty


def test_options_state_what_they_take():
    """`Any` says nothing: the rooms that still have it are named, and no other may."""
    functions = {name: inspect.unwrap(getattr(roughxr, name)) for name in FUNCTIONS}
    plain = inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
    silent = {
        (one.__module__.split(".")[1], name, key)
        for name, one in functions.items()
        for key, parameter in inspect.signature(one).parameters.items()
        if parameter.kind in plain and parameter.annotation == "Any" and key != "chunks"
    }
    assert {room for room, *_ in silent} <= {"contact", "studies", "statistics"}, silent


def test_the_package_says_that_it_is_typed():
    assert resources.files(roughxr).joinpath("py.typed").is_file()


def test_a_typed_program_uses_every_public_function():
    """The type checker reads that program: what it does not call is not checked. A name in a comment is no call."""
    from . import typed_use

    calls = (node.func for node in ast.walk(ast.parse(inspect.getsource(typed_use))) if isinstance(node, ast.Call))
    called = {one.attr for one in calls if isinstance(one, ast.Attribute) and ast.unparse(one.value) == "roughxr"}
    assert set(FUNCTIONS) - called == set()
