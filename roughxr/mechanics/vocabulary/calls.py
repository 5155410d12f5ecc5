"""Calls of public functions: unknown, surplus, doubled and missing arguments are refused in the package's words."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from inspect import Parameter, isfunction, signature
from typing import Any, TypeVar, cast

from .refusal import WrongCall
from .text import did_you_mean

_Function = TypeVar("_Function", bound=Callable[..., Any])
_Class = TypeVar("_Class", bound=type)

#: Kinds of arguments that may stand without a name.
_BY_POSITION = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)

_parameters_of = functools.cache(lambda function: tuple(signature(function).parameters.values()))


@functools.cache
def _checked(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        is_public = checked.__module__ != function.__module__
        door = f"{checked.__module__}." * is_public + function.__name__
        check_call(function, arguments, options, door)
        return function(*arguments, **options)

    return checked


def checked_call(function: _Function) -> _Function:
    """Return a function that refuses wrong calls in words; the same one for the same function."""
    return cast(_Function, _checked(function))


def checked_class(record: _Class) -> _Class:
    """Return a dataclass or a named tuple that refuses wrong calls in words."""
    maker_name = "__new__" if issubclass(record, tuple) else "__init__"
    maker = getattr(record, maker_name)

    @functools.wraps(maker)
    def checked(own: Any, *arguments: Any, **options: Any) -> Any:
        check_call(maker, arguments, options, record.__name__, given=1)
        return maker(own, *arguments, **options)

    setattr(record, maker_name, checked)
    return record


def public_functions(namespace: Mapping[str, Any], names: Iterable[str], module: str) -> dict[str, Any]:
    """Return those of some names that are functions, as functions of a public module that refuse wrong calls."""
    checked = {name: checked_call(namespace[name]) for name in names if isfunction(namespace[name])}
    for function in checked.values():
        function.__module__ = module  # where pickle and help find it
    return checked


def check_call(
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    options: Mapping[str, Any],
    door: str,
    *,
    given: int = 0,
) -> None:
    """Raise where arguments are unknown, too many, doubled or missing, after some that are given anyway."""
    parameters = _parameters_of(function)[given:]
    kinds = {parameter.kind for parameter in parameters}
    by_position = [parameter.name for parameter in parameters if parameter.kind in _BY_POSITION]
    by_name = [parameter.name for parameter in parameters if parameter.kind is parameter.KEYWORD_ONLY]
    verb = door.rpartition(".")[2]
    if Parameter.VAR_KEYWORD not in kinds:
        _refuse_unknown(verb, options, by_name, by_position)
    if len(arguments) > len(by_position) and Parameter.VAR_POSITIONAL not in kinds:
        raise _surplus(verb, len(arguments), by_name, by_position)
    if doubled := [name for name in by_position[: len(arguments)] if name in options]:
        raise WrongCall(doubled[0], "one value", "two, one of them without a name")
    needed = [parameter.name for parameter in parameters if parameter.default is parameter.empty]
    to_give = [name for name in (*by_position[len(arguments) :], *by_name) if name not in options]
    if missing := [name for name in needed if name in to_give]:
        raise WrongCall(verb, ", ".join(missing), "none", f"see help({door})")


def _refuse_unknown(verb: str, options: Mapping[str, Any], by_name: list[str], by_position: list[str]) -> None:
    """Raise for an option that a function does not have."""
    for name in options:
        if name not in (*by_position, *by_name):
            similar = did_you_mean(name, (*by_name, *by_position))
            listed = ", ".join(by_name or by_position)
            advice = f"its options are {listed}" if listed else "leave it out"
            raise WrongCall(name, f"an option of {verb}", f"no such option{similar}", advice)


def _surplus(verb: str, given: int, by_name: list[str], by_position: list[str]) -> WrongCall:
    """Return the error of more arguments without a name than a function takes."""
    count = len(by_position)
    expected = f"at most {count} argument{'s' * (count > 1)} without a name ({', '.join(by_position)})"
    expected = expected if by_position else "arguments by their names"
    advice = f"name {'the others' if by_position else 'them'}: {', '.join(f'{name}=' for name in by_name)}"
    return WrongCall(verb, expected, f"{given} without a name", advice if by_name else "")
