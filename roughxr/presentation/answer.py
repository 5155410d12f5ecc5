"""The answer in one line: how hard it sticks on average, and how sure that is."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..statistics import bootstrap, mean_of_few, pull_off, smooth_pull_off
from ..statistics.sampling import by_share
from ..vocabulary import schema
from ..vocabulary.numbers import interval, number, percent, quantity
from ..vocabulary.verbs import verb

#: Fewer places than this are no sample to draw resamples from.
_FEW = 30


@verb
def answer(ds: xr.Dataset) -> xr.Dataset:
    """Return the mean pull-off force with its 95 % interval, and print it with what it hangs on.

    Parameters
    ----------
    ds : Dataset
        A solution, for example of `adhesive`, `rigid` or `superpose`, or its `pull_off`. Of several preloads the first.

    Returns
    -------
    Dataset
        Scalars: ``pull_off_force`` (nN), the mean over the places that pull, ``low`` and ``high`` (nN), the ends of its
        interval over places (fewer than 30 are taken as log-normal, since they show no tail), ``places``, and
        ``mesh_error``, the median of the relative errors by mesh and step; NaN where a number cannot be told, such as
        an interval of one place.

    Raises
    ------
    ValueError
        If ``ds`` holds no force, or no place pulls.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0])})
    >>> found = answer(schema.label(pull))
    593 nN (95 % interval 0.23 … 1.61 µN by 3 places); as the scan shows the surface, without what is below its pixels
    """
    found, words = answered(ds)
    print(words)
    return found


def answered(ds: xr.Dataset, *, mesh_error: float | None = None) -> tuple[xr.Dataset, str]:
    """Return what `answer` does, and its words; the error by mesh and step may be given where ``ds`` holds none."""
    pull = ds if "pull_off_force" in ds else pull_off(ds)
    pull = pull.isel(preload=0) if "preload" in pull.dims else pull
    force = pull["pull_off_force"].load()
    known = int(force.notnull().sum())
    if not known:
        raise ValueError(f"pull_off_force: expected at least one place that pulls, found none of {force.size}")
    low, high = _interval(pull[["pull_off_force"]], known)
    error = float(np.abs(pull["pull_off_error"]).median()) if "pull_off_error" in pull else np.nan
    found = {
        "pull_off_force": float(by_share(force).mean()),
        "low": low,
        "high": high,
        "places": known,
        "mesh_error": error if mesh_error is None else mesh_error,
    }
    out = xr.Dataset(found, coords={name: pull[name] for name in schema.TRAVELLING if name in pull.coords})
    for name in ("low", "high"):
        out[name].attrs = {"units": "nN", "long_name": f"{name} end of the mean pull-off's interval"}
    out["places"].attrs = {"units": "1", "long_name": "number of places that pull"}
    out["mesh_error"].attrs = {"units": "1", "long_name": "relative error by mesh and step, median"}
    return schema.record(schema.label(out), "answer", pull), _in_words(found, force.size, pull)


def _interval(pull: xr.Dataset, known: int) -> tuple[float, float]:
    """Return the ends of the 95 % interval of the mean: of few places, which show no tail, by `mean_of_few`."""
    if known < 2:
        return np.nan, np.nan
    if known < _FEW:
        return mean_of_few(pull["pull_off_force"].values)
    ends = bootstrap(pull, "pull_off_force", statistics=["mean"]).sel(resampling="block")
    return float(ends["low"].item()), float(ends["high"].item())


def _in_words(found: dict[str, float], places: int, pull: xr.Dataset) -> str:
    """Return the answer as a line."""
    of = f"{found['places']} place{'s' * (found['places'] > 1)}" + f" of {places}" * (found["places"] < places)
    ends = f"95 % interval {interval(found['low'], found['high'], 'nN')} by {of}"
    sure = [ends if found["places"] > 1 else of]
    if np.isfinite(found["mesh_error"]):
        sure.append(f"mesh and step {percent(found['mesh_error'])}")
    said = [f"{quantity(found['pull_off_force'])} ({'; '.join(sure)})"]
    if {"sphere_radius", "work_of_adhesion"} <= set(pull.coords):
        smooth = smooth_pull_off(pull)
        said.append(
            f"{number(100 * found['pull_off_force'] / smooth, '%')} of what a smooth flat holds" if smooth else ""
        )
    return "; ".join([*filter(None, said), "as the scan shows the surface, without what is below its pixels"])
