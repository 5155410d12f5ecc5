"""Maps of the fields of one contact: pressure, displacement and gap."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.scans import regions
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import Quantity, magnitude
from .images import COLOURS, image
from .style import BLACK, BLUE, COLUMN, SMALL, TEXT, Axes, axes, label_axes, panels, styled

#: Largest number of displacements or loads that are drawn in panels of their own.
_MOST_PANELS = 4

#: Number of cells from which a contact is drawn without their number.
_FEW_CELLS = 12


@styled
def field_map(
    ds: xr.Dataset,
    name: str = "pressure",
    *,
    scan: xr.Dataset | None = None,
    subregion: int | None = None,
    delta: Quantity | None = None,
    ax: Axes | None = None,
) -> Any:
    """Draw pressure, displacement or gap of one contact cell by cell, with the outline of the contact.

    Parameters
    ----------
    ds : Dataset
        A solution of `direct` or `adhesive` with fields; of `adhesive` with tension, blue, beside pressure, red, each
        on its own scale.
    scan : Dataset, optional
        The scan that it was solved on: its heights are drawn in grey below the pressure, and yielded cells outlined.
    subregion, delta : optional
        By default the first place, and each of two to four displacements or loads in a panel of its own; of more, and
        on a given ``ax``, the largest. Else the nearest displacement (nm) is drawn.

    Returns
    -------
    Axes, or an array of several

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
    pressed = [dim for dim in ("delta", "load", "preload") if 1 < ds.sizes.get(dim, 1) <= _MOST_PANELS]
    if ax is not None or delta is not None or len(pressed) != 1:
        return _draw_field(axes(ax, aspect=0.85), _contact(ds, subregion, delta), name, scan)
    (along,) = pressed
    count = ds.sizes[along]
    made = panels(None, 1, count, aspect=0.85 / count, width=count * COLUMN)
    for order, panel in enumerate(made):
        step = ds.isel({along: [order]})
        _draw_field(panel, _contact(step, subregion, None), name, scan)
        panel.set_title(
            f"{schema.VARIABLES[along].long_name} {format_number(step[along][0], step[along].attrs['units'], 3)}"
        )
    return made


def _draw_field(ax, contact: xr.Dataset, name: str, scan: xr.Dataset | None):
    """Draw one field of one contact."""
    pressure = contact["pressure"]
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
        # each sign on its own scale, so that a small tension is seen beside a large pressure
        limits = (lowest, highest or -lowest)
        bar = image(ax, pressure, extent, name, "vlag", limits=limits, middle=0.0)
        bar.ax.set_ylim(lowest, highest)  # only values that occur: in grey print both signs look alike
    else:
        # from zero, so that few cells of similar pressure do not look different
        limits = (0.0, None) if name == "pressure" else (None, None)
        image(ax, contact[name], extent, name, COLOURS[name], limits=limits)
    touching = (pressure > 0).values
    _outline(ax, contact, touching, BLACK)
    count = int(touching.sum())
    if 0 < count < _FEW_CELLS:
        words = f"contact of {count} cell{'s' * (count > 1)}"
        ax.text(0.02, 0.98, words, va="top", transform=ax.transAxes, fontsize=SMALL)
    if scan is not None and "residual_height" in contact:
        _outline(ax, contact, contact["residual_height"].values < 0, BLUE)
    _show_contact(ax, contact, extent)
    ax.locator_params(nbins=4)
    return label_axes(ax, "indenter_x", "indenter_y")


def _show_contact(ax, contact: xr.Dataset, extent: tuple[float, float, float, float]):
    """Limit the Axes to a square 1.2 times as wide as the contact, within the data; all of them without contact."""
    cells = np.nonzero(contact["pressure"].notnull().values)
    if not cells[0].size:
        return
    x = contact["x"].values[cells[0]]
    y = contact["y"].values[cells[1]]
    cell = (extent[1] - extent[0]) / contact.sizes["x"]
    # least width of the drawn square, in cells
    half = 0.6 * max(np.ptp(x), np.ptp(y), 12 * cell)
    middle_x = 0.5 * (x.min() + x.max())
    middle_y = 0.5 * (y.min() + y.max())
    ax.set_xlim(np.clip([middle_x - half, middle_x + half], *extent[:2]))
    ax.set_ylim(np.clip([middle_y - half, middle_y + half], *extent[2:]))


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
    # least tension that is drawn, over the largest tension
    shown = (contact["pressure"] > 0) | (size > 0.02 * -contact["pressure"].min())
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
    """Draw a line along the edges of cells that are next to other cells."""
    from matplotlib.collections import LineCollection

    if not cells.any() or cells.all():
        return
    x_low, x_high, y_low, y_high = regions.extent(contact)
    x = np.linspace(x_low, x_high, cells.shape[0] + 1)
    y = np.linspace(y_low, y_high, cells.shape[1] + 1)
    outer = np.pad(cells, 1)
    upright = np.argwhere(outer[1:, 1:-1] != outer[:-1, 1:-1])
    level = np.argwhere(outer[1:-1, 1:] != outer[1:-1, :-1])
    lines = [[(x[i], y[j]), (x[i], y[j + 1])] for i, j in upright]
    lines += [[(x[i], y[j]), (x[i + 1], y[j])] for i, j in level]
    ax.add_collection(LineCollection(lines, colors=color, linewidths=0.5, capstyle="projecting"), autolim=False)
