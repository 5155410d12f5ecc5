"""The straight line of a force-distance curve far from the surface: offset, tilt, drift and virtual deflection."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr


class Baseline(NamedTuple):
    """A straight line over the piezo's travel, fitted to the part of it that is farthest from the surface."""

    far: np.ndarray  # mask of the samples that it was fitted to
    centre: float  # mean travel of these samples, nm
    coefficients: np.ndarray  # nN at the centre, nN/nm
    noise: float  # standard deviation about the line, nN
    covariance: np.ndarray

    def at(self, z: Any) -> Any:
        """Return the force of the line, nN."""
        return self.coefficients[0] + self.coefficients[1] * (z - self.centre)

    def error(self, z: float) -> float:
        """Return the standard error of the line, nN."""
        row = np.array([1.0, z - self.centre])
        return float(np.sqrt(row @ self.covariance @ row))

    def work_error(self, z: np.ndarray) -> float:
        """Return the standard error of the work along a travel, nN nm, due to the line and to the noise."""
        row = np.trapezoid(np.c_[np.ones(z.size), z - self.centre], z, axis=0)
        return float(np.sqrt(row @ self.covariance @ row + self.noise**2 * (np.diff(z) ** 2).sum()))


def baseline_of(z: np.ndarray, force: np.ndarray, share: float) -> Baseline:
    """Fit the baseline of a curve."""
    far = z < z.min() + share * np.ptp(z)
    centre = float(z[far].mean())
    coefficients, noise, covariance = fitted(np.c_[np.ones(far.sum()), z[far] - centre], force[far])
    return Baseline(far, centre, coefficients, noise, covariance)


def fitted(design: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Return coefficients, standard deviation of the residual, and the coefficients' covariance."""
    coefficients, *_ = np.linalg.lstsq(design, values, rcond=None)
    noise = float(np.sqrt(((values - design @ coefficients) ** 2).sum() / (values.size - design.shape[1])))
    return coefficients, noise, noise**2 * np.linalg.inv(design.T @ design)


def kept(recorded: xr.Dataset, contact_points: np.ndarray, share: float) -> xr.Dataset:
    """Return all curves on one axis of distances."""
    branches = recorded["branch"].values.tolist() if "branch" in recorded.dims else ["retraction"]
    shape = (recorded.sizes["subregion"], len(branches), recorded.sizes["sample"])
    distance = contact_points[:, None, None] - recorded["piezo"].values.reshape(shape)
    force = recorded["force"].values.reshape(shape)
    axis = _distances(distance)
    values = [[_on(axis, *both, share) for both in zip(*curve)] for curve in zip(distance, force)]
    coords = {"branch": branches, "piezo_distance": axis}
    made = np.array(values).reshape(*shape[:2], axis.size)
    return xr.Dataset({"force": (("subregion", "branch", "piezo_distance"), made)}, coords)


def _distances(distance: np.ndarray) -> np.ndarray:
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
