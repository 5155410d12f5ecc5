"""An error budget of the simulated pull-off: what is known of how far its mean can be trusted, and from where.

Each entry is one standard deviation of the mean pull-off, relative to it. That of sampling is of the places on this
scan; all others are the change of the mean over a sample of places when one thing is changed by about as much as it may
be off (`sensitivity`): what one bar of the tornado shows, and nothing is computed twice. An entry that was not computed
is NaN and says why.

What waves shorter than the scan shows would do is no such entry: it is not off, it is not known. It stands beside the
total, which holds for a surface that ends where the scan does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..catalogue import asperities
from ..contact.short_waves import quietly, scale_dependence
from ..scans import self_affine_fit
from ..statistics import bootstrap
from ..tip import tip_flags
from ..units import positive, whole_number
from .verb import sensitivity

#: Entries that a change of `sensitivity` gives: the factor, and what is done, its settings put in.
CHANGED: dict[str, tuple[str, str]] = {
    "mesh": ("mesh", "cells {}"),
    "step": ("step", "steps of the displacement {}"),
    "preload": ("preload", "preload {}"),
    "levelling": ("levelling", "another levelling: {}"),
    "pixel": ("interpolation", "heights between the pixels by {} in place of splines"),
    "tip": ("tip radius", "a tip of {} taken off the scan"),
    "range of the law": ("range of adhesion", "range of adhesion {}"),
    "work of adhesion": ("surface energy", "work of adhesion {}"),
    "modulus": ("modulus", "contact modulus {}"),
    "sphere radius": ("sphere radius", "radius {}"),
}

#: The entries that the scan's own places give, and that its shortest waves do.
SAMPLING, SHORT_WAVES = "sampling", "shorter waves"

#: All entries in order; of a body that yields its hardness besides.
ENTRIES = (SAMPLING, *CHANGED, SHORT_WAVES)

#: Waves that are added, in parts of the shortest that the scan shows, and cut off, in pixels.
_ADDED, _CUT = (0.5, 0.5**0.5), (2, 4)

#: A tip that changes the pull-off by less than this part falls off by more than the heights from a pixel to the next.
_UNSEEN = 1e-4

#: Standard deviations within an interval of 95 %.
_WITHIN = 4.0


class _Entry(NamedTuple):
    """One entry: relative standard deviation, NaN where it is not known, and how it was got, or why it was not."""

    value: float
    how: str


def error_budget(
    ds: xr.Dataset,
    *,
    solved: xr.Dataset | None = None,
    changes: xr.Dataset | None = None,
    scales: xr.Dataset | None = None,
    subregions: Any = None,
    places: int = 4,
    preload: Any = 0.0,
    law: str = "auto",
    refine: int | str = "auto",
    step: Any = 0.4,
    settings: Mapping[str, Sequence] | None = None,
    seeds: int = 2,
    tip_radius: Any = 10.0,
    progress: bool = False,
) -> xr.Dataset:
    """Return by how much the mean simulated pull-off may be off, and from what: one entry for each source.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with a pair that adheres.
    solved : Dataset, optional
        The result of `adhesive` at all places, from which sampling is told; by default from the sample alone.
    changes : Dataset, optional
        The result of `sensitivity` with method="adhesive", by default computed here.
    scales : Dataset, optional
        The result of `cut_off_waves`, by default computed here.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, by default those of ``solved``.
    places : int
        So many of them, spread evenly, are solved again with each change.
    preload, law, refine, step
        Of `adhesive`, as `sensitivity` takes them.
    settings : mapping of str to sequence, optional
        By how much each factor may be off, see `sensitivity`: a factor that is left out is not computed, and one of
        which it is known that it is not off, such as ``{"modulus": [1.0]}``, gives 0.
    seeds : int
        Surfaces made of each roughness that continues the scan's spectrum; 0 leaves this out.
    tip_radius : number or quantity
        Of the tip that took the scan, nm: which part of the asperities is sharper. What it does to the pull-off is told
        by the settings.
    progress : bool
        Tell on standard error what is being computed.

    Returns
    -------
    Dataset
        ``relative_error`` and ``how`` along ``entry``; ``total_error``, the root of the sum of squares of all entries
        that were computed but "shorter waves"; ``pull_off_mean`` (nN), ``shortest_wavelength`` (nm) that the scan
        shows, ``contact_radius_pixels``, the median radius at pull-off of the smallest contact that matters, in pixels
        of the scan, and ``sharper_than_tip``, the share of asperities. The attribute ``condition`` says for which
        surface the total holds, and ``resolved`` whether the contacts are larger than the pixels.

    Raises
    ------
    ValueError
        If no pair with adhesion is assigned, or ``changes`` or ``scales`` are none.

    Notes
    -----
    Of a factor that is changed both up and down the larger change counts. The changes are taken as independent and as
    one standard deviation each; that of sampling is a quarter of its 95 % interval.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    >>> options = {"settings": {"surface energy": [0.9, 1.1]}, "places": 1, "seeds": 0, "law": "griffith", "step": 1}
    >>> budget = error_budget(scan, **options)
    >>> bool(budget.relative_error.sel(entry="work of adhesion") > 0.05), budget.how.sel(entry="mesh").item()
    (True, 'not computed: left out of the settings')
    """
    ds = schema.validate(ds, "scan")
    centres = regions.centres(ds, solved if subregions is None and solved is not None else subregions)
    how = {"subregions": centres, "preload": preload, "law": law, "refine": refine, "step": step}
    if changes is None:
        changes = sensitivity(ds, method="adhesive", places=places, settings=settings, progress=progress, **how)
    if "pull_off_change" not in changes:
        raise ValueError("changes: expected what sensitivity(method='adhesive') returns, found no pull_off_change")
    if scales is None and whole_number(seeds, "seeds", least=0):
        scales = cut_off_waves(ds, seeds=seeds, places=places, **how)
    pulls = (changes.isel(case=0) if solved is None else solved)["pull_off_force"]
    pulls = pulls.isel(preload=0) if "preload" in pulls.dims else pulls
    entries = {SAMPLING: _sampling(pulls)}
    entries |= {entry: _of_changes(changes, *told) for entry, told in CHANGED.items()}
    if "hardness" in ds.coords:
        entries["hardness"] = _of_changes(changes, "hardness", "hardness {}")
    entries[SHORT_WAVES] = _of_short_waves(scales)
    out = _budget(entries).assign(_known(ds, changes, pulls, positive(tip_radius, "nm", "tip_radius")))
    out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
    shown = float(out["shortest_wavelength"])
    out.attrs = {"law": changes.attrs.get("law", law), "places": changes.sizes["subregion"]}
    out.attrs |= {"condition": _condition(shown), "resolved": _resolved(float(out["contact_radius_pixels"]))}
    arguments = {name: how[name] for name in ("preload", "law", "refine", "step")}
    arguments |= {"places": places, "settings": settings, "seeds": seeds}
    return schema.record(schema.label(out), "error_budget", ds, subregions=subregions, **arguments)


def cut_off_waves(
    ds: xr.Dataset,
    *,
    seeds: int = 2,
    places: int = 4,
    subregions: Any = None,
    preload: Any = 0.0,
    law: str = "auto",
    refine: int | str = "auto",
    step: Any = 0.4,
) -> xr.Dataset | None:
    """Return the simulated pull-off over the shortest wave: two below what the scan shows, its own, and cut off above.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with a pair that adheres.
    seeds, places, subregions, preload, law, refine, step
        As for `error_budget`.

    Returns
    -------
    Dataset or None
        Of `scale_dependence`; None where the scan has no spectrum to continue, or the indenter is no sphere.
    """
    if "sphere_radius" not in ds.coords:
        return None
    spectrum = self_affine_fit(ds)
    shown, pixel = float(spectrum["shortest_wavelength"]), schema.square_pixel(ds)
    if not np.isfinite(float(spectrum["psd_plateau"])) or not np.isfinite(shown):
        return None
    waves = {*(part * shown for part in _ADDED), shown, *(n * pixel for n in _CUT if n * pixel > 1.02 * shown)}
    sample = regions.sample(regions.centres(ds, subregions), places)
    options = {"subregions": sample, "preload": preload, "law": law, "refine": refine, "step": step}
    return scale_dependence(ds, shortest=sorted(waves), seeds=seeds, method="adhesive", **options)


def _budget(entries: Mapping[str, _Entry]) -> xr.Dataset:
    """Return the entries and their total."""
    values = np.array([entries[name].value for name in entries])
    known = np.array([entries[name].value for name in entries if name != SHORT_WAVES])
    total = float(np.sqrt(np.nansum(known**2))) if np.isfinite(known).any() else np.nan
    how = [entries[name].how for name in entries]
    columns = {"relative_error": ("entry", values), "how": ("entry", how), "total_error": total}
    return xr.Dataset(columns, {"entry": list(entries)})


def _sampling(force: xr.DataArray) -> _Entry:
    """Return what landing at other places of this surface leaves open."""
    count = int(force.notnull().sum())
    if count < 2:
        return _Entry(np.nan, f"not computed: it takes two places that pull, there are {count}")
    found = bootstrap(force.to_dataset(name="pull_off_force"), "pull_off_force", statistics=["mean"]).isel(statistic=0)
    block = found.sel(resampling="block")
    half = float(block["high"] - block["low"]) / _WITHIN
    independent = float(block["independent_places"])
    words = f"bootstrap of blocks of the {count} places, worth {independent:.3g} independent ones"
    return _Entry(half / float(found["estimate"]), words)


def _of_changes(changes: xr.Dataset, factor: str, words: str) -> _Entry:
    """Return the largest change that a factor's settings make."""
    cases = changes.isel(case=np.flatnonzero(changes["factor"].values == factor))
    if not cases.sizes["case"]:
        return _Entry(np.nan, "not computed: left out of the settings")
    change = np.abs(cases["pull_off_change"].values)
    if not np.isfinite(change).any():
        return _Entry(np.nan, f"not computed: {cases['reason'].values[0]}")
    told = " and ".join(map(str, cases["setting"].values[np.isfinite(change)]))
    unseen = factor == "tip radius" and np.nanmax(change) < _UNSEEN
    seen = ", which is too sharp for the pixels to show" if unseen else ""
    return _Entry(float(np.nanmax(change)), f"{words.format(told)}{seen}; {_count(changes)}")


def _count(ds: xr.Dataset) -> str:
    count = ds.sizes["subregion"]
    return f"{count} place{'s' * (count > 1)}"


def _of_short_waves(scales: xr.Dataset | None) -> _Entry:
    """Return the change that continuing the scan's spectrum by an octave makes."""
    if scales is None:
        return _Entry(np.nan, "not computed: left out, no sphere, or a scan without a spectrum to continue")
    if "shortest_kept" not in scales.dims:
        raise ValueError("scales: expected what cut_off_waves returns, found no dimension 'shortest_kept'")
    means = scales["pull_off_force"].mean("subregion")
    shown = scales.attrs["shortest_wavelength"]
    least = means.isel(shortest_kept=0)
    wave, ratios = float(least["shortest_kept"]), least / means.sel(shortest_kept=shown, method="nearest").mean()
    scatter = f", ± {100 * float(ratios.std()):.2g} % over {ratios.size} seeds" if ratios.size > 1 else ""
    words = f"its spectrum continued from {shown:.3g} down to {wave:.3g} nm{scatter}; {_count(scales)}"
    return _Entry(abs(float(ratios.mean()) - 1), words)


def _known(ds: xr.Dataset, changes: xr.Dataset, pulls: xr.DataArray, tip_radius: float) -> dict[str, float]:
    """Return what else a reader should know beside the entries."""
    found = quietly(asperities, ds)
    sharp = tip_flags(found, tip_radius=tip_radius)["sharper_than_tip"]
    return {
        "pull_off_mean": float(pulls.mean()),
        "shortest_wavelength": float(found.coords.get("shortest_wavelength", np.nan)),
        "contact_radius_pixels": float(changes.attrs["contact_radius_pixels"]),
        "sharper_than_tip": float(sharp.mean()) if sharp.size else np.nan,
        "tip_radius": tip_radius,
    }


def _condition(shown: float) -> str:
    """Say for which surface the pull-off holds."""
    if not np.isfinite(shown):
        return "for a surface as smooth as this scan shows it"
    return f"for a surface as smooth below {shown:.3g} nm as this scan shows it"


def _resolved(pixels: float) -> str:
    """Say how large the contacts are beside the scan's pixels."""
    words = f"At pull-off the smallest contact that matters has a radius of {pixels:.2g} pixels (median place)"
    if pixels >= 2:
        return f"{words}."
    return f"{words}: what the surface does within a pixel, which the scan does not show, decides how hard it sticks."
