"""Maps: a scan, its asperities, the contact centres on it, and the fields of one contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from .. import regions, schema
from .style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    SMALL,
    TEXT,
    axes,
    display_unit,
    fold_labels,
    in_words,
    label_axes,
    label_axis,
    legend,
    panels,
    round_ticks,
    styled,
    tidy,
)

#: Colour map of each field: lightness is monotonic, so that the order is kept in grey print.
COLOURS = {"height": "mako", "pressure": "rocket_r", "displacement": "crest", "gap": "mako_r"}


@styled
def scan_map(
    ds: xr.Dataset,
    *,
    ax: Any = None,
    cmap: str = COLOURS["height"],
    robust: bool = False,
    limits: tuple[float, float] | None = None,
    colorbar: bool = True,
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
    colorbar : bool
        Draw the colour bar.

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
    _image(ax, ds["height"], regions.extent(ds), "height", cmap, limits=limits, colorbar=colorbar)
    return label_axes(ax, "x", "y")


@styled
def contact_grid(ds: xr.Dataset, subregions: Any = None, *, ax: Any = None, highlight: Any = None, **options: Any):
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
    ax: Any = None,
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
        ax.plot(
            shown["x"],
            shown["y"],
            "o",
            color="white",
            markeredgecolor=BLACK,
            markersize=2.2,
            markeredgewidth=0.3,
        )
    else:
        _ellipses(ax, shown, depth)
    ax.set(xlim=(x_low, x_high), ylim=(y_low, y_high))
    return ax


@styled
def subregion_map(ds: xr.Dataset, name: str = "pull_off_force", *, ax: Any = None, cmap: str = "rocket_r"):
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
    drawn = draw_places(ax, ds, ds[name].values, cmap=_cmap(cmap))
    _colorbar(ax, drawn, name)
    return label_axes(ax, "subregion_x", "subregion_y")


def draw_places(ax, ds: xr.Dataset, values: np.ndarray, **colours: Any):
    """Draw a number for each contact centre: tiles where the centres lie on a grid, else points.

    Parameters
    ----------
    ax : Axes
    ds : Dataset
        With the centres ``subregion_x``, ``subregion_y``.
    values : array
        One for each centre; NaN is left grey.
    **colours
        Colour map and norm of matplotlib.

    Returns
    -------
    matplotlib artist
        The artist that a colour bar can be made for.
    """
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


@styled
def field_map(
    ds: xr.Dataset,
    name: str = "pressure",
    *,
    subregion: int = 0,
    delta: float | None = None,
    ax: Any = None,
    cmap: str | None = None,
    location: str = "right",
):
    """Draw pressure, displacement or gap of one contact, with the outline of the contact.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    name : {"pressure", "displacement", "gap"}
    subregion : int
        Number along ``subregion``.
    delta : float, optional
        The nearest displacement (nm) is used; by default the largest.
    ax : Axes, optional
    cmap : str, optional
    location : {"right", "top"}
        Position of the colour bar.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the solution has no fields.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> ds = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> field_map(ds, "gap", ax=Figure().subplots()).get_xlabel()
    'x from the contact centre [nm]'
    """
    one = _contact(ds, subregion, delta)
    ax = axes(ax, aspect=0.85)
    values = one[name].where(one["pressure"] > 0) if name == "pressure" else one[name]
    if not bool((one["pressure"] > 0).any()) and name in ("pressure", "displacement"):
        return _nothing_touches(ax, one)
    _image(ax, values, regions.extent(one), name, cmap or COLOURS[name], location=location)
    _outline(ax, one)
    return _centred(ax, one)


def _nothing_touches(ax, one: xr.Dataset):
    """Write that nothing touches on an empty map: a colour bar would show values that do not exist."""
    _centred(ax, one)
    ax.text(0.5, 0.5, "nothing touches", ha="center", va="center", transform=ax.transAxes, fontsize=TEXT)
    return ax


@styled
def topography_map(
    ds: xr.Dataset,
    scan: xr.Dataset,
    *,
    subregion: int = 0,
    delta: float | None = None,
    ax: Any = None,
    location: str = "right",
):
    """Draw the undeformed heights below one contact, with the outline of the contact.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    scan : Dataset
        The scan that it was solved on.
    subregion, delta, ax, location
        As for `field_map`.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the solution has no fields.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> ds = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> topography_map(ds, scan, ax=Figure().subplots()).get_xlabel()
    'x from the contact centre [nm]'
    """
    one = _contact(ds, subregion, delta)
    ax = axes(ax, aspect=0.85)
    _image(ax, _heights(one, scan), regions.extent(one), "height", COLOURS["height"], location=location)
    _outline(ax, one, color="white")
    return _centred(ax, one)


@styled
def pressure_on_topography(
    ds: xr.Dataset,
    scan: xr.Dataset,
    *,
    subregion: int = 0,
    delta: float | None = None,
    ax: Any = None,
):
    """Draw the pressure of one contact over the undeformed heights in grey, with the outline of the contact.

    Cells that have yielded are outlined.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    scan : Dataset
        The scan that it was solved on.
    subregion, delta, ax
        As for `field_map`.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the solution has no fields.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> ds = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> len(pressure_on_topography(ds, scan, ax=Figure().subplots()).images)  # heights, and the pressure over them
    2
    """
    one = _contact(ds, subregion, delta)
    ax = axes(ax, aspect=0.85)
    extent = regions.extent(one)
    _image(ax, _heights(one, scan), extent, "height", "gray", colorbar=False)
    _image(ax, one["pressure"].where(one["pressure"] > 0), extent, "pressure", COLOURS["pressure"])
    _outline(ax, one)
    if "residual_height" in one:
        _ring(ax, one, one["residual_height"].values < 0, BLUE)
    return _centred(ax, one)


@styled
def contact_section(
    ds: xr.Dataset, scan: xr.Dataset, *, subregion: int = 0, delta: float | None = None, ax: Any = None
):
    """Draw a section along x through the highest pressure: surface before and in contact, and the indenter.

    The deformation of both bodies is drawn on the surface, while the indenter keeps its shape; the contact is
    black.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    scan : Dataset
        The scan that it was solved on.
    subregion, delta, ax
        As for `field_map`.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the solution has no fields.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> ds = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> ax = contact_section(ds, scan, ax=Figure().subplots())
    >>> [line.get_label() for line in ax.lines[:3]]
    ['before', 'indenter', 'in contact']
    """
    one = _contact(ds, subregion, delta)
    one = one.assign(height=_heights(one, scan))
    column = int(one["pressure"].fillna(0).max("x").argmax("y"))
    line = one.isel(y=column)
    line = line.sel(x=slice(-_view(one), _view(one)))
    deformed = line["height"] - line["displacement"] + line.get("residual_height", 0.0)
    touching = line["pressure"] > 0
    ax = axes(ax)
    ax.plot(line["x"], line["height"], color=GREY, linewidth=0.8, label="before")
    ax.plot(line["x"], deformed + line["gap"], color=ORANGE, linestyle=(0, (4, 1.5)), label="indenter")
    ax.plot(line["x"], deformed, color=BLUE, linewidth=1.0, label="in contact")
    ax.plot(line["x"], deformed.where(touching), color=BLACK, linewidth=2, marker="s", markersize=2)
    low, high = float(deformed.min()), float(line["height"].max())
    ax.set_ylim(low - 0.05 * (high - low), high + 0.85 * (high - low))
    ax.set_xlim(-_view(one), _view(one))
    label_axis(ax.yaxis, "height")
    label_axis(ax.xaxis, "indenter_x")
    return legend(ax, loc="upper center", handlelength=1.5, borderaxespad=0)


@styled
def contact_maps(
    ds: xr.Dataset, scan: xr.Dataset, *, subregion: int = 0, delta: float | None = None, ax: Any = None
) -> np.ndarray:
    """Draw one contact: topography, pressure and displacement, each with the contact's outline, and a section.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    scan : Dataset
        The scan that it was solved on.
    subregion, delta
        As for `field_map`.
    ax : sequence of four Axes, optional

    Returns
    -------
    array of four Axes

    Raises
    ------
    ValueError
        If the solution has no fields.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> ds = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> contact_maps(ds, scan, ax=Figure().subplots(2, 2).ravel()).size
    4
    """
    made = panels(ax, 2, 2, aspect=1.14)
    which = {"subregion": subregion, "delta": delta}
    topography_map(ds, scan, ax=made[0], location="top", **which)
    field_map(ds, "pressure", ax=made[1], location="top", **which)
    field_map(ds, "displacement", ax=made[2], location="top", **which)
    contact_section(ds, scan, ax=made[3], **which)
    for one in made:
        fold_labels(one, 24, 40)
    return made


def _contact(ds: xr.Dataset, subregion: int, delta: float | None) -> xr.Dataset:
    """Return one contact's fields along (x, y)."""
    missing = [name for name in ("pressure", "displacement", "gap") if name not in ds]
    if missing:
        raise ValueError(f"expected a solution with {', '.join(missing)}; solve again with direct(…, fields=True)")
    one = ds.sel(subregion=subregion) if "subregion" in ds.dims else ds
    if "delta" in one.dims:
        one = one.isel(delta=-1) if delta is None else one.sel(delta=delta, method="nearest")
    elif "load" in one.dims:
        one = one.isel(load=-1)
    return one.transpose("x", "y", ...)


def _heights(one: xr.Dataset, scan: xr.Dataset) -> xr.DataArray:
    """Return the scan's heights on the pixels of a contact's fields, NaN beyond the scan."""
    at = {}
    for axis in ("x", "y"):
        offset = float(one[f"subpixel_{axis}"]) if f"subpixel_{axis}" in one else 0.0
        at[axis] = one[axis].values + float(one[f"subregion_{axis}"]) + offset
    found = scan["height"].reindex(at, method="nearest", tolerance=0.51 * max(schema.pixel(scan)))
    return found.transpose("x", "y").assign_coords(x=one["x"], y=one["y"])


def _image(ax, values, extent, name: str, cmap: str, *, limits=None, colorbar=True, location="right"):
    low, high = (None, None) if limits is None else limits
    style = {"vmin": low, "vmax": high, "cmap": _cmap(cmap), "origin": "lower", "aspect": "equal"}
    image = ax.imshow(np.asarray(values, dtype=float).T, extent=extent, **style)
    if colorbar:
        _colorbar(ax, image, name, location, extend="neither" if limits is None else _beyond(values, *limits))


def _beyond(values, low: float, high: float) -> str:
    """Return at which ends of a colour bar values are cut off."""
    below, above = float(np.nanmin(values)) < low, float(np.nanmax(values)) > high
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")


def _colorbar(ax, drawn, name: str, location: str = "right", extend: str = "neither"):
    unit = display_unit(schema.VARIABLES[name].units, float(np.abs(drawn.get_clim()).max()))
    beside = ax.inset_axes([1.03, 0, 0.045, 1] if location == "right" else [0, 1.03, 1, 0.045])
    style = {"location": location, "format": unit.formatter(), "extend": extend}
    bar = ax.figure.colorbar(drawn, cax=beside, **style)
    bar.set_label(in_words(name, unit), fontsize=SMALL if location == "top" else TEXT)
    bar.outline.set_linewidth(0.4)
    round_ticks(bar.ax.xaxis if location == "top" else bar.ax.yaxis)
    tidy(bar.ax)


def _cmap(name: str):
    """Return a colour map by name; seaborn registers its own when it is imported."""
    import matplotlib
    import seaborn  # noqa: F401

    return matplotlib.colormaps[name]


def _outline(ax, one: xr.Dataset, color: str = BLACK):
    """Draw the edge of the contact."""
    _ring(ax, one, one["pressure"].values > 0, color)


def _ring(ax, one: xr.Dataset, cells: np.ndarray, color: str):
    """Draw a line around some cells."""
    inside = cells.astype(float)
    if inside.any() and not inside.all():
        ax.contour(one["x"].values, one["y"].values, inside.T, [0.5], colors=[color], linewidths=0.5)


def _view(one: xr.Dataset) -> float:
    """Return the half-width (nm) of the view of a contact: 1.5 times its reach, as far as there are data."""
    inside = one["pressure"] > 0
    whole = float(max(np.abs(regions.extent(one))))
    reach = max(float(np.abs(one[axis]).where(inside).max()) for axis in ("x", "y"))
    return min(1.5 * reach, whole) if reach > 0 else whole


def _centred(ax, one: xr.Dataset):
    """Limit the view to the contact and its surroundings, on axes from its centre, with few ticks."""
    view = _view(one)
    ax.set(xlim=(-view, view), ylim=(-view, view))
    ax.locator_params(nbins=4)
    return label_axes(ax, "indenter_x", "indenter_y")


def _ellipses(ax, catalogue: xr.Dataset, depth: float):
    from matplotlib.collections import EllipseCollection

    peaks = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    patch = float(peaks["patch_radius"]) if "patch_radius" in peaks else np.inf
    semi_axes = (np.sqrt(2 * depth / peaks[f"curvature_{end}"].values) for end in ("min", "max"))
    longer, shorter = (2 * np.minimum(axis, patch) for axis in semi_axes)
    places = np.c_[peaks["x"].values, peaks["y"].values]
    style = {"facecolor": "none", "edgecolor": "white", "linewidth": 0.7, "units": "xy"}
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
    grid = _grid(x, y)
    if grid is None:
        return
    style = {"color": "white", "linewidth": 0.5, "alpha": 0.7}
    for middle, line, low in zip(grid, (ax.axvline, ax.axhline), (extent[0], extent[2])):
        for between in (middle[1:] + middle[:-1]) / 2:
            if between > low:
                line(between, **style)
