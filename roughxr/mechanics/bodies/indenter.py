"""Rough indenters: a sphere fitted to a probe's scan and subtracted, and rough spheres in many placements.

In an elastic half space two rough bodies touch as one with the sum of their roughnesses touches a smooth one. A
particle presents another part of its surface each time it lands, in a random orientation: an ensemble of indenters
along ``placement``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantity, positive, whole_number


@schema.verb("scan")
def fit_sphere(ds: xr.Dataset) -> xr.Dataset:
    """Fit a sphere to the scan of a probe's face, and subtract it.

    Parameters
    ----------
    ds : Dataset
        A scan of the face, such as of a colloidal probe over a grating of spikes; missing pixels are left out.

    Returns
    -------
    Dataset
        The scan with ``height`` (nm) less the sphere: its roughness, of zero mean, for `placements`; and as scalars
        ``fitted_radius`` (nm), ``fit_rms`` (nm), ``apex_x`` and ``apex_y`` (nm), and ``apex_tilt`` (rad), the
        inclination of the sphere in the middle of the scan. A tilt of the scan only moves the apex of a sphere, so that
        both cannot be distinguished.

    Raises
    ------
    ValueError
        If the scan is not curved as a sphere's face is: hollow, or flatter than it is rough.

    Notes
    -----
    Wavelengths on the probe above half the scan count as curvature; the scanning tip rounds features
    sharper than itself (use `erode` first, on this scan as on the surface's).

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> x = np.linspace(-200.0, 200.0, 41)
    >>> nm = {"units": "nm"}
    >>> cap = np.sqrt(3000.0**2 - (x[:, None] - 30) ** 2 - x**2)
    >>> face = xr.Dataset({"height": (("x", "y"), cap, nm)}, {"x": ("x", x, nm), "y": ("y", x, nm)})
    >>> fitted = face.contact.fit_sphere()
    >>> round(float(fitted.fitted_radius)), round(float(fitted.apex_x)), bool(abs(fitted.height).max() < 1e-6)
    (3000, 30, True)
    """
    height = ds["height"].values.astype(float)
    x, y = np.meshgrid(ds["x"].values, ds["y"].values, indexing="ij")
    finite = np.isfinite(height)
    if finite.sum() < 10:
        raise Refusal("height", "at least 10 heights to fit a sphere to", finite.sum())
    middle = float(ds["x"].mean()), float(ds["y"].mean())
    top_x, top_y, top, radius = _sphere(x[finite] - middle[0], y[finite] - middle[1], height[finite])
    r2 = (x - middle[0] - top_x) ** 2 + (y - middle[1] - top_y) ** 2
    residual = height - (top - _sphere_depth(r2, radius))
    out = ds.assign(height=(("x", "y"), residual - residual[finite].mean(), ds["height"].attrs))
    out["fitted_radius"] = radius
    out["fit_rms"] = float(residual[finite].std())
    out["apex_x"] = middle[0] + top_x
    out["apex_y"] = middle[1] + top_y
    out["apex_tilt"] = float(np.arcsin(min(np.hypot(top_x, top_y) / radius, 1.0)))
    return schema.label(out)


def _sphere_depth(r2: Any, radius: float) -> Any:
    """Return the depth of a sphere's surface below its apex, nm; beyond its radius the depth of its equator."""
    return r2 / (radius + np.sqrt(np.maximum(radius**2 - r2, 0.0)))


def _sphere(x: np.ndarray, y: np.ndarray, height: np.ndarray) -> tuple[float, float, float, float]:
    """Return apex (x, y, height) and radius, nm, of the sphere that fits the heights by least squares."""
    from scipy.optimize import least_squares

    x0, y0, top, radius = _paraboloid(x, y, height)
    scale = np.array([1.0, 1.0, 1.0, radius])

    def residuals(fit):
        x0, y0, top, radius = fit * scale
        return top - _sphere_depth((x - x0) ** 2 + (y - y0) ** 2, abs(radius)) - height

    fit = least_squares(residuals, [x0, y0, top, 1.0], x_scale=[radius, radius, 1.0, 1.0], method="lm")
    x0, y0, top, radius = (float(value) for value in fit.x * scale)
    rise = float(np.ptp(_sphere_depth((x - x.mean()) ** 2 + (y - y.mean()) ** 2, abs(radius))))
    rms = float(np.sqrt(np.mean(fit.fun**2)))
    # smallest height of a cap over its rms roughness at which a sphere can be fitted
    if rise < 2.0 * rms or not np.isfinite(radius):
        raise Refusal(
            "height",
            "part of a sphere",
            f"heights that curve by only {rise:.3g} nm over a roughness of {rms:.3g} nm rms",
            "scan a larger part of the sphere",
        )
    return x0, y0, top, abs(radius)


def _paraboloid(x: np.ndarray, y: np.ndarray, height: np.ndarray) -> tuple[float, float, float, float]:
    """Return apex and radius of the round paraboloid that fits the heights."""
    scale = float(np.hypot(x, y).max())
    design = np.c_[np.ones(x.size), x / scale, y / scale, (x**2 + y**2) / scale**2]
    base, along_x, along_y, bend = np.linalg.lstsq(design, height, rcond=None)[0]
    if bend >= 0:
        raise Refusal("height", "part of a sphere, lower away from its apex", "heights that do not fall off")
    radius = float(-(scale**2) / (2 * bend))
    x0 = along_x / scale * radius
    y0 = along_y / scale * radius
    return float(x0), float(y0), float(base + (x0**2 + y0**2) / (2 * radius)), radius


@schema.verb("scan")
def placements(
    roughness: xr.Dataset,
    *,
    sphere_radius: Quantity,
    count: int = 16,
    width: Quantity | None = None,
    seed: int = 0,
) -> xr.Dataset:
    """Return rough spheres in random placements, each with another part of a roughness at its apex.

    Parts are turned by random quarter turns.

    Parameters
    ----------
    roughness : Dataset
        A scan of the roughness: from `fit_sphere`, of a flat face of the same make, or synthetic.
    sphere_radius : number or quantity
        Radius of the sphere below the roughness, nm.
    count : int
        Number of placements.
    width : number or quantity, optional
        Side of the part that faces the surface, nm; by default half of the scan's shorter side. It must be larger
        than any contact, see `assign_pair`.
    seed : int
        The same seed gives the same placements.

    Returns
    -------
    Dataset
        ``indenter_height`` (nm) along (placement, indenter_x, indenter_y), facing the surface, for `vary`; ``patch_x``
        and ``patch_y`` (nm), the centre of the part on the scan, and ``rotation`` (rad).

    Raises
    ------
    ValueError
        If ``width`` does not fit the scan of the roughness.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans import synthetic
    >>> rough = synthetic.self_affine((64, 64), 10, rms=1, hurst=0.8, rolloff=200, seed=1)
    >>> placed = rough.contact.placements(sphere_radius=3000, count=3)
    >>> dict(placed.indenter_height.sizes), round(float(placed.indenter_x[0]))
    ({'placement': 3, 'indenter_x': 31, 'indenter_y': 31}, -150)
    """
    pixel = schema.square_pixel(roughness)
    radius = positive(sphere_radius, "nm", "sphere_radius")
    whole_number(count, "count", least=1)
    height = schema.finite(roughness["height"].values).astype(float)
    height = height[:, ::-1]  # rotated by 180° about the x axis to face the surface
    n = _part(height.shape, pixel, width)
    rng = np.random.default_rng(seed)
    first = np.stack([rng.integers(0, size - n + 1, count) for size in height.shape], axis=1)
    turns = rng.integers(0, 4, count)  # quarter turns leave all heights unchanged
    axis = (np.arange(n) - (n - 1) / 2) * pixel
    sphere = _sphere_depth(axis[:, None] ** 2 + axis**2, radius)
    parts = [np.rot90(height[a : a + n, b : b + n], k) for (a, b), k in zip(first, turns)]
    middle = first + (n - 1) / 2
    out = xr.Dataset(
        {"indenter_height": (("placement", "indenter_x", "indenter_y"), np.stack(parts) - sphere)},
        {
            "placement": np.arange(count),
            "indenter_x": axis,
            "indenter_y": axis,
            "patch_x": ("placement", float(roughness["x"][0]) + middle[:, 0] * pixel),
            "patch_y": ("placement", float(roughness["y"][-1]) - middle[:, 1] * pixel),
            "rotation": ("placement", turns * (np.pi / 2)),
        },
    )
    return schema.label(out)


def _part(shape: tuple[int, int], pixel: float, width: Any) -> int:
    """Return the width of a part in pixels, an odd number."""
    wide = 0.5 * min(shape) * pixel if width is None else positive(width, "nm", "width")
    n = int(wide / pixel - 1) // 2 * 2 + 1
    if n < 3 or n > min(shape):
        raise Refusal(
            "width",
            f"at least {4 * pixel:g} nm, and a part that fits the scan of {min(shape) * pixel:g} nm",
            f"{wide:g} nm",
        )
    return n
