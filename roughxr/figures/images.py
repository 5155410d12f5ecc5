"""Images of a map with their colour bars, in one set of colours for all maps."""

from __future__ import annotations

import numpy as np

from ..vocabulary import schema
from .style import SMALL, TEXT, display_unit, in_words, round_ticks, tidy

#: Colour map of each field: lightness is monotonic, so that the order is kept in grey print.
COLOURS = {"height": "mako", "pressure": "rocket_r", "displacement": "crest", "gap": "mako_r"}


def image(ax, values, extent, name: str, cmap: str, *, limits=None, bar: bool = True, location="right"):
    """Draw values along (x, y) as an image, with a colour bar in the schema's words."""
    low, high = (None, None) if limits is None else limits
    style = {"vmin": low, "vmax": high, "cmap": colour_map(cmap), "origin": "lower", "aspect": "equal"}
    drawn = ax.imshow(np.asarray(values, dtype=float).T, extent=extent, **style)
    if bar:
        colorbar(ax, drawn, name, location, extend="neither" if limits is None else _beyond(values, *limits))


def _beyond(values, low: float, high: float) -> str:
    """Return at which ends of a colour bar values are cut off."""
    below, above = float(np.nanmin(values)) < low, float(np.nanmax(values)) > high
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")


def colorbar(ax, drawn, name: str, location: str = "right", extend: str = "neither"):
    """Draw the colour bar of an artist beside its Axes, in a unit that suits its range."""
    unit = display_unit(schema.VARIABLES[name].units, float(np.abs(drawn.get_clim()).max()))
    beside = ax.inset_axes([1.03, 0, 0.045, 1] if location == "right" else [0, 1.03, 1, 0.045])
    style = {"location": location, "format": unit.formatter(), "extend": extend}
    bar = ax.figure.colorbar(drawn, cax=beside, **style)
    bar.set_label(in_words(name, unit), fontsize=SMALL if location == "top" else TEXT)
    bar.outline.set_linewidth(0.4)
    round_ticks(bar.ax.xaxis if location == "top" else bar.ax.yaxis)
    tidy(bar.ax)


def colour_map(name: str):
    """Return a colour map by name; seaborn registers its own when it is imported."""
    import matplotlib
    import seaborn  # noqa: F401

    return matplotlib.colormaps[name]
