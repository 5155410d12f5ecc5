"""Sums over asperities: the options of a law, the asperities as plain arrays, and the exact pull-off."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..jobs.spread import is_lazy
from ..kernels.asperity import contact_sums as sums
from ..kernels.asperity import pull_off_search
from ..kernels.asperity.asperity_laws import ASPERITY_LAWS, RANGED, AsperityLaw, asperities_scales, subset
from ..kernels.asperity.asperity_laws import law as kernel_law
from ..scans import regions
from ..specimen import need_wide_scan
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS, DUGDALE, JKR, read_law
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, Phrase
from .catalogue import catalogue_of

#: Formulations of adhesion on an elliptic asperity, for the law "jkr".
FORMULATIONS = ASPERITY_LAWS[1:]

#: The default formulation.
DEFAULT = "energy"

#: Formulation of the ellipses of "dugdale", which takes only these two.
_OF_RANGED = "self_similar"

#: The record of the pull-off at one contact centre.
PULL_OFF = np.dtype([("pull_off_force", float), ("pull_off_delta", float), ("contacts", int), ("truncated", bool)])


class SumOptions(NamedTuple):
    """The law of the asperities, and the sphere pressed against them."""

    law: str  # name of the kernel's law: of "jkr" the formulation
    adhesion_range: float  # nm: z₀, or NaN for a law without range
    adheres: bool
    composite: bool
    radius: float
    contact_modulus: float
    work_of_adhesion: float

    def kernel_law(self) -> AsperityLaw:
        """Return the law for the kernels."""
        return kernel_law(self.law, self.adhesion_range) if self.law in RANGED else kernel_law(self.law)


def read_options(
    ds: xr.Dataset, law: str, formulation: str, *, dry_range: float | None = None, coated: bool = False
) -> SumOptions:
    """Return the options of a sum over asperities; raise if they contradict each other.

    ``dry_range`` (nm) is that of the law without liquid, by default the pair's.
    """
    schema.one_of(formulation, FORMULATIONS, "formulation")
    row = ADHESION_LAWS[law]
    if formulation not in row.formulations:
        expected = Phrase("none with ", Argument("law", law))
        advice = Phrase("leave it out, or take ", Argument("law", JKR))
        raise Refusal("formulation", expected, f"{formulation!r}", advice)
    if "indenter_height" in ds:
        expected = Phrase("a sphere (assign_pair with ", Argument("sphere_radius"), ")")
        raise Refusal("", expected, "the height map of an indenter", "use direct")
    pair = read_pair(ds, "sphere_radius", "contact_modulus", half_space=not coated)
    if row.adheres:
        pair.need("work_of_adhesion")
    length = pair.range if dry_range is None else dry_range
    if pair.menisci is not None:  # of a longer range and a larger work than the solids
        length += pair.menisci.part * (pair.menisci.range - length)
    return SumOptions(
        law=law if law in (*ASPERITY_LAWS, *RANGED) else formulation,
        adhesion_range=length if row.has_range else np.nan,
        adheres=row.adheres,
        composite=formulation != "published",
        radius=pair.sphere_radius,
        contact_modulus=pair.contact_modulus,
        work_of_adhesion=pair.work if row.adheres else 0.0,
    )


def law_attributes(law: str, formulation: str, options: SumOptions) -> dict[str, Any]:
    """Return the law's name and its parameters as attributes of a result."""
    if ADHESION_LAWS[law].has_range:
        return {"law": law, "formulation": _OF_RANGED, "adhesion_range": options.adhesion_range}
    return {"law": law, "formulation": formulation}


def fit_options(formulation: str | None) -> dict[str, str]:
    """Return the options of `asperities`: the paper's for the published formulas, else the defaults."""
    return {"patch": "paper"} if formulation == "published" else {}


@dataclass(frozen=True, eq=False)
class Summands:
    """A valid scan or catalogue whose asperities are summed, with the law and options of the sum."""

    ds: xr.Dataset
    law: str
    formulation: str
    options: SumOptions
    lazy: bool

    @cached_property
    def catalogue(self) -> xr.Dataset:
        """The given catalogue, or that of the scan."""
        if "asperity" in self.ds.dims:
            return self.ds
        return catalogue_of(self.ds, **fit_options(self.formulation))

    @cached_property
    def prepared(self) -> Asperities:
        """The asperities as plain numbers."""
        return plain_asperities(self.catalogue, self.options)

    @property
    def median_contact(self) -> float:
        """Radius (nm) of JKR's contact of the median asperity at pull-off."""
        sphere = 1 / self.options.radius if self.options.composite else 0.0
        least, largest = (self.catalogue[f"curvature_{end}"].values for end in ("min", "max"))
        peaks = least > 0
        radii = 1 / np.sqrt((least[peaks] + sphere) * (largest[peaks] + sphere))
        contacts, _ = read_pair(self.ds).contact_at_pull_off(radii, self.options.work_of_adhesion)
        return float(np.median(contacts)) if contacts.size else 0.0


def read_summands(
    ds: xr.Dataset, law: str | None, formulation: str, *, verb: str = "superpose", coated: bool = False
) -> Summands:
    """Return the `Summands` of a scan or catalogue and options; raise if they contradict each other."""
    schema.need_dataset(ds)
    ds = schema.validate(ds, "asperities" if "asperity" in ds.dims else "scan")
    dry_range = None if law else 0.0  # the default without liquid is "jkr"
    law = read_law(law or (DUGDALE if schema.is_humid(ds) else JKR), verb)
    options = read_options(ds, law, formulation, dry_range=dry_range, coated=coated and not is_lazy(ds))
    if "height" in ds and {"x", "y"} <= set(ds.dims) and not is_lazy(ds):
        need_wide_scan(ds["height"].values, regions.sides(ds), options.radius)
    return Summands(ds, law, formulation, options, is_lazy(ds))


class Asperities(NamedTuple):
    """The peaks of a catalogue as plain numbers, scaled by a law."""

    field: sums.Field
    patch_radius: float  # nm
    excluded: int  # saddles left out
    grid: pull_off_search.AsperityGrid | None  # for the search of the pull-off, of laws with adhesion


def plain_asperities(catalogue: xr.Dataset, options: SumOptions) -> Asperities:
    """Return the peaks of a catalogue as plain numbers, with composite curvatures if the law uses them."""
    sphere = 0.5 / options.radius if options.composite else 0.0
    law = options.kernel_law()
    A, B = (0.5 * catalogue[name].values + sphere for name in ("curvature_min", "curvature_max"))
    scales = asperities_scales(A, B, options.contact_modulus, options.work_of_adhesion, law)
    x = catalogue["x"].values
    y = catalogue["y"].values
    depth = float(catalogue["datum_height"]) - catalogue["height"].values
    at_edge = catalogue["edge"].values.astype(float) if "edge" in catalogue else np.zeros(x.size)
    peaks = np.isfinite(scales.P)
    x, y, depth, at_edge = (array[peaks] for array in (x, y, depth, at_edge))
    orientation = catalogue["orientation"].values[peaks]
    field = sums.Field(x, y, depth, orientation, at_edge, _nearest_neighbours(x, y), subset(scales, peaks))
    grid = None
    if options.adheres:
        grid = pull_off_search.build_grid(field, law, options.radius)
    return Asperities(field, float(catalogue["patch_radius"]), int((~peaks).sum()), grid)


def _nearest_neighbours(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the indices of the nearest points of each point, −1 if there are fewer."""
    from scipy.spatial import cKDTree

    points = np.c_[x, y]
    count = min(sums.NEIGHBOURS, max(x.size - 1, 0))
    out = np.full((x.size, sums.NEIGHBOURS), -1, np.intp)
    if count:
        unbalanced = {"balanced_tree": False, "compact_nodes": False}
        nearest = cKDTree(points, **unbalanced).query(points, k=count + 1)[1]
        itself = nearest == np.arange(x.size)[:, None]
        itself[~itself.any(axis=1), -1] = True  # if points coincide, another one may come first
        out[:, :count] = nearest[~itself].reshape(x.size, count)
    return out


def exact_pull_offs(
    x: np.ndarray, y: np.ndarray, grid: pull_off_search.AsperityGrid, options: SumOptions
) -> np.ndarray:
    """Return the exact pull-off at each centre, records of ``PULL_OFF``; NaN without adhesion."""
    results = pull_off_search.pull_offs(x, y, grid, options.kernel_law().spline, options.radius)
    force = -results[:, pull_off_search.FORCE]
    delta = results[:, pull_off_search.DELTA]
    records = np.zeros(x.size, PULL_OFF)
    records["pull_off_force"] = np.where(force > 0, force, np.nan)
    records["pull_off_delta"] = delta
    records["contacts"] = results[:, pull_off_search.CONTACTS]
    records["truncated"] = results[:, pull_off_search.AT_EDGE] > 0
    return records
