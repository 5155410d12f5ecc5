"""Pool several scans of one surface, or several placements: their common mean and the spread between them.

Each statistic is computed scan by scan, and pooled as random effects: y_i = μ + b_i + e_i, where b varies from scan to
scan with variance τ², and the variance of e within each scan is estimated by the bootstrap.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from .sampling import SAMPLES, map_samples
from .uncertainty import bootstrap


class Pool(NamedTuple):
    """A mean of several estimates."""

    mean: float
    low: float
    high: float
    between: float  # standard deviation between the estimates beyond their own errors
    p_value: float  # probability of as large a spread by the estimates' own errors alone


@schema.verb("result")
def pooled(
    ds: xr.Dataset,
    name: str,
    *,
    over: str = "scan",
    statistics: Sequence[str] = ("mean", "std", "q5", "q50", "q95"),
    resamples: int = 399,
) -> xr.Dataset:
    """Return statistics of several scans pooled as one surface, with intervals that include the scatter between scans.

    Parameters
    ----------
    ds : Dataset
        Along ``over``, for example results of several scans by ``xr.concat(…, "scan")``, or placements of `vary`.
    name : str
        A variable along ``over`` and its samples, or along ``over`` alone, for example a roughness.
    over : str
        The dimension that is pooled.
    statistics : sequence of str
        See `bootstrap`; of a variable along ``over`` alone only the mean.
    resamples : int
        For the bootstrap within each scan.

    Returns
    -------
    Dataset
        Along ``statistic``: ``pooled`` with ``pooled_low`` and ``pooled_high``, the mean over scans and its 95 %
        interval; ``between_std``, the standard deviation between scans beyond the scatter of their places;
        ``between_p_value``, the probability of such differences by that scatter alone. Along (``over``, statistic):
        each scan's ``estimate`` and its ``standard_error``.

    Notes
    -----
    τ² is Paule and Mandel's. The interval is Hartung and Knapp's, with Student's t, never narrower than the scans' own
    errors require; if no sample is negative it is the interval of the logarithm. For two scans it is wide.

    References
    ----------
    Paule & Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377, doi:10.6028/jres.087.022; Hartung & Knapp, Stat. Med. 20
    (2001) 3875, doi:10.1002/sim.1009.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> values = np.random.default_rng(0).normal([[10.0], [12.0], [14.0]], 1.0, (3, 200))
    >>> ds = xr.Dataset({"pull_off_force": (("scan", "subregion"), values)})
    >>> pool = roughxr.statistics.pooled(ds, "pull_off_force", statistics=["mean"]).squeeze()
    >>> bool(pool.pooled_low < 12 < pool.pooled_high), round(float(pool.between_std)), float(pool.between_p_value)
    (True, 2, 0.0)
    """
    _need_several(ds, name, over)
    # confidence level of the intervals
    confidence = 0.95
    if ds[name].ndim == 1:
        estimate = ds[name].values[:, None].astype(float)
        error = np.zeros((ds.sizes[over], 1))
        labels = ["mean"]
    else:
        options = {"statistics": statistics, "confidence": confidence, "resamples": resamples}
        estimate, error, labels = _scan_statistics(ds, name, over, options)
    solve = partial(random_effects, confidence=confidence, positive=bool(ds[name].min() >= 0))
    pools = [solve(*both) for both in zip(estimate.T, error.T)]
    out = xr.Dataset(
        {key: ("statistic", list(values)) for key, values in zip(_NAMES, zip(*pools))}
        | {"estimate": ((over, "statistic"), estimate), "standard_error": ((over, "statistic"), error)},
        {"statistic": labels, over: ds[over].values if over in ds.coords else np.arange(ds.sizes[over])},
    )
    out = schema.label(out)
    for variable in (*_NAMES[:4], "estimate", "standard_error"):
        out[variable].attrs["units"] = ds[name].attrs.get("units", "1")
    out.attrs = {"variable": name, "confidence": confidence, "pooled_over": over}
    return out


def _need_several(ds: xr.Dataset, name: str, over: str) -> None:
    """Raise unless a variable has samples of several scans, and no further dimension."""
    if name not in ds or over not in ds[name].dims:
        dims = tuple(ds[name].dims) if name in ds else f"variables {', '.join(map(str, ds.data_vars))}"
        raise Refusal(name, f"a variable along {over!r}", dims)
    others = [str(dim) for dim in ds[name].dims if dim not in (over, *SAMPLES, "x", "y")]
    if others:
        raise Refusal(name, f"only {over!r} and its samples", f"also {', '.join(others)}", "select one value of each")
    if ds.sizes[over] < 2:
        raise Refusal(over, "at least two", ds.sizes[over], "for one take `bootstrap`")


_NAMES = ("pooled", "pooled_low", "pooled_high", "between_std", "between_p_value")


def _scan_statistics(ds: xr.Dataset, name: str, over: str, options: dict) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return the statistics of each scan and their standard errors, (scans, statistics)."""
    from scipy.stats import t

    parts = [map_samples(ds.isel({over: k})[[name]]) for k in range(ds.sizes[over])]
    dim = next((dim for dim in SAMPLES if dim in parts[0][name].dims), SAMPLES[0])
    parts = [
        part.isel({dim: np.isfinite(part[name].values)}) for part in parts
    ]  # padding to other scans' samples does not count as missing
    intervals = [bootstrap(part, name, fewest=0, **options) for part in parts]
    estimate = np.stack([interval["estimate"].values for interval in intervals])
    count = [max(float(interval["independent_places"]), 2.0) for interval in intervals]
    widths = 2 * t.ppf(0.5 + options["confidence"] / 2, np.array(count) - 1)
    below = estimate - np.stack([interval["low"].values for interval in intervals])
    above = np.stack([interval["high"].values for interval in intervals]) - estimate
    error = (below + np.where(np.isnan(above), below, above)) / widths[:, None]
    return estimate, error, list(options["statistics"])


def random_effects(estimate: np.ndarray, error: np.ndarray, *, confidence: float, positive: bool = False) -> Pool:
    """Return the mean of estimates that differ by more than their own errors."""
    from scipy.stats import chi2, t

    k = estimate.size
    tau2 = _variance_between(estimate, error)
    weight = _weights(error, tau2)
    mean = float((weight * estimate).sum() / weight.sum())
    scatter = (weight * (estimate - mean) ** 2).sum() / (k - 1)
    exact = not (error > 0).any()
    half = t.ppf(0.5 + confidence / 2, k - 1) * np.sqrt((scatter if exact else max(scatter, 1.0)) / weight.sum())
    bare = _weights(error, 0.0)
    spread = (bare * (estimate - (bare * estimate).sum() / bare.sum()) ** 2).sum()
    p_value = np.nan if exact else float(chi2.sf(spread, k - 1))
    ends = np.array([-half, half])
    low, high = mean * np.exp(ends / mean) if positive and mean > 0 else mean + ends
    return Pool(mean, float(low), float(high), float(np.sqrt(tau2)), p_value)


def _weights(error: np.ndarray, tau2: float) -> np.ndarray:
    """Return inverse variances, or equal weights without error and spread."""
    variance = error**2 + tau2
    return np.ones(error.size) if not variance.all() else 1 / variance


def _variance_between(estimate: np.ndarray, error: np.ndarray) -> float:
    """Return the variance between estimates by Paule and Mandel: the weighted sum of squares equals its expectation."""
    from scipy.optimize import brentq

    k = estimate.size
    if not (error > 0).any():
        return float(estimate.var(ddof=1))

    def excess(tau2):
        weight = _weights(error, tau2)
        mean = (weight * estimate).sum() / weight.sum()
        return (weight * (estimate - mean) ** 2).sum() - (k - 1)

    largest = k * float(np.ptp(estimate)) ** 2
    return 0.0 if excess(0.0) <= 0 or largest == 0 else float(brentq(excess, 0.0, largest))
