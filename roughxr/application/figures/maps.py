"""Maps of a scan: its heights with contact centres or asperities on it, and one value at each contact centre."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from ...mechanics.particles.force_balance import MODES, NEITHER, NO_CONTACT, NO_REST
from ...mechanics.scans import regions
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import Places
from .images import COLOURS, colorbar, colour_map, image
from .style import BLACK, BLUE, GREEN, ORANGE, Axes, axes, label_axes, legend, styled

#: Colours of the modes of detachment; grey for places without one.
_MODES = dict(zip((*MODES, NEITHER, NO_CONTACT, NO_REST), (BLUE, ORANGE, GREEN, "#f2f2f2", "#c8c8c8", "#969696")))


@styled
def scan_map(
    ds: xr.Dataset,
    *,
    subregions: Places = None,
    highlight: ArrayLike | None = None,
    catalogue: xr.Dataset | None = None,
    limits: tuple[float | None, float | None] = (None, None),
    ax: Axes | None = None,
):
    """Draw the heights of a scan, and contact centres or asperities on it.

    Parameters
    ----------
    ds : Dataset
        A scan; to see single asperities, select a part of it first (``ds.sel(x=slice(0, 1000))``).
    subregions, highlight
        Contact centres (see `regions.centres`), drawn as crosses, and a mask of those to be ringed.
    catalogue : Dataset, optional
        Asperities: each fitted paraboloid is outlined 0.2 nm below its vertex, at most as wide as its patch.
    limits : (float, float)
        Ends of the colour scale, nm; by default the lowest and the highest point.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.figures.scan_map(roughxr.open_sample("glass"), subregions=(8, 8)).get_xlabel()
    'x [µm]'
    """
    ds = schema.validate(ds, "scan")
    ax = axes(ax, aspect=0.85)
    extend = "neither" if tuple(limits) == (None, None) else "both"
    image(ax, ds["height"], regions.extent(ds), "height", COLOURS["height"], limits=limits, extend=extend)
    if catalogue is not None:
        _ellipses(ax, schema.validate(catalogue, "asperities"))
    if subregions is not None:
        centres = regions.centres(ds, subregions)
        x = centres["subregion_x"].values
        y = centres["subregion_y"].values
        ax.plot(x, y, "+", color="white", markersize=4, markeredgewidth=0.8)
        chosen = np.zeros(x.size, bool) if highlight is None else np.asarray(highlight, dtype=bool)
        ax.plot(x[chosen], y[chosen], "o", mfc="none", mec=ORANGE, markersize=11, mew=1.2)
    return label_axes(ax, "x", "y")


@styled
def subregion_map(ds: xr.Dataset, name: str = "pull_off_force", *, ax: Axes | None = None):
    """Draw one value for each contact centre at its place on the scan, as tiles where the centres lie on a grid.

    ``name`` is a variable along ``subregion``; ``"mode"`` of `critical_load` is drawn in one colour for each mode, with
    the number of places in the legend.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> pull_offs = scan.contact.pull_off_map(subregions=(8, 8))
    >>> roughxr.figures.subregion_map(pull_offs).get_xlabel()
    'x of the contact centre [µm]'
    """
    if name not in ds or ds[name].dims != ("subregion",):
        raise Refusal(name, "a variable along 'subregion' alone", advice="select one displacement or load first")
    ax = axes(ax, aspect=0.85)
    if name == "mode":
        _modes(ax, ds)
    else:
        colorbar(ax, _centre_values(ax, ds, ds[name].values, cmap=colour_map("rocket_r")), name)
    return label_axes(ax, "subregion_x", "subregion_y")


def critical_map(ds: xr.Dataset, ax: Axes | None = None):
    """Draw a result of `critical_load`: the mode at each place, or the critical strength where all have one mode."""
    strength = str(next(iter(ds.data_vars)))
    alike = np.unique(ds["mode"].values.astype(str)).size == 1 and bool(ds[strength].notnull().any())
    return subregion_map(ds, strength if alike else "mode", ax=ax)


def _modes(ax, ds: xr.Dataset):
    """Draw the mode of detachment at each place, with a legend that counts the places."""
    from matplotlib.colors import ListedColormap

    mode = ds["mode"].values.astype(str)
    order = np.array([list(_MODES).index(word) for word in mode], float)
    colours = {"cmap": ListedColormap(list(_MODES.values())), "vmin": -0.5, "vmax": len(_MODES) - 0.5}
    _centre_values(ax, ds, order, **colours)
    for word, colour in _MODES.items():
        if word in mode:
            ax.scatter([], [], color=colour, marker="s", s=22, label=f"{word} ({np.sum(mode == word)})")
    legend(ax)


def _centre_values(ax, ds: xr.Dataset, values: np.ndarray, **colours: Any):
    """Draw a number for each contact centre: tiles where the centres lie on a grid, else points."""
    x = ds["subregion_x"].values
    y = ds["subregion_y"].values
    ax.set_aspect("equal")
    tiles = pd.DataFrame({"x": x, "y": y, "value": values}).pivot_table("value", "y", "x", dropna=False)
    if tiles.size != x.size or min(tiles.shape) < 2:
        return ax.scatter(x, y, c=values, s=22, edgecolor=BLACK, linewidth=0.4, **colours)
    ax.set_facecolor("#dddddd")
    return ax.pcolormesh(tiles.columns, tiles.index, tiles, edgecolor="white", linewidth=0.4, **colours)


def _ellipses(ax, catalogue: xr.Dataset):
    """Draw the outlines of the asperities."""
    from matplotlib.collections import EllipseCollection

    peaks = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    patch = float(peaks["patch_radius"]) if "patch_radius" in peaks else np.inf
    # depth (nm) below the vertex of a fitted paraboloid at which its outline is drawn
    semi_axes = (np.sqrt(2 * 0.2 / peaks[f"curvature_{end}"].values) for end in ("min", "max"))
    longer, shorter = (2 * np.minimum(axis, patch) for axis in semi_axes)
    centres = np.c_[peaks["x"].values, peaks["y"].values]
    angles = np.degrees(peaks["orientation"].values)
    style: dict[str, Any] = {"facecolor": "none", "edgecolor": "white", "linewidth": 0.7, "units": "xy"}
    outlines = EllipseCollection(longer, shorter, angles, offsets=centres, offset_transform=ax.transData, **style)
    ax.add_collection(outlines, autolim=False)
