"""Doubts about the pull-off forces of curves, in words, and the order of the curves by them."""

from __future__ import annotations

import numpy as np
import xarray as xr

#: Standard error, over the pull-off force, from which a curve is doubtful.
_LEAST_ERROR = 0.1

#: Limit of a curve without a pull, in standard deviations of its noise, from which a curve is doubtful.
_WIDEST_LIMIT = 20.0

#: Number of ruptures from which a curve is doubtful.
_SEVERAL = 3


def curve_doubts(ds: xr.Dataset) -> list[list[str]]:
    """Return the doubts about each curve, from the result of `curves_pull_off`."""
    return [_doubts(ds.isel(subregion=number)) for number in range(ds.sizes["subregion"])]


def most_doubtful(ds: xr.Dataset, count: int) -> np.ndarray:
    """Return the numbers of the most doubtful curves, the most doubtful first."""
    error = (ds["pull_off_standard_error"] / ds["pull_off_force"]).values
    width = _LEAST_ERROR * (ds["pull_off_at_most"] / ds["force_noise"]).values / _WIDEST_LIMIT
    relative = np.where(np.isfinite(error), error, width)
    doubt = np.where(np.isfinite(relative), relative, np.inf)  # curves without any result first
    return np.argsort(-doubt, kind="stable")[:count]


def _doubts(curve: xr.Dataset) -> list[str]:
    """Return the doubts about one curve."""
    reason = str(curve["reason"].values)
    doubts = [reason] if reason else []
    if np.isnan(curve["contact_point"]):
        doubts.append("no contact point: the force is nowhere above the baseline")
    error = float(curve["pull_off_standard_error"] / curve["pull_off_force"])
    if error > _LEAST_ERROR:
        doubts.append(f"the standard error is {error:.0%} of the pull-off")
    width = float(curve["pull_off_at_most"] / curve["force_noise"])
    if width > _WIDEST_LIMIT:
        doubts.append(f"the limit is {width:.0f} times the noise: drift or interference")
    ruptures = float(curve["ruptures"])
    if ruptures >= _SEVERAL:
        doubts.append(f"{ruptures:.0f} ruptures: the detachment has several steps")
    return doubts
