"""The scanning tip: its distortion of a surface, the reconstruction, and the asperities sharper than the tip.

The image by a parabolic tip of apex radius R is the surface's grey-scale dilation by −r²/(2R). A summit of radius ρ has
an image of radius ρ + R; if that hardly exceeds R, ρ is a small difference of large numbers and uncertain. Erosion
removes the tip exactly where it touched the surface. References: Keller, Surf. Sci. 253 (1991) 353; Villarrubia, J.
Res. NIST 102 (1997) 425.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.units import Quantity, positive


@schema.verb("scan")
def dilate(ds: xr.Dataset, *, tip_radius: Quantity) -> xr.Dataset:
    """Return the image of a surface by a parabolic tip.

    Parameters
    ----------
    ds : Dataset
        A scan without missing pixels: the true surface.
    tip_radius : number or quantity
        Of the tip's apex, nm.

    Returns
    -------
    Dataset
        The scan with the heights (nm) of the image, nowhere lower than the surface.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> bool((roughxr.scans.dilate(scan, tip_radius=10).height >= scan.height).all())
    True
    """
    return _swept(ds, tip_radius, 1.0)


@schema.verb("scan")
def erode(ds: xr.Dataset, *, tip_radius: Quantity) -> xr.Dataset:
    """Return the highest surface with this image by a parabolic tip.

    Parameters
    ----------
    ds, tip_radius
        As for `dilate`; the scan is the image.

    Returns
    -------
    Dataset
        The scan with the tip's effect removed, nowhere higher than the image (nm). It equals the surface where the tip
        touched it. Summits sharper than the tip, which only noise makes, are cut off: see `tip_flags`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> sharper = roughxr.scans.erode(scan, tip_radius="10 nm")
    >>> bool((sharper.height <= scan.height + 1e-9).all())
    True
    """
    return _swept(ds, tip_radius, -1.0)


def impossible_share(ds: xr.Dataset, *, tip_radius: Quantity) -> float:
    """Return the part of the heights removed by `erode` that no image by this tip contains: noise, or a sharper tip."""
    eroded = erode(ds, tip_radius=tip_radius)
    image = dilate(eroded, tip_radius=tip_radius)
    removed = float((ds["height"] - eroded["height"]).sum())
    return float((ds["height"] - image["height"]).sum()) / removed if removed > 0 else 0.0


def _swept(ds: xr.Dataset, tip_radius: Any, sign: float) -> xr.Dataset:
    """Return heights after sweeping the parabola along x, then along y, as it is a sum of one parabola for each."""
    radius = positive(tip_radius, "nm", "tip_radius")
    height = sign * schema.finite(np.asarray(ds["height"].values, dtype=float))
    for axis, step in enumerate(schema.pixel(ds)):
        height = _highest(height, axis, step, radius)
    return schema.label(ds.assign(height=(("x", "y"), sign * height)))


def _highest(height: np.ndarray, axis: int, step: float, radius: float) -> np.ndarray:
    """Return the upper envelope along an axis of downward parabolas with their vertices at all heights."""
    from scipy.ndimage import grey_dilation

    reach = int(np.ceil(np.sqrt(2 * radius * np.ptp(height)) / step))
    reach = min(max(reach, 1), height.shape[axis] - 1)
    parabola = -((step * np.arange(-reach, reach + 1)) ** 2) / (2 * radius)
    shape = [1, 1]
    shape[axis] = parabola.size
    return grey_dilation(height, structure=parabola.reshape(shape), mode="constant", cval=-np.inf)


@schema.verb("asperities")
def tip_flags(catalogue: xr.Dataset, *, tip_radius: Quantity) -> xr.Dataset:
    """Flag the asperities of an image that are sharper than its tip.

    Parameters
    ----------
    catalogue : Dataset
        Asperities of the image.
    tip_radius : number or quantity
        Of the tip's apex, nm.

    Returns
    -------
    Dataset
        The catalogue with ``sharper_than_tip`` (the summit has a smaller radius than the tip: image radius below 2R),
        ``beyond_tip`` (image radius below R, impossible with this tip: noise, or a sharper tip), and
        ``curvature_recovered`` (nm⁻¹): the summit's larger principal curvature, 1/(ρ − R) for an image of radius ρ; NaN
        for ``beyond_tip``.

    Examples
    --------
    >>> import roughxr
    >>> flagged = roughxr.scans.tip_flags(roughxr.open_sample("glass").contact.asperities(), tip_radius=1e6)
    >>> bool(flagged.sharper_than_tip.all())
    True
    """
    radius = positive(tip_radius, "nm", "tip_radius")
    image = catalogue["curvature_max"]
    inside = image * radius < 1
    out = catalogue.assign(
        sharper_than_tip=image * radius > 0.5,
        beyond_tip=~inside,
        curvature_recovered=(image / (1 - image * radius).where(inside)).drop_attrs(),
    )
    return schema.label(out.assign_coords(tip_radius=radius))
