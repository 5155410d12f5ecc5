"""Several scans in one folder: a run of each, one table of all places, the pooled mean, and a page that compares."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from .. import report
from ..archive import whole
from ..jobs.progress import about, say
from ..statistics import bootstrap, pooled
from ..tables import to_table
from ..vocabulary import schema
from ..vocabulary.numbers import interval, quantity, sure

_FORCE = "pull_off_force"


def folders(scans: Iterable[str | Path], output: Path) -> dict[Path, Path]:
    """Return a folder for each scan, by the name of its file; raise where two have the same."""
    chosen: dict[Path, Path] = {}
    for scan in map(Path, scans):
        if output / scan.stem in chosen.values():
            raise ValueError(f"{scan}: expected files of different names, found two called {scan.stem!r}: rename one")
        chosen[scan] = output / scan.stem
    return chosen


def run_each(scans: Mapping[Path, Path], run_one: Callable[[Path, Path], Any]):
    """Return the places of each scan that could be analysed, and why the others could not.

    Called again after an interruption it goes on from there, as every run does.
    """
    places, refused, begun = {}, {}, time.monotonic()
    for number, (scan, folder) in enumerate(scans.items(), start=1):
        each = (time.monotonic() - begun) / max(number - 1, 1)
        left = f", {about(each * (len(scans) - number + 1))} left for all of them" if number > 1 else ""
        say(f"scan {number} of {len(scans)}: {scan.name}{left}")
        try:
            places[scan.name] = report.by_place(run_one(scan, folder))
        except (ValueError, OSError, ImportError) as error:
            refused[scan.name] = str(error)
            say(f"{scan.name}: left out: {error}")
    if not any(_FORCE in one for one in places.values()):
        raise ValueError("expected at least one scan with a pull-off, found none: " + "; ".join(refused.values()))
    return {name: one for name, one in places.items() if _FORCE in one}, refused


def together(places: Mapping[str, xr.Dataset], refused: Mapping[str, str], output: Path) -> str:
    """Write the table of all places and the page of all scans; return the pooled answer in words."""
    frames = [one.to_dataframe().reset_index().assign(scan=name) for name, one in places.items()]
    every = xr.Dataset.from_dataframe(pd.concat(frames, ignore_index=True).rename_axis("row"))
    for name in every.data_vars:
        every[name].attrs = next((one[name].attrs for one in places.values() if name in one.variables), {})
    to_table(schema.label(every), output / "places.csv")
    rows = {name: _mean(one) for name, one in places.items()}
    answer = _pooled_words(places) if len(places) > 1 else ""
    with whole(output / "index.html") as temporary:
        temporary.write_text(_page(rows, refused, answer), encoding="utf-8")
    return answer


def _mean(places: xr.Dataset) -> tuple[str, str, str]:
    """Return mean, interval and number of places of one scan as they are printed."""
    known = int(places[_FORCE].notnull().sum())
    mean = quantity(float(places[_FORCE].mean()))
    if known < 2:
        return mean, "–", str(known)
    ends = bootstrap(places[[_FORCE]], _FORCE, statistics=["mean"]).isel(statistic=0).sel(resampling="block")
    return mean, interval(float(ends["low"]), float(ends["high"]), "nN"), str(known)


def _pooled_words(places: Mapping[str, xr.Dataset]) -> str:
    """Return the mean over scans with its interval, and how much scans differ."""
    each = [one[[_FORCE]].where(one[_FORCE].notnull(), drop=True) for one in places.values()]
    enough = [one for one in each if one.sizes["subregion"] > 1]
    if len(enough) < 2:
        return ""
    padded = [one.assign_coords(subregion=np.arange(one.sizes["subregion"])) for one in enough]
    pooled_mean = pooled(xr.concat(padded, "scan", join="outer"), _FORCE, statistics=["mean"]).isel(statistic=0)
    value, low, high = (float(pooled_mean[name]) for name in ("pooled", "pooled_low", "pooled_high"))
    mean = sure(value, low, high)
    return (
        f"Pull-off force, mean over {len(enough)} scans: {mean}; "
        f"standard deviation between scans {quantity(float(pooled_mean['between_std']))} beyond the scatter of places."
    )


def _page(rows: Mapping[str, tuple[str, str, str]], refused: Mapping[str, str], answer: str) -> str:
    """Return the page that compares the scans."""
    cells = "".join(
        f"<tr><td><a href='{escape(Path(name).stem)}/report.html'>{escape(name)}</a></td>"
        + "".join(f"<td>{escape(one)}</td>" for one in row)
        + "</tr>\n"
        for name, row in rows.items()
    )
    left = "".join(f"<li>{escape(name)}: {escape(reason)}</li>\n" for name, reason in refused.items())
    return (
        "<!DOCTYPE html>\n<html lang='en'><meta charset='utf-8'><title>Scans compared · roughxr</title>\n"
        "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
        "td,th{text-align:left;padding:.2rem 1.5rem .2rem 0}</style>\n"
        f"<h1>Scans compared</h1>\n<p>{escape(answer)}</p>\n<table>\n<tr><th>scan</th><th>mean pull-off</th>"
        f"<th>95 % interval over places</th><th>places</th></tr>\n{cells}</table>\n"
        + (f"<h2>Left out</h2>\n<ul>{left}</ul>\n" if left else "")
        + "</html>\n"
    )
