"""Roughness parameters: the paper's two, and those of ISO 25178-2.

The paper (equations 44 and 45) takes heights from a datum, Z = 0, and not from their mean: R_a = mean |Z|,
R_q = sqrt(mean Z²). (The values that it prints are sqrt(sum Z²) / MN instead, too small by 512 for its 512 x 512
pixels.) ISO 25178-2 takes heights from the mean plane; so do all numbers here whose name begins with ``s_``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.schema import label, pixel, verb
from .levelling import level
from .texture_parameters import NAMES, texture_parameters


@verb("scan")
def roughness(ds: xr.Dataset) -> xr.Dataset:
    """Return the roughness parameters of a scan.

    Parameters
    ----------
    ds : Dataset
        A scan; missing pixels do not count.

    Returns
    -------
    Dataset
        Scalars ``s_a``, ``s_q``, ``s_p``, ``s_v``, ``s_z`` in nm, ``s_sk``, ``s_ku``, ``s_dq``, ``s_dr`` of
        unit 1 (about the least-squares plane), ``r_a_datum`` and ``r_q_datum`` in nm (about height 0); of the texture
        ``s_al`` (nm), ``s_tr`` (1) and ``s_td`` (rad, from x towards y), NaN if pixels are missing, or a texture is
        longer than the scan; ``s_k``, ``s_pk``, ``s_vk`` (nm) of the material ratio curve. Size and pixel are
        coordinates, origin and levelling history attributes. Lazy if the scan is.

    Raises
    ------
    ValueError
        If ``ds`` is no scan, or has too few heights to level.

    Notes
    -----
    ISO 25178-2:2021. s_ku is 3 for Gaussian heights. Slopes are differences
    between neighbouring pixels; s_dr is the developed area of the surface triangulated over its pixel
    centres, averaged over both diagonals, less the projected area, over the projected area. So s_dr is near
    s_dq²/2 for small slopes. The others are those of surfalize 0.17.1 and later; of scans with more than 1024 pixels
    along a side, the autocorrelation is the mean of at most four parts.

    Examples
    --------
    >>> import roughxr
    >>> measures = roughxr.roughness(roughxr.open_sample("glass"))
    >>> round(float(measures.s_q), 1)
    1.9
    """
    flat = ds.assign(height=level(ds)["height"])
    heights = ds["height"]  # the paper's numbers are about height 0
    datum = {"r_a_datum": abs(heights).mean(), "r_q_datum": np.sqrt((heights**2).mean())}
    texture = xr.apply_ufunc(
        texture_parameters,
        flat["height"].drop_vars(list(flat["height"].coords)),
        kwargs={"pixel": pixel(ds)},
        input_core_dims=[["x", "y"]],
        output_core_dims=[["parameter"]],
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"output_sizes": {"parameter": len(NAMES)}, "allow_rechunk": True},
    )
    texture_scalars = {name: texture.isel(parameter=number) for number, name in enumerate(NAMES)}
    out = xr.Dataset({**_height_parameters(flat["height"]), **_slope_parameters(flat), **texture_scalars, **datum})
    out = out.assign_coords(_frame(ds)).assign_attrs(ds.attrs)
    return label(out)


def _height_parameters(height: xr.DataArray) -> dict[str, xr.DataArray]:
    """Return the height parameters of ISO 25178-2 of heights above their reference."""
    square = (height**2).mean()
    rms = square**0.5
    peak = height.max()
    valley = -height.min()
    return {
        "s_a": abs(height).mean(),
        "s_q": rms,
        "s_p": peak,
        "s_v": valley,
        "s_z": peak + valley,
        "s_sk": (height**3).mean() / rms.where(rms > 0) ** 3,
        "s_ku": (height**4).mean() / square.where(square > 0) ** 2,
    }


def _slope_parameters(flat: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return rms slope and developed area ratio over the right triangles at the corners of every cell."""
    height = flat["height"].drop_vars(list(flat["height"].coords))
    dx, dy = pixel(flat)
    along_x = height.diff("x") / dx
    along_y = height.diff("y") / dy
    square = area = xr.DataArray(0.0)
    for row in (slice(None, -1), slice(1, None)):
        for column in (slice(None, -1), slice(1, None)):
            slope2 = along_x.isel(y=row) ** 2 + along_y.isel(x=column) ** 2
            square = square + slope2.mean() / 4
            area = area + ((1 + slope2) ** 0.5).mean() / 4
    return {"s_dq": square**0.5, "s_dr": area - 1}


def _frame(scan: xr.Dataset) -> dict[str, Any]:
    """Return the scan's size and pixel as scalar coordinates."""
    dx, dy = pixel(scan)
    values = {"pixel_x": dx, "pixel_y": dy, "size_x": dx * scan.sizes["x"], "size_y": dy * scan.sizes["y"]}
    return values | {str(name): scan[name] for name in scan.coords if scan[name].ndim == 0}
