"""An error budget of the simulated pull-off: the known uncertainties of its mean, and their sources.

Each entry is one relative standard deviation of the mean pull-off, with its own standard error. The entry of sampling
is the standard error of the mean over places of this scan. Every other entry is the change of the mean, over a sample
of places, when one assumption is changed by about its uncertainty. Where the change is a known bias, as from the mesh
to one twice as fine, it is taken off the mean, and half of it stays as the entry. An entry that was not computed is NaN
and says why. Each change is solved at more places until the standard error of the total is a quarter of it.

The effect of wavelengths shorter than the scan shows is no such entry, since their heights are unknown rather than
uncertain. It is reported beside the total, which holds for a surface without such wavelengths.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..asperity.catalogue import asperities
from ..bodies.liquid import work_of
from ..bodies.pair import range_of
from ..contact.adhesion import adhesive
from ..contact.cycle import EDGED
from ..contact.mesh import Mesh, mesh_of
from ..contact.rigid.bodies import rigid
from ..scans import regions, self_affine_fit
from ..scans.tip import tip_flags
from ..statistics import bootstrap
from ..statistics.sampling import by_share, shares
from ..vocabulary import schema
from ..vocabulary.numbers import percent
from ..vocabulary.units import Places, Quantity, whole_number
from .assumptions import CHANGES, OF_SOLVES, OF_YIELD, SIMULATED, Case, cases
from .assumptions import OF_LIQUID as HUMID_SETTINGS
from .budget_changes import Change, Comparison, Simulation, cells_for, change_of
from .short_waves import quietly, scale_dependence

#: Entries given by a change: the factor, and a description into which its settings are put.
CHANGED: dict[str, tuple[str, str]] = {
    "mesh": ("mesh", "cells {}, and steps shorter by the same factor"),
    "preload": ("preload", "preload {}"),
    "levelling": ("levelling", "another levelling: {}"),
    "pixel": ("interpolation", "heights between the pixels by {}"),
    "tip": ("tip radius", "the distortion by a tip of {} removed from the scan"),
    "range of the law": ("range of adhesion", "range of adhesion {}"),
    "work of adhesion": ("surface energy", "work of adhesion {}"),
    "modulus": ("modulus", "contact modulus {}"),
    "sphere radius": ("sphere radius", "radius {}"),
}

#: The same of a body that yields.
OF_HARDNESS = {"hardness": ("hardness", "hardness {}")}

#: The same of a humid pair, and the entry of what the law of thin menisci leaves out.
OF_LIQUID = {"humidity": ("humidity", "humidity {}"), "contact angle": ("contact angle", "contact angles {}")}
THIN = "thin menisci"

#: Entries whose change is a known bias, taken off the mean, and the part of it that stays as uncertainty: about as much
#: as still finer meshes add, whose order lies between the first and the second.
BIASES, _LEFT = ("mesh", THIN), 0.5

#: Places at which changes are solved first, and the part of itself to which the total is to be known.
_FIRST, _TOTAL_TOLERANCE = 4, 0.25

#: The entries given by the scan's own places, and by its shortest waves.
SAMPLING, SHORT_WAVES = "sampling", "finer roughness"

#: Shortest waves that are added, as parts of the shortest that the scan shows, and that are cut off, in pixels.
_ADDED, _CUT = (0.5, 0.5**0.5), (2, 4)

#: A tip whose effect is smaller than this part cannot be seen on the scan's pixels: between neighbours its flanks fall
#: by more than the heights do.
_LEAST_TIP_EFFECT = 1e-4


class _Entry(NamedTuple):
    """One entry: the change of the mean, how it was computed, or why it was not, and what it leaves uncertain."""

    change: Change
    how: str
    missing: int = 0  # places that are known in one case only, or in none
    bias: bool = False
    slope: float = np.nan  # d ln F / d ln parameter

    @property
    def value(self) -> float:
        """The relative standard deviation; of a bias what is left of it, and how well it is known."""
        if self.bias:
            return float(np.hypot(_LEFT * self.change.value, np.nan_to_num(self.change.error)))
        return abs(self.change.value)


def _none(why: str) -> _Entry:
    return _Entry(Change(np.nan, np.nan, 0), f"not computed: {why}")


def error_budget(
    ds: xr.Dataset,
    *,
    subregions: Places = None,
    places: int = 8,
    law: str = "auto",
    mesh: Mesh | int | str = "auto",
    settings: Mapping[str, Sequence] | None = None,
    seeds: int = 2,
) -> xr.Dataset:
    """Return the uncertainty of the mean simulated pull-off: one entry for each source.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an adhesive pair.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    places : int
        Most places at which each change is solved: 4, 8, 16, … until the total has a standard error of a quarter.
    law, mesh
        Options of `adhesive` at preload 0, which computes the mean at all centres. Changes are solved on the coarsest
        mesh on which the law can be solved, without range on the median mesh of the mean, and compared to the base on
        that mesh.
    settings : mapping of str to sequence, optional
        The uncertainty of each factor, by default `SIMULATED`: "mesh" (factor by which cells are finer and steps
        shorter), "preload" (added, in mean pull-offs), "levelling" ("plane" or "quadratic"), "interpolation"
        ("splines"), "tip radius" (nm, of the tip removed), "range of adhesion", "surface energy", "modulus", "sphere
        radius" and "hardness" (factors; the last where one is assigned), of a humid pair "humidity" and "contact
        angle" (added, degrees). A factor that is left out is not computed, and one that is known to be exact, such as
        ``{"modulus": [1.0]}``, gives 0.
    seeds : int
        Number of surfaces for each roughness that continues the scan's spectrum; 0 leaves this out.

    Returns
    -------
    Dataset
        Along ``entry``, of a humid pair also for its humidity, its contact angles and what the law of thin menisci
        leaves out: ``relative_error``, and its own ``standard_error`` by the scatter over places; ``pull_off_change``,
        with its sign, of which those where ``known_bias`` is true are taken off; ``slope``, d ln F/d ln parameter
        where the change multiplies a parameter; ``places`` that it rests on,
        ``missing_places``, at which a case could not be followed, and ``how``. ``total_error``, the root of the sum of
        squares of all computed entries except "finer roughness", and ``total_standard_error``; ``pull_off_mean`` (nN),
        that of `adhesive`, and ``pull_off_corrected``, the same without known biases; ``shortest_wavelength`` (nm)
        that the scan shows, ``contact_radius_pixels``, the median radius at pull-off of the smallest relevant contact,
        in pixels of the scan, and ``sharper_than_tip``, the share of asperities. The attribute ``condition`` says for
        which surface the total holds, ``resolved`` whether the contacts are larger than the pixels, and ``decided``
        how well the total is known, by how many places.

    Raises
    ------
    ValueError
        If no pair with adhesion is assigned.

    Notes
    -----
    For a factor that is changed both up and down, the larger change is used. The changes are taken as independent and
    as one standard deviation each; the entry of sampling is s/√n, n the number of independent places. Half of a known
    bias, and its standard error, stay as its entry.

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
    ds, most = schema.validate(ds, "scan"), whole_number(places, "places", least=1)
    _need_factors(ds, settings)
    how: dict[str, Any] = {"preload": 0.0, "law": law, "mesh": mesh_of(mesh, Mesh())}
    solved = quietly(adhesive, ds, subregions=regions.centres(ds, subregions), **how)
    changes = changes_of(ds, solved, most=most, settings=settings, preload=0.0, mesh=how["mesh"])
    scales = None
    if whole_number(seeds, "seeds", least=0):
        scales = cut_off_waves(ds, seeds=seeds, places=min(most, _FIRST), subregions=solved)
    out = budget_of(ds, solved, changes, scales)
    how |= {"subregions": subregions, "places": places, "settings": settings, "seeds": seeds}
    return schema.record(out, "error_budget", ds, **how)


def changes_of(
    ds: xr.Dataset,
    solved: xr.Dataset,
    *,
    most: int,
    preload: float,
    mesh: Mesh,
    settings: Mapping[str, Sequence] | None = None,
    finer: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the pull-off under each change, at as many places as the standard error of the total needs.

    ``solved`` is the simulation on ``mesh`` at all places; ``finer``, if given, at some with cells and steps halved.
    """
    tried = _cases_of(ds, settings)
    comparison = _compared(tried, solved, preload=preload, mesh=mesh, finer=finer)
    count, sampling = solved.sizes["subregion"], _sampling(_first_preload(solved))
    order, done = _spread(count)[:most], 0
    cases = [k for k in range(len(tried)) if comparison.known_at(k) < min(_FIRST, count)]
    while True:
        some = order[done : max(2 * done, _FIRST)]
        comparison.solve(cases, some)
        done += len(some)
        out = comparison.results()
        entries = _entries(ds, out, sampling)
        cases = _undecided(entries, tried)
        if done == len(order) or not cases:
            return out


def _spread(count: int) -> list[int]:
    """Return all places, those of the first few far apart from each other, along a grid's rows and columns too."""
    step = next(n for n in range(round(0.382 * count) or 1, count + 2) if np.gcd(n, count) == 1)
    return [k * step % count for k in range(count)]


def _undecided(entries: Mapping[str, _Entry], tried: Sequence[Case]) -> list[int]:
    """Return the cases of those entries that leave the total unknown; none where it is known well enough."""
    off, total = _unsure(entries), _total(entries)
    if not np.sqrt(sum(off.values())) > _TOTAL_TOLERANCE * total:
        return []
    factors = {factor: entry for entry, (factor, _) in (CHANGED | OF_HARDNESS | OF_LIQUID).items()}
    few = {entry for entry, variance in off.items() if variance > (_TOTAL_TOLERANCE * total) ** 2 / len(off)}
    return [k for k, case in enumerate(tried) if factors.get(case.factor) in few]


def _total(entries: Mapping[str, _Entry]) -> float:
    """Return the root of the sum of squares of all computed entries."""
    values = np.array([entry.value for entry in entries.values()])
    return float(np.sqrt(np.nansum(values**2))) if np.isfinite(values).any() else np.nan


def _unsure(entries: Mapping[str, _Entry]) -> dict[str, float]:
    """Return the variance that each computed entry leaves in the total; inf where its own error is not known.

    That of the square of a normal number of mean m and deviation s is 4 m² s² + 2 s⁴.
    """
    total, known = _total(entries), {name: entry for name, entry in entries.items() if np.isfinite(entry.value)}
    out = {}
    for name, entry in known.items():
        error = entry.change.error
        out[name] = np.inf if np.isnan(error) else (entry.value**2 + 0.5 * error**2) * (error / max(total, 1e-300)) ** 2
    return out


def budget_of(ds: xr.Dataset, solved: xr.Dataset, changes: xr.Dataset, scales: xr.Dataset | None) -> xr.Dataset:
    """Return the budget of the simulation at all places, and of what `changes_of` and `cut_off_waves` found."""
    pulls = _first_preload(solved)
    entries = _entries(ds, changes, _sampling(pulls))
    if schema.is_wet(ds):
        entries[THIN] = _of_thin_menisci(ds, solved)
    separate = {SHORT_WAVES: _of_short_waves(scales)}
    total, unsure = _total(entries), float(np.sqrt(sum(_unsure(entries).values())))
    mean, shifts = float(by_share(pulls).mean()), [entry.change.value for entry in entries.values() if entry.bias]
    out = _as_columns(entries | separate).assign(_known(ds, solved))
    out = out.assign(total_error=total, total_standard_error=unsure if np.isfinite(unsure) else np.nan)
    out = out.assign(pull_off_mean=mean, pull_off_corrected=mean * float(np.prod(1 + np.nan_to_num(shifts))))
    out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
    out.attrs = {"law": solved.attrs["law"], "condition": _condition(float(out["shortest_wavelength"]))}
    out.attrs |= {"resolved": _resolved(float(out["contact_radius_pixels"])), "decided": _decided(entries, pulls.size)}
    return schema.label(out)


def cut_off_waves(
    ds: xr.Dataset,
    *,
    seeds: int = 2,
    places: int = 4,
    subregions: Places = None,
    preload: Quantity = 0.0,
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
    solve = partial(scale_dependence, shortest=sorted(waves), seeds=seeds, subregions=sample)
    return solve(ds, method="adhesive", preload=preload)


def _entries(ds: xr.Dataset, changes: xr.Dataset, sampling: _Entry) -> dict[str, _Entry]:
    """Return the entries of the total, but for what is known of thin menisci."""
    factors = CHANGED | (OF_HARDNESS if "hardness" in ds.coords else {}) | (OF_LIQUID if schema.is_wet(ds) else {})
    return {SAMPLING: sampling} | {entry: _of_changes(changes, entry, *how) for entry, how in factors.items()}


def _as_columns(entries: Mapping[str, _Entry]) -> xr.Dataset:
    columns = {
        "relative_error": [entry.value for entry in entries.values()],
        "standard_error": [entry.change.error for entry in entries.values()],
        "pull_off_change": [np.nan if name == SAMPLING else entry.change.value for name, entry in entries.items()],
        "slope": [entry.slope for entry in entries.values()],
        "known_bias": [entry.bias for entry in entries.values()],
        "places": [entry.change.places for entry in entries.values()],
        "missing_places": [entry.missing for entry in entries.values()],
        "how": [entry.how for entry in entries.values()],
    }
    out = xr.Dataset({name: ("entry", values) for name, values in columns.items()}, {"entry": list(entries)})
    out["standard_error"].attrs["units"] = "1"
    return out


def _sampling(force: xr.DataArray) -> _Entry:
    """Return the uncertainty from the choice of places on this surface."""
    count = int(force.notnull().sum())
    if count < 2:
        return _none(f"needs at least two places that pull, found {count}")
    intervals = bootstrap(force.to_dataset(name="pull_off_force"), "pull_off_force", statistics=["mean", "std"])
    independent = float(intervals["independent_places"].sel(resampling="block"))
    mean, deviation = (float(intervals["estimate"].sel(statistic=name)) for name in ("mean", "std"))
    value = deviation / np.sqrt(independent) / mean
    words = f"standard error of the {count} places, equivalent to {independent:.3g} independent ones"
    error = value / np.sqrt(2 * max(independent - 1, 1))  # of a standard deviation by so many
    return _Entry(Change(value, float(error), count), words, int(force.isnull().sum()))


def _of_changes(changes: xr.Dataset, entry: str, factor: str, words: str) -> _Entry:
    """Return the largest change among a factor's settings."""
    cases = changes.isel(case=np.flatnonzero(changes["factor"].values == factor))
    if not cases.sizes["case"]:
        return _none("left out of the settings")
    change = np.abs(cases["pull_off_change"].values)
    if not np.isfinite(change).any():
        return _none(cases["reason"].values[0])
    largest = cases.isel(case=int(np.nanargmax(change)))
    settings = " and ".join(map(str, cases["setting"].values[np.isfinite(change)]))
    unseen = factor == "tip radius" and np.nanmax(change) < _LEAST_TIP_EFFECT
    seen = ", which is too sharp for the pixels to show" if unseen else ""
    relative = Change(float(largest["pull_off_change"]), float(largest["standard_error"]), int(largest["places"]))
    missing = int(largest["missing_places"])
    off = ": subtracted from the mean, and half of it counted as error" * (entry in BIASES)
    how = f"{words.format(settings)}{seen}{off}; {_count(relative.places, missing)}"
    return _Entry(relative, how, missing, entry in BIASES, _slope(cases))


def _slope(cases: xr.Dataset) -> float:
    """Return d ln F / d ln parameter through the cases, or from the base to a single case."""
    ratio, change = np.log(cases["parameter_ratio"].values), np.log1p(cases["pull_off_change"].values)
    known = np.isfinite(ratio) & np.isfinite(change) & (ratio != 0)
    if not known.any():
        return np.nan
    if known.sum() == 1:
        return float((change / ratio)[known][0])
    return float(np.polyfit(ratio[known], change[known], 1)[0])


def _count(places: int, missing: int = 0) -> str:
    return f"{places} place{'s' * (places > 1)}" + f", {missing} more could not be followed" * bool(missing)


def _of_thin_menisci(ds: xr.Dataset, solved: xr.Dataset) -> _Entry:
    """Return by how much the law of thin menisci is too high, between rigid bodies at a few of the places."""
    some = regions.sample(regions.centres(ds, solved), _FIRST)
    errors = quietly(rigid, ds, subregions=some, delta=[0.0])["meniscus_error"].values
    errors = errors[np.isfinite(errors)]
    if errors.size == 0:
        return _none("the error of thin menisci is known at no place")
    error = float(errors.std(ddof=1) / np.sqrt(errors.size)) if errors.size > 1 else np.nan
    words = "the energy of menisci's edges, which their law leaves out, between rigid bodies; subtracted from the mean"
    change = Change(-float(errors.mean()), error, errors.size)
    return _Entry(change, f"{words}; {_count(errors.size)}", some.sizes["subregion"] - errors.size, bias=True)


def _of_short_waves(scales: xr.Dataset | None) -> _Entry:
    """Return the change when the scan's spectrum is extrapolated by one octave."""
    if scales is None:
        return _none("left out, no sphere, or a scan without a spectrum to continue")
    shown, force = scales.attrs["shortest_wavelength"], scales["pull_off_force"].mean("seed")
    least, own = force.isel(shortest_kept=0), force.sel(shortest_kept=shown, method="nearest")
    relative = change_of(least.values, own.values, shares(scales).values)
    wave, missing = float(least["shortest_kept"]), scales.sizes["subregion"] - relative.places
    words = f"spectrum extrapolated from {shown:.3g} down to {wave:.3g} nm, random surfaces: {scales.sizes['seed']}"
    return _Entry(relative, f"{words}; {_count(relative.places, missing)}", missing)


def _known(ds: xr.Dataset, solved: xr.Dataset) -> dict[str, float]:
    """Return further variables that a reader should see beside the entries."""
    catalogue = quietly(asperities, ds)
    (tip_radius,) = SIMULATED["tip radius"]
    sharp = tip_flags(catalogue, tip_radius=tip_radius)["sharper_than_tip"]
    resolution = solved["pull_off_resolution"] / solved["refinement"]
    return {
        "shortest_wavelength": float(catalogue.coords.get("shortest_wavelength", np.nan)),
        "contact_radius_pixels": float(resolution.median()),
        "sharper_than_tip": float(sharp.mean()) if sharp.size else np.nan,
        "tip_radius": tip_radius,
    }


def _decided(entries: Mapping[str, _Entry], places: int) -> str:
    """Return a sentence on how well the total is known, and by how many places."""
    solved = [entry.change.places for name, entry in entries.items() if name != SAMPLING and entry.change.places]
    if not solved:
        return "No change was computed."
    least, most = min(solved), max(solved)
    count = f"{least}" if least == most else f"{least} to {most}"
    part = np.sqrt(sum(_unsure(entries).values())) / max(_total(entries), 1e-300)
    if not np.isfinite(part):
        return f"Too few places for a standard error of the total: each change is solved at {count} of {places}."
    return f"The total has a standard error of {percent(part)}: each change is solved at {count} of {places} places."


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


def _need_factors(ds: xr.Dataset, settings: Mapping[str, Sequence] | None) -> None:
    """Raise where bodies do not adhere, or a factor does not exist, or not for a dry pair."""
    if work_of(ds) <= 0:
        raise ValueError("expected a pair with work_of_adhesion > 0, found 0; assign one with assign_pair")
    for factor in settings or ():
        schema.one_of(factor, (*OF_SOLVES, *CHANGES), "settings")
        if factor in HUMID_SETTINGS and not schema.is_wet(ds):
            raise ValueError(
                f"settings: expected a humid pair for {factor!r}, found a dry one; assign_pair(humidity=…) first"
            )


def _cases_of(ds: xr.Dataset, settings: Mapping[str, Sequence] | None) -> list[Case]:
    """Return the base and the changes of the simulation, by default all that a scan and its pair have."""
    more = (OF_YIELD if "hardness" in ds.coords else {}) | (HUMID_SETTINGS if schema.is_wet(ds) else {})
    return cases(_with_range(ds), SIMULATED | more if settings is None else settings)


def _compared(
    tried: Sequence[Case],
    solved: xr.Dataset,
    *,
    preload: float,
    mesh: Mesh,
    finer: xr.Dataset | None = None,
) -> Comparison:
    """Return cases to be compared to the simulation of a scan, on the largest cells that the law bears.

    A law without range has no such cells, and is solved on the median mesh of the simulation.

    ``finer``, if given, is the simulation at some of the places with cells and steps halved.
    """
    ds, law, step = tried[0].ds, solved.attrs["law"], float(mesh.step)
    meshes = _first_preload(solved, "refinement").values
    pulls = _first_preload(solved)
    usual = int(np.quantile(meshes, 0.5, method="higher"))
    cells = usual if law in EDGED else min(cells_for(ds, preload, law), int(meshes.max()))
    way = Simulation(
        regions.centres(ds, solved), preload, law, Mesh(cells, None, step), float(by_share(pulls).mean()), meshes
    )
    alike = mesh.refine != "auto" or mesh.accuracy is None  # else some places took shorter steps
    known = {(n, step): np.where(meshes == n, pulls.values, np.nan) for n in np.unique(meshes).tolist() if alike}
    if finer is not None:
        some = dict(zip(_places_of(finer), _first_preload(finer).values))
        known[2 * int(meshes.max()), step / 2] = np.array([some.get(place, np.nan) for place in _places_of(solved)])
    return Comparison(tried, way, known)


def _first_preload(solved: xr.Dataset, name: str = "pull_off_force") -> xr.DataArray:
    """Return the pull-off, or another variable, at each place, of several preloads that from the first."""
    values = solved[name]
    return values.isel(preload=0) if "preload" in values.dims else values


def _places_of(solved: xr.Dataset) -> list[tuple[float, float]]:
    return list(zip(*(solved[name].values.tolist() for name in ("subregion_x", "subregion_y"))))


def _with_range(ds: xr.Dataset) -> xr.Dataset:
    """Return a scan to which the range of adhesion that `adhesive` would use is assigned."""
    return ds.assign_coords(adhesion_range=range_of(ds))
