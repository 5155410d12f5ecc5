"""Force against displacement: many places, their mean, one place, and the smooth sphere beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from .. import statistics
from ..contact import reference
from ..vocabulary import schema
from .style import BLACK, BLUE, GREY, ORANGE, Axes, Panels, axes, label_axes, label_axis, legend, panels, stroke, styled


@styled
def force_fan(
    ds: xr.Dataset,
    *,
    ax: Axes | None = None,
    quantiles: tuple[float, float] = (0.05, 0.25),
    lines: bool = True,
    interval: float | None = 0.95,
    force_limits: tuple[float, float] | None = None,
):
    """Draw the sweep of every subregion, their median, and bands that contain most of them.

    Parameters
    ----------
    ds : Dataset
        A solution.
    ax : Axes, optional
    quantiles : (float, float)
        Lower ends of the outer and the inner band; their upper ends are as far from 1.
    lines : bool
        Draw each subregion.
    interval : float, optional
        Confidence level of the median's interval, by block bootstrap; None for no interval.
    force_limits : (float, float), optional
        Ends of the force axis, nN: pull-off is small compared with the push of deep contact. The
        displacements are then limited to those at which something touches and not every place exceeds these ends. By
        default all forces are shown, and where the pull would be invisible, those beyond it on a logarithmic scale.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the forces do not lie along ``subregion`` and ``delta`` alone.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset(
    ...     {"force": (("subregion", "delta"), [[0.0, 1.0, 4.0], [0.0, 2.0, 5.0]])},
    ...     coords={"delta": [0.0, 1.0, 2.0]},
    ... )
    >>> force_fan(ds, ax=Figure().subplots()).get_ylabel()
    'contact force [nN]'
    """
    ds = _sweep(ds)
    ax = axes(ax)
    delta, force = ds["delta"].values, ds["force"].transpose("delta", "subregion")
    single = ds.sizes["subregion"] == 1
    if lines and not single:
        ax.plot(delta, force.values, color=GREY, linewidth=0.35, alpha=0.6)
        ax.plot([], [], color=GREY, linewidth=0.6, label=f"{ds.sizes['subregion']} places")
    for low, alpha in zip(() if single else quantiles, (0.22, 0.4)):
        band = force.quantile([low, 1 - low], "subregion").values
        words = f"{100 * (1 - 2 * low):.0f} % of them"
        ax.fill_between(delta, *band, color=BLUE, alpha=alpha, linewidth=0, label=words)
    words = f"place {ds['subregion'].item()}" if single else "median"
    ax.plot(delta, force.median("subregion"), color=BLACK, linewidth=1.4, label=words)
    if interval is not None:
        _error_bars(ax, ds, "q50", interval, BLACK, label=f"its {100 * interval:g} % interval")
    if force_limits is not None:
        ax.set_ylim(*force_limits)
        begun = (force != 0).any("subregion").values
        shown = delta[begun & (force.min("subregion") <= force_limits[1]).values]
        if shown.size > 1:
            ax.set_xlim(shown[0] - 0.1 * np.ptp(shown), shown[-1])
    elif (pulls := _pull_unseen(force)) > 0:
        ax.set_yscale("symlog", linthresh=pulls, linscale=1.0)
        ax.set_yticks([tick for tick in ax.get_yticks() if tick == 0 or abs(tick) >= pulls])  # nearer to 0 they overlap
    _zero(ax, force)
    ground = {"frameon": True, "framealpha": 0.85, "edgecolor": "none"}  # curves of single places cross it
    return legend(label_axes(ax, "delta", "force"), loc="upper left", **ground)


#: A pull that is a smaller part of the axis is not visible.
_LEAST_VISIBLE = 0.05


def _pull_unseen(force: xr.DataArray) -> float:
    """Return the median place's pull-off force (nN) where it is too small to be visible beside the push, else 0."""
    pull = float(-force.min("delta").median())
    return pull if 0 < pull < _LEAST_VISIBLE * float(force.max()) else 0.0


@styled
def mean_force(
    solutions: xr.Dataset | Mapping[str, xr.Dataset],
    *,
    ax: Axes | None = None,
    where: ArrayLike | None = None,
    band: float | None = 0.16,
    interval: float | None = 0.95,
):
    """Draw the mean force over subregions, of one solution or of several side by side.

    Parameters
    ----------
    solutions : Dataset or mapping of str to Dataset
        Solutions by their labels in the legend.
    ax : Axes, optional
    where : DataArray or array of bool, optional
        Mask of the subregions to use; all by default. A solution with a single subregion is always used.
    band : float, optional
        Lower quantile of a band over subregions around each mean; None for no band.
    interval : float, optional
        Confidence level of the mean's interval, by block bootstrap, drawn as bars; None for no interval.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the forces do not lie along ``subregion`` and ``delta`` alone.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset(
    ...     {"force": (("subregion", "delta"), [[0.0, 1.0, 4.0], [0.0, 2.0, 5.0]])},
    ...     coords={"delta": [0.0, 1.0, 2.0]},
    ... )
    >>> ax = mean_force({"direct": ds}, where=[True, False], ax=Figure().subplots())
    >>> ax.lines[0].get_ydata().tolist()
    [0.0, 1.0, 4.0]
    """
    named = {"mean": solutions} if isinstance(solutions, xr.Dataset) else solutions
    ax = axes(ax)
    for order, (name, ds) in enumerate(named.items()):
        force = _chosen(_sweep(ds), where)["force"]
        look = stroke(order)
        if band is not None and force.sizes["subregion"] > 1:
            spread = force.quantile([band, 1 - band], "subregion").values
            words = f"{100 * (1 - 2 * band):.0f} % of places" if order == 0 else None
            ax.fill_between(ds["delta"], *spread, color=look["color"], alpha=0.18, linewidth=0, label=words)
        points: dict[str, Any] = {"marker": "os^D"[order % 4], "markevery": 1} if ds.sizes["delta"] <= 40 else {}
        ax.plot(ds["delta"], force.mean("subregion"), label=name, markersize=2.6, **points, **look)
        if interval is not None:
            words = f"bars: {100 * interval:g} % interval of the mean" if order == 0 else None
            _error_bars(ax, _chosen(ds, where), "mean", interval, look["color"], label=words)
        _zero(ax, force)
    return legend(label_axes(ax, "delta", "force"), loc="upper left")


#: Largest number of displacements with an interval: more would hide the line.
_MOST_BARS = 20


def _error_bars(ax, ds: xr.Dataset, statistic: str, confidence: float, color: str, label: str | None = None):
    """Draw intervals of a statistic of the force at some displacements, where there are enough places."""
    if ds.sizes["subregion"] < 2:
        return
    some = ds.isel(delta=slice(None, None, -(-ds.sizes["delta"] // _MOST_BARS)))
    intervals = statistics.bootstrap(some, "force", statistics=[statistic], confidence=confidence, resamples=399)
    low, high = (intervals[end].sel(resampling="block", statistic=statistic) for end in ("low", "high"))
    style = {"color": color, "linewidth": 0.8, "label": label}
    ax.vlines(some["delta"].values, low.values, high.values, **style)


@styled
def force_ratio(
    ds: xr.Dataset,
    reference: xr.Dataset,
    *,
    ax: Axes | None = None,
    where: ArrayLike | None = None,
    words: str = "ratio of mean forces",
    order: int = 0,
):
    """Draw the mean force of one solution over that of another, at the displacements of the first.

    Parameters
    ----------
    ds, reference : Dataset
        Solutions; the reference is interpolated.
    ax : Axes, optional
    where : DataArray or array of bool, optional
        Mask of the subregions to use, as for `mean_force`.
    words : str
        Label of the axis; the ratio has unit 1.
    order : int
        Index of the line style.

    Returns
    -------
    Axes

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> delta = np.array([1.0, 2.0, 3.0])
    >>> hertz = xr.Dataset({"force": (("subregion", "delta"), [delta**1.5])}, coords={"delta": delta})
    >>> ax = force_ratio(2 * hertz, hertz, ax=Figure().subplots())
    >>> np.round(ax.lines[0].get_ydata(), 9).tolist()
    [2.0, 2.0, 2.0]
    """
    ratio = mean_ratio(ds, reference, where=where)
    ax = axes(ax, aspect=0.45)
    ax.plot(ratio["delta"], ratio, marker="o" if ratio.size <= 40 else None, markersize=2.6, **stroke(order))
    label_axis(ax.xaxis, "delta")
    ax.set_ylabel(words)
    return ax


def mean_ratio(ds: xr.Dataset, reference: xr.Dataset, *, where: Any = None) -> xr.DataArray:
    """Return the ratio of two solutions' mean forces along the first one's ``delta``, NaN beyond the reference."""
    mean, below = (_chosen(one, where)["force"].mean("subregion") for one in (ds, reference))
    straight = (below.clip(min=0) ** (2 / 3)).interp(delta=mean["delta"]) ** 1.5
    return (mean / straight.where(straight > 0)).rename("ratio")


@styled
def sweep(
    solutions: Mapping[str, xr.Dataset],
    *,
    subregion: int = 0,
    smooth: bool = True,
    ax: Axes | None = None,
    force_limits: tuple[float, float] | None = None,
):
    """Draw one subregion's sweep by several laws, its pull-off marked, beside the smooth sphere's JKR curve.

    Parameters
    ----------
    solutions : mapping of str to Dataset
        Solutions by their labels in the legend.
    subregion : int
        Number along ``subregion``.
    smooth : bool
        Draw the same sphere on a smooth flat at the datum, from the pair on the first solution that has a
        work of adhesion.
    ax : Axes, optional
    force_limits : (float, float), optional
        Ends of the force axis, nN: pull-off is small compared with the push of deep contact.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the forces do not lie along ``subregion`` and ``delta`` alone.
    KeyError
        If there is no such subregion.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset(
    ...     {"force": (("subregion", "delta"), [[-1.0, -2.0, 4.0]])},
    ...     coords={"subregion": [7], "delta": [0.0, 1.0, 2.0]},
    ... )
    >>> sweep({"energy": ds}, subregion=7, ax=Figure().subplots()).lines[0].get_label()
    'energy'
    """
    ax = axes(ax)
    for order, (name, ds) in enumerate(solutions.items()):
        force = _sweep(ds)["force"].sel(subregion=subregion)
        ax.plot(ds["delta"], force, label=name, **stroke(order))
        _mark_pull_off(ax, ds["delta"].values, force.values, stroke(order)["color"])
    with_pair = [ds for ds in solutions.values() if all(name in ds.coords for name in schema.PAIR)]
    if smooth and with_pair:
        delta, pull = _wide_range(with_pair)
        ax.plot(delta, pull, color=BLACK, linewidth=0.9, label="smooth sphere, JKR")
        _mark_pull_off(ax, delta, pull, BLACK)
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    ax.plot([], [], "v", color=GREY, markersize=4, label="pull-off")
    if force_limits is not None:
        ax.set_ylim(*force_limits)
        _within(ax, solutions, subregion, force_limits[1])
    return legend(label_axes(ax, "delta", "force"), loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=2)


def _within(ax, solutions: Mapping[str, xr.Dataset], subregion: int, highest: float):
    """Limit the displacements to those at which at least one of the curves is within the figure."""
    ends = []
    for ds in solutions.values():
        force = ds["force"].sel(subregion=subregion)
        shown = ds["delta"].values[(force <= highest).values]
        ends.append(shown[-1] if shown.size else ds["delta"].values[-1])
    ax.set_xlim(right=max(ends) + 0.03 * (max(ends) - ax.get_xlim()[0]))


@styled
def against_hertz(ds: xr.Dataset, *, ax: Panels | None = None) -> np.ndarray:
    """Draw a smooth sphere's direct simulation against Hertz's law, and its relative error below.

    Parameters
    ----------
    ds : Dataset
        A direct solution on a flat, with its pair.
    ax : sequence of two Axes, optional

    Returns
    -------
    array of two Axes
        Force, and relative error in per cent.

    Raises
    ------
    ValueError
        If it is no solution, or no pair is assigned.

    Examples
    --------
    Hertz's own force, increased by half:

    >>> from matplotlib.figure import Figure
    >>> pair, delta = {"sphere_radius": 500.0, "contact_modulus": 40.0}, np.array([1.0, 2.0])
    >>> ds = xr.Dataset(coords={"delta": delta, **pair})
    >>> ds["force"] = ("subregion", "delta"), [1.5 * hertz_sphere(ds, delta)]
    >>> force, error = against_hertz(ds, ax=Figure().subplots(2))
    >>> np.round(error.lines[-1].get_ydata(), 6).tolist()
    [50.0, 50.0]
    """
    ds = schema.validate(ds, "solution")
    upper, lower = made = panels(ax, 2, 1, aspect=1.0, height_ratios=[2.2, 1], sharex=True)
    delta, force = ds["delta"].values, ds["force"].mean("subregion").values
    fine = np.linspace(0, delta.max(), 200)
    upper.plot(fine, hertz_sphere(ds, fine), color=BLACK, linewidth=1.0, label="Hertz")
    look = {"color": ORANGE, "linestyle": "none", "marker": "o", "markerfacecolor": "white"}
    upper.plot(delta, force, label="direct simulation", **look)
    lower.axhspan(-1, 1, color=GREY, alpha=0.18, linewidth=0, label="within 1 %")
    lower.axhline(0, color=GREY, linewidth=0.5)
    lower.plot(delta, 100 * hertz_error(ds), color=ORANGE, marker="o", markerfacecolor="white")
    lower.set_ylim(-1.2 * max(1.5, _largest(lower)), 1.2 * max(1.5, _largest(lower)))
    label_axis(upper.yaxis, "force")
    upper.set_xlabel("")
    lower.set_ylabel("relative error [%]")
    label_axis(lower.xaxis, "delta")
    legend(upper, loc="upper left")
    legend(lower, loc="lower right")
    return made


def hertz_sphere(ds: xr.Dataset, delta: np.ndarray) -> np.ndarray:
    """Return Hertz's force (nN) of the pair on ``ds`` against a flat, (4/3) E* √R δ^(3/2), 0 out of contact."""
    radius, modulus = schema.pair(ds, "sphere_radius", "contact_modulus")
    return 4 / 3 * modulus * np.sqrt(radius) * np.clip(delta, 0, None) ** 1.5


def hertz_error(ds: xr.Dataset) -> np.ndarray:
    """Return the relative error of a smooth sphere's force against Hertz's, along ``delta``; NaN at δ ≤ 0."""
    hertz = hertz_sphere(ds, ds["delta"].values)
    return ds["force"].mean("subregion").values / np.where(hertz > 0, hertz, np.nan) - 1


def jkr_sphere(ds: xr.Dataset, delta: np.ndarray) -> np.ndarray:
    """Return the stable JKR force (nN) of the pair on ``ds`` against a flat, 0 beyond its branch; NaN if humid."""
    if schema.is_wet(ds):
        return np.full(np.shape(delta), np.nan)
    radius, modulus, work = schema.pair(ds, "sphere_radius", "contact_modulus", "work_of_adhesion")
    if work == 0:
        return hertz_sphere(ds, delta)
    sphere = reference.jkr_sphere(delta, radius=radius, contact_modulus=modulus, work_of_adhesion=work)
    return sphere["force"].fillna(0).values


def _sweep(ds: xr.Dataset) -> xr.Dataset:
    """Return a solution whose forces lie along subregions and displacements alone; raise for others, with advice."""
    if isinstance(ds, xr.Dataset) and "force" not in ds and "pull_off_force" in ds:
        raise ValueError(
            "expected forces along delta, found only pull-offs; solve with adhesive(…, delta=[…]) for force curves, "
            " or draw the pull-off: ds.contact.plot('pull_off_force')"
        )
    ds = schema.validate(ds, "solution")
    others = [str(dim) for dim in ds["force"].dims if dim not in ("subregion", "delta")]
    if others:
        ways = [f"{dim}={ds[dim].values.tolist()[-1]!r}" if dim in ds.coords else f"{dim}=…" for dim in others]
        raise ValueError(
            f"force: expected one along ('subregion', 'delta'), found also {', '.join(others)}; select one first, for "
            f"example ds.sel({', '.join(ways)})"
        )
    return ds


def _chosen(ds: xr.Dataset, where: Any) -> xr.Dataset:
    if where is None or ds.sizes["subregion"] == 1:
        return ds
    return ds.isel(subregion=np.flatnonzero(np.asarray(where, dtype=bool)))


def _zero(ax, force: xr.DataArray):
    """Draw the line between push and pull where there is any pull."""
    if float(force.min()) < 0:
        ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)


def _wide_range(solutions: list[xr.Dataset]) -> tuple[np.ndarray, np.ndarray]:
    """Return the smooth sphere's whole stable branch up to the largest displacement of the solutions."""
    first = next((ds for ds in solutions if float(ds["work_of_adhesion"]) > 0), solutions[0])
    highest = max(float(ds["delta"].max()) for ds in solutions)
    radius, modulus, work = schema.pair(first, *schema.PAIR, wet=True)
    end = 0.0
    if work > 0 and not schema.is_wet(first):
        sphere = {"radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
        end = reference.jkr_sphere([0.0], **sphere).attrs["end_of_branch"]
    delta = np.linspace(end * (1 - 1e-9), highest, 400)
    return delta, jkr_sphere(first, delta)


def _mark_pull_off(ax, delta: np.ndarray, force: np.ndarray, color: str):
    k = int(np.nanargmin(force))
    if force[k] < 0:
        ax.plot(delta[k], force[k], "v", color=color, markersize=4.5, markeredgecolor="white", markeredgewidth=0.5)


def _largest(ax) -> float:
    values = [np.nanmax(np.abs(line.get_ydata())) for line in ax.lines if len(line.get_ydata())]
    return float(max(values))
