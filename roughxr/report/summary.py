"""The summary of a run: its answer with all known errors, computed once and read by every page, table and the shell."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..scans.regions import extent
from ..statistics import smooth_pull_off
from ..statistics.headline import answered, best_estimate
from ..statistics.sampling import at_first_preload
from ..vocabulary import schema
from ..vocabulary.numbers import interval, is_too_wide, number, percent, quantity

Run = Mapping[str, xr.Dataset]

BUDGET = "statistics/error_budget"
SUMMARY = "statistics/summary"

#: Shortest wavelength (nm) of a scan too coarse for the question: contacts at pull-off are smaller.
_COARSE_WAVELENGTH = 50.0

#: Entry of the error budget, and what reduces it.
_REMEDIES = {
    "sampling": "solve more places, or scan a larger area",
    "mesh": "solve on a finer mesh (--mesh)",
    "pixel": "measure a scan with finer pixels",
    "tip": "measure with a sharper tip",
    "work of adhesion": "measure the work of adhesion of this pair, for example with measured pull-offs",
    "modulus": "measure the modulus of the softer body",
    "sphere radius": "measure the radius of the sphere",
    "range of the law": "state the range of adhesion of this pair (adhesion_range)",
    "shorter waves": "measure a smaller scan with finer pixels",
}


def summary(run: Run) -> xr.Dataset:
    """Return the answer of a run as scalars with units, empty where the run holds no simulation with adhesion.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    Dataset
        The scalars of `answer`; ``total_error``, the relative error by all known sources; ``best_estimate``,
        ``best_low`` and ``best_high`` (nN), with the roughness below the pixel extrapolated; ``largest_error``, the
        largest entry of the error budget. NaN for what the run does not know. The attribute ``words`` is the headline.
    """
    if SUMMARY in run:
        return run[SUMMARY]
    if "statistics/adhesive" not in run:
        return xr.Dataset()
    pull = at_first_preload(run["statistics/adhesive"])
    if not bool((pull["pull_off_force"] > 0).any()):
        return xr.Dataset(attrs={"words": "The sphere adheres at no place."})
    finer = run.get("solutions/finer")
    change = None if finer is None else float(abs(mesh_change(run)).median())
    out = answered(pull, mesh_error=change)[0].load()
    best = best_estimate(run) or (np.nan, np.nan, np.nan)
    names = ("best_estimate", "best_low", "best_high")
    total, largest, source = np.nan, np.nan, ""
    if BUDGET in run:
        errors = run[BUDGET]["relative_error"]
        entries = errors.where(errors["entry"] != "shorter waves", drop=True).fillna(0.0)
        total, largest = float(run[BUDGET]["total_error"]), float(entries.max())
        source = str(entries["entry"][int(np.argmax(entries.values))].item())
    out = out.assign({**dict(zip(names, best)), "total_error": total, "largest_error": largest})
    for name, words in zip(names, ("best estimate of the mean pull-off force", "its lower end", "its upper end")):
        out[name].attrs = {"units": "nN", "long_name": words}
    out["total_error"].attrs = {"units": "1", "long_name": "relative error by all known sources"}
    out["largest_error"].attrs = {"units": "1", "long_name": "relative error by its largest source"}
    out.attrs["largest_source"] = source
    out.attrs["words"] = " ".join(filter(None, [*_sentences(out, run, pull), _next(out, run)]))
    return out


def headline(run: Run) -> str:
    """Return the mean pull-off with its errors, the best estimate, the largest error, and what to do next.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    str
        Empty where the run holds no simulation with adhesion.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [40.0])})
    >>> print(headline({"statistics/adhesive": pull}))
    Mean pull-off 40 nN (1 place) for the surface as scanned.
    """
    return str(summary(run).attrs.get("words", ""))


def mesh_change(run: Run) -> xr.DataArray:
    """Return the relative change of the pull-off on a finer mesh with shorter steps, at the places solved on both."""
    finer, whole = run["solutions/finer"], run["statistics/adhesive"]
    same = [
        int(np.argmin(np.hypot(whole["subregion_x"] - x, whole["subregion_y"] - y).values))
        for x, y in zip(finer["subregion_x"].values, finer["subregion_y"].values)
    ]
    coarse = finer["pull_off_force"].copy(data=whole["pull_off_force"].isel(subregion=same).values)
    return (coarse / finer["pull_off_force"] - 1).assign_attrs(units="1")


def _sentences(out: xr.Dataset, run: Run, pull: xr.Dataset) -> list[str]:
    mean, low, high = (float(out[name]) for name in ("pull_off_force", "low", "high"))
    known, count = int(out["places"]), pull["pull_off_force"].size
    places = f"{known} place{'s' * (known > 1)}" + f" of {count}" * (known < count)
    said = f"95 % interval {interval(low, high, 'nN')}, {places}" if np.isfinite(low) else places
    if np.isfinite(out["total_error"]):
        said += f"; ± {percent(out['total_error'])} with all known errors"
    elif np.isfinite(out["mesh_error"]):
        said += f"; ± {percent(out['mesh_error'])} by mesh and step"
    air = f" at {percent(pull['humidity'])} relative humidity" if "humidity" in pull.coords else ""
    sentences = [f"Mean pull-off {quantity(mean)} ({said}) for the surface as scanned{air}."]
    smooth = smooth_pull_off(pull) if "sphere_radius" in pull.coords else np.nan
    if mean > smooth > 0:
        sentences.append(
            f"This is {percent(mean / smooth)} of the pull-off from a smooth flat, a limit for soft bodies that stiff "
            "bodies can exceed by up to a third."
        )
    if np.isfinite(best := float(out["best_estimate"])):
        ends = interval(float(out["best_low"]), float(out["best_high"]), "nN")
        effect = "lowers it" if best < mean else "hardly changes it"
        shown = run["statistics/extrapolated"].attrs.get("longest_added")
        finer = f"finer than {float(shown):.3g} nm" if shown is not None else "finer than the pixel"
        sentences.append(
            f"Roughness {finer}, which this scan does not show, {effect}: best estimate {quantity(best)} ({ends})."
        )
    elif "statistics/extrapolated" in run:
        sentences.append(str(run["statistics/extrapolated"].attrs["known"]))
    if out.attrs["largest_source"]:
        sentences.append(
            f"The largest uncertainty is the {out.attrs['largest_source']} (± {percent(out['largest_error'])})."
        )
    return sentences


def _next(out: xr.Dataset, run: Run) -> str:
    """Return one sentence on what to do next; empty where nothing is known that would help."""
    if small := _scan_too_small(run):
        return small
    if is_too_wide(float(out["low"]), float(out["high"])):
        return "Next: solve more places, or scan a larger area."
    remedy = _REMEDIES.get(out.attrs["largest_source"], "")
    return f"Next: {remedy}." if remedy else ""


def _scan_too_small(run: Run) -> str:
    """Return what to do about a scan that is smaller than the region of contact, or too coarse for the contacts."""
    if "scan" not in run or "sphere_radius" not in run["scan"].coords:
        return ""
    scan = run["scan"]
    x_low, x_high, y_low, y_high = extent(scan)
    side, radius = min(x_high - x_low, y_high - y_low), float(scan["sphere_radius"])
    touched = 2 * np.sqrt(2 * radius * 2 * float(np.nanstd(scan["height"].values)))
    if side < 2 * touched:
        return (
            f"Next: measure a larger scan. All places share a few summits, since the sphere can touch "
            f"{number(touched, 'nm')} of the {number(side, 'nm')} of this scan."
        )
    known = run.get("solutions/adhesive", run["statistics/adhesive"]).coords.get("shortest_wavelength")
    if known is not None and float(known) > _COARSE_WAVELENGTH and not np.isfinite(best_estimate(run) or np.nan).all():
        return (
            f"Next: measure a finer scan. This scan does not resolve roughness finer than {number(known, 'nm')}, which "
            "probably lowers the pull-off much."
        )
    return ""


def recorded(run: Run, places: xr.Dataset, **options) -> dict[str, xr.Dataset]:
    """Return the groups of the summary and of the table of places, with the options of the run in their history."""
    return {"statistics/places": places} | {SUMMARY: schema.record(summary(run), "run", run["scan"], **options)}
