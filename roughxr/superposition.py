"""Superposition: the contact of a sphere with a scan's asperities, each as if it stood alone.

The quick way from a scan to adhesion, and the paper's; `direct` tells where it stops being true.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import dask
import numpy as np
import xarray as xr

from . import parallel, regions, schema
from .asperities import asperities, later
from .kernels import superposition as sums
from .kernels.asperity_contact import LAWS, asperities_scales
from .kernels.asperity_contact import law as read_law
from .kernels.indenter import PROFILES

#: Formulations of adhesion on an elliptic asperity.
FORMULATIONS = LAWS[1:]

_COUNTS = ("contacts", "contacts_beyond_patch", "contacts_overlapping")
_VARIABLES = ("force", "contact_area", *_COUNTS, "truncated")


class Options(NamedTuple):
    """What every task needs to know."""

    deltas: np.ndarray
    law: str
    composite: bool
    profile: int
    first_contact: bool
    radius: float
    contact_modulus: float
    work_of_adhesion: float


def superpose(
    ds: xr.Dataset,
    *,
    delta: Any,
    subregions: Any = None,
    law: str = "jkr",
    formulation: str = "energy",
    datum: str = "highest_peak",
    profile: str = "sphere",
    progress: bool = False,
) -> xr.Dataset:
    """Sum the contacts of all asperities with a sphere at each contact centre.

    Parameters
    ----------
    ds : Dataset
        A scan (its asperities are then found with the default patch) or an asperity catalogue, with an
        assigned pair.
    delta : array_like
        Displacements, nm, ascending.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"jkr", "hertz"}
        With or without adhesion.
    formulation : {"energy", "self_similar", "johnson_greenwood", "published"}
        How adhesion acts on an ellipse: its shape found by minimising the energy over both axes; Hertz's shape
        kept (the paper's derivation, corrected); the edge condition at the ends of both axes; the paper to the
        letter, with λ² where the derivation gives λ and the asperity's curvature alone. All but the last add
        the sphere's own curvature to the asperity's.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0: the sphere's lowest point level with the highest point of the whole scan, or this
        subregion's first touch of a vertex.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    progress : bool
        Show a bar while computing.

    Returns
    -------
    Dataset
        ``force`` (nN, negative pulls) and ``contact_area`` (nm²) along (subregion, delta); how many
        ``contacts`` there are, how many of them reach beyond the patch that their paraboloid was fitted to, and
        how many farther than the next asperity, where superposition loses its ground; ``truncated`` where an
        asperity at the scan's edge is in contact. ``excluded_asperities`` counts the saddles left out. Lazy
        where the scan is a dask array.

    Raises
    ------
    ValueError
        If no pair is assigned, no work of adhesion for law="jkr", the indenter is no sphere, or the
        displacements are empty, not finite or not ascending.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 15–24 and 35, printed with λ² for λ and with the sign of eq. 35 reversed.
    Johnson & Greenwood (2005) for the formulation of that name.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> sweep = superpose(scan, delta=np.arange(-5, 15, 0.5), subregions=(2, 2))
    >>> bool((sweep.force.min("delta") < 0).all())
    True
    """
    kind = "asperities" if "asperity" in ds.dims else "scan"
    ds = schema.validate(ds, kind)
    options = options_of(ds, delta, law, formulation, datum, profile)
    positions = regions.centres(ds, subregions)
    lazy = parallel.is_lazy(ds)
    later_on = lazy and kind == "scan"
    field = dask.delayed(catalogue_field)(later(ds), options) if later_on else catalogue_field(ds, options)
    centres = zip(positions["subregion_x"].values.tolist(), positions["subregion_y"].values.tolist())
    shape, when = (len(_VARIABLES) + 1, options.deltas.size), {"lazy": lazy, "progress": progress}
    packed = parallel.spread(_superpose, list(centres), shape, field, options, **when)
    out = _labelled(packed, ds, positions, options)
    out.attrs = {"datum": datum, "method": "superpose", "law": law, "formulation": formulation}
    out = schema.record(
        out,
        "superpose",
        ds,
        delta=options.deltas,
        subregions=subregions,
        law=law,
        formulation=formulation,
        datum=datum,
        profile=profile,
    )
    return parallel.finish(out, lazy=lazy, progress=progress)


def options_of(ds, delta, law, formulation, datum, profile) -> Options:
    """Return what every task needs to know, or say what is wrong with it."""
    schema.one_of(law, ("jkr", "hertz"), "law")
    schema.one_of(formulation, FORMULATIONS, "formulation")
    schema.one_of(datum, ("highest_peak", "first_contact"), "datum")
    schema.one_of(profile, PROFILES, "profile")
    if "indenter_height" in ds:
        raise ValueError("expected a sphere (assign_pair with sphere_radius), found an indenter's map; use direct")
    radius, modulus = schema.pair(ds, "sphere_radius", "contact_modulus")
    return Options(
        deltas=schema.ascending(delta, "nm", "delta"),
        law="hertz" if law == "hertz" else formulation,
        composite=formulation != "published",
        profile=PROFILES[profile],
        first_contact=datum == "first_contact",
        radius=radius,
        contact_modulus=modulus,
        work_of_adhesion=0.0 if law == "hertz" else schema.pair(ds, "work_of_adhesion")[0],
    )


def catalogue_field(ds: xr.Dataset, options: Options) -> tuple:
    """Return the asperities that are peaks under this sphere, the patch's half-width and the number left out."""
    from scipy.spatial import cKDTree

    catalogue = ds if "asperity" in ds.dims else asperities(ds)
    sphere = 0.5 / options.radius if options.composite else 0.0
    A, B = (0.5 * catalogue[name].values + sphere for name in ("curvature_min", "curvature_max"))
    scales = asperities_scales(A, B, options.contact_modulus, options.work_of_adhesion, read_law(options.law))
    x, y = catalogue["x"].values, catalogue["y"].values
    spacing = cKDTree(np.c_[x, y]).query(np.c_[x, y], k=2)[0][:, 1] if x.size > 1 else np.full(x.size, np.inf)
    depth = float(catalogue["datum_height"]) - catalogue["height"].values
    at_edge = catalogue["edge"].values.astype(float) if "edge" in catalogue else np.zeros(x.size)
    peaks = np.isfinite(scales.P)
    kept = [array[peaks] for array in (x, y, depth, spacing, at_edge)]
    scales = type(scales)(*(array[peaks] for array in scales))
    return sums.Field(*kept, scales), float(catalogue["patch_radius"]), int((~peaks).sum())


def _superpose(x: float, y: float, prepared: tuple, options: Options) -> np.ndarray:
    """Sum one subregion's sweep; return (variables and the number of excluded asperities, delta)."""
    field, patch_radius, excluded = prepared
    offset = sums.offsets(field, x, y, options.radius, options.profile)
    zero = offset.min() if options.first_contact and offset.size else 0.0
    branch = read_law(options.law).branch
    summed = sums.superpose(options.deltas + zero, field, offset, patch_radius, branch)
    return np.vstack([summed, np.full(options.deltas.size, float(excluded))])


def _labelled(packed, ds: xr.Dataset, positions: xr.Dataset, options: Options) -> xr.Dataset:
    out = xr.Dataset({name: (("subregion", "delta"), packed[:, k]) for k, name in enumerate(_VARIABLES)})
    out["excluded_asperities"] = packed[0, -1, 0].astype(int) if options.deltas.size else 0
    for name in _COUNTS:
        out[name] = out[name].astype(int)
    out["truncated"] = out["truncated"] > 0
    pair = {name: ds[name] for name in schema.PAIR if name in ds.coords}
    return schema.label(out.assign_coords(delta=options.deltas, **pair).assign_coords(positions.coords))
