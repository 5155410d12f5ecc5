"""The types that the public surface states; ``mypy`` checks them on the program of `typed_use`."""

import inspect
import typing
from importlib import resources

import roughxr
from roughxr.accessor import ContactAccessor


def test_public_functions_state_the_types_of_all_they_take_and_return():
    functions = {name: getattr(roughxr, name) for name in roughxr.__all__}
    functions |= {name: getattr(verb, "__wrapped__", None) for name, verb in vars(ContactAccessor).items()}
    for name, function in functions.items():
        if not inspect.isfunction(function):
            continue
        assert typing.get_type_hints(function), name  # every name in them is one that exists
        signature = inspect.signature(function)
        missing = [key for key, parameter in signature.parameters.items() if parameter.annotation is parameter.empty]
        assert not missing and signature.return_annotation is not signature.empty, name


def test_the_package_says_that_it_is_typed():
    assert resources.files(roughxr).joinpath("py.typed").is_file()
