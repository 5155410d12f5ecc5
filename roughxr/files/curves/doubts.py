"""What is doubtful in the pull-off forces of curves, as numbers, and the order of the curves by it."""

from __future__ import annotations

import numpy as np
import xarray as xr

#: Standard error, over the pull-off force, above which a curve is doubtful.
_LARGEST_ERROR = 0.1

#: Limit of a curve without a pull, in standard deviations of its noise, above which a curve is doubtful.
_WIDEST_LIMIT = 20.0

#: Number of ruptures above which a curve is doubtful.
_MOST_RUPTURES = 2


def curve_doubts(ds: xr.Dataset) -> list[dict[str, float]]:
    """Return the doubtful numbers of each curve by their names, from the result of `curves_pull_off`."""
    error, limit = _relative(ds)
    doubts = {
        "contact_point": (ds["contact_point"].values, np.isnan(ds["contact_point"].values)),
        "standard_error": (error, error > _LARGEST_ERROR),
        "limit": (limit, limit > _WIDEST_LIMIT),
        "ruptures": (ds["ruptures"].values, ds["ruptures"].values > _MOST_RUPTURES),
    }
    return [
        {name: float(values[number]) for name, (values, doubtful) in doubts.items() if doubtful[number]}
        for number in range(ds.sizes["subregion"])
    ]


def most_doubtful(ds: xr.Dataset, count: int) -> np.ndarray:
    """Return the numbers of the most doubtful curves, the most doubtful first."""
    error, limit = _relative(ds)
    relative = np.where(np.isfinite(error), error, _LARGEST_ERROR * limit / _WIDEST_LIMIT)
    doubt = np.where(np.isfinite(relative), relative, np.inf)  # curves without any result first
    return np.argsort(-doubt, kind="stable")[:count]


def _relative(ds: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the standard errors over the pull-offs, and the limits over the noise."""
    error = ds["pull_off_standard_error"] / ds["pull_off_force"]
    return error.values, (ds["pull_off_at_most"] / ds["force_noise"]).values
