"""What people read, kept as text files: words and units of numbers, names in words."""

from __future__ import annotations

import csv
from importlib.resources import files


def table_of_words(name: str) -> list[list[str]]:
    """Return the rows of a table of this folder, without its head and its lines of comment."""
    lines = files(__package__).joinpath(name).read_text(encoding="utf-8").splitlines()
    return list(csv.reader(line for line in lines[1:] if not line.startswith("#")))


def names_in_words(kind: str) -> dict[str, str]:
    """Return names of a kind, such as methods or formulas, with their words."""
    return {name: words for kind_of_name, name, words in table_of_words("names.csv") if kind_of_name == kind}
