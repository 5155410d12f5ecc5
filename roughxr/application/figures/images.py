"""Images of a map with their colour bars, in one set of colours for all maps."""

from __future__ import annotations

import numpy as np

from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.numbers import prefixed
from .style import TEXT, printed_label, round_ticks, tidy, unit_formatter

#: Colour map of each field: lightness is monotonic, so that the order is kept in grey print.
COLOURS = {"height": "mako", "pressure": "rocket_r", "displacement": "crest", "gap": "mako_r"}


def image(
    ax, values, extent, name: str, cmap: str, *, limits=(None, None), middle=None, bar: bool = True, extend="neither"
):
    """Draw values along (x, y) as an image, with a colour bar labelled from the schema, and return the bar.

    ``middle`` is the value in the middle of the colours, whose halves then have scales of their own.
    """
    from matplotlib.colors import Normalize, TwoSlopeNorm

    norm = Normalize(*limits) if middle is None else TwoSlopeNorm(middle, *limits)
    style = {"norm": norm, "cmap": colour_map(cmap), "origin": "lower", "aspect": "equal"}
    mappable = ax.imshow(np.asarray(values, dtype=float).T, extent=extent, **style)
    return colorbar(ax, mappable, name, extend) if bar else None


def colorbar(ax, mappable, name: str, extend: str = "neither"):
    """Draw the colour bar of an artist on the right of its Axes, in the unit that suits its range; return the bar."""
    unit, size = prefixed(float(np.abs(mappable.get_clim()).max()), schema.VARIABLES[name].units)
    inset = ax.inset_axes([1.03, 0, 0.045, 1])
    bar = ax.figure.colorbar(mappable, cax=inset, format=unit_formatter(size), extend=extend)
    bar.set_label(printed_label(name, unit), fontsize=TEXT)
    bar.outline.set_linewidth(0.4)
    round_ticks(bar.ax.yaxis)
    tidy(bar.ax)
    return bar


def colour_map(name: str):
    """Return a colour map by name; seaborn registers its own when it is imported."""
    import matplotlib
    import seaborn  # noqa: F401

    return matplotlib.colormaps[name]
