"""What people read, kept as text files: sentences, words and units of numbers, names in words; and their renderer."""

from __future__ import annotations

import csv
import math
import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib.resources import files
from string import Formatter
from typing import Any

import numpy as np

from ...mechanics.vocabulary.numbers import format_number, format_percent, format_quantity, significant

#: How numbers are written, by what stands after the colon of a field; other formats are Python's.
_FORMATS: dict[str, Callable[[Any], str]] = {
    "": format_number,
    "%": format_percent,
    "nN": format_quantity,
    "nm": lambda value: format_number(value, "nm", 2),
    "GPa": lambda value: format_number(value, "GPa"),
    "zJ": lambda value: format_number(1e3 * value, "zJ"),
    "Pa": lambda value: format_quantity(value, "Pa"),
    "2": lambda value: format_number(value, digits=2),
    "~": significant,
    "+": format_number,
    "?": lambda value: "",
}


class _Unknown(LookupError):
    """A value of a sentence is not known."""


def _is_known(value: Any) -> bool:
    """Return whether a value is a number, a text that is not empty, or true."""
    if value is None or isinstance(value, (str, bool, np.bool_)):
        return bool(value)
    return not math.isnan(value)


class _Sentences(Formatter):
    """The sentences of a file, whose fields are values or other entries of the file."""

    def __init__(self, entries: Mapping[str, Any], values: Mapping[str, Any]):
        self.entries = entries
        self.values = values

    def render(self, name: str) -> str:
        """Return the first text of an entry whose values are all known, empty if there is none."""
        texts = self.entries[name]
        for text in [texts] if isinstance(texts, str) else texts:
            try:
                return self.format(text)
            except _Unknown:
                continue
        return ""

    def get_value(self, key: Any, args: Any, kwargs: Any) -> Any:
        if key in self.entries:
            if key in self.values:
                raise ValueError(f"{key!r} is a value and an entry of the sentences")
            return self.render(key)
        value = self.values.get(key)
        if not _is_known(value):
            raise _Unknown(key)
        return value

    def format_field(self, value: Any, format_spec: str) -> str:
        if isinstance(value, str) and not format_spec:
            return value
        if format_spec == "+" and not value > 0:
            raise _Unknown(value)
        written = _FORMATS.get(format_spec)
        return written(value) if written else format(float(value), format_spec)


@cache
def _entries(file: str) -> dict[str, Any]:
    return tomllib.loads(files(__package__).joinpath(file).read_text(encoding="utf-8"))


def render_sentence(file: str, name: str, values: Mapping[str, Any]) -> str:
    """Return an entry of a file with values in its fields, empty if one of them is not known."""
    return _Sentences(_entries(file), values).render(name)


def render_sentences(file: str, names: Iterable[str], values: Mapping[str, Any]) -> list[str]:
    """Return entries of a file with values in their fields, without those of which a value is not known."""
    return list(filter(None, (render_sentence(file, name, values) for name in names)))


def table_of_words(name: str) -> list[list[str]]:
    """Return the rows of a table of this folder, without its head and its lines of comment."""
    lines = files(__package__).joinpath(name).read_text(encoding="utf-8").splitlines()
    return list(csv.reader(line for line in lines[1:] if not line.startswith("#")))


def names_in_words(kind: str) -> dict[str, str]:
    """Return names of a kind, such as methods or formulas, with their words."""
    return {name: words for kind_of_name, name, words in table_of_words("names.csv") if kind_of_name == kind}
