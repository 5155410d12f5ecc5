"""The style of all figures: size, fonts, colours for colour-blind readers and grey print, and labels with units.

Data are drawn in the schema's units (nm, nN, GPa), so that several results can share the Axes; only the labels of
ticks and axes have prefixes (µm, µN).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import xarray as xr

from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.calls import check_call
from ...mechanics.vocabulary.numbers import SUPERSCRIPTS, format_number, prefixed
from ...mechanics.vocabulary.refusal import Refusal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any  # matplotlib is imported at the first figure

#: Several Axes, as matplotlib's ``subplots`` returns them.
Panels: TypeAlias = Sequence[Axes] | np.ndarray

#: Width of one column, inches.
COLUMN = 85 / 25.4

#: Width of two columns, inches.
PAGE = 175 / 25.4

#: Font size of tick labels and small print, points.
SMALL = 6.5

#: Font size of axis labels and legends, points.
TEXT = 7.0

#: Font size of titles, points.
TITLE = 8.0

#: matplotlib's settings while a figure is drawn; the user's are restored afterwards.
SETTINGS: dict[Any, Any] = {
    "font.size": TEXT,
    "axes.labelsize": TEXT,
    "axes.titlesize": TEXT,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.0,
    "boxplot.medianprops.color": "#222222",
    "boxplot.meanprops.markerfacecolor": "#222222",
    "boxplot.meanprops.markeredgecolor": "#222222",
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "figure.dpi": 150,
    "figure.facecolor": "white",
    "figure.titlesize": TITLE,
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
}

#: Colours of seaborn's "colorblind" palette, then black and grey.
BLUE, ORANGE, GREEN, VERMILION, PURPLE = "#0173b2", "#de8f05", "#029e73", "#d55e00", "#cc78bc"
BLACK, GREY = "#222222", "#8a8a8a"

#: Line styles in order of use: distinct by dashes as well as by colour.
STROKES = (
    {"color": BLUE, "linestyle": "-"},
    {"color": ORANGE, "linestyle": (0, (5, 1.6))},
    {"color": GREEN, "linestyle": (0, (5, 1.4, 1, 1.4))},
    {"color": PURPLE, "linestyle": (0, (1, 1.1))},
    {"color": BLACK, "linestyle": (0, (7, 1.5, 1, 1.5, 1, 1.5))},
)

#: Height of a row above the Axes, for a mean with its interval, over their height.
ROW = 0.05

#: Dashes (points) of lines that mark a value.
DASHED = (0, (4, 2))


def ticks_in_unit(axis, size: float) -> None:
    """Print the ticks of an axis in a unit of this size; call it after the last change of the axis' scale."""
    axis.set_major_formatter(unit_formatter(size))
    axis.set_minor_formatter("")


def unit_formatter(size: float):
    """Return a formatter of ticks in a unit of this size."""
    from matplotlib.ticker import FuncFormatter

    return FuncFormatter(lambda value, _: format_number(value / size, digits=6))


def log_ticks(axis) -> None:
    """Put more ticks on a logarithmic axis of a narrower range; label the axis afterwards."""
    from matplotlib.ticker import LogLocator

    low, high = axis.get_view_interval()
    axis.set_major_locator(
        LogLocator(subs=(1, 1.5, 2, 3, 5, 7) if high < 5 * low else (1, 2, 5) if high < 50 * low else (1,))
    )


def styled(function: Callable) -> Callable:
    """Return a function that takes Datasets in any units, draws in this style, and restores the caller's rcParams."""

    @functools.wraps(function)
    def draw(*arguments: Any, **options: Any):
        import matplotlib

        check_call(function, arguments, options, function.__name__)
        options = {name: _in_table_units(value) for name, value in options.items()}
        settings: Any = matplotlib.rcParams  # rc_context would also reset a notebook's backend
        before = {name: settings[name] for name in SETTINGS}
        settings.update(SETTINGS)
        try:
            drawn = function(*map(_in_table_units, arguments), **options)
            figure = drawn if hasattr(drawn, "draw_without_rendering") else np.ravel(drawn)[0].figure
            layout = figure.get_layout_engine() if options.get("ax") is None else None
            # constrained layout fits maps of equal scale only in a second pass
            if layout and any(ax.get_aspect() != "auto" for ax in figure.axes):
                layout.execute(figure)
            return drawn
        finally:
            settings.update(before)

    return draw


def _in_table_units(value: Any) -> Any:
    return schema.in_package_units(value) if isinstance(value, (xr.Dataset, xr.DataArray)) else value


def write_png(figure: Any, target: Any, dpi: int) -> None:
    """Write a figure as PNG: drawn once, where `savefig` draws it once more to find its layout."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(dpi)
    FigureCanvasAgg(figure).print_png(target)


def stroke(order: int) -> dict[str, Any]:
    """Return the colour and dashes of the ``order``-th line of a figure."""
    return dict(STROKES[order % len(STROKES)])


def tidy(ax):
    """Return the Axes with small ticks, set explicitly because ticks are made after the settings are restored."""
    ax.tick_params(which="major", labelsize=SMALL, width=0.6, length=2.5, pad=2)
    ax.tick_params(which="minor", width=0.4, length=1.5)
    return ax


def axes(ax=None, *, aspect: float = 0.72):
    """Return ``ax``, or the Axes of a new pyplot figure of one column's width."""
    return ax if ax is not None else panels(None, 1, 1, aspect=aspect)[0]


def panels(ax: Any, rows: int, columns: int, *, aspect: float, width: float = COLUMN):
    """Return the given sequence of Axes, or those of a new pyplot figure of a width (inches), as a flat array."""
    if ax is not None:
        flat_axes = np.asarray(ax, dtype=object).ravel()
        if flat_axes.size != rows * columns:
            raise Refusal("ax", f"{rows * columns} Axes", flat_axes.size)
        return flat_axes
    from matplotlib import pyplot

    _, made = pyplot.subplots(rows, columns, figsize=(width, aspect * width), layout="constrained", squeeze=False)
    return np.array([tidy(panel) for panel in made.flat])


def printed_label(name: str, unit: str = "") -> str:
    """Return the schema's label of a variable with its unit, powers as superscripts."""
    label = f"{schema.VARIABLES[name].long_name} [{unit}]" if unit not in ("1", "") else schema.axis_label(name)
    return re.sub(r"\^(-?\d+)", lambda power: power.group(1).translate(SUPERSCRIPTS), label)


def label_axis(axis, name: str, largest: float | None = None) -> tuple[str, float]:
    """Label a matplotlib axis from the schema, in the unit that suits a value; return that unit and its size.

    The value is the largest of the axis, or another one that matters, such as the tension on a logarithmic axis.
    Call it after the last change of the axis' scale and limits: a change of scale would replace the ticks' unit alone.
    """
    if name not in schema.VARIABLES:
        axis.set_label_text(name)
        return "1", 1.0
    suited = np.abs(axis.get_view_interval()).max() if largest is None else largest
    unit, size = prefixed(float(suited), schema.VARIABLES[name].units)
    axis.set_label_text(printed_label(name, unit))
    round_ticks(axis)
    ticks_in_unit(axis, size)
    return unit, size


def round_ticks(axis):
    """Put the ticks of a linear axis at steps of one, two or five."""
    from matplotlib.ticker import MaxNLocator

    locator = axis.get_major_locator()
    if isinstance(locator, MaxNLocator):
        locator.set_params(steps=[1, 2, 5, 10])


def label_axes(ax, x: str, y: str):
    """Return the Axes with both axes labelled from the schema."""
    label_axis(ax.xaxis, x)
    label_axis(ax.yaxis, y)
    return ax


def legend(ax, *, rows: float = 0.0, **options: Any):
    """Return the Axes with a legend of its labelled artists above them, where it hides no data.

    ``rows`` are those of `distributions.draw_mean` below the legend.
    """
    labels = ax.get_legend_handles_labels()[1]
    if labels:
        # largest number of characters of a label beside another one
        columns = 2 if max(map(len, labels)) < 26 else 1
        place = {"loc": "lower left", "bbox_to_anchor": (0, 1 + ROW * rows), "borderpad": 0, "columnspacing": 1.0}
        ax.legend(ncols=columns, **place, **options)
        if not ax.child_axes:  # matplotlib moves a title above these, but not above a legend
            room = ax.inset_axes((0, 1, 1, 0))
            room.set_visible(False)
            room.set_axes_locator(functools.partial(_legend_extent, ax))
    return ax


def _legend_extent(ax, _: object, renderer: Any):
    """Return the extent of a legend, of its Axes where it is removed, over the figure."""
    drawn = ax.get_legend()
    extent = ax.bbox if drawn is None else drawn.get_window_extent(renderer)
    return extent.transformed(ax.figure.transSubfigure.inverted())
