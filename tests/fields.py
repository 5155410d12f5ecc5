"""Correlated fields of known mean and median on a grid of places, and samples of known laws."""

import functools

import numpy as np
import xarray as xr
from scipy.ndimage import gaussian_filter


def field(side, length, rng):
    """Return a normal field of variance 1 on (side, side) places, correlation exp(−d²/(2·length²)) over spacings."""
    margin = int(4 * length) + 2
    noise = rng.normal(size=(side + 2 * margin, side + 2 * margin))
    smooth = gaussian_filter(noise, length / np.sqrt(2), mode="wrap", truncate=5.0)
    return (smooth / _smoothed_std(length))[margin:-margin, margin:-margin]


@functools.cache
def _smoothed_std(length):
    """Return the standard deviation of smoothed noise of variance 1."""
    weights = np.zeros((81, 81))
    weights[40, 40] = 1.0
    return np.sqrt((gaussian_filter(weights, length / np.sqrt(2), truncate=5.0) ** 2).sum())


def grid_samples(values, spacing=625.0, name="pull_off_force", units="nN"):
    """Return values (nx, ny) as a Dataset along ``subregion`` with the centres of a grid."""
    x, y = ((axis.ravel() + 0.5) * spacing for axis in np.mgrid[: values.shape[0], : values.shape[1]])
    places = {"subregion_x": ("subregion", x), "subregion_y": ("subregion", y)}
    return xr.Dataset({name: ("subregion", values.ravel(), {"units": units, "long_name": "force"})}, coords=places)
