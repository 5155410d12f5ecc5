"""The straight line of a force-distance curve far from the surface: offset, tilt, drift and virtual deflection."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


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
