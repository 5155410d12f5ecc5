"""Images of a map with their colour bars, in one set of colours for all maps."""

from __future__ import annotations

import numpy as np

from ..vocabulary import schema
from ..vocabulary.numbers import prefixed
from .style import TEXT, in_unit, in_words, round_ticks, tidy

#: Colour map of each field: lightness is monotonic, so that the order is kept in grey print.
COLOURS = {"height": "mako", "pressure": "rocket_r", "displacement": "crest", "gap": "mako_r"}


def image(ax, values, extent, name: str, cmap: str, *, limits=(None, None), bar: bool = True):
    """Draw values along (x, y) as an image, with a colour bar in the schema's words."""
    style = {"vmin": limits[0], "vmax": limits[1], "cmap": colour_map(cmap), "origin": "lower", "aspect": "equal"}
    drawn = ax.imshow(np.asarray(values, dtype=float).T, extent=extent, **style)
    if bar:
        colorbar(ax, drawn, name, "neither" if limits[0] is None else "both")


def colorbar(ax, drawn, name: str, extend: str = "neither"):
    """Draw the colour bar of an artist on the right of its Axes, in the prefix that suits its range."""
    unit, size = prefixed(float(np.abs(drawn.get_clim()).max()), schema.VARIABLES[name].units)
    inset = ax.inset_axes([1.03, 0, 0.045, 1])
    bar = ax.figure.colorbar(drawn, cax=inset, format=in_unit(size), extend=extend)
    bar.set_label(in_words(name, unit), fontsize=TEXT)
    bar.outline.set_linewidth(0.4)
    round_ticks(bar.ax.yaxis)
    tidy(bar.ax)


def colour_map(name: str):
    """Return a colour map by name; seaborn registers its own when it is imported."""
    import matplotlib
    import seaborn  # noqa: F401

    return matplotlib.colormaps[name]
