"""The effective sample size of correlated places."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np


class Correlogram(NamedTuple):
    """Correlation of samples in bins of their distance."""

    correlation: np.ndarray
    pairs: np.ndarray  # in each bin, of all samples


def correlogram(values: np.ndarray, places: np.ndarray) -> Correlogram:
    """Return the correlation of samples against their distance, in bins as wide as their mean spacing."""
    values = normal_scores(values)
    chosen, i, j, bins = _neighbours(np.ascontiguousarray(places, dtype=float).tobytes())
    deviation = values[chosen] - values[chosen].mean()
    pairs = np.bincount(bins)
    total = np.bincount(bins, deviation[i] * deviation[j])
    variance = (deviation**2).mean()
    correlation = total / np.maximum(pairs, 1) / (variance if variance > 0 else 1.0)
    return Correlogram(correlation, pairs * (values.size / chosen.size) ** 2)


@lru_cache(maxsize=4)  # all variables of a result, and their parts, lie at the same places
def _neighbours(coordinates: bytes) -> tuple[np.ndarray, ...]:
    """Return the samples used of places as bytes, both of each pair of neighbours, and its bin."""
    from scipy.spatial import cKDTree

    places = np.frombuffer(coordinates).reshape(-1, 2)
    # upper ends of the bins up to the largest distance of the correlation
    ends = mean_spacing(places) * np.arange(1.5, 7.0)
    # largest number of samples for the correlation: more samples take longer without better accuracy
    chosen = np.random.default_rng(0).permutation(len(places))[:2000]
    # nearer than the last end, at which neighbours lie on some grids, and would have a bin of their own
    i, j = cKDTree(places[chosen]).query_pairs((1 - 1e-9) * ends[-1], output_type="ndarray").T
    return chosen, i, j, np.digitize(np.hypot(*(places[chosen[i]] - places[chosen[j]]).T), ends)


def normal_scores(values: np.ndarray) -> np.ndarray:
    """Return the normal quantiles of the samples' ranks."""
    from scipy.special import ndtri
    from scipy.stats import rankdata

    largest = np.abs(values).max(initial=0.0) or 1.0
    alike = np.round(values / largest, 10)  # an asperity can give equal forces, but for rounding, at several places
    return ndtri((rankdata(alike) - 0.5) / values.size)


def independent_places(values: np.ndarray, places: np.ndarray | None) -> float:
    """Return the effective sample size, the number of independent samples with a mean of equal variance.

    Few samples do not determine their correlation: 1/n is averaged over exponential and Gaussian correlations of all
    lengths up to half the side, by their likelihood (Berger, De Oliveira & Sansó, J. Am. Stat. Assoc. 96 (2001) 1361).

    References
    ----------
    Bayley & Hammersley (1946), The "effective" number of independent observations in an autocorrelated series;
    Geyer, Stat. Sci. 7 (1992) 473, for the initial positive part of the correlation of many samples.
    """
    n = values.size
    if places is None or n < 3 or np.ptp(values) == 0:
        return float(n)
    # up to this number of samples the correlation is averaged over all that fit, since a correlogram would be too noisy
    if n <= 100:
        return _averaged_independent_places(values, places)
    lags = correlogram(values, places)
    effective = float(n)
    for _ in range(5):  # subtracting the mean removes 1/effective of the correlation
        correlation = lags.correlation + (1 - lags.correlation) / effective
        initial_positive = np.cumprod(correlation > 0).astype(bool)
        effective = n**2 / (n + 2 * (lags.pairs * correlation)[initial_positive].sum())
    return float(np.clip(effective, 1.0, n))


def _averaged_independent_places(values: np.ndarray, places: np.ndarray) -> float:
    """Return the harmonic mean of the effective sample size over correlations, weighted by their likelihood.

    The likelihood is integrated over mean and variance of the samples' normal scores.
    """
    n = values.size
    scores = normal_scores(values)
    models = _correlation_models(np.ascontiguousarray(places, dtype=float).tobytes())
    likelihood = []
    for inverse, sums, total, determinant in zip(*models[:4]):
        off = scores - sums @ scores / total
        likelihood.append(-0.5 * (determinant + (n - 1) * np.log(max(off @ inverse @ off, 1e-300))))
    weights = np.exp(np.array(likelihood) - max(likelihood))
    return float(1 / np.average(models.mean, weights=weights))


class _CorrelationModels(NamedTuple):
    """Correlations of samples at places: their inverse matrices, log determinants with a free mean, and means."""

    inverse: np.ndarray
    column_sums: np.ndarray  # of the inverse
    total: list[float]  # their sum
    log_determinant: np.ndarray
    mean: np.ndarray


@lru_cache(maxsize=4)  # all variables of a result, and their parts, lie at the same places
def _correlation_models(coordinates: bytes) -> _CorrelationModels:
    """Return exponential and Gaussian correlations of all lengths up to half the side, of places as bytes."""
    places = np.frombuffer(coordinates).reshape(-1, 2)
    n = len(places)
    distance = np.hypot(*(places[:, None] - places).T) / mean_spacing(places)
    lengths = 2.0 ** np.arange(-2.5, np.log2(0.5 * np.sqrt(n)) + 0.01, 0.5)
    relative = distance / lengths[:, None, None]
    shapes = np.stack([np.exp(-relative), np.exp(-(relative**2) / 2)], axis=1).reshape(-1, n, n)
    # part of the variance without correlation between neighbours; it keeps matrices well conditioned
    nugget = 0.05
    correlation = (1 - nugget) * shapes + nugget * np.eye(n)
    inverse = np.linalg.inv(correlation)
    determinant = np.linalg.slogdet(correlation)[1] + np.log(inverse.sum(axis=(1, 2)))
    totals = [matrix.sum() for matrix in inverse]
    return _CorrelationModels(inverse, inverse.sum(axis=1), totals, determinant, correlation.mean(axis=(1, 2)))


def mean_spacing(places: np.ndarray) -> float:
    """Return the side (nm) of the square that one sample occupies on average."""
    return float(np.sqrt(np.prod(_extent(places)) / len(places)))


def _extent(places: np.ndarray) -> np.ndarray:
    """Return the sides of the rectangle that the samples cover: half a spacing beyond the outermost."""
    span = np.ptp(places, axis=0)
    columns = np.array([np.unique(np.round(axis, 6)).size for axis in places.T])
    on_grid = columns.prod() == len(places) and (columns > 1).all()
    if on_grid:
        return span * columns / (columns - 1)
    side = np.sqrt(max(span.prod(), 1e-300) / len(places)) if span.all() else max(span.max(), 1.0) / len(places)
    return span + side
