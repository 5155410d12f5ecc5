"""The answer in one line: how hard it sticks on average, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.numbers import number, percent, quantity, sure
from . import bootstrap, pull_off, smooth_pull_off
from .sampling import at_first_preload, by_share, conditions


def answer(ds: xr.Dataset) -> xr.Dataset:
    """Return the mean pull-off force with its 95 % interval, and print it with its condition and errors.

    Parameters
    ----------
    ds : Dataset
        A solution, for example of `adhesive`, `rigid`, `superpose` or `extrapolated`, or its `pull_off`. Of several
        preloads the first.

    Returns
    -------
    Dataset
        Scalars: ``pull_off_force`` (nN), the mean over the places that pull, ``low`` and ``high`` (nN), the ends of its
        interval over places, ``places``, and ``mesh_error``, the median of the relative errors by mesh and step, of
        `rigid` by its cells; NaN for what is not known, such as the interval of one place.

    Raises
    ------
    ValueError
        If ``ds`` holds no force, or no place pulls.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0])})
    >>> found = answer(schema.label(pull))
    593 nN (95 % interval 230 … 1607 nN) by 3 places; for the surface as scanned, without roughness below its pixels
    """
    ds = schema.entered(ds)
    mean, words = answered(ds) if "pull_off_mean" not in ds else _extrapolated_answer(ds)
    print(words)
    return mean


def _extrapolated_answer(ds: xr.Dataset) -> tuple[xr.Dataset, str]:
    """Return the best estimate of `extrapolated` and its interval, and the same in words."""
    ends = {"pull_off_force": "pull_off_mean", "low": "pull_off_lower", "high": "pull_off_upper"}
    out = xr.Dataset({name: ds[source].variable for name, source in ends.items()}, schema.travelling(ds))
    words = sure(*(float(out[name]) for name in ends))
    return out, f"best estimate {words}, with the roughness below the pixel; {ds.attrs['assumed']}"


def answered(ds: xr.Dataset, *, mesh_error: float | None = None) -> tuple[xr.Dataset, str]:
    """Return what `answer` does, and its words; the error by mesh and step may be given where ``ds`` holds none."""
    if "pull_off_force" not in ds and "force" not in ds:
        raise ValueError("expected a solution, or its pull_off, found neither; run adhesive, rigid or superpose first")
    pull = ds if "pull_off_force" in ds else pull_off(ds)
    pull = at_first_preload(pull)
    force = pull["pull_off_force"].load()
    _refuse_several(force)
    if not force.dims and not {"subregion", "subregion_x"} & set(force.coords):
        raise ValueError(
            "expected places along subregion, found one force that tells no place; answer the solution before its mean "
            "is taken, or one place, isel(subregion=0)"
        )
    known = int(force.notnull().sum())
    if not (force > 0).any():
        raise ValueError(f"pull_off_force: expected at least one place that pulls, found none of {force.size}")
    ends = bootstrap(pull[["pull_off_force"]], "pull_off_force", statistics=["mean"]) if known > 1 else None
    low, high = (np.nan if ends is None else float(ends[end].sel(resampling="block").item()) for end in ("low", "high"))
    own = next((name for name in ("pull_off_error", "cell_error") if name in pull), None)
    error = float(np.abs(pull[own]).median()) if own else np.nan
    told = {
        "pull_off_force": float(by_share(force).mean()),
        "low": low,
        "high": high,
        "places": known,
        "mesh_error": error if mesh_error is None else mesh_error,
    }
    out = xr.Dataset(told, coords=schema.travelling(pull))
    for name in ("low", "high"):
        out[name].attrs = {"units": "nN", "long_name": f"{name} end of the mean pull-off's interval"}
    out["places"].attrs = {"units": "1", "long_name": "number of places that pull"}
    out["mesh_error"].attrs = {"units": "1", "long_name": "relative error by mesh and step, median"}
    return schema.record(schema.label(out), "answer", pull), _in_words(told, force.size, pull)


def best_estimate(run: Mapping[str, xr.Dataset]) -> tuple[float, float, float] | None:
    """Return a run's mean pull-off with the roughness below the scan, and the ends of its interval, nN.

    None where the run did not look for it, or found that it cannot be known.

    Examples
    --------
    >>> best_estimate({}) is None
    True
    """
    if "statistics/extrapolated" not in run:
        return None
    found = run["statistics/extrapolated"]
    mean, lower, upper = (float(found[f"pull_off_{name}"]) for name in ("mean", "lower", "upper"))
    return (mean, lower, upper) if np.isfinite(mean) else None


def _refuse_several(force: xr.DataArray):
    """Raise where there are several answers, and say how to have them all, or one."""
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


def _in_words(told: dict[str, float], places: int, pull: xr.Dataset) -> str:
    """Return the answer as a line."""
    of = f"{told['places']} place{'s' * (told['places'] > 1)}" + f" of {places}" * (told["places"] < places)
    mean = quantity(told["pull_off_force"]) + f" ({of})"
    if told["places"] > 1:
        mean = f"{sure(told['pull_off_force'], told['low'], told['high'])} by {of}"
    said = [mean]
    if np.isfinite(told["mesh_error"]):
        cells = "overestimated through the size of cells by about" if "cell_error" in pull else "error of mesh and step"
        said.append(f"{cells} {percent(told['mesh_error'])}")
    if {"sphere_radius", "work_of_adhesion"} <= set(pull.coords) and (smooth := smooth_pull_off(pull)):
        share = told["pull_off_force"] / smooth
        doubt = ", which only a surface shaped to fit the sphere could reach: take adhesive, or a finer mesh"
        said.append(f"{number(100 * share, '%')} of the pull-off from a smooth flat" + doubt * bool(share > 1.02))
    return "; ".join([*said, "for the surface as scanned, without roughness below its pixels"])
