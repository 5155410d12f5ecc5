"""Superposition: the contact of a sphere with a scan's asperities, each as if it stood alone.

The quick way from a scan to adhesion, and the paper's; `direct` tells where it stops being true.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import dask
import numpy as np
import xarray as xr

from .. import regions, schema
from ..catalogue import asperities, later
from ..jobs import lazy as parallel
from ..kernels.asperity import superposition as sums
from ..kernels.asperity.laws import ASPERITY_LAWS, AsperityLaw, asperities_scales
from ..kernels.asperity.laws import law as read_law
from ..kernels.halfspace.separation import PROFILES
from ..units import positive

#: Laws that adhere, and all.
ADHESIVE = ("jkr", "maugis")
LAWS = (*ADHESIVE, "hertz")

#: Formulations of adhesion on an elliptic asperity, of the law "jkr".
FORMULATIONS = ASPERITY_LAWS[1:]

#: The formulation that is the default, and the one whose ellipses "maugis" has: what may be named beside it.
_DEFAULT, _OF_MAUGIS = "energy", "self_similar"

#: z₀ unless it is given, nm.
_DISTANCE = 0.3

_COUNTS = ("contacts", "contacts_beyond_patch", "contacts_overlapping")
_VARIABLES = ("force", "contact_area", *_COUNTS, "truncated")


class Options(NamedTuple):
    """What every task needs to know."""

    deltas: np.ndarray
    law: str  # the kernel's
    equilibrium_distance: float  # nm, NaN for a law without range
    composite: bool
    profile: int
    first_contact: bool
    radius: float
    contact_modulus: float
    work_of_adhesion: float

    def kernel_law(self) -> AsperityLaw:
        """Return the law as the kernels want it."""
        return read_law(self.law, self.equilibrium_distance) if self.law == "maugis" else read_law(self.law)


def superpose(
    ds: xr.Dataset,
    *,
    delta: Any,
    subregions: Any = None,
    law: str = "jkr",
    formulation: str = _DEFAULT,
    equilibrium_distance: Any = _DISTANCE,
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
    law : {"jkr", "maugis", "hertz"}
        Adhesion without range, of a range, or none. "maugis" is Maugis's and Dugdale's law between JKR and DMT,
        read for each asperity at its own λ = 1.157 μ, Tabor's μ taken with R = 1/(2√(AB)) (see `tabor`). It is the
        law of a sphere: an ellipse keeps Hertz's shape, its load is that of "self_similar" for large μ, and 2πwR for
        small μ less the same part (0.2 % at B/A = 1.5, 3 % at 5, 6 % at 10). The pull across a gap, before an
        asperity touches and after it lets go, is left out: on a surface of 1.5 nm rms less than 1 % of the pull-off
        for λ > 0.5, some 5 % at λ = 0.2, half of it where z₀ reaches the roughness (3 nm, λ = 0.02). Below λ = 0.02
        and above 50 the table's ends stand for DMT and JKR.
    formulation : {"energy", "self_similar", "johnson_greenwood", "published"}
        Of law="jkr": how adhesion acts on an ellipse: its shape found by minimising the energy over both axes;
        Hertz's shape kept (the paper's derivation, corrected); the edge condition at the ends of both axes; the
        paper to the letter, with λ² where the derivation gives λ and the asperity's curvature alone. All but the
        last add the sphere's own curvature to the asperity's.
    equilibrium_distance : number or quantity
        Of law="maugis": z₀ of the interatomic potential, nm, which sets the range of adhesion.
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
        If no pair is assigned, no work of adhesion for a law that adheres, the indenter is no sphere, the
        displacements are empty, not finite or not ascending, or a formulation is named beside law="maugis" that it
        does not have.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 15–24 and 35, printed with λ² for λ and with the sign of eq. 35 reversed.
    Johnson & Greenwood (2005) for the formulation of that name. Maugis, J. Colloid Interface Sci. 150, 243 (1992).

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
    options = options_of(ds, delta, law, formulation, equilibrium_distance, datum, profile)
    positions = regions.centres(ds, subregions)
    lazy = parallel.is_lazy(ds)
    later_on = lazy and kind == "scan"
    field = dask.delayed(catalogue_field)(later(ds), options) if later_on else catalogue_field(ds, options)
    centres = zip(positions["subregion_x"].values.tolist(), positions["subregion_y"].values.tolist())
    shape, when = (len(_VARIABLES) + 1, options.deltas.size), {"lazy": lazy, "progress": progress}
    packed = parallel.spread(_superpose, list(centres), shape, field, options, **when)
    out = _labelled(packed, ds, positions, options)
    named = law_of(law, formulation, options)
    out.attrs = {"datum": datum, "method": "superpose", **named}
    arguments = {"subregions": subregions, **named, "datum": datum, "profile": profile}
    out = schema.record(out, "superpose", ds, delta=options.deltas, **arguments)
    return parallel.finish(out, lazy=lazy, progress=progress)


def options_of(ds, delta, law, formulation, equilibrium_distance, datum, profile) -> Options:
    """Return what every task needs to know, or say what is wrong with it."""
    distance = _checked(law, formulation, equilibrium_distance)
    schema.one_of(datum, ("highest_peak", "first_contact"), "datum")
    schema.one_of(profile, PROFILES, "profile")
    if "indenter_height" in ds:
        raise ValueError("expected a sphere (assign_pair with sphere_radius), found an indenter's map; use direct")
    radius, modulus = schema.pair(ds, "sphere_radius", "contact_modulus")
    return Options(
        deltas=schema.ascending(delta, "nm", "delta"),
        law=formulation if law == "jkr" else law,
        equilibrium_distance=distance,
        composite=formulation != "published",
        profile=PROFILES[profile],
        first_contact=datum == "first_contact",
        radius=radius,
        contact_modulus=modulus,
        work_of_adhesion=0.0 if law == "hertz" else schema.pair(ds, "work_of_adhesion")[0],
    )


def _checked(law: str, formulation: str, equilibrium_distance: Any) -> float:
    """Return z₀ in nm, NaN for a law without range, or say which of the three do not go together."""
    if law in FORMULATIONS or formulation in LAWS:
        raise ValueError(
            f"law: expected one of {', '.join(map(repr, LAWS))}, and formulation one of "
            f"{', '.join(map(repr, FORMULATIONS))}, found law={law!r}, formulation={formulation!r}"
        )
    schema.one_of(law, LAWS, "law")
    schema.one_of(formulation, FORMULATIONS, "formulation")
    distance = positive(equilibrium_distance, "nm", "equilibrium_distance")
    if law != "maugis":
        if distance != _DISTANCE:
            raise ValueError(f"equilibrium_distance: expected for law='maugis' alone, found {distance:g} for {law!r}")
        return np.nan
    if formulation not in (_DEFAULT, _OF_MAUGIS):
        raise ValueError(
            f"formulation: expected none beside law='maugis', found {formulation!r}; take law='jkr' for it"
        )
    return distance


def law_of(law: str, formulation: str, options: Options) -> dict[str, Any]:
    """Return the law's name and what goes with it, as attributes of a result."""
    if law == "maugis":
        return {"law": law, "formulation": _OF_MAUGIS, "equilibrium_distance": options.equilibrium_distance}
    return {"law": law, "formulation": formulation}


def catalogue_field(ds: xr.Dataset, options: Options) -> tuple:
    """Return the asperities that are peaks under this sphere, the patch's half-width and the number left out."""
    catalogue = ds if "asperity" in ds.dims else asperities(ds)
    sphere = 0.5 / options.radius if options.composite else 0.0
    A, B = (0.5 * catalogue[name].values + sphere for name in ("curvature_min", "curvature_max"))
    scales = asperities_scales(A, B, options.contact_modulus, options.work_of_adhesion, options.kernel_law())
    x, y = catalogue["x"].values, catalogue["y"].values
    spacing = _spacing(x, y)
    depth = float(catalogue["datum_height"]) - catalogue["height"].values
    at_edge = catalogue["edge"].values.astype(float) if "edge" in catalogue else np.zeros(x.size)
    peaks = np.isfinite(scales.P)
    kept = [array[peaks] for array in (x, y, depth, spacing, at_edge)]
    scales = type(scales)(*(array[peaks] for array in scales))
    return sums.Field(*kept, scales), float(catalogue["patch_radius"]), int((~peaks).sum())


def _spacing(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the distance from each point to the next; inf where there is but one."""
    from scipy.spatial import cKDTree

    if x.size < 2:
        return np.full(x.size, np.inf)
    points = np.c_[x, y]
    quickly_made = {"balanced_tree": False, "compact_nodes": False}
    return cKDTree(points, **quickly_made).query(points, k=[2])[0][:, 0]


def _superpose(x: float, y: float, prepared: tuple, options: Options) -> np.ndarray:
    """Sum one subregion's sweep; return (variables and the number of excluded asperities, delta)."""
    field, patch_radius, excluded = prepared
    offset = sums.offsets(field, x, y, options.radius, options.profile)
    zero = offset.min() if options.first_contact and offset.size else 0.0
    branch = options.kernel_law().spline
    summed = sums.superpose(options.deltas + zero, field, offset, patch_radius, branch)
    return np.vstack([summed, np.full(options.deltas.size, float(excluded))])


def _labelled(packed, ds: xr.Dataset, positions: xr.Dataset, options: Options) -> xr.Dataset:
    found = {name: packed[:, k] for k, name in enumerate(_VARIABLES)}
    found |= {name: found[name].astype(int) for name in _COUNTS}
    found["truncated"] = found["truncated"] > 0
    out = {name: (("subregion", "delta"), values) for name, values in found.items()}
    out["excluded_asperities"] = (), packed[0, -1, 0].astype(int)
    pair = {name: ds[name] for name in schema.PAIR if name in ds.coords}
    return schema.label(xr.Dataset(out, {**positions.coords, **pair, "delta": options.deltas}))
