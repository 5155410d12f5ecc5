"""An error budget of the simulated pull-off: the known uncertainties of its mean, and their sources.

Each entry is one relative standard deviation of the mean pull-off. The entry of sampling is the scatter between places
on this scan. Every other entry is the change of the mean, over a sample of places, when one assumption is changed by
about its uncertainty (`sensitivity`): the length of its bar in the tornado plot, nothing is computed twice. An entry
that was not computed is NaN and says why.

The effect of waves shorter than the scan shows is no such entry, since their heights are unknown rather than uncertain.
It is reported beside the total, which holds for a surface without such waves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...asperity.catalogue import asperities
from ...contact.mesh import COARSE, Mesh, mesh_of
from ...contact.rigid_bodies import rigid
from ...scans import regions, self_affine_fit
from ...scans.tip import tip_flags
from ...statistics import bootstrap
from ...vocabulary import schema
from ...vocabulary.units import positive, whole_number
from ...vocabulary.verbs import verb
from ..short_waves import mean_over_waves, quietly, scale_dependence
from .verb import sensitivity

#: Entries given by a change of `sensitivity`: the factor, and a description into which its settings are put.
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

#: The same of a humid pair, and the entry of what the law of thin menisci leaves out.
OF_LIQUID = {"humidity": ("humidity", "humidity {}"), "contact angle": ("contact angle", "contact angles {}")}
THIN = "thin menisci"

#: The entries given by the scan's own places, and by its shortest waves.
SAMPLING, SHORT_WAVES = "sampling", "shorter waves"

#: Shortest waves that are added, as parts of the shortest that the scan shows, and that are cut off, in pixels.
_ADDED, _CUT = (0.5, 0.5**0.5), (2, 4)

#: A tip whose effect is smaller than this part cannot be seen on the scan's pixels: between neighbours its flanks fall
#: by more than the heights do.
_UNSEEN = 1e-4

#: Standard deviations in the width of a 95 % interval.
_WITHIN = 4.0


class _Entry(NamedTuple):
    """One entry: relative standard deviation, NaN if not known, and how it was computed, or why it was not."""

    value: float
    how: str


@verb
def error_budget(
    ds: xr.Dataset,
    *,
    subregions: Any = None,
    places: int = 4,
    preload: Any = 0.0,
    law: str = "auto",
    mesh: Mesh | int | str | None = None,
    settings: Mapping[str, Sequence] | None = None,
    seeds: int = 2,
    tip_radius: Any = 10.0,
) -> xr.Dataset:
    """Return the uncertainty of the mean simulated pull-off: one entry for each source.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an adhesive pair.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    places : int
        Number of centres, spread evenly, at which each change is solved again.
    preload, law, mesh
        Options of `adhesive`, as for `sensitivity`.
    settings : mapping of str to sequence, optional
        The uncertainty of each factor, see `sensitivity`: a factor that is left out is not computed, and one that is
        known to be exact, such as ``{"modulus": [1.0]}``, gives 0.
    seeds : int
        Number of surfaces for each roughness that continues the scan's spectrum; 0 leaves this out.
    tip_radius : number or quantity
        Of the tip that took the scan, nm, for the share of asperities that are sharper. The effect of the tip on the
        pull-off is computed with the settings.

    Returns
    -------
    Dataset
        ``relative_error`` and ``how`` along ``entry``, of a humid pair also for its humidity, its contact angles and
        what the law of thin menisci leaves out; ``total_error``, the root of the sum of squares of all computed
        entries except "shorter waves"; ``pull_off_mean`` (nN), ``shortest_wavelength`` (nm) that the scan shows,
        ``contact_radius_pixels``, the median radius at pull-off of the smallest relevant contact, in pixels of the
        scan, and ``sharper_than_tip``, the share of asperities. The attribute ``condition`` says for which surface the
        total holds, and ``resolved`` whether the contacts are larger than the pixels.

    Raises
    ------
    ValueError
        If no pair with adhesion is assigned.

    Notes
    -----
    For a factor that is changed both up and down, the larger change is used. The changes are taken as independent and
    as one standard deviation each; the entry of sampling is a quarter of its 95 % interval.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    >>> options = {"settings": {"surface energy": [0.9, 1.1]}, "places": 1, "seeds": 0, "law": "griffith"}
    >>> budget = error_budget(scan, **options)
    >>> bool(budget.relative_error.sel(entry="work of adhesion") > 0.05), budget.how.sel(entry="mesh").item()
    (True, 'not computed: left out of the settings')
    """
    ds = schema.validate(ds, "scan")
    some = regions.sample(regions.centres(ds, subregions), whole_number(places, "places", least=1))
    how = {"preload": preload, "law": law, "mesh": mesh_of(mesh, COARSE)}
    changes = sensitivity(ds, method="adhesive", subregions=some, settings=settings, **how)
    scales = None
    if whole_number(seeds, "seeds", least=0):
        scales = cut_off_waves(ds, seeds=seeds, places=places, subregions=some, preload=preload)
    out = budget_of(ds, changes, scales, tip_radius=tip_radius)
    how |= {"subregions": subregions, "places": places, "settings": settings, "seeds": seeds}
    return schema.record(out, "error_budget", ds, **how)


def budget_of(ds: xr.Dataset, changes: xr.Dataset, scales: Any, *, pulls: Any = None, tip_radius: Any = 10.0):
    """Return the budget of what `sensitivity` and `cut_off_waves` found, with all places' pull-offs if given."""
    pulls = changes["pull_off_force"].isel(case=0) if pulls is None else pulls
    pulls = pulls.isel(preload=0) if "preload" in pulls.dims else pulls
    entries = {SAMPLING: _sampling(pulls)}
    entries |= {entry: _of_changes(changes, *told) for entry, told in CHANGED.items()}
    if "hardness" in ds.coords:
        entries["hardness"] = _of_changes(changes, "hardness", "hardness {}")
    if schema.is_wet(ds):
        entries |= {entry: _of_changes(changes, *told) for entry, told in OF_LIQUID.items()}
        entries[THIN] = _of_thin_menisci(ds, changes)
    entries[SHORT_WAVES] = _of_short_waves(scales)
    out = _budget(entries).assign(_known(ds, changes, pulls, positive(tip_radius, "nm", "tip_radius")))
    out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
    shown = float(out["shortest_wavelength"])
    out.attrs = {"law": changes.attrs["law"], "places": changes.sizes["subregion"]}
    out.attrs |= {"condition": _condition(shown), "resolved": _resolved(float(out["contact_radius_pixels"]))}
    return schema.label(out)


def cut_off_waves(
    ds: xr.Dataset,
    *,
    seeds: int = 2,
    places: int = 4,
    subregions: Any = None,
    preload: Any = 0.0,
) -> xr.Dataset | None:
    """Return the simulated pull-off over the shortest wave: at two below that of the scan, at its own, and above it."""
    if "sphere_radius" not in ds.coords:
        return None
    spectrum = self_affine_fit(ds)
    shown, pixel = float(spectrum["shortest_wavelength"]), schema.square_pixel(ds)
    if not np.isfinite(float(spectrum["psd_plateau"])) or not np.isfinite(shown):
        return None
    waves = {*(part * shown for part in _ADDED), shown, *(n * pixel for n in _CUT if n * pixel > 1.02 * shown)}
    sample = regions.sample(regions.centres(ds, subregions), places)
    options = {"subregions": sample, "preload": preload}
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
    """Return the uncertainty from the choice of places on this surface."""
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
    """Return the largest change among a factor's settings."""
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


def _of_thin_menisci(ds: xr.Dataset, changes: xr.Dataset) -> _Entry:
    """Return by how much the law of thin menisci is too high between rigid bodies at the same places."""
    found = quietly(rigid, ds, subregions=changes, delta=[0.0])
    words = f"the energy of the menisci's edges, which their law leaves out, between rigid bodies; {_count(changes)}"
    return _Entry(float(found["meniscus_error"].mean()), words)


def _of_short_waves(scales: xr.Dataset | None) -> _Entry:
    """Return the change when the scan's spectrum is continued by one octave."""
    if scales is None:
        return _Entry(np.nan, "not computed: left out, no sphere, or a scan without a spectrum to continue")
    means = mean_over_waves(scales)
    shown = scales.attrs["shortest_wavelength"]
    least = means.isel(shortest_kept=0)
    wave, ratios = float(least["shortest_kept"]), least / means.sel(shortest_kept=shown, method="nearest").mean()
    scatter = f", ± {100 * float(ratios.std()):.2g} % over {ratios.size} seeds" if ratios.size > 1 else ""
    words = f"its spectrum continued from {shown:.3g} down to {wave:.3g} nm{scatter}; {_count(scales)}"
    return _Entry(abs(float(ratios.mean()) - 1), words)


def _known(ds: xr.Dataset, changes: xr.Dataset, pulls: xr.DataArray, tip_radius: float) -> dict[str, float]:
    """Return further variables that a reader should see beside the entries."""
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
    """Return a sentence on the surface for which the pull-off holds."""
    if not np.isfinite(shown):
        return "for the surface as scanned, without finer roughness"
    return f"for the surface as scanned, without roughness below {shown:.3g} nm"


def _resolved(pixels: float) -> str:
    """Return a sentence on the size of the contacts in the scan's pixels."""
    words = f"At pull-off the smallest contact that matters has a radius of {pixels:.2g} pixels (median place)"
    if pixels >= 2:
        return f"{words}."
    return f"{words}: the pull-off depends on the surface within a pixel, which the scan does not show."
