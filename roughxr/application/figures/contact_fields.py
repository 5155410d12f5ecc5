"""Maps of the fields of one contact: pressure, displacement and gap."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...mechanics.scans import regions
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import Quantity, magnitude
from .images import COLOURS, image
from .style import BLACK, BLUE, TEXT, Axes, axes, label_axes, styled


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
        A solution of `direct` or `adhesive` with fields; of `adhesive` with tension, blue, beside pressure, red.
    scan : Dataset, optional
        The scan that it was solved on: its heights are drawn in grey below the pressure, and yielded cells outlined.
    subregion, delta : optional
        By default the first place, and the largest displacement (nm); the nearest one is drawn.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> contact = scan.contact.direct(load=[500.0], fields=True)
    >>> roughxr.figures.field_map(contact, scan=scan).get_xlabel()
    'x from the contact centre [nm]'
    """
    schema.one_of(name, ("pressure", "displacement", "gap"), "name")
    if scan is not None and name != "pressure":
        raise Refusal("scan", "with name='pressure', to be drawn below it", f"name={name!r}")
    contact = _contact(ds, subregion, delta)
    pressure = contact["pressure"]
    ax = axes(ax, aspect=0.85)
    extent = regions.extent(contact)
    if scan is not None:
        heights = _heights(contact, scan).values
        low, high = np.nanmin(heights), np.nanmax(heights)
        # range of the scale of grey below the lowest height, in ranges of height
        pale = low - 2.0 * (high - low), high  # so that dark pressures are seen, also in grey print
        image(ax, heights, extent, "height", "gray", limits=pale, bar=False)
    if name in ("pressure", "displacement") and not pressure.notnull().any():
        # without a colour bar, which would show values that do not exist
        ax.text(0.5, 0.5, "nothing touches", ha="center", va="center", transform=ax.transAxes, fontsize=TEXT)
    elif name == "pressure" and (pressure < 0).any():
        lowest, highest = np.nanmin(pressure), max(np.nanmax(pressure), 0.0)
        largest = max(-lowest, highest)
        bar = image(ax, pressure, extent, name, "vlag", limits=(-largest, largest), extend="neither")
        # tension and pressure are equally dark: only values that occur, so that one sign alone is clear in grey print
        bar.ax.set_ylim(lowest, highest)
    else:
        image(ax, contact[name], extent, name, COLOURS[name])
    _outline(ax, contact, (pressure > 0).values, BLACK)
    if scan is not None and "residual_height" in contact:
        _outline(ax, contact, contact["residual_height"].values < 0, BLUE)
    _show_contact(ax, contact, extent)
    ax.locator_params(nbins=4)
    return label_axes(ax, "indenter_x", "indenter_y")


def _show_contact(ax, contact: xr.Dataset, extent: tuple[float, float, float, float]):
    """Limit the Axes to a square 1.2 times as wide as the contact, within the data; all of them without contact."""
    inside = contact["pressure"].notnull()
    if not bool(inside.any()):
        return
    ends = [[float(getattr(contact[axis].where(inside), end)()) for end in ("min", "max")] for axis in ("x", "y")]
    # least width of the drawn square, in cells
    half = 0.6 * max(max(high - low for low, high in ends), 12 * (extent[1] - extent[0]) / inside.sizes["x"])
    limits = []
    for (low, high), first, last in zip(ends, extent[::2], extent[1::2]):
        middle = 0.5 * (low + high)
        limits.append((max(middle - half, first), min(middle + half, last)))
    ax.set(xlim=limits[0], ylim=limits[1])


def _contact(ds: xr.Dataset, subregion: int | None, delta: Quantity | None) -> xr.Dataset:
    """Return one contact's fields along (x, y), the pressure NaN where there is neither contact nor much tension."""
    missing = [name for name in ("pressure", "displacement", "gap") if name not in ds]
    if missing:
        raise Refusal("", f"a solution with {', '.join(missing)}", advice="solve again with direct(…, fields=True)")
    contact = ds
    if "subregion" in ds.dims:
        contact = ds.isel(subregion=0) if subregion is None else ds.sel(subregion=subregion)
    if "delta" in contact.dims:
        last = contact["delta"].values[-1] if delta is None else magnitude(delta, "nm", "delta")
        contact = contact.sel(delta=last, method="nearest")
    others = [dim for dim in contact["pressure"].dims if dim not in ("x", "y")]
    contact = contact.isel(dict.fromkeys(others, -1))  # the largest load or preload, on retraction
    size = abs(contact["pressure"])
    # least tension that is drawn, over the largest pressure or tension
    shown = size > (0.02 * size.max() if bool((contact["pressure"] < 0).any()) else 0.0)
    return contact.assign(pressure=contact["pressure"].where(shown)).transpose("x", "y", ...)


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
        # level of the outline of a mask, below a half, so that diagonal neighbours have one outline: they are one patch
        ax.contour(contact["x"].values, contact["y"].values, mask, [0.49], colors=[color], linewidths=0.5)
