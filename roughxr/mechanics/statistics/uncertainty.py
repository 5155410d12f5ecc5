"""Confidence intervals of statistics over many places, by a bootstrap of as many draws as places are independent.

Neighbours are alike, so that n places have a mean as accurate as m < n independent ones. Resamples therefore have m
draws (Bickel, Götze & van Zwet 1997). Percentiles of few draws are too narrow: they are taken at the levels of
Student's t (Hesterberg 2015, "expanded percentile"). Intervals of quantiles need no resamples: the share of samples
below a quantile is binomial (Clopper & Pearson; Woodruff 1952; Korn & Graubard 1998). Where a quantile may lie beyond
all samples, the interval includes that of a log-normal distribution, too.

Fewer than thirty samples are taken as log-normal, with Cox's interval of the mean (Zhou & Gao 1997; Olsson 2005). A
prior above the scatter of measured scans joins it where that shortens the interval, since few samples overstate their
scatter by chance. If any sample is negative, they are taken as normal, with Student's t. The interval of std is from
χ², of quantiles Owen's (1968). More samples whose logarithms scatter more than those of measured scans do not show
their tail either: the log-normal interval is then included.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.numbers import format_number
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import fraction
from .censoring import (
    RELATIVE_STD,
    finite_ends,
    least_spread_values,
    likelihood_estimates,
    most_spread_values,
    with_infinity,
)
from .densities import bin_shares
from .places import independent_places
from .pull_off_events import smooth_pull_off
from .sampling import (
    Samples,
    limit_attributes,
    map_samples,
    other_dimensions,
    sample_dimension,
    samples,
)

#: Below this number of samples a normal or log-normal distribution is assumed.
FEWEST_SAMPLES = 30

#: Words before those of a variable, of the ends of its intervals.
_ENDS_IN_WORDS = {
    "estimate": "",
    "low": "lower end, ",
    "high": "upper end, ",
    "likelihood_low": "lower end by a likelihood, ",
    "likelihood_high": "upper end by a likelihood, ",
}

#: Why there is no interval: effective sample size, and number of samples.
_TOO_FEW = "too few independent places for an interval: {} of {}; take a larger grid or a larger scan"

#: Prior of a logarithm's standard deviation: measured scans have 0.01 … 0.78.
_PRIOR_SPREAD = 0.8

#: Degrees of freedom of that prior.
_PRIOR_FREEDOM = 3


class Resampling(NamedTuple):
    """The confidence level of intervals, and the resamples that they are computed from."""

    confidence: float
    resamples: int
    seed: int


@schema.verb("result")
def bootstrap(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    statistics: Sequence[str] = ("mean", "std", "q5", "q50", "q95"),
    confidence: float = 0.95,
    resamples: int = 999,
    seed: int = 0,
    within: xr.Dataset | None = None,
    fewest: float = 3.5,
) -> xr.Dataset:
    """Return statistics of a variable with their confidence intervals.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity``, or a map; other dimensions, as of `vary`, are kept.
    statistics : sequence of str
        "mean", "std" (with n − 1), "q5" for the quantile of 5 per cent, and so on; "relative_std", std over mean, on
        its own, since it has no unit. Samples with a ``landing_share`` are weighted by it; n is then Kish's effective
        number.
    confidence : float
        Between 0 and 1.
    resamples : int
        Number of resamples.
    seed : int
        The same seed gives the same intervals.
    within : Dataset, optional
        All places of the surface, if ``ds`` contains only some: their correlation sets the effective sample size.
    fewest : float
        Smallest effective sample size of places with an interval: its own error is large below 3.5.

    Returns
    -------
    Dataset
        Along ``statistic``: ``estimate``, ``low`` and ``high``, in the variable's units. ``independent_places`` is the
        effective sample size. Below ``fewest``, the ends of all intervals are NaN, and the attribute ``no_interval``
        states why. Samples without places count as independent. Values alone do not show debris that they have missed:
        the attribute ``missed_share`` is the share of the surface on which it can lie.

        Pull-off forces may be known by limits, ``pull_off_at_most`` or ``pull_off_at_least`` of `curves_pull_off`. Then
        ``low`` and ``high`` hold wherever each lies between 0 and its limit. ``estimate`` is that of a likelihood with
        censoring, with the interval ``likelihood_low`` … ``likelihood_high``; NaN if fewer than three forces are
        measured. The attribute ``law`` names the law of the likelihood, if there is one; ``limits_below`` and
        ``limits_above`` count the limits, ``largest_limit`` and ``least_limit`` (nN) are their ends.

    Raises
    ------
    ValueError
        If there are fewer than two finite samples, several conditions, or too few ``resamples`` for the level.

    Notes
    -----
    Coverage of nominal 95 % intervals in trials. Three to nine log-normal samples: mean 94 to 95 % (σ up to 0.7), 91 to
    93 % (σ = 1). Up to thirty (σ = 0.5): quantiles 92 to 97 %, std 78 to 91 %. Means of log-normal fields on grids of
    3 × 3 to 8 × 8 with five or more independent places: 93 to 99 %, of fields with exponential correlation 89 to 99 %;
    with two to four, where an interval is given, 83 to 97 %. Grids on eleven maps of seven measured scans: 94 to 99 %,
    on a sixteenth of a map 90 to 95 %. Of 64 to 256 samples std 91 to 97 %; 5 % and 95 % quantiles of 36 to 144 places
    on log-normal, normal, uniform, gamma and bimodal fields 91 to 100 %.

    With 0 to 90 % of 64 curves below the detection limit, bounds contain the true mean in 95 to 100 % of trials, the
    interval of the likelihood in 97 to 100 % (``tests/benchmarks/censored_curves.py``).

    Results of a scan have ``on_debris`` and ``debris_share`` (`regions.centres`). The mean is then that of the places
    on and off debris, weighted by their areas, and its interval that of both. Of a pull-off force with fewer than two
    places on debris, the interval extends to that of a smooth flat there, which debris exceeds only
    if it fits the sphere or ripples. ``tests/benchmarks/debris_intervals.py``
    prints the coverage.

    References
    ----------
    Bickel, Götze & van Zwet, Stat. Sinica 7 (1997) 1; Hesterberg, Am. Stat. 69 (2015) 371,
    doi:10.1080/00031305.2015.1089789; Woodruff, J. Am. Stat. Assoc. 47 (1952) 635; Korn & Graubard, Surv. Meth. 24
    (1998) 193; Zou & Donner, Stat. Med. 27 (2008) 1693, doi:10.1002/sim.3095.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> values = np.random.default_rng(1).normal(15.0, 2.0, 400)
    >>> ds = xr.Dataset({"height": ("asperity", values, {"units": "nm"})})
    >>> mean = ds.contact.bootstrap("height", statistics=["mean"]).sel(statistic="mean")
    >>> bool(mean.low < 15 < mean.high), mean.estimate.units
    (True, 'nm')
    """
    resampling = _read_resampling(confidence, resamples, seed)
    labels = _labels(statistics)
    others = other_dimensions(ds, name)
    shape = [ds.sizes[dim] for dim in others]
    if 0 in shape:
        raise Refusal(name, "at least two finite samples", f"none along {', '.join(others)}")
    entries = []
    for index in np.ndindex(*shape):
        entry = dict(zip(others, index))
        surface = None if within is None else within.isel(entry, missing_dims="ignore")
        entries.append(_statistics_of_entry(ds.isel(entry), surface, name, labels, resampling, fewest))
    missing = [np.nan] * len(labels)
    rows = dict.fromkeys(row for entry in entries for row in entry.rows)
    variables = {row: [entry.rows.get(row, missing) for entry in entries] for row in rows}
    out = xr.Dataset(
        {row: ((*others, "statistic"), np.reshape(values, (*shape, -1))) for row, values in variables.items()},
        {"statistic": labels},
        _common_attributes([entry.attrs for entry in entries]),
    )
    counts = np.reshape([entry.independent_places for entry in entries], shape)
    out = schema.label(_named_ends(out, ds[name]).assign(independent_places=(others, counts)))
    return out.assign_coords({dim: ds[dim].variable for dim in others})


class _Entry(NamedTuple):
    """Statistics of samples, such as those of one entry of a varied parameter."""

    rows: dict[str, Any]  # estimates and ends, each along the statistics
    independent_places: float
    attrs: dict[str, Any]


def _statistics_of_entry(
    ds: xr.Dataset, within: xr.Dataset | None, name: str, labels: list[str], resampling: Resampling, fewest: float
) -> _Entry:
    """Return statistics of a variable along its samples alone."""
    sample = samples(ds, name)
    confidence = resampling.confidence
    count = _independent(sample, None if within is None else samples(within, name))
    attrs = {"variable": name, "confidence": confidence, "samples": sample.values.size, "missing": sample.missing}
    rows, law = _estimates(sample, count, labels, confidence)
    rows |= dict(zip(("low", "high"), _ends(ds, name, sample, count, labels, resampling)))
    if sample.places is not None and count < fewest:
        rows = {row: values if row == "estimate" else np.full(len(labels), np.nan) for row, values in rows.items()}
        attrs["no_interval"] = _TOO_FEW.format(format_number(count, digits=2), sample.values.size)
    attrs |= law
    if sample_dimension(map_samples(ds, name), name) == "subregion" and "debris_share" not in ds.coords:
        attrs["missed_share"] = missed_share(count, 1 - confidence)
    return _Entry(rows, count, attrs)


def _common_attributes(attributes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return attributes without those of which two entries have different values."""
    merged = {name: value for attrs in attributes for name, value in attrs.items()}
    return {
        name: value for name, value in merged.items() if all(attrs.get(name, value) == value for attrs in attributes)
    }


def _read_resampling(confidence: Any, resamples: int, seed: int) -> Resampling:
    """Return the options of a bootstrap; raise for too few resamples for the level."""
    confidence = fraction(confidence, "confidence")
    if resamples < 1 / (1 - confidence):
        raise Refusal("resamples", f"at least {1 / (1 - confidence):.0f}", resamples)
    return Resampling(confidence, resamples, seed)


def _named_ends(out: xr.Dataset, variable: xr.DataArray) -> xr.Dataset:
    """Return statistics of a variable and their intervals with units and long names."""
    units = "1" if RELATIVE_STD in out["statistic"] else variable.attrs.get("units", "1")
    long_name = variable.attrs.get("long_name", variable.name)
    for name in out.data_vars:
        out[name].attrs = {"units": units, "long_name": _ENDS_IN_WORDS[str(name)] + long_name}
    return out


def _labels(statistics: Sequence[str]) -> list[str]:
    """Return names of statistics of one unit; raise for a single one, whose letters would be taken for names."""
    if isinstance(statistics, str):
        raise Refusal("statistics", "a list of names", f"{statistics!r}", f"pass [{statistics!r}]")
    labels = list(statistics)
    if RELATIVE_STD in labels and len(labels) > 1:
        raise Refusal("statistics", f"{RELATIVE_STD} alone, since it has no unit", labels)
    return labels


def _ends(
    ds: xr.Dataset, name: str, sample: Samples, count: float, labels: list[str], resampling: Resampling
) -> np.ndarray:
    """Return the lower and upper ends, (2, statistics), also of samples that are limits or of two populations."""
    find_ends = _intervals if sample.censored is None else _bounded_ends
    ends = find_ends(sample, count, labels, resampling)
    largest = _largest(ds, name)
    if "mean" in labels and _shows_two_populations(sample, largest):
        share = float(ds["debris_share"])
        ends[:, labels.index("mean")] = _two_population_ends(sample, share, largest, resampling)
    return ends


def _estimates(sample: Samples, count: float, labels: list[str], confidence: float) -> tuple[dict, dict]:
    """Return estimates, of limits by a likelihood with its interval, and limits and law as attributes."""
    if sample.censored is None:
        return {"estimate": [_estimate(label, sample.values, sample.weights) for label in labels]}, {}
    law, values = likelihood_estimates(sample.censored, labels, max(count, 2.0), confidence)
    attrs = limit_attributes(sample.bounds) | ({"law": law} if law else {})
    return dict(zip(("estimate", "likelihood_low", "likelihood_high"), values)), attrs


def missed_share(independent: float, risk: float = 0.05) -> float:
    """Return the share of the surface with debris that so many independent places may miss with a probability."""
    return 1 - risk ** (1 / independent)


def _estimate(label: str, values: np.ndarray, weights: np.ndarray | None) -> Any:
    """Return a statistic of samples; raise for an unknown name."""
    if label in ("mean", "std"):
        return (_mean if label == "mean" else _std)(values, weights)
    if label == RELATIVE_STD:
        return _std(values, weights) / _mean(values, weights)
    try:
        share = float(label.removeprefix("q")) / 100
    except ValueError:
        share = np.nan
    if not (label.startswith("q") and 0 <= share <= 1):
        raise Refusal("statistics", "mean, std or q0 … q100", f"{label!r}")
    return _quantile(values, share, weights)


def _mean(values: np.ndarray, weights: np.ndarray | None) -> Any:
    """Return the mean along the last axis, weighted if weights are given."""
    return np.mean(values, axis=-1) if weights is None else np.average(values, axis=-1, weights=weights)


def _std(values: np.ndarray, weights: np.ndarray | None) -> Any:
    """Return the standard deviation along the last axis with n − 1; with weights, n is Kish's effective number."""
    if weights is None:
        return np.std(values, axis=-1, ddof=1)
    effective = _effective_count(weights, values.shape[-1])
    variance = _mean((values - _mean(values, weights)[..., None]) ** 2, weights)
    return np.sqrt(variance) * np.sqrt(effective / np.maximum(effective - 1, 1e-12))


def _effective_count(weights: np.ndarray | None, size: int) -> Any:
    """Return Kish's effective number of weighted samples along the last axis."""
    return size if weights is None else weights.sum(axis=-1) ** 2 / (weights**2).sum(axis=-1)


def _quantile(values: np.ndarray, share: Any, weights: np.ndarray | None = None) -> Any:
    """Return quantiles; of weighted samples by xarray's definition, which equal weights make that of NumPy."""
    if weights is None:
        return np.quantile(values, share)
    return xr.DataArray(values).weighted(xr.DataArray(weights)).quantile(share).values


def density_intervals(ds: xr.Dataset, name: str, *, bins: Any, confidence: float = 0.95):
    """Return bootstrap intervals of a histogram's densities."""
    sample = samples(ds, name)
    edges = np.asarray(bins, dtype=float)
    shares = []
    numbered = sample._replace(values=np.arange(sample.values.size))
    for chosen, _ in _resampled(numbered, _independent(sample), Resampling(confidence, 399, 0)):
        shares += [_bin_fractions(sample, row, edges) for row in chosen]
    return np.quantile(np.array(shares) / np.diff(edges), [0.5 - confidence / 2, 0.5 + confidence / 2], axis=0)


def _bin_fractions(sample: Samples, chosen: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the fraction of the weight of chosen samples in each bin."""
    weights = np.ones(chosen.size) if sample.weights is None else sample.weights[chosen]
    bounds = None if sample.bounds is None else sample.bounds[:, chosen]
    drawn = sample._replace(values=sample.values[chosen], weights=weights, bounds=bounds)
    return bin_shares(drawn, edges)[0] / weights.sum()


def _independent(sample: Samples, within: Samples | None = None) -> float:
    """Return the effective sample size, at most that of all places of the surface."""
    counts = [independent_places(part.values, part.places) for part in (sample, within) if part is not None]
    weights = sample.weights if sample.on_debris is None else None
    return float(min(counts) * _effective_count(weights, sample.values.size) / sample.values.size)


def _resampled(sample: Samples, count: float, resampling: Resampling) -> Iterator[tuple]:
    """Yield resamples of ``count`` values, and of their weights (or None), in arrays (some resamples, draws)."""
    rng = np.random.default_rng(resampling.seed)
    # largest number of draws of a resample; deviations of the mean of fewer draws are scaled
    draws = min(max(round(count), 2), 20_000)
    # number of values in memory while resampling: 40 MB
    step = max(1, 5_000_000 // draws)
    for start in range(0, resampling.resamples, step):
        chosen = rng.integers(0, sample.values.size, (min(step, resampling.resamples - start), draws))
        yield sample.values[chosen], None if sample.weights is None else sample.weights[chosen]


def _intervals(sample: Samples, count: float, labels: list[str], resampling: Resampling) -> np.ndarray:
    """Return the lower and upper ends, (2, statistics), for ``count`` independent places."""
    from scipy.special import ndtr, stdtrit  # of `scipy.stats`, whose checks take longer than all else here

    confidence = resampling.confidence
    if sample.values.size < FEWEST_SAMPLES:
        return np.array([_small_sample_ends(label, sample, max(count, 1.5), confidence) for label in labels]).T
    moments = ["mean", *(label for label in labels if label in ("std", RELATIVE_STD))]
    drawn = [[_estimate(label, *resamples) for label in moments] for resamples in _resampled(sample, count, resampling)]
    drawn_moments = np.concatenate(drawn, axis=1)
    means = drawn_moments[0]
    degrees = max(count, 2.0) - 1
    low = ndtr(stdtrit(degrees, 0.5 - confidence / 2))
    ends = dict(zip(moments, np.quantile(drawn_moments, [low, 1 - low], axis=1).T))
    spread = float(_mean((sample.values - _mean(sample.values, sample.weights)) ** 2, sample.weights) ** 0.5)
    # factor on deviations: samples that are alike scatter less about their own mean than about the true one
    times = spread / float(np.sqrt(degrees) * means.std()) if means.std() > 0 else 1.0
    return np.array([_interval_ends(label, sample, ends.get(label), times, count, confidence) for label in labels]).T


def _largest(ds: xr.Dataset, name: str) -> float:
    """Return the pull-off force from a smooth flat as the bound of pull-off forces, NaN for other variables."""
    is_bounded = name == "pull_off_force" and {"sphere_radius", "work_of_adhesion"} <= set(ds.coords)
    return smooth_pull_off(ds) if is_bounded else np.nan


def _shows_two_populations(sample: Samples, largest: float) -> bool:
    """Return whether the places, or a largest value, determine the means off and on debris."""
    if sample.on_debris is None:
        return False
    places = int(sample.on_debris.sum())
    return sample.values.size - places > 1 and (places > 1 or np.isfinite(largest))


def _two_population_ends(sample: Samples, share: float, largest: float, resampling: Resampling) -> np.ndarray:
    """Return the ends of the mean's interval for places off and on debris, whose ``share`` of the area is known.

    Their errors are independent (Zou & Donner 2008). Fewer than two places on debris show only that its mean lies
    between 0 and the largest value.
    """
    on_debris = np.asarray(sample.on_debris)
    off, on = (_part(sample, flags) for flags in (~on_debris, on_debris))
    off_ends = _intervals(off, _independent(off), ["mean"], resampling)[:, 0]
    if on.values.size < 2:
        return (1 - share) * off_ends + share * np.array([0.0, max(largest, off_ends[1], *on.values)])
    on_ends = _intervals(on, _independent(on), ["mean"], resampling)[:, 0]
    means = np.array([off.values.mean(), on.values.mean()])
    weights = np.array([1 - share, share])
    offsets = weights[:, None] * (np.array([off_ends, on_ends]) - means[:, None])
    return weights @ means + np.array([-1, 1]) * np.hypot(*offsets)


def _part(sample: Samples, flags: np.ndarray) -> Samples:
    """Return some of the samples, which count equally."""
    places = None if sample.places is None else sample.places[flags]
    return Samples(sample.values[flags], None, places, 0)


def _bounded_ends(sample: Samples, count: float, labels: list[str], resampling: Resampling) -> np.ndarray:
    """Return the ends of intervals that hold wherever limited values lie between their bounds."""
    assert sample.bounds is not None
    if labels == [RELATIVE_STD]:
        (std_low, mean_low), (std_high, mean_high) = _bounded_ends(sample, count, ["std", "mean"], resampling)
        return np.array([[std_low / mean_high], [std_high / mean_low if mean_low > 0 else np.inf]])
    low, high = finite_ends(sample.bounds)
    parts = []
    with np.errstate(over="ignore", invalid="ignore"):
        for values in (
            low,
            high,
            least_spread_values(np.array([low, high])),
            most_spread_values(np.array([low, high])),
        ):
            bounded = sample._replace(values=values, bounds=None)
            parts.append(_intervals(bounded, count, labels, resampling))
    is_std = np.array(labels) == "std"
    ends = np.array([np.where(is_std, parts[2][0], parts[0][0]), np.where(is_std, parts[3][1], parts[1][1])])
    return with_infinity(ends)


def _interval_ends(label: str, sample: Samples, ends: Any, times: float, count: float, confidence: float) -> np.ndarray:
    """Return the ends of one statistic's interval, for ``count`` independent places.

    Of quantiles by Clopper and Pearson; of mean and std the percentiles of the resamples, ``ends``, ``times`` as wide.
    """
    from scipy.special import betaincinv  # of `scipy.stats.beta`, whose checks take longer than all else here

    values = sample.values
    estimate = _estimate(label, values, sample.weights)
    n = values.size
    low = values.min()
    high = values.max()
    if label in ("std", RELATIVE_STD):
        scaled = estimate * (ends / estimate) ** times if estimate > 0 else ends
        largest = 0.5 * (high - low) * np.sqrt(n / (n - 1)) if label == "std" else np.sqrt(n)
        return np.clip(scaled, 0.0, largest)
    if label == "mean":
        ends = estimate + (ends - estimate) * times
        # a tail that resamples do not show
        is_hidden = low > 0 and _std(np.log(values), sample.weights) > _PRIOR_SPREAD
    else:  # by Clopper and Pearson's interval of a share among independent draws
        share = float(label[1:]) / 100
        below = count * share
        above = count * (1 - share)
        tail = 0.5 - confidence / 2
        smallest_share = betaincinv(below, above + 1, tail) if below > 0 else 0.0
        largest_share = betaincinv(below + 1, above, 1 - tail) if above > 0 else 1.0
        ends = _quantile(values, [float(smallest_share), float(largest_share)], sample.weights)
        # the quantile may lie beyond all samples
        is_hidden = min(below, above) < -np.log(tail)
    if is_hidden:
        law = _small_sample_ends(label, sample, max(count, 1.5), confidence)
        ends = np.array([min(ends[0], law[0]), max(ends[1], law[1])])
    return np.clip(ends, low, high) if label == "mean" else ends


def _small_sample_ends(label: str, sample: Samples, count: float, confidence: float) -> np.ndarray:
    """Return the ends of an interval of few samples, taken as log-normal, or as normal if any is negative."""
    from scipy.special import gammaincinv, ndtri, stdtrit
    from scipy.stats import nct

    values, weights = sample.values, sample.weights
    estimate = _estimate(label, values, weights)
    tails = np.array([0.5 - confidence / 2, 0.5 + confidence / 2])
    lost = (1 - 1 / _effective_count(weights, values.size)) / (1 - 1 / count)  # to the mean of like places
    if label in ("std", RELATIVE_STD):
        chi_squared = 2 * gammaincinv(0.5 * (count - 1), tails[::-1])
        return estimate * np.sqrt(lost * (count - 1) / chi_squared)
    positive = values.min() >= 0 and values.max() > 0
    # lower bound of samples, as a fraction of the mean, before the logarithm
    law = np.log(np.maximum(values, 0.01 * values.mean())) if positive else values
    middle = _mean(law, weights)
    variance = _std(law, weights) ** 2 * lost
    if label == "mean" and positive:
        ends = _cox_ends(middle, variance, count, tails)
    elif label == "mean":
        ends = middle + stdtrit(count - 1, tails) * np.sqrt(variance / count)
    else:
        away = ndtri(np.clip(float(label[1:]) / 100, 1e-6, 1 - 1e-6)) * np.sqrt(count)
        ends = middle + nct.ppf(tails, count - 1, away) * np.sqrt(variance / count)
    ends = np.exp(ends) if positive else ends
    return np.array([min(ends[0], estimate), max(ends[1], estimate)])


def _cox_ends(middle: float, variance: float, count: float, tails: np.ndarray) -> np.ndarray:
    """Return the ends of ln(mean) of log-normal samples: of their own variance, or with the prior's, if narrower."""
    from scipy.special import stdtrit

    freedom = count - 1
    more = freedom + _PRIOR_FREEDOM
    pooled = (variance * freedom + _PRIOR_SPREAD**2 * _PRIOR_FREEDOM) / more
    candidates = [  # ln E[exp z] = E[z] + var(z)/2 of a normal z
        middle + spread / 2 + stdtrit(degrees, tails) * np.sqrt(spread / count + spread**2 / (2 * degrees))
        for spread, degrees in ((variance, freedom), (pooled, more))
    ]
    return min(candidates, key=np.ptp)
