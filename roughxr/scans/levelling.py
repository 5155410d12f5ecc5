"""Take the background off a scan: tilt, bow, and scan lines that sit at different heights.

The polynomial background is fitted by least squares on a product of Legendre polynomials in x and y scaled
to [-1, 1], which keeps the normal equations well conditioned (their few sums are all that a lazy scan needs
of its heights). Row alignment follows Gwyddion (http://gwyddion.net/documentation/user-guide-en/
scan-line-defects.html): the median of each line, or the median of the differences between neighbours.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from dask import is_dask_collection
from numpy.polynomial import legendre

from ..schema import label, record, validate
from ..units import magnitude

#: How often a background is fitted anew without the heights that stood out of the one before.
ROUNDS = 5

_ORDERS = {"plane": 1, "quadratic": 2}
_LINES = ("median", "median_difference")


def level(
    ds: xr.Dataset,
    *,
    method: str = "plane",
    order: int | None = None,
    exclude: xr.DataArray | None = None,
    exclude_above: Any = None,
    lines: str = "x",
) -> xr.Dataset:
    """Return a scan without its background.

    Parameters
    ----------
    ds : Dataset
        A scan.
    method : {"plane", "quadratic", "polynomial", "median", "median_difference"}
        Subtract the least-squares plane, second-order surface, or polynomial of total degree ``order``; or
        shift each scan line by its median, or so that the median difference to the line before is zero.
    order : int, optional
        Total degree of ``method="polynomial"``.
    exclude : DataArray of bool, optional
        (x, y), True where the heights do not belong to the background, such as particles.
    exclude_above : length, optional
        Leave out what stands more than this many nm above the background, found in five rounds.
    lines : {"x", "y"}
        Along which axis the scan lines run, the fast axis; for the two methods by line.

    Returns
    -------
    Dataset
        The same scan with new heights: of zero mean (polynomials) or zero median (lines) over the background.
        A lazy scan stays lazy, and is read twice per fit when computed, chunk by chunk.

    Raises
    ------
    ValueError
        If the options do not fit, or too few heights are left to fit.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> axis = np.arange(4) * 10.0
    >>> tilted = ("x", "y"), 3 + 0.1 * axis[:, None] + 0 * axis, {"units": "nm"}
    >>> nm = {"units": "nm"}
    >>> scan = xr.Dataset({"height": tilted}, {"x": ("x", axis, nm), "y": ("y", axis, nm)})
    >>> bool(abs(level(scan).height).max() < 1e-12)
    True
    """
    scan = validate(ds, "scan")
    above = None if exclude_above is None else float(magnitude(exclude_above, "nm", "exclude_above"))
    keep = _kept(scan["height"], exclude)
    if method in _LINES:
        if lines not in ("x", "y"):
            raise ValueError(f"lines: expected 'x' or 'y', found {lines!r}")
        height = _aligned(scan["height"], keep, method, lines, above)
    else:
        height = _flattened(scan["height"], keep, _degree(method, order), above)
    out = label(scan.assign(height=height.transpose("x", "y")))
    given = {"order": order, "exclude": _excluded(exclude), "exclude_above": above}
    given |= {"lines": lines} if method in _LINES else {}
    return record(out, "level", method=method, **given)


def _degree(method: str, order: int | None) -> int:
    if method in _ORDERS:
        if order not in (None, _ORDERS[method]):
            raise ValueError(f"order: method {method!r} has order {_ORDERS[method]}, found {order}; use 'polynomial'")
        return _ORDERS[method]
    if method != "polynomial":
        known = ", ".join([*_ORDERS, "polynomial", *_LINES])
        raise ValueError(f"method: expected one of {known}, found {method!r}")
    if isinstance(order, bool) or not isinstance(order, (int, np.integer)) or not 0 <= order <= 12:
        raise ValueError(f"order: expected a whole number from 0 to 12, found {order!r}")
    return int(order)


def _kept(height: xr.DataArray, exclude: xr.DataArray | None) -> xr.DataArray:
    """Return where heights are known and not excluded."""
    known = height.notnull()
    if exclude is None:
        return known
    mask = exclude if isinstance(exclude, xr.DataArray) else xr.DataArray(exclude, dims=height.dims)
    if mask.dtype != bool or dict(mask.sizes) != dict(height.sizes):
        raise ValueError(
            f"exclude: expected bool over {dict(height.sizes)}, found {mask.dtype} over {dict(mask.sizes)}"
        )
    xr.align(mask, height, join="exact", copy=False)  # a mask of another place may not pass for this one's
    return known & ~mask.transpose(*height.dims).drop_vars(list(mask.coords))


def _excluded(exclude: Any) -> str | None:
    return None if exclude is None else f"{int(np.asarray(exclude).sum())} pixels"


def _again(height: xr.DataArray, keep: xr.DataArray, after: Any) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the same lazy arrays, to be read anew once ``after`` is known.

    Without this, dask would keep every chunk in memory from the fit until the subtraction.
    """
    if not is_dask_collection(after):
        return height, keep
    from dask.graph_manipulation import bind

    fresh = bind([height.data, keep.data], after)
    return height.copy(data=fresh[0]), keep.copy(data=fresh[1])


def _flattened(height: xr.DataArray, keep: xr.DataArray, degree: int, above: float | None) -> xr.DataArray:
    """Return heights less their polynomial background."""
    along_x, along_y = (_legendre(height, axis, degree) for axis in ("x", "y"))
    first, counts = (height, keep), keep
    for _ in range(1 if above is None else ROUNDS):
        coefficients = _fit(height, counts, along_x, along_y)
        height, keep = _again(*first, coefficients)
        rest = height - along_x @ coefficients @ along_y.T
        counts = keep if above is None else keep & (rest <= above)
    return rest


def _legendre(height: xr.DataArray, axis: str, degree: int) -> Any:
    """Return the Legendre polynomials up to ``degree`` along one axis scaled to [-1, 1], in its chunks."""
    places = height[axis].values
    scaled = 2 * (places - places[0]) / np.ptp(places) - 1
    basis = legendre.legvander(scaled, degree)
    if not height.chunks:
        return basis
    return xr.DataArray(basis, dims=(axis, "power")).chunk({axis: height.chunksizes[axis]}).data


def _fit(height: xr.DataArray, keep: xr.DataArray, along_x: Any, along_y: Any) -> Any:
    """Return the least-squares coefficients of the products of polynomials, zero beyond the total degree."""
    right = along_x.T @ height.where(keep, 0.0).data @ along_y
    left = _products(along_x).T @ keep.data.astype(float) @ _products(along_y)
    if not is_dask_collection(right):
        return _solved(left, right)
    return left.map_blocks(_solved, right, chunks=right.chunks, dtype=float)


def _products(basis: Any) -> Any:
    """Return the products of every two polynomials along one axis, as columns."""
    return (basis[:, :, None] * basis[:, None, :]).reshape(basis.shape[0], -1)


def _solved(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve the normal equations for the terms whose total degree is wanted."""
    n = len(right)
    p, q = np.nonzero(np.add.outer(np.arange(n), np.arange(n)) < n)
    matrix = left.reshape(n, n, n, n).transpose(0, 2, 1, 3)[p, q][:, p, q]
    if np.linalg.matrix_rank(matrix) < len(p):
        raise ValueError(
            f"level: expected heights enough for a background of {len(p)} terms, found too few that are "
            "known and not excluded; exclude less, or lower the order"
        )
    out = np.zeros_like(right)
    out[p, q] = np.linalg.solve(matrix, right[p, q])
    return out


def _aligned(height: xr.DataArray, keep: xr.DataArray, method: str, lines: str, above: float | None):
    """Return heights with each scan line shifted by one offset."""
    if height.chunks:
        height, keep = height.chunk({lines: -1}), keep.chunk({lines: -1})  # a median needs its whole line
    across = "y" if lines == "x" else "x"
    first, counts = (height, keep), keep
    for _ in range(1 if above is None else ROUNDS):
        offset = _offsets(height.where(counts), method, lines, across)
        height, keep = _again(*first, offset.data)
        rest = height - offset
        counts = keep if above is None else keep & (rest <= above)
    return rest


def _offsets(background: xr.DataArray, method: str, lines: str, across: str) -> xr.DataArray:
    """Return one offset per scan line; a line without background stays, or joins the one before."""
    medians = background.median(lines)
    if method == "median":
        return medians.fillna(0.0)
    steps = background.diff(across, label="upper").median(lines).reindex({across: background[across]})
    if medians.chunks:
        medians, steps = medians.chunk({across: -1}), steps.chunk({across: -1})
    core = [[across], [across]]
    return xr.apply_ufunc(
        _drift,
        medians,
        steps,
        input_core_dims=core,
        output_core_dims=core[:1],
        dask="parallelized",
        output_dtypes=[float],
    )


def _drift(medians: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the running sum of the steps from line to line, at the height of the lines' medians."""
    drift = np.cumsum(np.nan_to_num(steps, nan=0.0))
    return drift + np.nanmedian(medians - drift)
