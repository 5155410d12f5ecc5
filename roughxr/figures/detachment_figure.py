"""Figures of detachment: the resisting moments of places by direction, and the fraction of particles that remain."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..particles.force_balance import MODES, NEITHER, NO_CONTACT, critical_load, expect_moments
from ..statistics.sampling import shares
from ..vocabulary import schema
from ..vocabulary.numbers import number
from .maps import draw_places
from .rose import dashed_circle, polar
from .style import BLUE, GREEN, GREY, ORANGE, SMALL, Axes, axes, label_axes, legend, log_ticks, stroke, styled

#: Colours of the modes; light where there is none.
_MODES = dict(zip((*MODES, NEITHER, NO_CONTACT), (BLUE, ORANGE, GREEN, "#f2f2f2", "#c8c8c8")))

#: Largest number of places at which each is marked by its mode's first letter, for print in grey.
_MOST_LETTERS = 150


@styled
def moment_rose(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the resisting moment over the direction of rolling: the median place, and half of all places around it.

    Parameters
    ----------
    ds : Dataset
        Result of `rolling`.
    ax : polar Axes, optional

    Returns
    -------
    Axes
        The dashed circle is the median of all places and directions. Where a median is negative, the place rolls off
        by itself, and the line passes through the centre.

    Raises
    ------
    ValueError
        If ``ds`` holds no resisting moments of places in contact, or the axes given are not polar.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> moment = (("subregion", "direction"), [[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]])
    >>> ds = xr.Dataset({"resisting_moment": moment}, {"direction": [0.0, 2.0, 4.0]})
    >>> moment_rose(ds, ax=Figure().add_subplot(projection="polar")).name
    'polar'
    """
    expect_moments(ds)
    moment = ds["resisting_moment"].transpose("subregion", "direction").dropna("subregion", how="all")
    if not moment.sizes["subregion"]:
        raise ValueError("resisting_moment: expected a place in contact, found none")
    rose = polar(ax)
    low, middle, high = (np.maximum(np.quantile(moment, q, axis=0), 0.0) for q in (0.25, 0.5, 0.75))
    angle = np.r_[ds["direction"].values, ds["direction"].values[0] + 2 * np.pi]
    rose.fill_between(angle, *(np.r_[end, end[0]] for end in (low, high)), color=BLUE, alpha=0.25, linewidth=0)
    rose.plot(angle, np.r_[middle, middle[0]], color=BLUE)
    level = max(float(np.median(moment)), 0.0)
    dashed_circle(rose, level)
    rose.set_rlim(0, 1.1 * max(high.max(), level))
    rose.set_rticks([level] if level else [])
    rose.set_yticklabels([])
    words = schema.VARIABLES["resisting_moment"].long_name
    half = f"median and middle half of {moment.sizes['subregion']} places; dashed {number(level, 'nN nm')}"
    rose.set_xlabel(f"{words} from x (0°) towards y,\n{half}")
    return rose


@styled
def mode_map(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw how the sphere comes off at each place: it rolls, slides or lifts, whichever needs the least load.

    Parameters
    ----------
    ds : Dataset
        Result of `critical_load`, for one load.
    ax : Axes, optional

    Returns
    -------
    Axes
        Tiles where the centres lie on a grid, else points; the legend counts the places. Each of up to 150
        tiles bears its mode's first letter.

    Raises
    ------
    ValueError
        If ``ds`` holds no modes along ``subregion`` alone.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> modes = {"mode": ("subregion", ["roll", "slide", "roll", "roll"])}
    >>> centres = {"subregion_x": ("subregion", [0.0, 0, 1, 1]), "subregion_y": ("subregion", [0.0, 1, 0, 1])}
    >>> ax = mode_map(xr.Dataset(modes, coords=centres), ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['roll (3)', 'slide (1)']
    """
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import ListedColormap

    if "mode" not in ds or ds["mode"].dims != ("subregion",):
        raise ValueError("expected mode along subregion only, from ds.contact.critical_load(), found none")
    ax, mode = axes(ax, aspect=0.95), ds["mode"].values.astype(str)
    counts = {word: int((mode == word).sum()) for word in _MODES}
    order = np.array([list(_MODES).index(word) for word in mode], float)
    colours = {"cmap": ListedColormap(list(_MODES.values())), "vmin": -0.5, "vmax": len(_MODES) - 0.5}
    drawn = draw_places(ax, ds, order, **colours)
    if mode.size <= _MOST_LETTERS and isinstance(drawn, QuadMesh):
        for x, y, word in zip(ds["subregion_x"].values, ds["subregion_y"].values, mode):
            ax.text(x, y, word[0] if word in MODES else "", ha="center", va="center", color="white", fontsize=SMALL)
    shown = [word for word, count in counts.items() if count]
    keys = [
        ax.scatter([], [], color=_MODES[word], marker="s", s=22, label=f"{word} ({counts[word]})") for word in shown
    ]
    ax.legend(handles=keys, loc="lower left", bbox_to_anchor=(0, 1), ncols=len(shown), handletextpad=0.1)
    return label_axes(ax, "subregion_x", "subregion_y")


@styled
def fraction_remaining(ds: xr.Dataset, *, measured: dict[str, tuple[Any, Any]] | None = None, ax: Axes | None = None):
    """Draw the fraction of particles left over friction velocity, with its band, a line for each time.

    Parameters
    ----------
    ds : Dataset
        Result of `resuspension`.
    measured : dict of str to (array, array), optional
        Measured friction velocities (m/s) and fractions, by their labels in the legend.
    ax : Axes, optional

    Returns
    -------
    Axes
        Dotted where drag, torque and lift are not valid.

    Raises
    ------
    ValueError
        If ``ds`` holds no fractions remaining along friction_velocity and time.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> left = (("friction_velocity", "time"), [[1.0], [0.2]])
    >>> ds = xr.Dataset({"remaining": left}, {"friction_velocity": [0.1, 1.0], "time": [1]})
    >>> fraction_remaining(ds, ax=Figure().subplots()).get_xlabel()
    'friction velocity [m/s]'
    """
    if "remaining" not in ds or set(ds["remaining"].dims) != {"friction_velocity", "time"}:
        raise ValueError(
            "expected remaining along friction_velocity and time, from ds.contact.resuspension(), found none"
        )
    ax = axes(ax)
    speed = ds["friction_velocity"].values
    known = ds["in_range"].values if "in_range" in ds else np.ones(speed.size, bool)
    for order in range(ds.sizes["time"]):
        now, look = ds.isel(time=order), stroke(order)
        if "remaining_low" in ds:
            ends = now["remaining_low"], now["remaining_high"]
            ax.fill_between(speed, *ends, color=look["color"], alpha=0.2, linewidth=0)
        ax.plot(speed, np.where(known, now["remaining"], np.nan), label=f"{float(now['time']):g} s", **look)
        ax.plot(speed, np.where(_beside(~known), now["remaining"], np.nan), color=look["color"], linestyle=":")
    for words, (velocities, fractions) in (measured or {}).items():
        ax.plot(velocities, fractions, linestyle="none", marker="o", markersize=2.5, label=words)
    if speed[speed > 0].size and speed.max() > 20 * speed[speed > 0].min():
        ax.set_xscale("log")
    ax.set_ylim(0, 1.05)
    ax.axhline(0.5, color=GREY, linewidth=0.5, zorder=0)
    return legend(label_axes(ax, "friction_velocity", "remaining"), loc="best")


@styled
def landed_and_at_rest(landed: xr.Dataset, rested: xr.Dataset):
    """Draw how particles that rolled to rest differ from the same where they landed.

    Parameters
    ----------
    landed, rested : Dataset
        Results of `rolling`: at a grid of places, and at those of `resting`.

    Returns
    -------
    array of Axes
        Shares of particles up to a pull-off force, a number of contacts, and a critical friction velocity.

    Raises
    ------
    ValueError
        If one of them is no result of `rolling`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> held = roughxr.rolling(scan, directions=8, subregions=(2, 2))
    >>> landed_and_at_rest(held, held)[1].get_xlabel()
    'asperities in contact'
    """
    from matplotlib import pyplot

    panels = pyplot.subplots(1, 3, figsize=(7.0, 2.3), layout="constrained", sharey=True)[1]
    for ds, words, order in ((landed, "where they landed", 1), (rested, "at rest", 0)):
        share = shares(ds).values
        drawn = ds.merge(critical_load(ds), compat="override", combine_attrs="override")
        for ax, name in zip(panels, ("pull_off_force", "contacts", "critical_friction_velocity")):
            values = drawn[name].values.astype(float)
            rank = np.argsort(values)
            part = np.cumsum([0.0, *share[rank]]) / share.sum()
            ax.step([values[rank[0]], *values[rank]], part, where="post", label=words, **stroke(order))
            if name != "contacts":
                ax.set_xscale("log")
                log_ticks(ax.xaxis)
            label_axes(ax, name, "cdf")
    panels[0].set_ylabel("share of particles")
    for ax in panels[1:]:
        ax.set_ylabel("")
    legend(panels[1], loc="best")
    return panels


def _beside(flags: np.ndarray) -> np.ndarray:
    """Return the flags, set at their neighbours too, so that lines of both kinds meet."""
    out = flags.copy()
    out[:-1] |= flags[1:]
    return out
