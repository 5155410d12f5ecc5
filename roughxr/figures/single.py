"""One asperity in dimensionless units: the curves of Hertz and JKR, stable and unstable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..kernels.asperity.laws import ASPERITY_LAWS, Curve, curve
from ..vocabulary import schema
from .style import BLACK, GREY, SMALL, Axes, axes, legend, stroke, styled

#: Labels of the laws in a legend.
NAMES = {
    "hertz": "Hertz",
    "published": "JKR",
    "self_similar": "JKR",
    "energy": "JKR, least energy",
}


class _Axis(NamedTuple):
    name: str  # in the schema
    symbol: str


_AXES = {
    "delta": _Axis("delta", r"$\delta/\delta_c$"),
    "P": _Axis("force", r"$P/P_c$"),
    "a": _Axis("semi_axis_a", r"$a/a_c$"),
}

#: Offsets, in points, of the labels of pull-off and end of branch, which avoid all curves.
_LABEL_OFFSETS = {
    ("delta", "a"): ((-14, 10), (10, 2)),
    ("P", "a"): ((10, 0), (10, -4)),
    ("delta", "P"): ((44, -3), (10, 12)),
}


@styled
def asperity_curve(
    x: str = "delta",
    y: str = "P",
    *,
    laws: Sequence[str] = ("hertz", "self_similar"),
    ratio: float = 1.0,
    largest: float = 1.9,
    ax: Axes | None = None,
):
    """Draw two of displacement, load and contact radius of one asperity against each other.

    All are in units of JKR's own scales a_c, δ_c and P_c, so that one curve is valid for every sphere and,
    for laws that keep Hertz's ellipse, every paraboloid. Solid branches are stable while the quantity on the
    x axis is prescribed (the displacement unless x is the load), dashed ones are not.

    Parameters
    ----------
    x, y : {"delta", "P", "a"}
    laws : sequence of str
        Names from ``kernels.asperity.laws.ASPERITY_LAWS``; the pull-off and jump-on of the last one are marked.
    ratio : float
        B/A of the paraboloid, which matters only for "energy".
    largest : float
        The longest semi-axis drawn, a/a_c.
    ax : Axes, optional

    Returns
    -------
    Axes
        Both axes have unit 1.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ax = asperity_curve("delta", "a", ax=Figure().subplots())
    """
    for name in (x, y):
        schema.one_of(name, _AXES, "x and y")
    ax = axes(ax, aspect=0.8)
    ax.axhline(0, color="#cccccc", linewidth=0.5, zorder=0)
    ax.axvline(0, color="#cccccc", linewidth=0.5, zorder=0)
    for order, law in enumerate(laws):
        schema.one_of(law, ASPERITY_LAWS, "laws")
        states = curve(law, np.linspace(1e-4, 2 * largest, 2000), ratio)
        _branches(ax, states, _stable(states, x), x, y, NAMES[law], order, hertz=law == "hertz")
    _cut(ax, states, x, y, largest)
    if laws[-1] != "hertz":
        _mark(ax, states, x, y)
    ax.set(xlabel=_words(x), ylabel=_words(y))
    return legend(ax, loc="upper left") if y == "P" else legend(ax, loc="lower right", bbox_to_anchor=(1, 0.11))


def _cut(ax, states: Curve, x: str, y: str, largest: float):
    """Cut all curves at one edge, where the last one's semi-axis is the largest; no radius is negative."""
    shown = states.a <= largest
    across, up = getattr(states, x)[shown], getattr(states, y)[shown]
    left = min(float(across.min()), 0.0)
    ax.set_xlim(left - 0.15 * (across.max() - left) * (left < 0), across.max())
    low = 0.0 if y == "a" else float(up.min()) - 0.1 * float(np.ptp(up))
    ax.set_ylim(low, up.max())


def _words(axis: str) -> str:
    """Return the schema's name and the symbol of a dimensionless quantity."""
    shown = _AXES[axis]
    return f"{schema.VARIABLES[shown.name].long_name} {shown.symbol}"


def _stable(states: Curve, x: str) -> np.ndarray:
    """Return where the branch is stable: at prescribed load, beyond the largest pull; else as the kernel says."""
    if x != "P" or not (states.P < 0).any():
        return states.stable
    return np.arange(states.P.size) >= states.P.argmin()


def _branches(ax, states: Curve, stable: np.ndarray, x: str, y: str, name: str, order: int, hertz: bool):
    across, up = getattr(states, x), getattr(states, y)
    look = stroke(1 - order if order < 2 else order)
    width = 1.7 if order < 2 else 0.9
    if hertz:
        ax.plot(across, up, label=name, **look)
        return
    first = int(np.argmax(stable))
    color = look["color"]
    ax.plot(across[first:], up[first:], color=color, linestyle="-", linewidth=width, label=f"{name}, stable")
    if first:
        dashes = {"linestyle": (0, (2, 1.2)), "linewidth": 1.0}
        ax.plot(across[: first + 1], up[: first + 1], color=color, label=f"{name}, unstable", **dashes)


def _mark(ax, states: Curve, x: str, y: str):
    """Mark where a prescribed load detaches the asperity and, except on an axis of loads, the end of the branch."""
    across, up = getattr(states, x), getattr(states, y)
    pull = int(states.P.argmin())
    end = int(np.argmax(states.stable))
    beside = _LABEL_OFFSETS.get((x, y), ((12, 12), (12, -12)))
    points = ((pull, "D", "pull-off"), (end, "s", "jump-on, let-go"))
    for (k, marker, words), offset in zip(points[: 1 if x == "P" else 2], beside):
        ax.plot(across[k], up[k], marker, color=BLACK, markersize=3.6, zorder=5)
        line = {"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "shrinkA": 1, "shrinkB": 2.5}
        style = {"fontsize": SMALL, "ha": "right" if offset[0] < 0 else "left", "va": "center"}
        words += f"\n({across[k]:.3g}, {up[k]:.3g})".replace("-", "−")
        ax.annotate(words, (across[k], up[k]), offset, textcoords="offset points", arrowprops=line, **style)
