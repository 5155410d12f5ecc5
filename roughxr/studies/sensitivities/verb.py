"""Sensitivity of the pull-off to each assumption, computed at the same places.

One factor at a time is changed from the given scan and pair.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ...bodies.liquid import work_of
from ...bodies.pair import range_of
from ...contact.adhesion import adhesive
from ...contact.mesh import COARSE, Mesh, mesh_of
from ...scans import regions
from ...statistics.sampling import by_share
from ...vocabulary import schema
from ...vocabulary.units import Places, Quantity, magnitude
from ...vocabulary.verbs import verb
from ..short_waves import quietly
from .changes import CHANGES, OF_FITS, OF_LIQUID, OF_SOLVES, OF_YIELD, SETTINGS, SIMULATED, Case, cases
from .simulated import Comparison, Simulation, cells_for
from .superposed import Sweep, superposed, sweep_of

METHODS = ("superpose", "adhesive")


@verb
def sensitivity(
    ds: xr.Dataset,
    *,
    method: str = "superpose",
    subregions: Places = None,
    settings: Mapping[str, Sequence] | None = None,
    preload: Quantity | None = None,
    law: str | None = None,
    mesh: Mesh | int | str | None = None,
) -> xr.Dataset:
    """Return how the pull-off force changes with each assumption.

    Parameters
    ----------
    ds : Dataset
        A scan with an adhesive pair.
    method : {"superpose", "adhesive"}
        "superpose": superposed asperities; "adhesive": the simulation, which solves every place anew in each case (take
        a few, such as ``regions.sample(centres, 4)``).
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`; the same in all cases.
    settings : mapping of str to sequence, optional
        Settings to try for each factor, by default ``SETTINGS`` or, for "adhesive", ``SIMULATED``: "levelling"
        ("plane", "quadratic" or "cubic"), "pixel" (number joined along each axis), "height step" (nm, rounding), "tip
        radius" (nm, of a tip removed from the scan), "surface energy", "modulus" and "sphere radius" (factors), of a
        humid pair "humidity" and "contact angle" (to be added, angles in degrees on both bodies); for "superpose" also
        "fit window" (pixels) and "vertex" (as for `asperities`); for "adhesive" also "mesh" (factor by which cells are
        finer and steps shorter), "preload" (to be added, in mean pull-offs), "interpolation" ("splines"
        between the pixels), "range of adhesion" and "hardness" (factors; hardness by default only where one is
        assigned; if it is listed for named materials without one, they yield at their estimated hardness).
    preload, law, mesh
        Options of `adhesive` for that method; by default 0 nN, "auto" and ``Mesh(accuracy=None, step=0.4)``, the
        coarsest mesh on which the law can be solved.

    Returns
    -------
    Dataset
        Along ``case``, of which the first is the base: ``pull_off_mean``, ``pull_off_std``, ``pull_off_median`` (nN);
        coordinates ``factor`` and ``setting``. For "superpose" also the ends ``pull_off_mean_low`` and
        ``pull_off_mean_high`` (95 %, block bootstrap), ``asperities``, ``unbracketed`` (places whose sweep was too
        short), and ``sharper_than_tip``, the share of asperities too sharp for the tip (NaN in other cases). For
        "adhesive" also ``pull_off_change``, that of the mean from the base case on cells of the same size, over the
        ``places`` known in both, with its ``standard_error`` by their scatter, the number of ``missing_places``,
        ``refinement``, the ``pull_off_force`` of each place, and ``reason``, why a case has no results.

    Raises
    ------
    ValueError
        If no pair with adhesion is assigned, or the method does not have a factor.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((64, 64), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.2)
    >>> found = sensitivity(scan, subregions=(3, 3), settings={"surface energy": [2.0]})
    >>> found.setting.values.tolist(), bool(found.pull_off_mean[1] > found.pull_off_mean[0])
    (['as given', '× 2'], True)
    """
    ds = schema.validate(ds, "scan")
    method = schema.one_of(method, METHODS, "method")
    need_factors(ds, settings, method)
    centres = regions.centres(ds, subregions)
    if method == "superpose":
        schema.refuse_unused("method='superpose'", preload=preload, law=law, mesh=mesh)
        more = OF_LIQUID if schema.is_wet(ds) else {}
        tried = cases(ds, SETTINGS | more if settings is None else settings)
        out, arguments = superposed(ds, tried, Sweep(centres, sweep_of(ds))), {}
    else:
        load = magnitude(0.0 if preload is None else preload, "nN", "preload")
        how = {"preload": load, "law": law or "auto", "mesh": mesh_of(mesh, COARSE)}
        solved = quietly(adhesive, ds, subregions=centres, **how)
        tried = cases_of(ds, settings)
        found = compared(tried, solved, preload=load, mesh=how["mesh"], cells=int(solved["refinement"].max()))
        found.solve(range(len(tried)), range(centres.sizes["subregion"]))
        out, arguments = found.told(), how
    out = out.assign_coords(factor=("case", [case.factor for case in tried])).assign_attrs(method=method)
    arguments |= {"method": method, "settings": settings}
    return schema.record(schema.label(out), "sensitivity", ds, subregions=subregions, **arguments)


def need_factors(ds: xr.Dataset, settings: Mapping[str, Sequence] | None, method: str) -> None:
    """Raise where bodies do not adhere, or a factor is none of the method's or of a dry pair's."""
    if work_of(ds) <= 0:
        raise ValueError("expected a pair with work_of_adhesion > 0, found 0; assign one with assign_pair")
    known = *(OF_FITS if method == "superpose" else OF_SOLVES), *(name for name in CHANGES if name not in OF_SOLVES)
    for factor in settings or ():
        schema.one_of(factor, known, "settings")
        if factor in OF_LIQUID and not schema.is_wet(ds):
            raise ValueError(
                f"settings: expected a humid pair for {factor!r}, found a dry one; assign_pair(humidity=…) first"
            )


def cases_of(ds: xr.Dataset, settings: Mapping[str, Sequence] | None) -> list[Case]:
    """Return the base and the changes of the simulation, by default all that a scan and its pair have."""
    more = (OF_YIELD if "hardness" in ds.coords else {}) | (OF_LIQUID if schema.is_wet(ds) else {})
    return cases(_with_range(ds), SIMULATED | more if settings is None else settings)


def compared(
    tried: Sequence[Case],
    solved: xr.Dataset,
    *,
    preload: float,
    mesh: Mesh,
    cells: int | None = None,
    finer: xr.Dataset | None = None,
) -> Comparison:
    """Return cases to be compared to the simulation of a scan, by default on the largest cells that the law bears.

    ``finer``, if given, is the simulation at some of the places with cells and steps halved.
    """
    ds, law, step = tried[0].ds, solved.attrs["law"], float(mesh.step)
    meshes = first_preload(solved, "refinement").values
    cells, pulls = cells or min(cells_for(ds, preload, law), int(meshes.max())), first_preload(solved)
    way = Simulation(
        regions.centres(ds, solved), preload, law, Mesh(cells, None, step), float(by_share(pulls).mean()), meshes
    )
    alike = mesh.refine != "auto" or mesh.accuracy is None  # else some places took shorter steps
    known = {(n, step): np.where(meshes == n, pulls.values, np.nan) for n in np.unique(meshes).tolist() if alike}
    if finer is not None:
        some = dict(zip(_places_of(finer), first_preload(finer).values))
        known[2 * int(meshes.max()), step / 2] = np.array([some.get(place, np.nan) for place in _places_of(solved)])
    return Comparison(tried, way, known)


def first_preload(solved: xr.Dataset, name: str = "pull_off_force") -> xr.DataArray:
    """Return the pull-off, or another variable, at each place, of several preloads that from the first."""
    values = solved[name]
    return values.isel(preload=0) if "preload" in values.dims else values


def _places_of(solved: xr.Dataset) -> list[tuple[float, float]]:
    return list(zip(*(solved[name].values.tolist() for name in ("subregion_x", "subregion_y"))))


def _with_range(ds: xr.Dataset) -> xr.Dataset:
    """Return a scan to which the range of adhesion that `adhesive` would use is assigned."""
    return ds.assign_coords(adhesion_range=range_of(ds))
