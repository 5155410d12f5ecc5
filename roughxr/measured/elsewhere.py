"""A test on other surfaces: the work of adhesion fitted on one must predict the pull-off forces on the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.units import Places, fraction
from ..vocabulary.verbs import verb
from .comparison import compare
from .fitting import COUNTED, PLACES, SHOWN, fit_pair, method_error, predicted, unseen

_ENDS = ("", "_low", "_high")


@verb
def predict_others(
    surfaces: Mapping[str, tuple[xr.Dataset, xr.Dataset]],
    *,
    fit_on: str,
    statistics: Sequence[str] = ("mean", "std"),
    method: str = "adhesive",
    subregions: Places = None,
    confidence: float = 0.95,
    resamples: int = 399,
    seed: int = 0,
    below: Mapping[str, xr.Dataset] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Fit the work of adhesion on one surface, predict the others, and tell whether their measured forces agree.

    Parameters
    ----------
    surfaces : mapping of str to (Dataset, Dataset)
        For each surface a scan with an assigned pair, and the forces measured on it, from `open_pull_off`.
    fit_on : str
        The surface that the work of adhesion is fitted on, see `fit_pair`.
    statistics : sequence of str
        Statistics that must agree, see `bootstrap`.
    method : {"adhesive", "superposed"}
        How pull-offs are predicted: by the direct simulation, or by superposed asperities.
    subregions, confidence, **options
        As for `fit_pair`.
    resamples, seed : int, int
        Of the bootstraps of the statistics.
    below : mapping of str to Dataset, optional
        For each surface the result of `continued`, see `fit_pair`: the verdict then counts what the scans do not show.

    Returns
    -------
    Dataset
        Along (surface, statistic), the fitted surface included: ``predicted`` (nN) at the fitted work of adhesion, with
        ``predicted_low`` and ``predicted_high``, between which the measured statistic is expected from the fit's
        interval and the scatter between both predicted and measured places; ``measured``; ``inside``, whether it lies
        between them; ``ratio``, measured over predicted. Along ``surface`` ``was_fitted``. Also the fit, see
        `fit_pair`. The attribute ``verdict`` sums this up in words.

    Raises
    ------
    ValueError
        If there is no second surface, the one to fit on is unknown, or the fit's interval is open, so that nothing can
        be predicted.

    Notes
    -----
    The errors are taken as independent and their logarithms added in squares. An error common to all surfaces, such as
    that of a spring constant, is absorbed by the fit and does not show here. The ratio of superposed asperities to the
    simulation is not: it differs from surface to surface, by a factor of 1.6 in standard deviation, and every interval
    holds this. With method="superposed" only a foreign surface that is off by several times is therefore found out.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans.synthetic import self_affine
    >>> make = {"rms": 2.0, "hurst": 0.9, "rolloff": 300}
    >>> scans = [self_affine((96, 96), 10, seed=seed, **make).contact.assign_pair(
    ...     sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1) for seed in (1, 2)]
    >>> pulls = [one.assign_coords(work_of_adhesion=0.3).contact.pull_off_map(subregions=(7, 7)) for one in scans]
    >>> found = predict_others(dict(zip("ab", zip(scans, pulls))), fit_on="a", method="superposed", resamples=99)
    >>> bool(found.inside.sel(surface="b", statistic="mean"))
    True
    """
    fraction(confidence, "confidence")
    schema.one_of(fit_on, tuple(surfaces), "fit_on")
    if len(surfaces) < 2:
        raise ValueError(f"surfaces: expected at least one other than {fit_on!r}, found none")
    if below is not None and (lacking := set(surfaces) - set(below)):
        raise ValueError(f"below: expected every surface, found none for {', '.join(sorted(lacking))}")
    chance = {"confidence": confidence, "resamples": resamples, "seed": seed}
    schema.one_of(method, ("adhesive", "superposed"), "method")
    given = {"subregions": PLACES[method] if subregions is None else subregions, **options}
    under = below or dict.fromkeys(surfaces)
    fit = fit_pair(*surfaces[fit_on], method=method, confidence=confidence, below=under[fit_on], **given)
    works = _works(fit, fit_on)
    law = {"law": fit.attrs["law"]} if method == "adhesive" else {}
    parts = [
        _compared(*both, works, method, given | law, statistics, chance, under[name]) for name, both in surfaces.items()
    ]
    out = xr.concat(parts, xr.DataArray(list(surfaces), dims="surface", name="surface"))
    out["was_fitted"] = ("surface", [name == fit_on for name in surfaces])
    out = schema.label(out.merge(fit.drop_attrs(deep=False), compat="override"))
    for name in ("predicted", "predicted_low", "predicted_high", "measured"):
        out[name].attrs["units"] = "nN"
    out.attrs = {key: fit.attrs[key] for key in ("method", "confidence", "not_identifiable")}
    out.attrs |= {"fit_on": fit_on, "verdict": f"{_verdict(out, fit_on)}; {COUNTED if below else SHOWN}"}
    return schema.record(out, "predict_others", surfaces[fit_on][0], fit_on=fit_on, method=method, **chance, **options)


def _works(fit: xr.Dataset, fit_on: str) -> list[float]:
    """Return the fitted work of adhesion and the ends of its interval."""
    works = [float(fit[name]) for name in ("fitted_work_of_adhesion", "fitted_work_low", "fitted_work_high")]
    if not np.isfinite(works).all():
        raise ValueError(
            f"fit_on: expected a surface whose forces tell the work of adhesion, found {fit_on!r}: "
            f"{fit.attrs['not_identifiable']}"
        )
    return works


def _compared(ds, measured, works, method, given, statistics, chance, below) -> xr.Dataset:
    """Return the statistics of one surface, predicted with their interval and measured."""
    factor, error = unseen(predicted(ds, method, given), below) if below is not None else (1.0, 0.0)
    forces = [predicted(ds.assign_coords(work_of_adhesion=work), method, given) for work in works]
    forces = [one.assign(pull_off_force=factor * one["pull_off_force"]) for one in forces]
    common = np.hypot(np.nan_to_num(method_error(forces[0], method)), error)
    common *= NormalDist().inv_cdf(0.5 + chance["confidence"] / 2)
    sides = [compare(one, measured, statistics=statistics, shift=None, **chance) for one in forces]
    own = sides[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        p, m = ({end: np.log(own[f"{name}{end}"].values) for end in _ENDS} for name in ("predicted", "measured"))
        less, more = (np.log(one["predicted"].values) for one in sides[1:])
    low = p[""] - np.sqrt((p[""] - less) ** 2 + (p[""] - p["_low"]) ** 2 + (m["_high"] - m[""]) ** 2 + common**2)
    high = p[""] + np.sqrt((more - p[""]) ** 2 + (p["_high"] - p[""]) ** 2 + (m[""] - m["_low"]) ** 2 + common**2)
    out = own[["predicted", "measured", "ratio"]].drop_attrs(deep=False)
    out["predicted_low"], out["predicted_high"] = ("statistic", np.exp(low)), ("statistic", np.exp(high))
    return out.assign(inside=("statistic", (low <= m[""]) & (m[""] <= high)))


def _verdict(out: xr.Dataset, fit_on: str) -> str:
    """Return a sentence on which surfaces agree."""
    others = out.isel(surface=np.flatnonzero(~out["was_fitted"].values))
    said = []
    for name in others["surface"].values:
        one = others.sel(surface=name)
        off = [str(label) for label in one["statistic"].values[~one["inside"].values]]
        said.append(f"{name}: {' and '.join(off)} outside" if off else f"{name}: inside")
    return f"fitted on {fit_on}; " + "; ".join(said)
