"""`compare`: predicted and measured pull-off forces by quantiles and distributions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..statistics import bootstrap
from ..statistics.censoring import RELATIVE_STD, finite_ends, with_infinity
from ..statistics.densities import shares_up_to
from ..statistics.means import BEST_ESTIMATE
from ..statistics.places import independent_places
from ..statistics.sampling import (
    Samples,
    counted_equally,
    forces_of_one_condition,
    limit_attributes,
    samples,
    with_limits,
    without_weights,
)
from ..vocabulary import schema
from ..vocabulary.error_sources import HALF_WIDTH
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, Phrase, without_warnings
from ..vocabulary.units import single

_NAME = "pull_off_force"

#: Probabilities of the quantiles that are compared.
_LEVELS = np.linspace(0.01, 0.99, 99)

STATISTICS = ("mean", "q5", "q25", "q50", "q75", "q95")


@schema.recorded
def compare(
    predicted: xr.Dataset,
    measured: xr.Dataset,
    *,
    extrapolation: xr.Dataset | None = None,
    force_std: float = 0.0,
    statistics: Sequence[str] = STATISTICS,
    resamples: int = 999,
) -> xr.Dataset:
    """Compare predicted and measured pull-off forces.

    Parameters
    ----------
    predicted : Dataset
        With ``pull_off_force`` along ``subregion``, or a map of it: from `pull_off`, `pull_off_map`, `rigid`.
    measured : Dataset
        The same, from `open_pull_off`, or a second prediction.
    extrapolation : Dataset, optional
        From `extrapolated`, of the predicted surface. The means are then judged by its interval, of all known errors,
        in place of the distributions as scanned.
    force_std : float
        Relative standard deviation of an error that all measured forces share, such as of the spring constant: 0.1 or
        "10 %". The intervals of measured statistics and ratios contain it; scatters and distributions do not.
    statistics : sequence of str
        Statistics whose ratios are reported, see `bootstrap`.
    resamples
        As for `bootstrap`, whose intervals are those of 95 %.

    Returns
    -------
    Dataset
        Along ``statistic``: ``predicted`` and ``measured`` with ``…_low`` and ``…_high``, and ``ratio``, measured over
        predicted, with its interval; NaN if either is not positive. Along ``probability``: ``predicted_quantile`` and
        ``measured_quantile``; if some forces are limits NaN where the quantile depends on them, which then lies between
        ``measured_quantile_low`` and ``measured_quantile_high``. ``distribution_distance``, Kolmogorov's, and its
        ``distribution_p_value``, for the effective numbers of independent samples ``predicted_places`` and
        ``measured_places``. ``predicted_relative_std`` and ``measured_relative_std``, standard deviations over means,
        do not contain errors that all places share; ``relative_std_ratio`` is their ratio, with intervals.
        ``scaled_distance`` is that of the distributions scaled to equal means; NaN if some forces are limits.
        ``pull_off_mean``, ``pull_off_low`` and ``pull_off_high`` are those of ``extrapolation``. In
        words by `answer`: the ratio of means, whether the places explain the scatter, and whether the distributions
        agree, or the means by ``extrapolation``.

    Raises
    ------
    ValueError
        If a Dataset has no pull-off forces, none of them is positive, or it has several conditions.

    Notes
    -----
    The ratio is that of the works of adhesion between rigid bodies only: pull-offs of bodies that deform grow faster
    than the work, which `fit_pair` finds.

    Intervals are those of a bootstrap. Forces that are known by limits enter as in `bootstrap`: intervals hold wherever
    they lie between 0 and the limit, and the distance of the distributions is the least that the limits allow. For the
    ratio, the errors of both are taken as independent and their logarithms added in squares (Donner & Zou, Stat.
    Methods Med. Res. 21 (2012) 347): at the same places of one surface it is wider than necessary. The p-value is for
    the number of independent places of the mean; tails have more, so that the test may miss differences but hardly
    reports false ones.

    The places explain the scatter unless the interval of ``relative_std_ratio`` excludes 0.9 … 1.1. Of 20 measured
    forces a ratio of 0.4 or 2.5 is found to differ in more than 95 % of trials, one of 1 in less than 5 %
    (``tests/benchmarks/scatter_verdict.py``).

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> rng = np.random.default_rng(0)
    >>> made = [xr.Dataset({"pull_off_force": ("subregion", f * rng.gamma(9, 1.0, 400))}) for f in (1.0, 1.5)]
    >>> compared = roughxr.compare(*made)
    >>> mean = compared.sel(statistic="mean")
    >>> bool(mean.ratio_low < 1.5 < mean.ratio_high), bool(compared.distribution_p_value < 0.001)
    (True, True)
    >>> print(compared.contact.answer().sentence.splitlines()[0])
    Measured over predicted mean: 1.56 (95 % interval 1.49 … 1.63).
    """
    predicted = forces_of_one_condition(predicted, "predicted")
    measured = forces_of_one_condition(measured, "measured")
    _refuse_exchanged(predicted, measured)
    if extrapolation is not None and not set(BEST_ESTIMATE) <= set(getattr(extrapolation, "data_vars", ())):
        raise Refusal("extrapolation", "a result of `extrapolated`", type(extrapolation).__name__ + " without its mean")
    both = [_samples(ds, words) for ds, words in ((predicted, "predicted"), (measured, "measured"))]
    force_std = single(force_std, "1", "force_std", "a relative error from 0 to below 1", lambda part: 0 <= part < 1)
    out = _statistics((predicted, measured), list(statistics), resamples, force_std)
    out = out.assign(_scatter((predicted, measured), resamples) | {"scaled_distance": _scaled_distance(*both)})
    best = {} if extrapolation is None else {name: float(extrapolation[name]) for name in BEST_ESTIMATE}
    out = out.assign(best).assign_coords(probability=_LEVELS)
    for name, forces in zip(("predicted", "measured"), both):
        quantiles = {f"{name}_quantile{end}": values for end, values in _quantiles(forces).items()}
        out = out.assign({quantile: ("probability", values) for quantile, values in quantiles.items()})
        out.attrs |= {f"{name}_{key}": value for key, value in limit_attributes(forces.bounds).items()}
    out = schema.label(out.assign(_distribution_test(*both)))
    for name in ("predicted", "measured"):
        for end in ("", "_low", "_high"):
            out[name + end].attrs["units"] = "nN"
    out.attrs |= {
        "confidence": 0.95,
        "force_std": force_std,
        "measured_from": str(measured.attrs.get("source_file", "not stated")),
        "missing": "NaN where a value is not positive",
    }
    return out


def _quantiles(forces: Samples) -> dict[str, np.ndarray]:
    """Return the quantiles at `_LEVELS`; of limits those that do not depend on them, and the ends of all."""
    if forces.bounds is None:
        return {"": np.quantile(forces.values, _LEVELS)}
    low, high = with_infinity(np.quantile(finite_ends(forces.bounds), _LEVELS, axis=1).T)
    return {"": np.where(low == high, low, np.nan), "_low": low, "_high": high}


def _refuse_exchanged(predicted: xr.Dataset, measured: xr.Dataset) -> None:
    """Raise where only the second forces are those of a pair of bodies: the ratio would be the inverse."""
    if "sphere_radius" in measured.coords and not schema.pair_coordinates(predicted):
        raise Refusal("predicted", "forces of a pair of bodies", "those of measured= alone", "exchange both")


def _samples(ds: xr.Dataset, words: str) -> Samples:
    sample = without_weights(samples(ds, _NAME, quiet=True), "compare")
    if not (sample.values > 0).any():
        raise Refusal(
            words,
            f"at least one positive {_NAME}",
            f"none of {sample.values.size}",
            Phrase("if the file counts adhesion as negative, open it with ", Argument("pulls", "negative")),
        )
    return sample


def _statistics(datasets: Sequence[xr.Dataset], statistics: list[str], resamples: int, force_std: float) -> xr.Dataset:
    """Return the statistics of both and their ratios, with intervals."""
    intervals = [_intervals(ds, statistics, resamples, seed) for seed, ds in enumerate(datasets)]
    if force_std > 0:
        intervals[1] = _with_shared_error(intervals[1], force_std)
    out = xr.Dataset(coords={"statistic": statistics})
    for name, ends in zip(("predicted", "measured"), intervals):
        out = out.assign({name: ends[0], f"{name}_low": ends[1], f"{name}_high": ends[2]})
    return out.assign(dict(zip(("ratio", "ratio_low", "ratio_high"), _ratio(*intervals))))


def _scatter(datasets: Sequence[xr.Dataset], resamples: int) -> dict[str, float]:
    """Return the relative standard deviations of both and their ratio, with intervals."""
    intervals = [_intervals(ds, [RELATIVE_STD], resamples, seed) for seed, ds in enumerate(datasets)]
    out = {}
    names = [f"predicted_{RELATIVE_STD}", f"measured_{RELATIVE_STD}", f"{RELATIVE_STD}_ratio"]
    for name, ends in zip(names, [*intervals, _ratio(*intervals)]):
        for end, (_, value) in zip(("", "_low", "_high"), ends):
            out[name + end] = value.item()
    return out


def _scaled_distance(predicted: Samples, measured: Samples) -> float:
    """Return the largest difference of the cumulative distributions at equal means; NaN if some forces are limits."""
    from scipy.stats import ks_2samp

    if predicted.bounds is not None or measured.bounds is not None:
        return np.nan
    scaled = [forces.values / forces.values.mean() for forces in (predicted, measured)]
    return float(ks_2samp(*scaled, method="asymp").statistic)


def _intervals(ds: xr.Dataset, statistics: list[str], resamples: int, seed: int) -> list:
    """Return the statistics with the ends of their intervals, all places counted equally."""
    forces = counted_equally(with_limits(ds, _NAME))
    out = without_warnings(bootstrap, forces, _NAME, statistics=statistics, resamples=resamples, seed=seed)
    return [("statistic", out[name].values) for name in ("estimate", "low", "high")]


def _with_shared_error(measured: list, force_std: float) -> list:
    """Return statistics whose intervals contain a relative standard deviation that all forces share."""
    value, low, high = (ends for _, ends in measured)
    shared = HALF_WIDTH * force_std
    with np.errstate(divide="ignore", invalid="ignore"):
        below, above = np.log(value / low), np.log(high / value)
    down = np.where(np.isfinite(below), value * np.exp(-np.hypot(below, shared)), low * np.exp(-shared))
    up = np.where(np.isfinite(above), value * np.exp(np.hypot(above, shared)), high * np.exp(shared))
    return [("statistic", ends) for ends in (value, down, up)]


def _ratio(predicted: list, measured: list) -> list:
    """Return the ratio of two estimates and its interval, with independent errors of the logarithms.

    Without a measured estimate, each end of the measured interval takes its place. An end at 0 is that of a limit.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        p, p_low, p_high = (np.log(np.where(ends > 0, ends, np.nan)) for _, ends in predicted)
        m, m_low, m_high = (np.log(np.where(ends >= 0, ends, np.nan)) for _, ends in measured)
        low = np.where(np.isneginf(m_low), m_low, m - p - np.hypot(m - m_low, p_high - p))
        middle = np.where(np.isnan(m), m_high, m)
        high = np.where(np.isposinf(m_high), m_high, middle - p + np.hypot(m_high - middle, p - p_low))
    return [("statistic", np.exp(ends)) for ends in (m - p, low, high)]


def _distribution_test(predicted: Samples, measured: Samples) -> dict[str, Any]:
    """Return the distance of two distributions, and its p-value for their effective numbers of independent places."""
    from scipy.stats import ks_2samp, kstwobign

    if measured.bounds is None and predicted.bounds is None:
        distance = float(ks_2samp(predicted.values, measured.values, method="asymp").statistic)
    else:
        distance = _least_distance(predicted, measured)
    counts = [independent_places(forces.values, forces.places) for forces in (predicted, measured)]
    size = np.sqrt(counts[0] * counts[1] / sum(counts))
    return {
        "distribution_distance": distance,
        "distribution_p_value": float(kstwobign.sf((size + 0.12 + 0.11 / size) * distance)),
        "predicted_places": counts[0],
        "measured_places": counts[1],
    }


def _least_distance(predicted: Samples, measured: Samples) -> float:
    """Return the least difference of the cumulative distributions at any value, wherever limited values lie."""
    ends = [
        np.tile(forces.values, (2, 1)) if forces.bounds is None else forces.bounds for forces in (predicted, measured)
    ]
    points = np.unique(np.concatenate([side.ravel() for side in ends]))
    largest, least = ([shares_up_to(side[end], points) for side in ends] for end in (0, 1))
    return float(max(0.0, (least[0] - largest[1]).max(), (least[1] - largest[0]).max()))
