"""Predicted beside measured pull-off forces: by quantiles, as whole distributions, and place by place where known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..statistics import bootstrap
from ..statistics.places import independent_places
from ..statistics.sampling import Samples, counted_equally, samples
from ..vocabulary import schema
from ..vocabulary.units import Quantity, fraction, magnitude
from .registration import Match, matched

_NAME = "pull_off_force"

#: Probabilities of the quantiles that are compared.
_LEVELS = np.linspace(0.01, 0.99, 99)

#: A shift is rejected if its correlation has a larger p-value than this.
_BY_CHANCE = 0.01

STATISTICS = ("mean", "std", "q5", "q25", "q50", "q75", "q95")


def compare(
    predicted: xr.Dataset,
    measured: xr.Dataset,
    *,
    statistics: Sequence[str] = STATISTICS,
    confidence: float = 0.95,
    resamples: int = 999,
    shift: str | Sequence[Quantity] | None = "find",
) -> xr.Dataset:
    """Compare predicted pull-off forces with measured ones.

    Parameters
    ----------
    predicted : Dataset
        With ``pull_off_force`` along ``subregion``, or a map of it: from `pull_off`, `pull_off_map`, `rigid`.
    measured : Dataset
        The same, from `open_pull_off`, or a second prediction.
    statistics : sequence of str
        Statistics whose ratios are reported, see `bootstrap`.
    confidence, resamples
        As for `bootstrap`.
    shift : "find", (length, length) or None
        Offset that maps measured places to predicted ones, along x and y. "find": search it within a quarter of the
        prediction's extent, if both places are known and the prediction lies on a grid. None: do not compare places.

    Returns
    -------
    Dataset
        Along ``statistic``: ``predicted`` and ``measured`` with ``…_low`` and ``…_high``, and ``ratio``, measured over
        predicted, with its interval; NaN where one of them is not positive. Along ``probability``:
        ``predicted_quantile`` and ``measured_quantile``. ``distribution_distance``, Kolmogorov's, and its
        ``distribution_p_value``, for the effective numbers of independent samples ``predicted_places`` and
        ``measured_places``. Where places can be compared, ``shift_x``, ``shift_y`` (nm), ``place_correlation`` (of
        normal scores) and ``place_p_value``; where this is below 0.01, also ``predicted_force`` and ``measured_force``
        along the measured ``subregion``, else the shift is NaN. The attribute ``places`` says which case applies.

    Raises
    ------
    ValueError
        If either has no pull-off forces along its places, or fewer than two of them.

    Notes
    -----
    Intervals are from a block bootstrap. The ratio adds the errors of both logarithms in squares, as independent ones
    (Donner & Zou, Stat. Methods Med. Res. 21 (2012) 347). At the same places of one surface its interval is too wide.
    The p-value counts the independent places of the mean. Tails have more of them: the test may miss differences, but
    rarely reports a false one.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> made = [xr.Dataset({"pull_off_force": ("subregion", f * rng.gamma(9, 1.0, 400))}) for f in (1.0, 1.5)]
    >>> found = compare(*made).sel(statistic="mean")
    >>> bool(found.ratio_low < 1.5 < found.ratio_high), bool(found.distribution_p_value < 0.001)
    (True, True)
    """
    predicted, measured = schema.entered(predicted), schema.entered(measured)
    fraction(confidence, "confidence")
    both = [_samples(ds, words) for ds, words in ((predicted, "predicted"), (measured, "measured"))]
    out = _statistics(both, list(statistics), confidence, resamples)
    for name, forces in zip(("predicted", "measured"), both):
        out[f"{name}_quantile"] = ("probability", np.quantile(forces.values, _LEVELS))
    out = out.assign_coords(probability=_LEVELS)
    out = out.assign(_tested(*both))
    out = schema.label(out.merge(_places(both[0], both[1], shift)))
    for name in ("predicted", "measured"):
        for end in ("", "_low", "_high"):
            out[name + end].attrs["units"] = "nN"
    out.attrs = {"confidence": confidence, "measured_from": str(measured.attrs.get("source_file", "not stated"))}
    out.attrs |= {
        "places": _words(out, both, shift),
        "missing": "NaN where a value is not positive, or no shift is found",
    }
    return schema.record(out, "compare", predicted, statistics=statistics, confidence=confidence, shift=shift)


def _samples(ds: xr.Dataset, words: str) -> Samples:
    if not isinstance(ds, xr.Dataset):
        raise TypeError(f"{words}: expected a Dataset with {_NAME}, found {type(ds).__name__}")
    if _NAME not in ds:
        names = ", ".join(map(str, ds.data_vars)) or "nothing"
        raise ValueError(f"{words}: expected {_NAME}, found {names}; take .contact.pull_off() of a solution first")
    sample = counted_equally(samples(ds, _NAME, quiet=True), "compare")
    if not (sample.values > 0).any():
        raise ValueError(
            f"{words}: expected at least one positive {_NAME}, found none of {sample.values.size}; "
            "if the file counts pulls as negative, state pulls='negative' where it is opened"
        )
    return sample


def _statistics(both: list[Samples], statistics: list[str], confidence: float, resamples: int) -> xr.Dataset:
    """Return the statistics of both with their intervals, and their ratios with theirs."""
    of = [_intervals(forces, statistics, confidence, resamples, k) for k, forces in enumerate(both)]
    out = xr.Dataset(coords={"statistic": statistics})
    for name, forces in zip(("predicted", "measured"), of):
        out = out.assign({name: forces[0], f"{name}_low": forces[1], f"{name}_high": forces[2]})
    return out.assign(dict(zip(("ratio", "ratio_low", "ratio_high"), _ratio(*of))))


def _intervals(forces: Samples, statistics: list[str], confidence: float, resamples: int, seed: int) -> list:
    ds = xr.Dataset({_NAME: ("subregion", forces.values)})
    if forces.places is not None:
        ds = ds.assign_coords(
            dict(zip(("subregion_x", "subregion_y"), (("subregion", axis) for axis in forces.places.T)))
        )
    out = bootstrap(ds, _NAME, statistics=statistics, confidence=confidence, resamples=resamples, seed=seed)
    block = out.sel(resampling="block")
    return [("statistic", block[name].values) for name in ("estimate", "low", "high")]


def _ratio(predicted: list, measured: list) -> list:
    """Return the ratio of two estimates and its interval, with independent errors of the logarithms."""
    with np.errstate(divide="ignore", invalid="ignore"):
        p, p_low, p_high, m, m_low, m_high = (
            np.log(np.where(ends > 0, ends, np.nan)) for _, ends in (*predicted, *measured)
        )
    low = m - p - np.hypot(m - m_low, p_high - p)
    high = m - p + np.hypot(m_high - m, p - p_low)
    return [("statistic", np.exp(ends)) for ends in (m - p, low, high)]


def _tested(predicted: Samples, measured: Samples) -> dict[str, Any]:
    """Return the distance of two distributions, and its p-value for their effective numbers of independent places."""
    from scipy.stats import ks_2samp, kstwobign

    distance = float(ks_2samp(predicted.values, measured.values, method="asymp").statistic)
    counts = [independent_places(forces.values, forces.places) for forces in (predicted, measured)]
    size = np.sqrt(counts[0] * counts[1] / sum(counts))
    return {
        "distribution_distance": distance,
        "distribution_p_value": float(kstwobign.sf((size + 0.12 + 0.11 / size) * distance)),
        "predicted_places": counts[0],
        "measured_places": counts[1],
    }


def _places(predicted: Samples, measured: Samples, shift: Any) -> xr.Dataset:
    """Return the comparison place by place; empty where places cannot be compared."""
    searched = isinstance(shift, str)
    if shift is None or predicted.places is None or measured.places is None:
        return xr.Dataset()
    given = None if searched and schema.one_of(shift, ("find",), "shift") else _shift(shift)
    try:
        match = matched(predicted, measured, shift=given)
    except ValueError:
        if not searched:
            raise
        return xr.Dataset()
    return _of_match(match, measured, certain=given is not None)


def _shift(shift: Any) -> tuple[float, float]:
    lengths = magnitude(shift, "nm", "shift") if not isinstance(shift, (tuple, list)) else shift
    if np.size(lengths) != 2:
        raise ValueError(f"shift: expected 'find', None or two lengths (along x, along y), found {shift!r}")
    along_x, along_y = (float(magnitude(length, "nm", "shift")) for length in lengths)
    return along_x, along_y


def _of_match(match: Match, measured: Samples, *, certain: bool) -> xr.Dataset:
    tells = certain or match.p_value < _BY_CHANCE
    out = {"shift_x": match.x, "shift_y": match.y} if tells else {"shift_x": np.nan, "shift_y": np.nan}
    ds = xr.Dataset({**out, "place_correlation": match.correlation, "place_p_value": match.p_value})
    if not tells:
        return ds
    ds["predicted_force"] = ("subregion", match.predicted)
    ds["measured_force"] = ("subregion", measured.values)
    assert measured.places is not None
    axes: dict[str, Any] = {f"subregion_{axis}": ("subregion", measured.places[:, k]) for k, axis in enumerate("xy")}
    return ds.assign_coords(subregion=np.arange(measured.values.size), **axes)


def _words(out: xr.Dataset, both: list[Samples], shift: Any) -> str:
    """Return a sentence on how places were compared."""
    if "shift_x" not in out:
        if shift is None:
            return "not compared: shift=None"
        unknown = [words for words, forces in zip(("predicted", "measured"), both) if forces.places is None]
        return f"not compared: {' and '.join(unknown)} of unknown place" if unknown else "not compared: no common grid"
    if np.isnan(out["shift_x"]):
        return "not compared: no shift correlates better than by chance"
    return "shift found" if isinstance(shift, str) else "shift as given"
