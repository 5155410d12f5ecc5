"""The result in words: mean pull-off force, its uncertainty, what limits it, and the next step."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.numbers import is_too_wide, number, percent, quantity, with_interval
from ..vocabulary.text import sentences_on_lines
from . import bootstrap, pull_off, smooth_pull_off
from .sampling import at_first_preload, by_share, conditions

#: Source of error: the roughness that the scan does not show.
UNSEEN = "unseen roughness"

#: Sources of error, and what reduces them.
_REMEDIES = {
    "sampling": "solve more places, or scan a larger area",
    "mesh": "solve on a finer mesh",
    "interpolation": "measure a scan with finer pixels",
    "tip radius": "measure with a sharper tip",
    "noise": "average several scans, or scan more slowly",
    "work of adhesion": "measure the work of adhesion of this pair, for example with measured pull-offs",
    "modulus": "measure the modulus of the softer body",
    "sphere radius": "measure the radius of the sphere",
    "range of adhesion": "state the adhesion range of this pair",
}

#: Units and meaning of the scalars of an answer, and of a run's summary.
SCALARS = {
    "pull_off_force": ("nN", "mean pull-off force of the surface as scanned"),
    "low": ("nN", "lower end of its 95 % interval over places"),
    "high": ("nN", "upper end of its 95 % interval over places"),
    "best_estimate": ("nN", "mean pull-off force of the real surface"),
    "best_low": ("nN", "lower end of its 95 % interval by all known errors"),
    "best_high": ("nN", "upper end of its 95 % interval by all known errors"),
    "total_error": ("1", "relative error by all known sources"),
    "largest_error": ("1", "relative error by its largest source"),
    "critical_friction_velocity": ("m/s", "friction velocity of air that detaches the sphere, median place"),
    "critical_friction_velocity_low": ("m/s", "lower end of its 95 % interval"),
    "critical_friction_velocity_high": ("m/s", "upper end of its 95 % interval"),
    "wall_shear_stress": ("Pa", "wall shear stress of air that detaches the sphere, median place"),
    "wall_shear_stress_low": ("Pa", "lower end of its 95 % interval"),
    "wall_shear_stress_high": ("Pa", "upper end of its 95 % interval"),
    "places": ("1", "number of places that adhere"),
    "solved_places": ("1", "number of places that were solved"),
    "independent_places": ("1", "number of independent places with as accurate a mean"),
    "supports": ("1", "contacts that support the sphere, median place"),
    "mesh_error": ("1", "relative numerical error of the mean, due to mesh and step"),
    "smooth_share": ("1", "mean pull-off force over that from a smooth flat"),
}

#: Ratio of the ends of an interval above which the next step is to narrow it.
_WIDE = 4.0

#: Relative errors of places, of the simulation with adhesion and of rigid bodies.
_PLACE_ERRORS = ("pull_off_error", "cell_error")


def answer(ds: xr.Dataset) -> xr.Dataset:
    """Return the mean pull-off force with its 95 % interval, and print it with its condition and errors.

    Parameters
    ----------
    ds : Dataset
        A solution, for example of `adhesive`, `rigid`, `superpose` or `extrapolated`, or its `pull_off`, or the group
        ``statistics/summary`` of a run. Of several preloads the first.

    Returns
    -------
    Dataset
        The scalars of `SCALARS`: ``pull_off_force`` (nN), the mean over the places that adhere, ``low`` and ``high``,
        the ends of its interval, ``places``, ``solved_places``, ``independent_places``, ``mesh_error`` and
        ``smooth_share``; NaN if unknown, as the ends are for too few independent places.

    Raises
    ------
    ValueError
        If ``ds`` contains no force, or no place adheres.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0])})
    >>> mean = answer(schema.label(pull))
    Mean pull-off 590 nN (95 % interval 230 … 1610 nN, 3 places) for the surface as scanned.
    Next: solve more places, or scan a larger area, since 3 places, 3 of them independent, give a wide interval.
    """
    ds = schema.entered(ds)
    if "pull_off_mean" in ds:  # of `extrapolated`
        ends = {"pull_off_force": "pull_off_mean", "low": "pull_off_lower", "high": "pull_off_upper"}
        mean = xr.Dataset({name: ds[source].variable for name, source in ends.items()}, schema.travelling(ds))
        mean.attrs["assumed"] = ds.attrs["assumed"]
    else:
        mean = ds if "solved_places" in ds else mean_pull_off(ds)  # a run's summary is one already
    print(sentences_on_lines(headline(mean)))
    return mean


def mesh_error(pull: xr.Dataset) -> float:
    """Return the relative numerical error of the mean pull-off, if errors of places add; NaN if unknown.

    Errors are weighted by the force of each place, as in the mean.
    """
    own = next((name for name in _PLACE_ERRORS if name in pull), None)
    if own is None:
        return np.nan
    force = pull["pull_off_force"].where(pull[own].notnull())
    return float(by_share(force * abs(pull[own])).mean() / by_share(force).mean())


def mean_pull_off(ds: xr.Dataset) -> xr.Dataset:
    """Return the Dataset of `answer` without printing."""
    if "pull_off_force" not in ds and "force" not in ds:
        raise ValueError("expected a solution, or its pull_off, found neither; run adhesive, rigid or superpose first")
    pull = at_first_preload(ds if "pull_off_force" in ds else pull_off(ds))
    force = pull["pull_off_force"].load()
    _refuse_several(force)
    if not force.dims and not {"subregion", "subregion_x"} & set(force.coords):
        raise ValueError(
            "expected places along subregion, found a single force; take the answer before the mean over places, or "
            "of one place, isel(subregion=0)"
        )
    known = int(force.notnull().sum())
    if not (force > 0).any():
        raise ValueError(f"pull_off_force: expected at least one place that adheres, found none of {force.size}")
    ends = bootstrap(pull[["pull_off_force"]], "pull_off_force", statistics=["mean"]) if known > 1 else None
    names = ("low", "high", "independent_places")
    low, high, independent = (np.nan if ends is None else float(ends[name].item()) for name in names)
    mean = float(by_share(force).mean())
    smooth = smooth_pull_off(pull) if {"sphere_radius", "work_of_adhesion"} <= set(pull.coords) else 0.0
    scalars = {
        "pull_off_force": mean,
        "low": low,
        "high": high,
        "places": known,
        "solved_places": force.size,
        "independent_places": independent,
        "mesh_error": mesh_error(pull),
        "smooth_share": mean / smooth if smooth > 0 else np.nan,
    }
    out = schema.record(with_units(xr.Dataset(scalars, coords=schema.travelling(pull))), "answer", pull)
    return out.assign_attrs(rigid="yes") if "cell_error" in pull and "pull_off_error" not in pull else out


def scalar_values(summary: xr.Dataset) -> dict[str, float]:
    """Return the scalars of a summary by name, in their units; NaN where it lacks one."""
    return {name: float(summary[name]) if name in summary else np.nan for name in SCALARS}


def with_units(summary: xr.Dataset) -> xr.Dataset:
    """Return scalars with their units and meaning."""
    for name in set(SCALARS) & set(summary.data_vars):
        units, meaning = SCALARS[name]
        summary[name].attrs = {"units": units, "long_name": meaning}
    return summary


def best_estimate(run: Mapping[str, xr.Dataset]) -> tuple[float, float, float] | None:
    """Return a run's best estimate and the ends of its interval, nN, or None."""
    if "statistics/extrapolated" not in run:
        return None
    extrapolated = run["statistics/extrapolated"]
    mean, lower, upper = (float(extrapolated[f"pull_off_{name}"]) for name in ("mean", "lower", "upper"))
    return (mean, lower, upper) if np.isfinite(mean) else None


def _refuse_several(force: xr.DataArray):
    """Raise for several scans or conditions, with advice on how to select or pool them."""
    others = conditions(force)
    if "scan" in others:
        raise ValueError(
            "expected one scan, found several; take statistics.pooled(pull, 'pull_off_force') for all, or isel(scan=0)"
        )
    if others:
        ways = ", ".join(f"{dim}=0" for dim in others)
        raise ValueError(
            f"expected one condition, found several along {', '.join(others)}; take "
            f"bootstrap(statistics=['mean']) of its pull_off for all, or one by isel({ways})"
        )


def headline(summary: xr.Dataset) -> str:
    """Return an answer or a run's summary in words, for all doors alike."""
    if "pull_off_force" not in summary:
        return str(summary.attrs.get("missing", ""))
    value = scalar_values(summary)
    if "assumed" in summary.attrs:
        words = with_interval(value["pull_off_force"], value["low"], value["high"])
        return f"Best estimate {words}, with the roughness below the pixel. {summary.attrs['assumed']}"
    mean, spread = value["pull_off_force"], _places_in_words(summary)
    opening = f"{quantity(mean)} ("
    if np.isfinite(value["low"]):
        opening = with_interval(mean, value["low"], value["high"]).removesuffix(")") + ", "
    if np.isfinite(value["total_error"]):
        spread += f"; ± {percent(value['total_error'])} with all known errors"
    elif np.isfinite(error := value["mesh_error"]):
        rigid = "rigid" in summary.attrs
        cells = f"overestimated by about {percent(error)} due to the size of cells"
        spread += f"; {cells}" if rigid else f"; ± {percent(error)} numerical error"
    air = f" at {percent(summary['humidity'])} relative humidity" if "humidity" in summary.coords else ""
    sentences = [f"Mean pull-off {opening}{spread}) for the surface as scanned{air}.", *_limits(summary, value)]
    if np.isfinite(best := value["best_estimate"]):
        effect = "lowers it" if best < mean else "hardly changes it"
        shown = summary.attrs.get("finest_shown")
        finer = f"finer than {number(shown, 'nm')}" if shown is not None else "finer than the pixel"
        ends = value["best_low"], value["best_high"]
        estimate = with_interval(best, *ends, why_wide="", name="interval" * is_too_wide(*ends))
        sentences.append(f"Roughness {finer}, which this scan does not show, {effect}: best estimate {estimate}.")
    sentences.append(str(summary.attrs.get("not_extrapolated", "")))
    if source := summary.attrs.get("largest_source"):
        words = "choice of places" if source == "sampling" else source
        sentences.append(f"The largest uncertainty is the {words} (± {percent(value['largest_error'])}).")
    return " ".join(filter(None, [*sentences, _next_step(summary, value)]))


def _limits(summary: xr.Dataset, value: Mapping[str, float]) -> list[str]:
    """Return sentences on a known bias above 10 %, and on a mean above that of a smooth flat."""
    sentences, mean = [], value["pull_off_force"]
    if abs(bias := summary.attrs.get("known_bias", 0.0)) > 0.1:
        sentences.append(f"Without its known bias, {percent(abs(bias))}, it is {quantity(mean * (1 - bias))}.")
    if value["smooth_share"] > 1:
        limit = "possible for stiff bodies, but not for soft ones"
        if "rigid" in summary.attrs:
            limit = "possible only for a surface shaped to fit the sphere: use adhesive, or a finer mesh"
        sentences.append(f"It is {percent(value['smooth_share'])} of the pull-off from a smooth flat, {limit}.")
    return sentences


def _places_in_words(summary: xr.Dataset) -> str:
    """Return the number of places, and whether they are too few for an interval."""
    known, count = int(summary["places"]), int(summary["solved_places"])
    words = f"{known} place{'s' * (known > 1)}" + f" of {count}" * (known < count)
    few = "independent_places" in summary and np.isnan(summary["low"]) and summary["independent_places"].notnull()
    return words + ", too few independent ones for an interval" * bool(few)


def _next_step(summary: xr.Dataset, value: Mapping[str, float]) -> str:
    """Return one sentence on the next step; empty if the errors suggest none."""
    advice = summary.attrs.get("advice", "")
    low, high, independent = (value[name] for name in ("low", "high", "independent_places"))
    if not advice and np.isfinite(independent) and (np.isnan(low) or high > _WIDE * low):
        effect = "are too few for an interval" if np.isnan(low) else "give a wide interval"
        counts = f"{number(value['places'])} places, {number(independent, digits=2)} of them independent,"
        advice = f"solve more places, or scan a larger area, since {counts} {effect}"
    advice = advice or _REMEDIES.get(summary.attrs.get("largest_source", ""))
    return f"Next: {advice}." if advice else ""
