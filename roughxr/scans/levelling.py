"""Remove the background of a scan: tilt, bow, and scan lines at different heights.

The polynomial background is fitted by least squares on Legendre polynomials. Row alignment follows Gwyddion
(http://gwyddion.net/documentation/user-guide-en/scan-line-defects.html).
"""

from __future__ import annotations

from typing import Any

import dask.array as da
import numpy as np
import xarray as xr
from dask import is_dask_collection
from numpy.polynomial import legendre

from ..vocabulary.schema import label, record, validate
from ..vocabulary.units import Quantity, magnitude, whole_number
from ..vocabulary.verbs import verb

#: Number of times that a background is fitted again without the heights that exceeded the last one.
ROUNDS = 5

_ORDERS = {"plane": 1, "quadratic": 2}
_LINES = ("median", "median_difference")


@verb
def level(
    ds: xr.Dataset,
    *,
    method: str = "plane",
    order: int | None = None,
    exclude: xr.DataArray | None = None,
    exclude_above: Quantity | None = None,
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
        Leave out heights more than this many nm above the background, which is then fitted in five rounds.
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
    inside = _inside(scan["height"], exclude)
    if method in _LINES:
        if lines not in ("x", "y"):
            raise ValueError(f"lines: expected 'x' or 'y', found {lines!r}")
        height = _aligned(scan["height"], inside, method, lines, above)
    else:
        height = _flattened(scan["height"], inside, _degree(method, order), above)
    out = label(scan.assign(height=height.transpose("x", "y")))
    given = {"order": order, "exclude": _excluded(exclude), "exclude_above": above}
    given |= {"lines": lines} if method in _LINES else {}
    return record(out, "level", method=method, **given)


def _degree(method: str, order: int | None) -> int:
    if method in _ORDERS:
        if order not in (None, _ORDERS[method]):
            raise ValueError(f"order: expected {_ORDERS[method]} for {method!r}, found {order}; take 'polynomial'")
        return _ORDERS[method]
    if method != "polynomial":
        known = ", ".join([*_ORDERS, "polynomial", *_LINES])
        raise ValueError(f"method: expected one of {known}, found {method!r}")
    return whole_number(order, "order", least=0, most=12)


def _inside(height: xr.DataArray, exclude: xr.DataArray | None) -> xr.DataArray | None:
    """Return where heights are not excluded, or None if none are."""
    if exclude is None:
        return None
    mask = exclude if isinstance(exclude, xr.DataArray) else xr.DataArray(exclude, dims=height.dims)
    if mask.dtype != bool or dict(mask.sizes) != dict(height.sizes):
        raise ValueError(
            f"exclude: expected bool over {dict(height.sizes)}, found {mask.dtype} over {dict(mask.sizes)}"
        )
    xr.align(mask, height, join="exact", copy=False)  # a mask for another place must not pass for this one's
    inside = ~mask.transpose(*height.dims).drop_vars(list(mask.coords))
    return inside.chunk(height.chunksizes) if height.chunks else inside.compute()


def _excluded(exclude: Any) -> str | None:
    if exclude is None:
        return None
    return "a lazy mask" if is_dask_collection(exclude) else f"{int(np.asarray(exclude).sum())} pixels"


def _again(height: xr.DataArray, after: Any) -> xr.DataArray:
    """Return the same lazy heights, read again after ``after``: dask would else keep all chunks until then."""
    if not is_dask_collection(after):
        return height
    from dask.graph_manipulation import bind

    return height.copy(data=bind(height.data, after))


def _flattened(height: xr.DataArray, inside: xr.DataArray | None, degree: int, above: float | None) -> xr.DataArray:
    """Return heights less the least-squares polynomial through those that are not too far above it."""
    basis = tuple(_legendre(height, axis, degree) for axis in ("x", "y"))
    raw, coefficients, limit = height, np.zeros((degree + 1, degree + 1)), np.inf
    for _ in range(1 if above is None else ROUNDS):
        coefficients = _fit(raw, inside, basis, coefficients, limit)
        raw, limit = _again(height, coefficients), np.inf if above is None else above
    if not height.chunks:
        return raw.copy(data=_less(raw.data, basis[0], basis[1], coefficients))
    parts = (raw.data, "xy", basis[0], "xp", basis[1], "yq", coefficients, "pq")
    return raw.copy(data=da.blockwise(_less, "xy", *parts, concatenate=True, dtype=float))


def _less(height: np.ndarray, along_x: np.ndarray, along_y: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return one block of heights less its polynomial."""
    return height - along_x @ coefficients @ along_y.T


def _legendre(height: xr.DataArray, axis: str, degree: int) -> Any:
    """Return the Legendre polynomials up to ``degree`` along one axis scaled to [-1, 1], in its chunks."""
    places = height[axis].values
    scaled = 2 * (places - places[0]) / np.ptp(places) - 1
    basis = legendre.legvander(scaled, degree)
    if not height.chunks:
        return basis
    return xr.DataArray(basis, dims=(axis, "power")).chunk({axis: height.chunksizes[axis]}).data


def _fit(height: xr.DataArray, inside: xr.DataArray | None, basis: tuple[Any, Any], before: Any, limit: float) -> Any:
    """Return the coefficients that fit the heights no more than ``limit`` above those ``before``."""
    n = basis[0].shape[1]
    mask = True if inside is None else inside.data
    if not height.chunks:
        return _solved(_sums(height.data, mask, *basis, before, limit)[0, 0], n)
    sums = da.blockwise(
        _sums,
        "xyk",
        *(height.data, "xy", mask, None if inside is None else "xy"),
        *(basis[0], "xp", basis[1], "yq", before, "pq", limit, None),
        new_axes={"k": n**2 + n**4},
        adjust_chunks={"x": lambda _: 1, "y": lambda _: 1},
        concatenate=True,
        dtype=float,
    ).sum(axis=(0, 1))
    return sums.map_blocks(_solved, n, drop_axis=0, new_axis=(0, 1), chunks=((n,), (n,)), dtype=float)


def _sums(height, mask, along_x, along_y, before, limit) -> np.ndarray:
    """Return the sums of the normal equations over one block: all in one go, so that no block is kept."""
    counts = (_less(height, along_x, along_y, before) <= limit) & mask  # False for a missing pixel
    right = along_x.T @ np.where(counts, height, 0.0) @ along_y
    left = _products(along_x).T @ counts.astype(float) @ _products(along_y)
    return np.concatenate([right.ravel(), left.ravel()])[None, None]


def _products(basis: np.ndarray) -> np.ndarray:
    """Return the products of every two polynomials along one axis, as columns."""
    return (basis[:, :, None] * basis[:, None, :]).reshape(basis.shape[0], -1)


def _solved(sums: np.ndarray, n: int) -> np.ndarray:
    """Solve the normal equations of n polynomials along each axis for the terms of total degree below n."""
    right, left = sums[: n**2].reshape(n, n), sums[n**2 :].reshape(n, n, n, n).transpose(0, 2, 1, 3)
    p, q = np.nonzero(np.add.outer(np.arange(n), np.arange(n)) < n)
    matrix = left[p, q][:, p, q]
    if np.linalg.matrix_rank(matrix) < len(p):
        raise ValueError(
            f"level: expected enough heights for a background of {len(p)} terms, found too few that are "
            "neither missing nor excluded; exclude less, or lower the order"
        )
    out = np.zeros_like(right)
    out[p, q] = np.linalg.solve(matrix, right[p, q])
    return out


def _aligned(
    height: xr.DataArray, inside: xr.DataArray | None, method: str, lines: str, above: float | None
) -> xr.DataArray:
    """Return heights with each scan line shifted by the background in it."""
    background = height if inside is None else height.where(inside)
    for _ in range(1 if above is None else ROUNDS):
        offsets = _offsets(background, method, lines)
        raw = _again(height, offsets.data)
        rest = raw - offsets
        if above is not None:
            background = raw.where((rest <= above) if inside is None else (rest <= above) & inside)
    return rest


def _offsets(background: xr.DataArray, method: str, lines: str) -> xr.DataArray:
    """Return one offset per scan line; a line without background stays, or joins the one before."""
    across = "y" if lines == "x" else "x"
    if background.chunks:
        background = background.chunk({lines: -1})  # a median needs its whole line
    medians = background.median(lines)
    if method == "median":
        return medians.fillna(0.0)
    steps = background.diff(across).median(lines).rename({across: "step"}).drop_vars("step")
    if medians.chunks:
        medians, steps = medians.chunk({across: -1}), steps.chunk({"step": -1})
    return xr.apply_ufunc(
        _drift,
        medians,
        steps,
        input_core_dims=[[across], ["step"]],
        output_core_dims=[[across]],
        dask="parallelized",
        output_dtypes=[float],
    )


def _drift(medians: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the running sum of the steps from line to line, at the height of the lines' medians."""
    drift = np.concatenate([[0.0], np.cumsum(np.nan_to_num(steps, nan=0.0))])
    return drift + np.nanmedian(medians - drift)
