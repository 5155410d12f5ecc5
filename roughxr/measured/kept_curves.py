"""Force-distance curves on one axis: forces less their baselines, over the distance from each contact point."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .baselines import baseline_of


def kept(recorded: xr.Dataset, contact_points: np.ndarray, share: float) -> xr.Dataset:
    """Return all curves on one axis of distances."""
    branches = recorded["branch"].values.tolist() if "branch" in recorded.dims else ["retraction"]
    shape = (recorded.sizes["subregion"], len(branches), recorded.sizes["sample"])
    distance = contact_points[:, None, None] - recorded["piezo"].values.reshape(shape)
    force = recorded["force"].values.reshape(shape)
    axis = _axis(distance)
    values = [[_on(axis, *both, share) for both in zip(*curve)] for curve in zip(distance, force)]
    coords = {"branch": branches, "piezo_distance": axis}
    made = np.array(values).reshape(*shape[:2], axis.size)
    return xr.Dataset({"force": (("subregion", "branch", "piezo_distance"), made)}, coords)


def _axis(distance: np.ndarray) -> np.ndarray:
    """Return distances from the most pressed to the farthest, in the step of the samples."""
    known = distance[np.isfinite(distance)]
    if known.size == 0:
        return np.empty(0)
    steps = np.abs(np.diff(distance, axis=-1))
    step = float(np.median(steps[np.isfinite(steps) & (steps > 0)]))
    return step * np.arange(np.ceil(known.min() / step), np.floor(known.max() / step) + 1)


def _on(axis: np.ndarray, distance: np.ndarray, force: np.ndarray, share: float) -> np.ndarray:
    """Return one branch less its own baseline, interpolated between its samples; NaN beyond them."""
    good = np.isfinite(distance) & np.isfinite(force)
    if good.sum() < 10:
        return np.full(axis.size, np.nan)
    order = np.argsort(distance[good], kind="stable")
    distance, force = distance[good][order], force[good][order]
    flat = force - baseline_of(-distance, force, share).at(-distance)
    return np.interp(axis, distance, flat, left=np.nan, right=np.nan)
