"""An error budget of the simulated pull-off: the known uncertainties of its mean, and their sources.

Each entry is a relative standard deviation of the mean pull-off, with its own standard error. The entry of sampling is
the standard error of the mean over places of this scan. Every other entry is the change of the mean, over a sample of
places, when one assumption is changed by about its uncertainty. A known bias, as from the mesh to a mesh twice as fine,
is subtracted from the mean, and a part of it is its entry. An entry that was not computed is NaN and states the reason.

Roughness finer than the scan is not an entry, since its heights are unknown rather than uncertain: see `extrapolated`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..contact.adhesion import adhesive
from ..contact.adhesive_options import longest_step
from ..contact.mesh import Mesh, read_mesh
from ..contact.rigid.bodies import rigid
from ..scans import regions
from ..specimen import specimen_of
from ..statistics import bootstrap
from ..statistics.means import mesh_error
from ..statistics.sampling import place_order, shares, weighted_by_landing_share
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from ..vocabulary.error_sources import CHANGED, ERROR_SOURCES, MESH, RANGE, SAMPLING, THIN, total_std
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import without_warnings
from ..vocabulary.units import Places, whole_number
from .assumptions import HUMID, pair_factors, range_deviation
from .budget_changes import Base, Change, FactorCase, changes, mean_change, needed_cells

#: Part of a known bias that is counted as uncertainty, of the mesh about the change by still finer meshes: their order
#: of convergence lies between one and two.
_BIAS_PART = 0.5


class _Entry(NamedTuple):
    """One entry: the change of the mean, and how it was computed or why it was not."""

    change: Change
    how: str
    bias: bool = False
    slope: float = np.nan  # d ln F / d ln parameter
    part: float = _BIAS_PART  # of a bias, as uncertainty

    @property
    def value(self) -> float:
        """The relative standard deviation; of a bias, a part of it combined with its standard error."""
        if self.bias:
            return float(np.hypot(self.part * self.change.value, np.nan_to_num(self.change.error)))
        return abs(self.change.value)


def _not_computed(why: str) -> _Entry:
    return _Entry(Change(np.nan, np.nan, 0), f"not computed: {why}")


@schema.recorded
def error_budget(
    ds: xr.Dataset,
    *,
    subregions: Places = None,
    places: int = 8,
    law: str = "auto",
    mesh: Mesh | int | str = "auto",
    settings: Mapping[str, Sequence] | None = None,
) -> xr.Dataset:
    """Return the uncertainty of the mean simulated pull-off, with an entry for each source.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an adhesive pair.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, by default those on ``ds``, else one in its middle; take a grid, such as (8, 8).
    places : int
        Number of places at which each change is solved.
    law, mesh
        As in `adhesive` at preload 0, which computes the mean at all centres. Changes are solved on the coarsest mesh
        that the law allows, and compared to the base on that mesh.
    settings : mapping of str to sequence, optional
        The uncertainty of each factor, by default one standard deviation: "mesh" (factor by which cells are finer and
        steps shorter), "preload" (added, in mean pull-offs), "levelling" ("plane" or "quadratic"), "interpolation"
        ("splines"), "tip radius" (nm, of the tip removed), "noise" (in parts of its upper limit), "range of adhesion",
        "work of adhesion", "modulus", "layer thickness", "sphere radius" and "hardness" (factors; thickness and
        hardness where assigned), of a humid pair "humidity" and "contact angle" (added, degrees). A factor that is left
        out is not computed, and one that is known to be exact, such as ``{"modulus": [1.0]}``, gives 0.

    Returns
    -------
    Dataset
        Along ``entry``, the factors, ``"sampling"``, and for a humid pair the error of the law of thin menisci:
        ``relative_std``, and its own ``standard_error`` by the scatter over places; ``pull_off_change``, with its
        sign; ``known_bias``, whether it is subtracted; ``slope``, d ln F/d ln parameter, if the change multiplies a
        parameter; ``places`` at which it is known, and ``how``. ``total_std``, the root of the sum of squares of all
        computed entries, and ``total_standard_error``; ``pull_off_mean`` (nN), that of `adhesive`, and
        ``pull_off_corrected``, without known biases. Each change is solved at ``changed_places`` of the
        ``solved_places`` (attributes).

    Raises
    ------
    ValueError
        If the pair has no work of adhesion, or ``settings`` names no source of error.

    Notes
    -----
    For a factor that is changed both up and down, the larger change is used. The changes are taken as independent, each
    as one standard deviation; the entry of sampling is s/√n, n the number of independent places. The entry of a known
    bias is half of it, that of a mesh without range 1.5 times it, combined with its standard error.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    >>> budget = scan.contact.error_budget(settings={"work of adhesion": [0.9, 1.1]}, places=1, law="jkr")
    >>> bool(budget.relative_std.sel(entry="work of adhesion") > 0.05), budget.how.sel(entry="mesh").item()
    (True, 'not computed: left out of the settings')
    """
    ds = schema.validate(ds, "scan")
    count = whole_number(places, "places", least=1)
    _need_factors(ds, settings)
    mesh = read_mesh(mesh, Mesh())
    solved = without_warnings(adhesive, ds, subregions=regions.centres(ds, subregions), preload=0.0, law=law, mesh=mesh)
    return budget_of(ds, solved, places=count, preload=0.0, mesh=mesh, settings=settings)


def budget_of(
    ds: xr.Dataset,
    solved: xr.Dataset,
    *,
    places: int,
    preload: float,
    mesh: Mesh,
    settings: Mapping[str, Sequence] | None = None,
    finer: xr.Dataset | None = None,
    only: Collection[str] = CHANGED,
) -> xr.Dataset:
    """Return the budget of a simulation at all places, ``solved`` on ``mesh``, by default by ``only`` some factors.

    ``finer``, if given, is the simulation at some of the places with cells and steps halved, for the entry of the mesh.
    """
    usual = pair_factors(ds)
    by_default = settings is None
    settings = {name: usual[name] for name in usual if name in only} if settings is None else dict(settings)
    pulls = solved["pull_off_force"]
    law = solved.attrs["law"]
    entries: dict[str, _Entry] = {}
    mean = float(weighted_by_landing_share(pulls).mean())
    if finer is not None and MESH in settings:
        del settings[MESH]
        entries[MESH] = _entry(MESH, [_on_finer_mesh(solved, finer)], finer.sizes["subregion"], law)
    elif MESH in settings and not solved["mesh"].any():
        del settings[MESH]
        how = "stated errors of places, by points, interpolation and the shape of the edge"
        entries[MESH] = _Entry(Change(mesh_error(solved), np.nan, pulls.size), how)
    sampled = regions.sample(solved, places)
    bare = ds.assign_coords(adhesion_range=read_pair(ds).range)
    cells = int(np.quantile(solved["mesh"], 0.5, method="higher"))
    if not ADHESION_LAWS[law].has_edge:
        cells = min(needed_cells(bare, preload, law), int(solved["mesh"].max()))
    count = sampled.sizes["subregion"]
    base = Base(bare, preload, law, np.full(count, cells), longest_step(specimen_of(ds), mesh))
    cases = changes(base, regions.centres(ds, sampled), settings, pull=mean, meshes=sampled["mesh"].values)
    for name in dict.fromkeys([*usual, *settings]):
        entries.setdefault(name, _entry(name, [case for case in cases if case.factor == name], count, law))
    if by_default:
        entries[RANGE] = _scaled(entries[RANGE], range_deviation(ds))
    if schema.is_humid(ds):
        entries[THIN] = _thin_menisci(ds, solved)
    return _labelled(ds, solved, {SAMPLING: _sampling(pulls)} | entries, mean, count)


def _labelled(ds: xr.Dataset, solved: xr.Dataset, entries: dict[str, _Entry], mean: float, count: int) -> xr.Dataset:
    """Return the entries and their total as a Dataset."""
    columns = {
        "relative_std": [entry.value for entry in entries.values()],
        "standard_error": [entry.change.error for entry in entries.values()],
        "pull_off_change": [np.nan if name == SAMPLING else entry.change.value for name, entry in entries.items()],
        "slope": [entry.slope for entry in entries.values()],
        "known_bias": [entry.bias for entry in entries.values()],
        "places": [entry.change.places for entry in entries.values()],
        "how": [entry.how for entry in entries.values()],
    }
    total, total_deviation = _total(entries)
    scalars = {
        "total_std": total,
        "total_standard_error": total_deviation,
        "pull_off_mean": mean,
        "pull_off_corrected": mean * np.prod([1 + np.nan_to_num(e.change.value) for e in entries.values() if e.bias]),
    }
    out = xr.Dataset({name: ("entry", values) for name, values in columns.items()} | scalars, {"entry": list(entries)})
    out["standard_error"].attrs["units"] = "1"
    out = out.assign_coords(schema.pair_coordinates(ds))
    out.attrs = {"law": solved.attrs["law"], "changed_places": count, "solved_places": solved.sizes["subregion"]}
    return schema.label(out)


def _total(entries: Mapping[str, _Entry]) -> tuple[float, float]:
    """Return the root of the sum of squares of all computed entries, and its standard error.

    The square of a normal number of mean m and deviation s has the variance 4 m² s² + 2 s⁴.
    """
    computed = np.array([(entry.value, entry.change.error) for entry in entries.values() if np.isfinite(entry.value)])
    if not computed.size:
        return np.nan, np.nan
    value, error = computed.T
    total = total_std(value)
    return total, float(np.sqrt(((value**2 + 0.5 * error**2) * error**2).sum())) / max(total, 1e-300)


def _on_finer_mesh(solved: xr.Dataset, finer: xr.Dataset) -> FactorCase:
    """Return the change of the pull-off at the places of a simulation with cells and steps halved."""
    base = solved.isel(subregion=place_order(finer, solved))
    change = mean_change(finer["pull_off_force"].values, base["pull_off_force"].values, shares(base).values)
    return FactorCase(MESH, 2, "2", change)


def _sampling(force: xr.DataArray) -> _Entry:
    """Return the uncertainty from the choice of places on this surface."""
    count = int(force.notnull().sum())
    if count < 2:
        return _not_computed(f"needs at least two places that adhere, found {count}")
    intervals = bootstrap(force.to_dataset(name="pull_off_force"), "pull_off_force", statistics=["mean", "std"])
    independent = float(intervals["independent_places"])
    mean, deviation = (float(intervals["estimate"].sel(statistic=name)) for name in ("mean", "std"))
    value = deviation / np.sqrt(independent) / mean
    how = f"standard error of the mean over {count} places, equivalent to {independent:.3g} independent ones"
    error = value / np.sqrt(2 * max(independent - 1, 1))  # of a standard deviation
    return _Entry(Change(value, float(error), count), how)


def _entry(factor: str, cases: Sequence[FactorCase], count: int, law: str) -> _Entry:
    """Return the largest change among a factor's settings, solved at ``count`` places."""
    # without range the order of convergence on soft rough bodies is a half
    part = _BIAS_PART if ADHESION_LAWS[law].has_range else 1.5
    solved = [case for case in cases if case.change.places]
    if not solved:
        return _not_computed(cases[0].reason if cases else "left out of the settings")
    change = max((case.change for case in solved), key=lambda change: abs(change.value))
    how = ERROR_SOURCES[factor].words.format(" and ".join(case.words for case in solved))
    # least effect of a tip that the scan's pixels resolve: a sharper tip's flanks are steeper than all slopes
    if factor == "tip radius" and abs(change.value) < 1e-4:
        how += " (the pixels are too coarse to show it)"
    if factor == MESH:
        how += f"; this known bias is subtracted from the mean, and {part:g} times its size counts as error"
    return _Entry(change, f"{how}; {_count(change.places, count)}", factor == MESH, _slope(factor, solved), part)


def _scaled(entry: _Entry, deviation: float) -> _Entry:
    """Return the entry of a parameter that changes by this factor up or down, by its slope; unchanged without one."""
    if not entry.change.value:
        return entry
    larger = float(np.sign(entry.slope) * np.expm1(abs(entry.slope) * np.log(deviation)))
    error = entry.change.error * abs(larger / entry.change.value)
    how = f"{entry.how}; scaled to × {deviation:g}"
    return entry._replace(change=Change(larger, error, entry.change.places), how=how)


def _slope(factor: str, cases: Sequence[FactorCase]) -> float:
    """Return d ln F / d ln parameter through the cases, or from the base to a single case."""
    if not ERROR_SOURCES[factor].is_ratio or all(case.setting == 1 for case in cases):
        return np.nan
    ratio = np.log([case.setting for case in cases])
    change = np.log1p([case.change.value for case in cases])
    return float(change[0] / ratio[0]) if len(cases) == 1 else float(np.polyfit(ratio, change, 1)[0])


def _count(places: int, tried: int) -> str:
    return f"{places} place{'s' * (places > 1)}" + f", {tried - places} more have no result" * (places < tried)


def _thin_menisci(ds: xr.Dataset, solved: xr.Dataset) -> _Entry:
    """Return the excess by the law of thin menisci, between rigid bodies at a few places."""
    # places at which the error of thin menisci is computed
    sampled = regions.sample(regions.centres(ds, solved), 4)
    errors = without_warnings(rigid, ds, subregions=sampled, delta=[0.0])["meniscus_error"].values
    errors = errors[np.isfinite(errors)]
    if errors.size == 0:
        return _not_computed("the error of thin menisci is known at no place")
    error = float(errors.std(ddof=1) / np.sqrt(errors.size)) if errors.size > 1 else np.nan
    how = "the energy of menisci's edges, which their law neglects, between rigid bodies; subtracted from the mean"
    change = Change(-float(errors.mean()), error, errors.size)
    return _Entry(change, f"{how}; {_count(errors.size, sampled.sizes['subregion'])}", bias=True)


def _need_factors(ds: xr.Dataset, settings: Mapping[str, Sequence] | None) -> None:
    """Raise if bodies do not adhere, or a factor does not exist for this pair."""
    if read_pair(ds, "work_of_adhesion").work <= 0:
        raise Refusal("", "a pair with work_of_adhesion > 0", "0", "assign one with assign_pair")
    for factor, values in (settings or {}).items():
        schema.one_of(factor, CHANGED, "settings")
        if isinstance(values, str):
            raise Refusal("settings", f"a list for {factor!r}, such as [{values!r}]", f"{values!r}")
        if factor in HUMID and not schema.is_humid(ds):
            raise Refusal("settings", f"a humid pair for {factor!r}", "a dry one", "assign_pair(humidity=…) first")
