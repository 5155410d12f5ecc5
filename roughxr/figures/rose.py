"""A rose of directions: in which direction asperities are elongated."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from .style import BLACK, BLUE, COLUMN, SMALL, Axes, styled

#: Angles of a circle.
_AROUND = np.linspace(0, 2 * np.pi, 181)


@styled
def orientation_rose(catalogue: xr.Dataset, *, bins: int = 18, ax: Axes | None = None):
    """Draw the orientation of the asperities' flattest direction as a polar histogram.

    A direction has no head or tail and is drawn at both ends. The area of a petal, not its length, is its share; the
    dashed circle is that of directions without preference, with a ring of two standard deviations of chance around it.

    Parameters
    ----------
    catalogue : Dataset
        Asperities; saddles are left out.
    bins : int
        Petals over half a turn.
    ax : polar Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If it is no catalogue of asperities, or the axes given are not polar.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> catalogue = xr.Dataset({name: ("asperity", [0.1, 0.2, 0.4]) for name in (
    ...     "height", "curvature_min", "curvature_max", "orientation")})
    >>> ax = orientation_rose(catalogue, ax=Figure().add_subplot(projection="polar"))
    >>> ax.name
    'polar'
    """
    catalogue = schema.validate(catalogue, "asperities")
    rose = polar(ax)
    angles = catalogue["orientation"].where(catalogue["curvature_min"] > 0).dropna("asperity").values
    counts, edges = np.histogram(angles, np.linspace(-np.pi / 2, np.pi / 2, bins + 1))
    share = counts * bins / max(counts.sum(), 1)  # 1 without preference
    middle = np.concatenate([edges[:-1], edges[:-1] + np.pi]) + np.pi / (2 * bins)
    style: dict[str, Any] = {"color": BLUE, "alpha": 0.45, "edgecolor": BLUE, "linewidth": 0.5}
    rose.bar(middle, np.tile(np.sqrt(share), 2), width=np.pi / bins, **style)
    _chance(rose, bins, counts.sum())
    rose.set_rlim(0, 1.15 * np.sqrt(max(share.max(initial=1.0), 1.0)))
    rose.set_rticks([])
    rose.set_thetagrids(range(0, 360, 45), [f"{(a + 90) % 180 - 90}°".replace("-", "−") for a in range(0, 360, 45)])
    rose.set_xlabel(f"{schema.VARIABLES['orientation'].long_name}\n({angles.size} asperities)")
    return rose


def _chance(ax, bins: int, total: int):
    """Draw the circle of directions without preference, and the ring of its random deviations."""
    dashed_circle(ax, 1.0)
    spread = 2 * np.sqrt(bins / max(total, 1))
    low, high = np.sqrt(max(1 - spread, 0)), np.sqrt(1 + spread)
    ax.fill_between(_AROUND, low, high, color=BLACK, alpha=0.15, linewidth=0)


def dashed_circle(ax, radius: float) -> None:
    """Draw what all directions would have without preference."""
    ax.plot(_AROUND, np.full(_AROUND.size, radius), color=BLACK, linewidth=0.8, linestyle=(0, (4, 2)))


def polar(ax: Any) -> Any:
    """Return the given polar axes, or new ones, with thin lines and small labels."""
    if ax is None:
        from matplotlib import pyplot

        size = (COLUMN, 0.8 * COLUMN)
        ax = pyplot.figure(figsize=size, layout="constrained").add_subplot(projection="polar")
    if ax.name != "polar":
        raise ValueError(f"ax: expected polar Axes, found {ax.name}; make them with projection='polar'")
    ax.tick_params(labelsize=SMALL, pad=0)
    ax.grid(linewidth=0.3)
    ax.spines["polar"].set_linewidth(0.4)
    return ax
