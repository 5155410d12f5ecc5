"""Figures of particles: resisting moments by direction, and the fraction that remains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.particles.force_balance import NO_CONTACT, fluid_of, strength_of_places
from ...mechanics.statistics.sampling import mean_of_places, shares
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.numbers import prefixed
from ...mechanics.vocabulary.refusal import Refusal
from .style import (
    BLACK,
    BLUE,
    COLUMN,
    DASHED,
    GREY,
    SMALL,
    Axes,
    axes,
    label_axes,
    label_axis,
    legend,
    log_ticks,
    printed_label,
    stroke,
    styled,
    ticks_in_unit,
)


@styled
def moment_rose(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the resisting moment of `rolling` over the direction: the median of all places, and their middle half.

    The dashed circle is the median of all places and directions. Where a median is negative, the sphere rolls by
    itself, and the line passes through the centre. ``ax`` is polar.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = scan.contact.rolling(directions=8, subregions=(3, 3))
    >>> roughxr.figures.moment_rose(moments).get_xlabel()
    'resisting moment [nN nm]\\nmedian and middle half of 9 places\\ndashed: median of all directions'
    """
    from matplotlib.ticker import MaxNLocator

    ds = schema.validate(ds, "moments")
    moment = ds["resisting_moment"].transpose("subregion", "direction").dropna("subregion", how="all")
    if not moment.sizes["subregion"]:
        raise Refusal("resisting_moment", "a place in contact", "none")
    rose = _polar_axes(ax)
    quartiles = np.maximum(np.quantile(moment, [0.25, 0.5, 0.75], axis=0), 0.0)
    low, middle, high = np.column_stack([quartiles, quartiles[:, 0]])
    angle = np.r_[ds["direction"].values, ds["direction"].values[0] + 2 * np.pi]
    rose.fill_between(angle, low, high, color=BLUE, alpha=0.25, linewidth=0)
    rose.plot(angle, middle, color=BLUE)
    level = max(float(np.median(moment)), 0.0)
    circle = np.linspace(0, 2 * np.pi, 181)
    rose.plot(circle, np.full(circle.size, level), color=BLACK, linewidth=0.8, linestyle=DASHED)
    rose.set_rlim(0, 1.1 * max(high.max(), level) or 1.0)
    rose.yaxis.set_major_locator(MaxNLocator(4, prune="lower"))
    rose.set_rlabel_position(67.5)
    for label in rose.get_yticklabels():
        label.set_bbox({"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 0.5})
    unit, size = prefixed(rose.get_rmax(), "nN nm")
    ticks_in_unit(rose.yaxis, size)
    places = f"median and middle half of {moment.sizes['subregion']} places\ndashed: median of all directions"
    rose.set_xlabel(f"{printed_label('resisting_moment', unit)}\n{places}")
    return rose


def _polar_axes(ax: Axes | None) -> Any:
    """Return polar Axes in small print, by default those of a new figure."""
    if ax is None:
        from matplotlib import pyplot

        width = (COLUMN, 0.8 * COLUMN)
        ax = pyplot.figure(figsize=width, layout="constrained").add_subplot(projection="polar")
    rose: Any = ax
    rose.tick_params(labelsize=SMALL, pad=0)
    rose.grid(linewidth=0.3)
    rose.spines["polar"].set_linewidth(0.4)
    return rose


@styled
def removed_share(criticals: Mapping[str, xr.Dataset], *, ax: Axes | None = None):
    """Draw the share that a steady load removes from each of several scans, over the wall shear stress or the load."""
    ax = axes(ax)
    least_positive = np.inf
    for order, (name, critical) in enumerate(criticals.items()):
        strength = strength_of_places(critical)
        is_flow = strength.name == "critical_friction_velocity"
        load = fluid_of(critical).density * strength**2 if is_flow else strength
        in_contact = mean_of_places((critical["mode"] != NO_CONTACT).astype(float))
        moved = load.dropna("subregion").sortby(load.dropna("subregion"))
        weights = shares(moved)
        removed = (weights.cumsum() / shares(load).sum() / in_contact).values
        look = stroke(order)
        ax.step(moved, removed, where="post", label=f"{name} ({moved.size})", **look)
        least_positive = min([least_positive, *moved.values[moved.values > 0][:1]])
    if is_flow:
        ax.set_xlabel("wall shear stress [Pa]")
    else:
        label_axis(ax.xaxis, str(strength.name))
    if np.isfinite(least_positive):
        ax.set_xscale("log", nonpositive="clip")  # places that no load holds lie at the left edge
        ax.set_xlim(left=least_positive / 1.5)
        log_ticks(ax.xaxis)
    ax.set(ylim=(0, 1.05), ylabel="share removed")
    return legend(ax)


@styled
def fraction_remaining(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the fraction remaining of `resuspension` over friction velocity, with its band, a line for each time.

    Dotted where drag, torque and lift are not valid.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = scan.contact.rolling(directions=8, subregions=(2, 1))
    >>> fraction = moments.contact.resuspension(friction_velocity=[0.3, 1.0, 3.0, 10.0])
    >>> roughxr.figures.fraction_remaining(fraction).get_ylabel()
    'fraction remaining'
    """
    ax = axes(ax)
    speed = ds["friction_velocity"].values
    valid = ds["in_range"].values if "in_range" in ds else np.ones(speed.size, bool)
    outside = ~valid | np.r_[~valid[1:], False] | np.r_[False, ~valid[:-1]]  # with neighbours: the lines meet
    band: str | None = "95 % interval"
    for order in range(ds.sizes["time"]):
        now = ds.isel(time=order)
        look = stroke(order)
        if "remaining_low" in ds:
            ends = now["remaining_low"], now["remaining_high"]
            ax.fill_between(speed, *ends, color=look["color"], alpha=0.2, linewidth=0, label=band)
            band = None
        ax.plot(speed, np.where(valid, now["remaining"], np.nan), label=f"after {float(now['time']):g} s", **look)
        beyond = "drag formulas not valid" if outside.any() and order == ds.sizes["time"] - 1 else None
        ax.plot(speed, np.where(outside, now["remaining"], np.nan), color=look["color"], linestyle=":", label=beyond)
    if speed.max() > 20 * speed[speed > 0].min(initial=np.inf):
        ax.set_xscale("log")
        log_ticks(ax.xaxis)
    ax.set_ylim(0, 1.05)
    ax.axhline(0.5, color=GREY, linewidth=0.5, zorder=0)
    return legend(label_axes(ax, "friction_velocity", "remaining"))
