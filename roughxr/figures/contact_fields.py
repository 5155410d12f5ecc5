"""The fields of one contact: maps of pressure, displacement, gap and topography, and a section through it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..scans import regions
from ..vocabulary import schema
from .images import COLOURS, image
from .style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    TEXT,
    Axes,
    Panels,
    axes,
    fold_labels,
    label_axes,
    label_axis,
    legend,
    panels,
    styled,
)


@styled
def field_map(
    ds: xr.Dataset,
    name: str = "pressure",
    *,
    scan: xr.Dataset | None = None,
    subregion: int = 0,
    delta: float | None = None,
    ax: Axes | None = None,
    cmap: str | None = None,
    location: str = "right",
):
    """Draw pressure, displacement, gap or undeformed heights of one contact, with the outline of the contact.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    name : {"pressure", "displacement", "gap", "height"}
    scan : Dataset, optional
        The scan that it was solved on, for its heights. Pressure is then drawn over them in grey, and cells that have
        yielded are outlined.
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
        If the solution has no fields, or the name and the scan do not go together.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, contact_modulus=40)
    >>> ds = scan.contact.direct(delta=[5.0], fields=True, datum="first_contact")
    >>> field_map(ds, "gap", ax=Figure().subplots()).get_xlabel()
    'x from the contact centre [nm]'
    >>> len(field_map(ds, scan=scan, ax=Figure().subplots()).images)  # heights, and the pressure over them
    2
    """
    if not {"height": scan is not None, "pressure": True}.get(name, scan is None):
        raise ValueError("scan: expected with name='height' or, to be drawn below it, 'pressure', and not otherwise")
    one = _contact(ds, subregion, delta)
    ax, extent = axes(ax, aspect=0.85), regions.extent(one)
    if scan is not None:
        one = one.assign(height=_heights(one, scan))
        if name == "pressure":
            image(ax, one["height"], extent, "height", "gray", bar=False)
    if name in ("pressure", "displacement") and not bool(one["pressure"].notnull().any()):
        # without a colour bar, which would show values that do not exist
        ax.text(0.5, 0.5, "nothing touches", ha="center", va="center", transform=ax.transAxes, fontsize=TEXT)
    else:
        image(ax, one[name], extent, name, cmap or COLOURS[name], location=location)
    _outlined(ax, one, "white" if name == "height" else BLACK)
    if name == "pressure" and {"height", "residual_height"} <= set(one):
        _ring(ax, one, one["residual_height"].values < 0, BLUE)
    return ax


@styled
def contact_section(
    ds: xr.Dataset, scan: xr.Dataset, *, subregion: int = 0, delta: float | None = None, ax: Axes | None = None
):
    """Draw a section along x through the highest pressure: surface before and in contact, and the indenter.

    The deformation of both bodies is drawn on the surface, while the indenter keeps its shape; the contact is
    black.

    Parameters
    ----------
    ds, scan : Dataset
        A direct solution with fields, and the scan that it was solved on.
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
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, contact_modulus=40)
    >>> ds = scan.contact.direct(delta=[5.0], fields=True, datum="first_contact")
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
    touching = line["pressure"].notnull()
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
    ds: xr.Dataset, scan: xr.Dataset, *, subregion: int = 0, delta: float | None = None, ax: Panels | None = None
) -> np.ndarray:
    """Draw one contact: topography, pressure and displacement, each with the contact's outline, and a section.

    Parameters
    ----------
    ds, scan : Dataset
        A direct solution with fields, and the scan that it was solved on.
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
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, contact_modulus=40)
    >>> ds = scan.contact.direct(delta=[5.0], fields=True, datum="first_contact")
    >>> contact_maps(ds, scan, ax=Figure().subplots(2, 2).ravel()).size
    4
    """
    made = panels(ax, 2, 2, aspect=1.14)
    which = {"subregion": subregion, "delta": delta}
    field_map(ds, "height", scan=scan, ax=made[0], location="top", **which)
    field_map(ds, "pressure", ax=made[1], location="top", **which)
    field_map(ds, "displacement", ax=made[2], location="top", **which)
    contact_section(ds, scan, ax=made[3], **which)
    for one in made:
        fold_labels(one, 24, 40)
    return made


def _contact(ds: xr.Dataset, subregion: int, delta: float | None) -> xr.Dataset:
    """Return one contact's fields along (x, y), the pressure NaN where nothing touches."""
    missing = [name for name in ("pressure", "displacement", "gap") if name not in ds]
    if missing:
        raise ValueError(f"expected a solution with {', '.join(missing)}; solve again with direct(…, fields=True)")
    one = ds.sel(subregion=subregion) if "subregion" in ds.dims else ds
    if "delta" in one.dims:
        one = one.isel(delta=-1) if delta is None else one.sel(delta=delta, method="nearest")
    elif "load" in one.dims:
        one = one.isel(load=-1)
    return one.assign(pressure=one["pressure"].where(one["pressure"] > 0)).transpose("x", "y", ...)


def _heights(one: xr.Dataset, scan: xr.Dataset) -> xr.DataArray:
    """Return the scan's heights on the pixels of a contact's fields, NaN beyond the scan."""
    at = {}
    for axis in ("x", "y"):
        offset = float(one[f"subpixel_{axis}"]) if f"subpixel_{axis}" in one else 0.0
        at[axis] = one[axis].values + float(one[f"subregion_{axis}"]) + offset
    height = scan["height"].reindex(at, method="nearest", tolerance=0.51 * max(schema.pixel(scan)))
    return height.transpose("x", "y").assign_coords(x=one["x"], y=one["y"])


def _ring(ax, one: xr.Dataset, cells: np.ndarray, color: str):
    """Draw a line around some cells."""
    inside = cells.astype(float)
    if inside.any() and not inside.all():
        ax.contour(one["x"].values, one["y"].values, inside.T, [0.5], colors=[color], linewidths=0.5)


def _view(one: xr.Dataset) -> float:
    """Return the half-width (nm) of the view of a contact: 1.5 times its reach, as far as there are data."""
    inside = one["pressure"].notnull()
    whole = float(max(np.abs(regions.extent(one))))
    reach = max(float(abs(one[axis]).where(inside).max()) for axis in ("x", "y"))
    return min(1.5 * reach, whole) if reach > 0 else whole


def _outlined(ax, one: xr.Dataset, color: str):
    """Draw the edge of the contact, and limit the axes, from its centre, to its surroundings."""
    _ring(ax, one, one["pressure"].notnull().values, color)
    view = _view(one)
    ax.set(xlim=(-view, view), ylim=(-view, view))
    ax.locator_params(nbins=4)
    label_axes(ax, "indenter_x", "indenter_y")
