"""Maps of the fields of one contact: pressure, displacement and gap."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.units import Quantity, magnitude
from .images import COLOURS, image
from .style import BLACK, BLUE, TEXT, Axes, axes, label_axes, styled

#: Level of the outline of a mask, below a half, so that diagonal neighbours have one outline: they are one patch.
_OUTLINE_LEVEL = 0.49


@styled
def field_map(
    ds: xr.Dataset,
    name: str = "pressure",
    *,
    scan: xr.Dataset | None = None,
    subregion: int | None = None,
    delta: Quantity | None = None,
    ax: Axes | None = None,
):
    """Draw pressure, displacement or gap of one contact, with the outline of the contact.

    Parameters
    ----------
    ds : Dataset
        A direct solution with fields.
    scan : Dataset, optional
        The scan that it was solved on: its heights are drawn in grey below the pressure, and yielded cells outlined.
    subregion, delta : optional
        By default the first place, and the largest displacement (nm); the nearest one is drawn.
    """
    schema.one_of(name, ("pressure", "displacement", "gap"), "name")
    if scan is not None and name != "pressure":
        raise ValueError(f"scan: expected with name='pressure', to be drawn below it, found name={name!r}")
    contact = _contact(ds, subregion, delta)
    ax = axes(ax, aspect=0.85)
    extent = regions.extent(contact)
    if scan is not None:
        image(ax, _heights(contact, scan), extent, "height", "gray", bar=False)
    if name in ("pressure", "displacement") and not bool(contact["pressure"].notnull().any()):
        # without a colour bar, which would show values that do not exist
        ax.text(0.5, 0.5, "nothing touches", ha="center", va="center", transform=ax.transAxes, fontsize=TEXT)
    else:
        image(ax, contact[name], extent, name, COLOURS[name])
    _outline(ax, contact, contact["pressure"].notnull().values, BLACK)
    if scan is not None and "residual_height" in contact:
        _outline(ax, contact, contact["residual_height"].values < 0, BLUE)
    inside = contact["pressure"].notnull()
    whole = float(max(np.abs(extent)))
    largest = max(float(abs(contact[axis]).where(inside).max()) for axis in ("x", "y"))
    view = min(1.5 * largest, whole) if largest > 0 else whole  # 1.5 times the contact, within the data
    ax.set(xlim=(-view, view), ylim=(-view, view))
    ax.locator_params(nbins=4)
    return label_axes(ax, "indenter_x", "indenter_y")


def _contact(ds: xr.Dataset, subregion: int | None, delta: Quantity | None) -> xr.Dataset:
    """Return one contact's fields along (x, y), the pressure NaN where nothing touches."""
    missing = [name for name in ("pressure", "displacement", "gap") if name not in ds]
    if missing:
        raise ValueError(f"expected a solution with {', '.join(missing)}; solve again with direct(…, fields=True)")
    contact = ds
    if "subregion" in ds.dims:
        contact = ds.isel(subregion=0) if subregion is None else ds.sel(subregion=subregion)
    if "delta" in contact.dims:
        last = contact["delta"].values[-1] if delta is None else magnitude(delta, "nm", "delta")
        contact = contact.sel(delta=last, method="nearest")
    elif "load" in contact.dims:
        contact = contact.isel(load=-1)
    return contact.assign(pressure=contact["pressure"].where(contact["pressure"] > 0)).transpose("x", "y", ...)


def _heights(contact: xr.Dataset, scan: xr.Dataset) -> xr.DataArray:
    """Return the scan's heights on the pixels of a contact's fields, NaN outside the scan."""
    positions = {}
    for axis in ("x", "y"):
        offset = float(contact[f"subpixel_{axis}"]) if f"subpixel_{axis}" in contact else 0.0
        positions[axis] = contact[axis].values + float(contact[f"subregion_{axis}"]) + offset
    height = scan["height"].reindex(positions, method="nearest", tolerance=0.51 * max(schema.pixel(scan)))
    return height.transpose("x", "y").assign_coords(x=contact["x"], y=contact["y"])


def _outline(ax, contact: xr.Dataset, cells: np.ndarray, color: str):
    """Draw a line around connected cells."""
    if cells.any() and not cells.all():
        mask = cells.T.astype(float)
        ax.contour(contact["x"].values, contact["y"].values, mask, [_OUTLINE_LEVEL], colors=[color], linewidths=0.5)
