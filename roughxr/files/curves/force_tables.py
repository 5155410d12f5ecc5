"""Tables of pull-off forces: one row for each place, named columns, units in the header or stated by the caller."""

from __future__ import annotations

import csv
import re
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...mechanics.vocabulary.text import Argument, Phrase
from ...mechanics.vocabulary.units import converts
from ..images.channel import UnreadableScan, first_bytes, length_factor, only_one, refuse_stated
from ..images.plain import decoded, separators
from .forces import measurable

#: Names with units: "force [nN]", "force (nN)", "force / nN", "force_nN".
_HEADED = re.compile(r"^(.*?)(?:\s*\[([^\]]*)\]|\s*\(([^)]*)\)|\s*/\s*([^/\s]+)|_(nm|[uµμm]?m|[pnuµμm]?N))$")

#: Names of columns of places: "x", "X Position", "subregion_x", "pos_x"; and names that only resemble one.
_PLACE = re.compile(
    r"(?:(?:subregion|pos(?:ition)?|coord(?:inate)?)[\s_]*)?([xy])(?:[\s_]*(?:pos(?:ition)?|coord(?:inate)?))?"
)
_PLACE_LIKE = re.compile(r"(?:^|[\s_])[xy](?:$|[\s_])|(?:position|coord)(?!.*(?:index|number))", re.IGNORECASE)

#: A number with a decimal comma; a power of ten before units, as in "10^-9 N", its digits perhaps raised.
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_POWER = re.compile(r"(?:[x×*·]?\s*10\s*\^?|1?[eE])\s*[({]?([-+]?\d+)[)}]?\s*[*·]?\s*([^\W\d].*)")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")

#: Columns of a distribution, whose rows are not pull-offs.
_DISTRIBUTION = re.compile(
    r"cumul|cdf|pdf|fraction|probab|percent|quantile|density|frequency|(?<!debris_)share|"
    r"^(counts?|occurrences?|events?|hits)$|^(number|no\.?|#) of|^(anzahl|nombre|effectifs?|numero|número|cantidad|n)$|"
    r"h(ä|ae)ufigkeit|fr[ée]quence|frecuencia|frequenza|частота|度数|頻度|频数|频率|"
    r"wahrscheinlichkeit|dichte|densit[ée]|densidad",
    re.IGNORECASE,
)

#: Columns of a summary, whose rows are means of pull-offs.
_SUMMARY = re.compile(
    r"^(.*[\s_])?(std|stdev|std\.? ?dev\.?|sd|s\.d\.|sem|standard deviation|standardabweichung|[ée]cart[- ]type|"
    r"desviaci[óo]n est[áa]ndar)$",
    re.IGNORECASE,
)

#: Columns of loads, which press: no pull-offs.
_LOAD = re.compile(
    r"load|set[\s_-]?point|trigger|threshold|(?:^|[\s_])(?:max|maximum|peak|applied)(?:$|[\s_])", re.IGNORECASE
)

#: Columns of conditions that a measurement may vary.
_SWEPT = re.compile(
    r"(?:^|[\s_])((?:pre)?load|set[\s_-]?point|humidity|rh|diameter|radius|temperature|dwell|contact time|"
    r"speed|velocity|voltage|last|luftfeuchte|durchmesser)(?:$|[\s_])",
    re.IGNORECASE,
)

#: Largest size of a workbook's sheet, bytes: half a million cells, which take some ten seconds.
_LARGEST_SHEET = 2**24

#: Longest name of a column, characters: searching longer ones for units would take minutes.
_LONGEST_NAME = 1000

#: Cells that mean a missing value.
_EMPTY = ("", "-", "nan", "na", "n/a", "none")

#: Names of columns of adhesion forces, certain and likely ones.
_ADHESION = re.compile("adhes|pull.?off", re.IGNORECASE)
_FORCE = re.compile("adhes|pull|force|snap", re.IGNORECASE)


class Column(NamedTuple):
    """One column of a table."""

    name: str
    units: str | None
    values: np.ndarray


#: Line and cells of each row.
_Rows = list[tuple[int, list[str]]]


def read_table(path: Path, pull_offs: bool = False) -> list[Column]:
    """Return the columns of numbers of a table; with ``pull_offs`` raise for rows below an empty line."""
    names, cells, comma, lines = (_read_spreadsheet if is_spreadsheet(path) else _read_text)(path)
    gaps = np.flatnonzero(np.diff(lines) > 1)
    if pull_offs and 0 < gaps.size < len(lines) - 1:  # a mean, or another table
        line = lines[gaps[0] + 1]
        where = (f"line {line}",)
        raise UnreadableScan(path, "one table", "an empty line above", "leave out what follows", where=where)
    _same_width(path, cells, len(names))
    columns = [_column(path, name, [(k, row[at]) for k, row in cells], comma) for at, name in enumerate(names)]
    return [column for column in columns if column is not None]


def is_spreadsheet(path: Path) -> bool:
    """Return whether a file is an Excel workbook, by the names of its members in any order."""
    if not first_bytes(path, 4).startswith(b"PK") or not zipfile.is_zipfile(path):
        return False
    with zipfile.ZipFile(path) as archive:
        return any(name.startswith("xl/") for name in archive.namelist())


def _read_spreadsheet(path: Path) -> tuple[list[str], _Rows, bool, list[int]]:
    """Return names (from the first row that is not empty) and rows of a workbook's first sheet, as `_in_text`."""
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    cells = ("xl/worksheets/", "xl/sharedStrings")
    size = max((member.file_size for member in members if member.filename.startswith(cells)), default=0)
    if size > _LARGEST_SHEET:
        largest, unpacked = (f"{bytes_ / 2**20:.3g} MiB" for bytes_ in (_LARGEST_SHEET, size))
        advice = "save the columns that are needed as CSV, which is read faster"
        raise UnreadableScan(path, f"a sheet of at most {largest} unpacked", unpacked, advice)
    try:
        frame = pd.read_excel(path, header=None, dtype=str, na_filter=False)
    except ImportError as error:
        raise ImportError(f"{path.name}: a workbook needs openpyxl; install it, or save the sheet as CSV") from error
    rows = [(k + 1, [str(cell).strip() for cell in row]) for k, row in enumerate(frame.to_numpy()) if any(row)]
    if len(rows) < 2:
        raise UnreadableScan(path, "a row of names and rows of numbers on the first sheet", f"{len(rows)} rows")
    return rows[0][1], rows[1:], False, [k for k, _ in rows[1:]]


def _read_text(path: Path) -> tuple[list[str], _Rows, bool, list[int]]:
    """Return names and rows of a text, whether numbers have a decimal comma, and the lines that are not empty."""
    lines = [(k + 1, line) for k, line in enumerate(decoded(path.read_bytes()).splitlines()) if line.strip()]
    rows = [(k, line) for k, line in lines if not line.lstrip().startswith("#")]
    if not rows:
        raise UnreadableScan(path, "a table of numbers", "comments only")
    heading = [_number(cell, True) for cell in _split(rows[0][1], separators(rows[0][1])[0]) if cell not in _EMPTY]
    first = 0 if any(number is not None for number in heading) else 1
    if len(rows) == first:
        raise UnreadableScan(path, "rows of numbers", "a line of names only")
    delimiter = _delimiter(rows[0][1], [line for _, line in rows[first:]])
    cells = [(k, _split(line, delimiter)) for k, line in rows[first:]]
    comma = any(_DECIMAL_COMMA.fullmatch(cell) for _, row in cells for cell in row)
    comments = [line.lstrip("# \t") for k, line in lines if k < rows[0][0]]
    names = _split(rows[0][1], delimiter) if first else _column_names(path, comments, delimiter, cells[0][1])
    if first and len(cells[0][1]) == 1:
        names = [rows[0][1].strip().strip('"')]
    return names, cells, comma, [k for k, _ in lines if cells[0][0] <= k <= cells[-1][0]]


def _delimiter(heading: str, rows: list[str]) -> str | None:
    """Return the delimiter of rows: tabulators before white space, and no comma in a column of decimal commas."""
    if "," not in heading and all(_DECIMAL_COMMA.fullmatch(line.strip()) or line.strip().isdecimal() for line in rows):
        return None
    delimiter = next((sign for sign in ";\t" if any(sign in line.strip() for line in rows)), None)
    return delimiter or separators(next((line for line in rows if "," in line), ""))[0]


def _column_names(path: Path, comments: list[str], delimiter: str | None, row: list[str]) -> list[str]:
    """Return the names in the last comment with one for each column; a single column of numbers needs no name."""
    width = len(row)
    for line in reversed(comments):
        for names in (_split(line, delimiter), _split(line, None)):
            if len(names) == width:
                return names
    numeric = [_number(cell, True) is not None for cell in row]
    if numeric.count(True) == 1:
        return [path.stem if number else "" for number in numeric]
    if width > 1:
        expected = f"a line of names above {width} columns, such as 'x [um], y [um], force [nN]'"
        advice = Phrase(
            "for an image give ",
            Argument("size", ...),
            "; for a force curve of NT-MDT give ",
            Argument("sensitivity", ...),
            " in nm/nA and ",
            Argument("spring_constant", ...),
        )
        raise UnreadableScan(path, expected, "numbers", advice)
    return [path.stem]


def _split(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line; units in brackets belong to the name before them, quoted text is one cell."""
    if delimiter is None:
        return re.split(r" (?![\[(])", " ".join(line.split()))
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def _number(cell: str, comma: bool) -> float | None:
    if cell.lower() in _EMPTY:
        return np.nan
    try:
        return float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        return None


def _same_width(path: Path, cells: list[tuple[int, list[str]]], width: int) -> None:
    for line, row in cells:
        if len(row) == width + 1 and not row[-1]:
            del row[-1]  # a separator at the end of the line
        if len(row) != width:
            raise UnreadableScan(path, f"{width} columns as named", f"{len(row)}: cut short?", where=(f"line {line}",))


def _column(path: Path, name: str, cells: list[tuple[int, str]], comma: bool) -> Column | None:
    """Return a column of numbers, None for one of text; raise for text among numbers."""
    numbers = [_number(cell, comma) for _, cell in cells]
    texts = [(line, cell) for (line, cell), number in zip(cells, numbers) if number is None]
    if len(texts) > sum(cell.lower() not in _EMPTY for _, cell in cells) / 2:
        return None
    if texts:
        line, cell = texts[0]
        raise UnreadableScan(path, f"a number in column {name!r}", repr(cell), where=(f"line {line}",))
    if len(name) > _LONGEST_NAME:
        raise UnreadableScan(path, f"names of at most {_LONGEST_NAME} characters", f"{len(name)} in one")
    headed = _HEADED.match(name)
    units = next(filter(None, headed.groups()[1:]), None) if headed else None
    power = _POWER.fullmatch(units.translate(_SUPERSCRIPTS)) if units else None
    scale = 10.0 ** int(power[1]) if power else 1.0
    values = np.array(numbers, dtype=float) * scale
    return Column(headed[1] if headed and units else name, power[2] if power else units, values)


def force_column(path: Path, columns: list[Column], name: str | int | None) -> Column:
    """Return the column of forces: the named one, by default the only candidate."""
    fitting = _likely_forces(columns) if name is None else _named(columns, str(name))
    wanted = f"a column {name!r}" if name is not None else "one column of pull-off forces"
    listed = ", ".join(f"{column.name!r} [{column.units or '?'}]" for column in columns) or "no column of numbers"
    return only_one(path, fitting, wanted, listed, Phrase("give its name, ", Argument("channel", ...)))


def refuse_distribution(path: Path, columns: list[Column], force: Column) -> None:
    """Raise for a histogram or a distribution, whose rows are not pull-offs."""
    others = [column for column in columns if not (column is force or _axis(column) or _is_row_number(column))]
    for what, pattern in (("a summary", _SUMMARY), ("a distribution", _DISTRIBUTION)):
        names = [column.name for column in others if pattern.search(column.name.strip())]
        if names:
            advice = "give the pull-offs themselves, or drop the column"
            raise UnreadableScan(path, "one row for each pull-off", f"{what} with column {names[0]!r}", advice)


def _is_row_number(column: Column) -> bool:
    """Return whether a column counts the rows."""
    return bool((np.diff(column.values) == 1).all()) and column.values.size > 1 and column.values[0] in (0, 1)


def swept_column(columns: list[Column], force: Column) -> Column | None:
    """Return the column of a condition with several values that differ by more than errors, None without one."""
    for column in columns:
        values = column.values[np.isfinite(column.values)]
        is_condition = column is not force and _SWEPT.search(column.name.strip())
        if not is_condition or values.size < 2:
            continue
        repeats = 1 < np.unique(values).size <= values.size / 2
        # ratio of conditions that differ, one row each; a recorded load differs by its noise
        if repeats or 0 < 1.5 * values.min() < values.max():
            return column
    return None


def _named(columns: list[Column], name: str) -> list[Column]:
    """Return the columns of a name; without an exact match, regardless of capitals."""
    return [column for column in columns if column.name == name] or [
        column for column in columns if column.name.lower() == name.lower()
    ]


def _likely_forces(columns: list[Column]) -> list[Column]:
    """Return candidate columns of forces: by units, else by names, else all except places and indices."""
    no_forces = ("index", "subregion", "sample")
    others = [column for column in columns if not (_axis(column) or column.name.strip().lower() in no_forces)]
    others = [column for column in others if _ADHESION.search(column.name) or not _LOAD.search(column.name)]
    forces = [column for column in others if converts(column.units, "nN")]
    if forces:
        named_alike = [column for column in forces if column.name == "pull_off_force"]
        return named_alike or [column for column in forces if _ADHESION.search(column.name)] or forces
    return [column for column in others if _FORCE.search(column.name)] or others


def _axis(column: Column) -> str:
    """Return "x" or "y" for a column of places, else nothing."""
    match = _PLACE.fullmatch(column.name.strip().lower())
    return match[1] if match else ""


def place_columns(path: Path, columns: list[Column], force: Column) -> dict[str, Column]:
    """Return the columns of places along x and y, if there are any."""
    others = [column for column in columns if column is not force]
    places = {_axis(column): column for column in others if _axis(column)}
    like = [column.name for column in others if _axis(column) or _PLACE_LIKE.search(column.name)]
    if len(places) != 2 and like:
        names = ", ".join(map(repr, like))
        raise UnreadableScan(path, "columns x and y of places, or none", names, "rename or drop them")
    return places


def lengths(path: Path, column: Column, option: str, given: str | None) -> np.ndarray:
    """Return a column of lengths in nm; units by the file, else by the caller's option."""
    if column.units and given and given != column.units:
        refuse_stated(path, option, given, repr(column.units))
    units = column.units or given
    advice = Phrase("state ", Argument(option, ...), ", such as 'um'")
    nanometres = length_factor(path, units, f"units of a length for {column.name!r}", advice)
    if not np.isfinite(column.values).all():
        raise UnreadableScan(path, "a place in every row", f"empty cells in column {column.name!r}")
    return measurable(column.values * nanometres, "nm", str(units))
