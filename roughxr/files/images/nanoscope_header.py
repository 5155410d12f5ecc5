r"""The header of NanoScope's files, of images, force curves and volumes: lists of entries, each with a title.

Entries are ``\name: value``, scaled ones ``\@4:name: V [quantity] (size of a count) value units``.
"""

from __future__ import annotations

import re
from typing import NamedTuple

#: Largest size of a header, bytes.
LARGEST_HEADER = 2**20

#: Last line of a header.
_HEADER_END = re.compile(rb"\\\*(?:Force )?[Ff]ile list end")

#: A value in V, its sensitivity, and the size of a count.
SCALED = re.compile(
    r"V (?:\[(?P<quantity>[^\]]*)\] )?\((?P<lsb>[-+0-9.eE]*)[^)]*\)\s*(?P<value>[-+0-9.eE]+) ?(?P<units>\w*)"
)

#: A sensitivity.
SENSITIVITY = re.compile(r"V\s+(?P<value>[-+0-9.eE]+) ?(?P<units>\S*)")


class Block(NamedTuple):
    """A list of a header: its title and values."""

    title: str
    values: dict[str, str]


def header_blocks(data: bytes) -> list[Block]:
    """Return the lists of the header with which data begin."""
    raw = data[:LARGEST_HEADER]
    end = _HEADER_END.search(raw)
    parts = re.split(r"(?m)^\\\*", raw[: end.start() if end else len(raw)].decode("latin-1"))
    blocks = (part.splitlines() for part in parts if part)
    return [Block(lines[0].strip(), header_values(lines[1:])) for lines in blocks]


def header_values(lines: list[str]) -> dict[str, str]:
    """Return the values of lines by their names, in small letters and without numbers; the last of each name."""
    entries = (re.sub(r"^\\@(?:\d+:)?|^.", "", line, count=1).partition(":") for line in lines)
    return {name.strip().lower(): value.strip() for name, _, value in entries}
