"""A figure as a sheet of a report: a title that says what is seen, panels, and a table of numbers."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..archive import whole
from ..vocabulary.numbers import number
from .style import COLUMN, GREY, SMALL, TITLE, laid_out, tidy

#: Number of letters on one line of a title at one column's width, and of small print.
_TITLE_LETTERS, _NOTE_LETTERS = 50, 66

#: Zlib's level for pixels: a quarter of the default's time, and files a twentieth larger.
_COMPRESSION = 2

#: Height of one line of the table, inches.
_LINE = 0.145


def sheet(
    title: str,
    *,
    shape: tuple[int, int] = (1, 1),
    aspect: float = 0.72,
    rows: Sequence[tuple[str, ...]] = (),
    note: str = "",
    **options,
):
    """Return a Figure and its panels: title above, panels of ``aspect`` × one column, a table below."""
    from matplotlib.figure import Figure

    notes = textwrap.wrap(note, _NOTE_LETTERS)
    below = _LINE * (len(rows) + 1.6) * bool(rows) + 0.85 * _LINE * len(notes) + 0.04
    lines = textwrap.wrap(title, _TITLE_LETTERS)
    above, middle = 0.155 * len(lines) + 0.08, aspect * COLUMN
    figure = Figure(figsize=(COLUMN, above + middle + below), layout="constrained")
    figure.suptitle("\n".join(lines), x=0.015, ha="left", fontsize=TITLE, fontweight="bold", linespacing=1.25)
    parts: Any = figure.subfigures(2, 1, height_ratios=[middle, below], hspace=0)
    upper, lower = parts
    axes = upper.subplots(*shape, squeeze=False, **options).ravel()
    for ax in axes:
        tidy(ax)
    _table(lower, rows, notes, below)
    return figure, axes


def _table(figure, rows, notes: list[str], height: float):
    ax = figure.add_axes((0.015, 0, 0.97, 1))
    ax.set(xlim=(0, 1), ylim=(height / _LINE, 0))
    ax.axis("off")
    line = 0.7
    if rows:
        if len(rows[0]) > 2:
            _row(ax, line, "", "here", "paper", color="#555555", style="italic")
        ax.axhline(line + 0.5, color=GREY, linewidth=0.5)
        for line, row in enumerate(rows, start=2):
            _row(ax, line - 0.2, *row)
        line = len(rows) + 1.9
    for k, text in enumerate(notes):
        ax.text(0, line + 0.85 * k, text, fontsize=SMALL - 0.7, color="#555555", va="center")


def _row(ax, line: float, quantity: str, here: str, paper: str | None = None, **style):
    ax.text(0.0, line, quantity, ha="left", va="center", fontsize=SMALL, **style)
    ax.text(1.0 if paper is None else 0.74, line, here, ha="right", va="center", fontsize=SMALL, **style)
    if paper is not None:
        ax.text(1.0, line, paper, ha="right", va="center", fontsize=SMALL, **style)


def save(figure, path, *, dpi: int = 300) -> Path:
    """Write a figure to a file.

    Parameters
    ----------
    figure : Figure or Axes
        Axes stand for their figure.
    path : path
        Its suffix gives the format: ``.png``, ``.pdf``, ``.svg``.
    dpi : int
        Dots per inch of a pixel format.

    Returns
    -------
    Path

    Examples
    --------
    >>> import tempfile
    >>> from matplotlib.figure import Figure
    >>> save(Figure(), Path(tempfile.mkdtemp()) / "empty.png", dpi=50).name
    'empty.png'
    """
    sheet = getattr(figure, "figure", None) or figure
    with whole(path) as temporary:
        if temporary.suffix == ".png":
            as_png(sheet, temporary, dpi)
        else:
            sheet.savefig(temporary, dpi=dpi)
    return Path(path)


def as_png(figure, file, dpi: int) -> None:
    """Write a figure's pixels; matplotlib's savefig by itself goes through a figure twice, once to lay it out."""
    with laid_out(figure, dpi):
        figure.savefig(file, format="png", dpi=dpi, pil_kwargs={"compress_level": _COMPRESSION})


def mean_and_spread(values, unit: str, *, size: float = 1.0, digits: int = 2) -> str:
    """Return mean ± standard deviation (n − 1) of the finite values, divided by ``size``, with one unit."""
    finite = np.asarray(values, dtype=float) / size
    finite = finite[np.isfinite(finite)]
    if finite.size == 0:
        return "–"
    if finite.size == 1:
        return number(finite[0], unit)
    return f"{finite.mean():.{digits}f} ± {finite.std(ddof=1):.{digits}f} {unit}".strip().replace("-", "−")
