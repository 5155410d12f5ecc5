"""Maps of a scan: its heights, its asperities, the contact centres on it, and one value at each of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.units import Places
from .images import COLOURS, colorbar, colour_map, image
from .style import BLACK, ORANGE, Axes, axes, label_axes, styled


@styled
def scan_map(
    ds: xr.Dataset,
    *,
    ax: Axes | None = None,
    cmap: str = COLOURS["height"],
    robust: bool = False,
    limits: tuple[float, float] | None = None,
):
    """Draw the heights of a scan.

    Parameters
    ----------
    ds : Dataset
        A scan.
    ax : Axes, optional
        A new figure by default.
    cmap : str
        Name of a colour map of matplotlib or seaborn.
    robust : bool
        Let the colour scale cover the middle 99 % of the heights.
    limits : (float, float), optional
        Heights (nm) at the ends of the colours.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> ax = scan_map(roughxr.open_sample("glass"), ax=Figure().subplots())
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('x [µm]', 'y [µm]')
    """
    ds = schema.validate(ds, "scan")
    ax = axes(ax, aspect=0.85)
    if robust and limits is None:
        limits = np.nanquantile(ds["height"].values, (0.005, 0.995))
    image(ax, ds["height"], regions.extent(ds), "height", cmap, limits=limits)
    return label_axes(ax, "x", "y")


@styled
def contact_grid(
    ds: xr.Dataset,
    subregions: Places = None,
    *,
    ax: Axes | None = None,
    highlight: ArrayLike | None = None,
    **options: Any,
):
    """Draw a scan with the contact centres on it, and the tiles where they lie on a grid.

    Parameters
    ----------
    ds : Dataset
        A scan.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    ax : Axes, optional
    highlight : array of bool, optional
        Mask of centres to be framed by their tile, or ringed where they are not on a grid.
    **options
        As for `scan_map`.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> ax = contact_grid(roughxr.open_sample("glass"), (8, 8), ax=Figure().subplots())
    """
    ax = scan_map(ds, ax=ax, **options)
    centres = regions.centres(ds, subregions)
    x, y = centres["subregion_x"].values, centres["subregion_y"].values
    _tile_lines(ax, x, y, regions.extent(ds))
    ax.plot(x, y, "+", color="white", markersize=4, markeredgewidth=0.8)
    if highlight is not None:
        _frames(ax, x, y, np.asarray(highlight, dtype=bool))
    return ax


@styled
def asperity_map(
    ds: xr.Dataset,
    catalogue: xr.Dataset,
    *,
    ax: Axes | None = None,
    shape: str = "ellipses",
    depth: float = 0.2,
    **options: Any,
):
    """Draw a scan with its asperities on it.

    Parameters
    ----------
    ds : Dataset
        A scan; select a part of it first (``ds.sel(x=slice(0, 1000))``) to see single asperities.
    catalogue : Dataset
        Its asperities; those beyond ``ds`` are left out.
    ax : Axes, optional
    shape : {"ellipses", "vertices"}
        The outline of each fitted paraboloid ``depth`` below its vertex, no longer than the fitted patch and
        none for a saddle; or its vertex.
    depth : float
        nm.
    **options
        As for `scan_map`.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> part = roughxr.open_sample("glass").sel(x=slice(0, 1000), y=slice(0, 1000))
    >>> ax = asperity_map(part, roughxr.asperities(part), ax=Figure().subplots())
    """
    schema.one_of(shape, ("ellipses", "vertices"), "shape")
    catalogue = schema.validate(catalogue, "asperities")
    ax = scan_map(ds, ax=ax, **options)
    x_low, x_high, y_low, y_high = regions.extent(ds)
    x, y = catalogue["x"], catalogue["y"]
    shown = catalogue.isel(asperity=((x >= x_low) & (x <= x_high) & (y >= y_low) & (y <= y_high)).values)
    if shape == "vertices":
        ax.plot(shown["x"], shown["y"], "o", color="white", markeredgecolor=BLACK, markersize=2.2, markeredgewidth=0.3)
    else:
        _ellipses(ax, shown, depth)
    ax.set(xlim=(x_low, x_high), ylim=(y_low, y_high))
    return ax


@styled
def subregion_map(ds: xr.Dataset, name: str = "pull_off_force", *, ax: Axes | None = None, cmap: str = "rocket_r"):
    """Draw one value for each contact centre, such as the pull-off force, at its place on the scan.

    Parameters
    ----------
    ds : Dataset
        With ``name`` along ``subregion`` and the centres ``subregion_x``, ``subregion_y``.
    name : str
    ax : Axes, optional
    cmap : str

    Returns
    -------
    Axes
        Tiles where the centres lie on a grid, else points.

    Raises
    ------
    ValueError
        If ``name`` does not lie along ``subregion`` alone.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset(
    ...     {"pull_off_force": ("subregion", [1.0, 2.0, 4.0, 3.0])},
    ...     coords={"subregion_x": ("subregion", [0.0, 0, 1, 1]), "subregion_y": ("subregion", [0.0, 1, 0, 1])},
    ... )
    >>> subregion_map(ds, ax=Figure().subplots()).get_xlabel()
    'x of the contact centre [nm]'
    """
    if name not in ds or ds[name].dims != ("subregion",):
        raise ValueError(f"{name}: expected a variable along 'subregion' alone; select one displacement first")
    ax = axes(ax, aspect=0.85)
    drawn = draw_places(ax, ds, ds[name].values, cmap=colour_map(cmap))
    colorbar(ax, drawn, name)
    return label_axes(ax, "subregion_x", "subregion_y")


def draw_places(ax, ds: xr.Dataset, values: np.ndarray, **colours: Any):
    """Draw a number for each contact centre: tiles where the centres lie on a grid, else points."""
    x, y = ds["subregion_x"].values, ds["subregion_y"].values
    grid = _grid(x, y)
    if grid is None:
        drawn = ax.scatter(x, y, c=values, s=22, edgecolor=BLACK, linewidth=0.4, **colours)
    else:
        tiles = np.full(tuple(axis.size for axis in grid), np.nan)
        tiles[np.searchsorted(grid[0], x), np.searchsorted(grid[1], y)] = values
        edges = [_edges(axis) for axis in grid]
        drawn = ax.pcolormesh(*edges, tiles.T, edgecolor="white", linewidth=0.4, **colours)
        ax.set_facecolor("#dddddd")
    ax.set_aspect("equal")
    return drawn


def _ellipses(ax, catalogue: xr.Dataset, depth: float):
    from matplotlib.collections import EllipseCollection

    peaks = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    patch = float(peaks["patch_radius"]) if "patch_radius" in peaks else np.inf
    semi_axes = (np.sqrt(2 * depth / peaks[f"curvature_{end}"].values) for end in ("min", "max"))
    longer, shorter = (2 * np.minimum(axis, patch) for axis in semi_axes)
    places = np.c_[peaks["x"].values, peaks["y"].values]
    style: dict[str, Any] = {"facecolor": "none", "edgecolor": "white", "linewidth": 0.7, "units": "xy"}
    angles = np.degrees(peaks["orientation"].values)
    ax.add_collection(
        EllipseCollection(longer, shorter, angles, offsets=places, offset_transform=ax.transData, **style)
    )


def _grid(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the columns and rows of the grid on which the centres lie, None if they do not lie on one."""
    columns, rows = np.unique(x), np.unique(y)
    full = columns.size * rows.size == x.size and np.unique(np.c_[x, y], axis=0).shape[0] == x.size
    return (columns, rows) if full else None


def _edges(middle: np.ndarray) -> np.ndarray:
    """Return the edges between equal tiles around their middles."""
    half = 0.5 * (np.diff(middle).min() if middle.size > 1 else 1.0)
    return np.append(middle - half, middle[-1] + half)


def _frames(ax, x: np.ndarray, y: np.ndarray, chosen: np.ndarray):
    """Frame the tiles of some centres without covering what is on them; ring centres that are not on a grid."""
    from matplotlib.patches import Rectangle

    grid = _grid(x, y)
    if grid is None or min(axis.size for axis in grid) < 2:
        style = {"markerfacecolor": "none", "markeredgecolor": ORANGE, "markersize": 14, "markeredgewidth": 1.2}
        ax.plot(x[chosen], y[chosen], "o", **style)
        return
    width, height = (0.92 * float(np.diff(axis).min()) for axis in grid)
    for at in zip(x[chosen] - width / 2, y[chosen] - height / 2):
        ax.add_patch(Rectangle(at, width, height, fill=False, edgecolor=ORANGE, linewidth=1.4))


def _tile_lines(ax, x, y, extent):
    style = {"color": "white", "linewidth": 0.5, "alpha": 0.7}
    for middle, line, low in zip(_grid(x, y) or (), (ax.axvline, ax.axhline), (extent[0], extent[2])):
        for between in (middle[1:] + middle[:-1]) / 2:
            if between > low:
                line(between, **style)
