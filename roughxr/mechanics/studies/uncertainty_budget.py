"""An error budget of the simulated pull-off: the known uncertainties of its mean, and their sources.

Each entry is a standard deviation of ln(mean pull-off), with its own standard error. The entry of places is the
standard error of the mean over the places of this scan. Every other entry is ln(1 + |change of the mean|), over a
sample of places, when one assumption is changed by about its uncertainty. A known bias, as from the mesh to a mesh
twice as fine, is subtracted from the mean, and a part of it is its entry. An entry that was not computed is NaN.

Roughness finer than the scan is not an entry, since its heights are unknown rather than uncertain: see `extrapolated`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

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
from ..statistics.sampling import mean_of_places, place_order, shares
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from ..vocabulary.error_sources import (
    CHANGED,
    ERROR_SOURCES,
    HALF_WIDTH,
    MESH,
    PLACES,
    RANGE,
    THIN,
    KnownError,
    error_table,
    symmetric_error,
    total_bias,
    total_error,
)
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import without_warnings
from ..vocabulary.units import Places, whole_number
from .assumptions import HUMID, pair_factors, range_deviation
from .budget_changes import Base, Change, FactorCase, changes, mean_change, needed_cells

#: Part of a known bias that is counted as uncertainty, of the mesh about the change by still finer meshes: their order
#: of convergence lies between one and two.
_BIAS_PART = 0.5


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
        Along ``entry``, the factors, ``"places"``, and for a humid pair the error of the law of thin menisci:
        ``relative_std``, the standard deviation of ln(mean), and its own ``standard_error`` by the scatter over places;
        ``pull_off_change``, relative, with its sign, and the ``setting`` that gives it; ``known_bias``, whether it is
        subtracted; ``slope``, d ln F/d ln parameter, if the change multiplies a parameter; ``places`` at which it is
        known, of the ``tried_places``; the ``reason`` why it is not known. ``total_std``, the root of the sum of
        squares of all computed entries, and ``total_standard_error``; ``pull_off_mean`` (nN), that of `adhesive`, and
        ``pull_off_corrected``, without known biases. Each change is solved at ``changed_places`` of the
        ``solved_places`` (attributes).

    Raises
    ------
    ValueError
        If the pair has no work of adhesion, or ``settings`` names no source of error.

    Notes
    -----
    For a factor that is changed both up and down, the larger change is used. The changes are taken as independent,
    each as one standard deviation: that of ln(mean) is ``ln(1 + |change|)``. The entry of places is s/√n over the
    mean, n the number of independent places. The entry of a known bias is that of half of it, of a mesh without range
    of 1.5 times it, combined with its standard error.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    >>> budget = scan.contact.error_budget(settings={"work of adhesion": [0.9, 1.1]}, places=1, law="jkr")
    >>> bool(budget.relative_std.sel(entry="work of adhesion") > 0.05), budget.setting.sel(entry="modulus").item()
    (True, '')
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
    deviation = range_deviation(ds) if settings is None else None
    settings = {name: usual[name] for name in usual if name in only} if settings is None else dict(settings)
    pulls = solved["pull_off_force"]
    law = solved.attrs["law"]
    mean = mean_of_places(pulls)
    errors = {PLACES: _error_of_places(pulls)}
    if MESH in settings and (finer is not None or not solved["mesh"].any()):
        del settings[MESH]
        errors[MESH] = stated_mesh_error(solved) if finer is None else _on_finer_mesh(solved, finer)
    sampled = regions.sample(solved, places)
    base = _base(ds, solved, sampled, preload=preload, mesh=mesh)
    cases = changes(base, regions.centres(ds, sampled), settings, pull=mean, meshes=sampled["mesh"].values)
    count = sampled.sizes["subregion"]
    for name in dict.fromkeys([*usual, *settings]):
        same_factor = [case for case in cases if case.factor == name]
        errors.setdefault(name, _error_of_factor(name, same_factor, count, law, deviation if name == RANGE else None))
    if schema.is_humid(ds):
        errors[THIN] = _thin_menisci(ds, solved)
    total = total_error(errors.values())
    out = error_table(errors).assign(
        total_std=total.std,
        total_standard_error=total.standard_error,
        pull_off_mean=mean,
        pull_off_corrected=mean * (1 + total_bias(errors.values())),
    )
    out = out.assign_coords(schema.pair_coordinates(ds))
    out.attrs = {"law": law, "changed_places": count, "solved_places": solved.sizes["subregion"]}
    return schema.label(out)


def _base(ds: xr.Dataset, solved: xr.Dataset, sampled: xr.Dataset, *, preload: float, mesh: Mesh) -> Base:
    """Return the simulation at a sample of places to which changes are compared."""
    law = solved.attrs["law"]
    bare = ds.assign_coords(adhesion_range=read_pair(ds).range)
    cells = int(np.quantile(solved["mesh"], 0.5, method="higher"))
    if not ADHESION_LAWS[law].has_edge:
        cells = min(needed_cells(bare, preload, law), int(solved["mesh"].max()))
    step = longest_step(specimen_of(ds), mesh)
    return Base(bare, preload, law, np.full(sampled.sizes["subregion"], cells), step)


def _error_by_change(change: Change, bias_part: float | None = None, **basis) -> KnownError:
    """Return the error by a change of the mean, of a known bias by a part of it and its standard error."""
    size = abs(change.value)
    if bias_part is not None:
        size = float(np.hypot(bias_part * change.value, np.nan_to_num(change.error)))
    return symmetric_error(
        np.log1p(size),
        standard_error=change.error / (1 + size),
        pull_off_change=change.value,
        known_bias=bias_part is not None,
        places=change.places,
        **basis,
    )


def _error_of_factor(
    factor: str, cases: Sequence[FactorCase], tried: int, law: str, deviation: float | None = None
) -> KnownError:
    """Return the error by the largest change among a factor's settings, or by their slope for another deviation."""
    known = [case for case in cases if case.change.places]
    if not known:
        return KnownError(tried_places=tried, reason=cases[0].reason) if cases else KnownError()
    largest = max(known, key=lambda case: abs(case.change.value))
    slope = _slope(factor, known)
    change = largest.change
    setting = largest.setting
    if deviation is not None and change.value:
        change = _scaled(change, slope, deviation)
        setting = deviation
    text = setting if isinstance(setting, str) else f"{setting:g}"
    part = bias_part(MESH, law) if factor == MESH else None
    return _error_by_change(change, part, slope=slope, tried_places=tried, setting=text)


def bias_part(source: str, law: str) -> float:
    """Return the part of the known bias of a source that counts as its error."""
    # without range the order of convergence on soft rough bodies is a half
    return 1.5 if source == MESH and not ADHESION_LAWS[law].has_range else _BIAS_PART


def _scaled(change: Change, slope: float, deviation: float) -> Change:
    """Return the change of a parameter by this factor up or down, by its slope."""
    larger = float(np.sign(slope) * np.expm1(abs(slope) * np.log(deviation)))
    return Change(larger, change.error * abs(larger / change.value), change.places)


def _slope(factor: str, cases: Sequence[FactorCase]) -> float:
    """Return d ln F / d ln parameter through the cases, or from the base to a single case."""
    if not ERROR_SOURCES[factor].is_ratio or all(case.setting == 1 for case in cases):
        return np.nan
    ratio = np.log([case.setting for case in cases])
    change = np.log1p([case.change.value for case in cases])
    return float(change[0] / ratio[0]) if len(cases) == 1 else float(np.polyfit(ratio, change, 1)[0])


def stated_mesh_error(solved: xr.Dataset) -> KnownError:
    """Return the error of the mean by those that a simulation states of its places, at 95 %."""
    count = solved["pull_off_force"].size
    return symmetric_error(mesh_error(solved) / HALF_WIDTH, places=count, tried_places=count)


def _on_finer_mesh(solved: xr.Dataset, finer: xr.Dataset) -> KnownError:
    """Return the error by the change at the places of a simulation with cells and steps halved."""
    base = solved.isel(subregion=place_order(finer, solved))
    change = mean_change(finer["pull_off_force"].values, base["pull_off_force"].values, shares(base).values)
    return _error_of_factor(MESH, [FactorCase(MESH, 2, change)], finer.sizes["subregion"], solved.attrs["law"])


def _error_of_places(force: xr.DataArray) -> KnownError:
    """Return the standard error of the mean by the choice of places on this surface."""
    count = int(force.notnull().sum())
    if count < 2:
        return KnownError(places=count, tried_places=force.size)
    intervals = bootstrap(force.to_dataset(name="pull_off_force"), "pull_off_force", statistics=["mean", "std"])
    independent = float(intervals["independent_places"])
    mean, deviation = (float(intervals["estimate"].sel(statistic=name)) for name in ("mean", "std"))
    std = deviation / np.sqrt(independent) / mean
    error = std / np.sqrt(2 * max(independent - 1, 1))  # of a standard deviation
    return symmetric_error(std, standard_error=float(error), places=count, tried_places=force.size)


def _thin_menisci(ds: xr.Dataset, solved: xr.Dataset) -> KnownError:
    """Return the excess by the law of thin menisci, between rigid bodies at a few places."""
    # places at which the error of thin menisci is computed
    sampled = regions.sample(regions.centres(ds, solved), 4)
    tried = sampled.sizes["subregion"]
    errors = without_warnings(rigid, ds, subregions=sampled, delta=[0.0])["meniscus_error"].values
    errors = errors[np.isfinite(errors)]
    if errors.size == 0:
        return KnownError(tried_places=tried)
    error = float(errors.std(ddof=1) / np.sqrt(errors.size)) if errors.size > 1 else np.nan
    return _error_by_change(Change(-float(errors.mean()), error, errors.size), _BIAS_PART, tried_places=tried)


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
