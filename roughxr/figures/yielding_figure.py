"""Figures of yield: the loop of force and displacement, and the pull-off over the preload."""

from __future__ import annotations

import xarray as xr

from .style import BLACK, GREY, VERMILION, Axes, axes, label_axes, legend, stroke, styled


@styled
def force_loop(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the mean force on loading and on retraction, with the area between them shaded.

    Parameters
    ----------
    ds : Dataset
        A solution with both branches, of `direct` with a hardness or of `adhesive` with displacements.
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the solution holds no forces along (subregion, branch, delta).

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> force = [[[0.0, 1.0, 4.0], [0.0, 0.5, 4.0]]]
    >>> ds = xr.Dataset(
    ...     {"force": (("subregion", "branch", "delta"), force)},
    ...     coords={"branch": ["loading", "retraction"], "delta": [0.0, 1.0, 2.0]},
    ... )
    >>> force_loop(ds, ax=Figure().subplots()).get_xlabel()
    'displacement [nm]'
    """
    if "force" not in ds or set(ds["force"].dims) != {"subregion", "branch", "delta"}:
        found = tuple(ds["force"].dims) if "force" in ds else "none"
        raise ValueError(f"force: expected forces along subregion, branch and delta, found {found}")
    ax = axes(ax)
    mean, delta = ds["force"].mean("subregion"), ds["delta"].values
    there, back = (mean.sel(branch=branch).values for branch in ("loading", "retraction"))
    ax.fill_between(delta, back, there, color=GREY, alpha=0.3, linewidth=0, label="work lost")
    ax.plot(delta, there, color=BLACK, label="loading")
    ax.plot(delta, back, color=VERMILION, linestyle=(0, (4, 1.5)), label="retraction")
    if float(mean.min()) < 0:
        ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    return legend(label_axes(ax, "delta", "force"), loc="upper left")


@styled
def preload_curve(solutions: dict[str, xr.Dataset], *, ax: Axes | None = None):
    """Draw the mean pull-off force over the preload, a line for each of several solutions.

    Parameters
    ----------
    solutions : dict of str to Dataset
        By their labels in the legend, for example with and without a hardness: ``pull_off_force`` along (subregion,
        preload).
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If there are none, or one has no pull-off along preloads.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset({"pull_off_force": (("subregion", "preload"), [[1.0, 2.0]])}, {"preload": [0.0, 10.0]})
    >>> preload_curve({"elastic": ds}, ax=Figure().subplots()).get_ylabel()
    'pull-off force [nN]'
    """
    if not solutions:
        raise ValueError("solutions: expected at least one, found none")
    ax = axes(ax)
    for order, (words, ds) in enumerate(solutions.items()):
        if "pull_off_force" not in ds or set(ds["pull_off_force"].dims) != {"subregion", "preload"}:
            raise ValueError(f"{words}: expected pull_off_force along subregion and preload, of several preloads")
        mean = ds["pull_off_force"].mean("subregion")
        ax.plot(ds["preload"], mean, label=words, marker="o", markersize=3, **stroke(order))
    ax.set_ylim(bottom=0)
    return legend(label_axes(ax, "preload", "pull_off_force"), loc="best")
