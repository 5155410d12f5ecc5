"""A figure as a file."""

from __future__ import annotations

from pathlib import Path

from ..archive import whole


def save(figure, path, *, dpi: int = 300) -> Path:
    """Write a figure to a file, which appears only once it is complete.

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
    with whole(path) as temporary:
        (getattr(figure, "figure", None) or figure).savefig(temporary, dpi=dpi)
    return Path(path)
