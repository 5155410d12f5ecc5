"""Remove the background of a scan: tilt, bow, and scan lines at different heights.

The polynomial background is fitted by least squares on Legendre polynomials. Row alignment follows Gwyddion
(http://gwyddion.net/documentation/user-guide-en/scan-line-defects.html).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.polynomial import legendre

from ..vocabulary.refusal import Refusal
from ..vocabulary.schema import history, in_memory, label, one_of, verb
from ..vocabulary.text import warn
from .plausibility import ImplausibleScan, faults

#: Total degree of each polynomial background.
_DEGREES = {"plane": 1, "quadratic": 2, "cubic": 3}
_LINES = ("median", "median_difference")

#: Methods of levelling.
METHODS = (*_DEGREES, *_LINES)


@verb("scan")
def level(ds: xr.Dataset, *, method: str = "plane", exclude: xr.DataArray | None = None) -> xr.Dataset:
    """Return a scan without its background.

    Parameters
    ----------
    ds : Dataset
        A scan. The heights of a chunked one are loaded, and chunked again, so that later results are lazy.
    method : {"plane", "quadratic", "cubic", "median", "median_difference"}
        Subtract the least-squares plane, or polynomial of total degree 2 or 3; or shift each scan line along x, the
        fast axis, by its median, or so that the median difference to the line before is zero.
    exclude : DataArray of bool, optional
        (x, y), True where the heights do not belong to the background, such as particles.

    Returns
    -------
    Dataset
        The same scan with new heights: of zero mean (polynomials) or zero median (lines) over the background.

    Raises
    ------
    ValueError
        If too few heights are neither missing nor excluded, or ``exclude`` belongs to another region.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> tilted = scan.assign(height=(scan.height + 0.1 * scan.x).assign_attrs(units="nm"))
    >>> bool(abs(tilted.contact.level().height - scan.contact.level().height).max() < 1e-9)
    True
    """
    height = in_memory(ds["height"])
    if not history(ds):  # open_scan has checked its scans already
        for fault in faults(height.values):
            warn(f"{fault}", ImplausibleScan)
    inside = np.isfinite(height.values)
    if exclude is not None:
        inside &= ~_mask(exclude, height)
    if one_of(method, METHODS, "method") in _LINES:
        levelled = _aligned(height.values, inside, method)
    else:
        levelled = _flattened(height, inside, _DEGREES[method])
    out = label(ds.assign(height=height.copy(data=levelled))).assign_attrs(levelling=method)
    if ds["height"].chunks:
        out["height"] = out["height"].chunk(ds["height"].chunksizes)
    return out


def _mask(exclude: xr.DataArray, height: xr.DataArray) -> np.ndarray:
    """Return a mask of the excluded heights."""
    mask = exclude if isinstance(exclude, xr.DataArray) else xr.DataArray(exclude, dims=height.dims)
    if mask.dtype != bool or dict(mask.sizes) != dict(height.sizes):
        raise Refusal("exclude", f"bool over {dict(height.sizes)}", f"{mask.dtype} over {dict(mask.sizes)}")
    xr.align(mask, height, join="exact", copy=False)  # refuse a mask of another region
    return mask.transpose(*height.dims).values


def _flattened(height: xr.DataArray, inside: np.ndarray, degree: int) -> np.ndarray:
    """Return heights less the least-squares polynomial through those inside."""
    along_x, along_y = (_legendre(height[axis].values, degree) for axis in ("x", "y"))
    n = degree + 1
    right = along_x.T @ np.where(inside, height.values, 0.0) @ along_y
    normal_matrix = (
        (_products(along_x).T @ inside.astype(float) @ _products(along_y)).reshape(n, n, n, n).transpose(0, 2, 1, 3)
    )
    p, q = np.nonzero(np.add.outer(np.arange(n), np.arange(n)) < n)
    matrix = normal_matrix[p, q][:, p, q]
    if np.linalg.matrix_rank(matrix) < len(p):
        raise Refusal(
            "level",
            f"enough heights for a background of {len(p)} terms",
            "too few that are neither missing nor excluded",
            "exclude less, or lower the order",
        )
    coefficients = np.zeros((n, n))
    coefficients[p, q] = np.linalg.solve(matrix, right[p, q])
    return height.values - along_x @ coefficients @ along_y.T


def _legendre(axis: np.ndarray, degree: int) -> np.ndarray:
    """Return the Legendre polynomials up to ``degree`` along one axis scaled to [-1, 1]."""
    return legendre.legvander(2 * (axis - axis[0]) / np.ptp(axis) - 1, degree)


def _products(basis: np.ndarray) -> np.ndarray:
    """Return the products of every two polynomials along one axis, as columns."""
    return (basis[:, :, None] * basis[:, None, :]).reshape(basis.shape[0], -1)


def _aligned(height: np.ndarray, inside: np.ndarray, method: str) -> np.ndarray:
    """Return heights with each line shifted; a line without background stays, or joins the line before."""
    background = xr.DataArray(np.where(inside, height, np.nan), dims=("x", "y"))
    medians = background.median("x").values
    if method == "median":
        return height - np.nan_to_num(medians, nan=0.0)
    steps = np.nan_to_num(background.diff("y").median("x").values, nan=0.0)
    drift = np.concatenate([[0.0], np.cumsum(steps)])
    return height - drift - np.nanmedian(medians - drift)
