"""The assigned pair of bodies as plain numbers, read once from the coordinates of a Dataset.

Verbs read it at their door, `read_pair`, or take that of the specimen; no function below asks a Dataset.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from ..vocabulary.refusal import Refusal
from .layer import film_of
from .liquid import Menisci, menisci_of
from .substances import CUT_OFF

if TYPE_CHECKING:
    from ..kernels.halfspace.layered import Film

#: Range of adhesion, nm, where none is assigned: about the interatomic distance of dry solids.
DEFAULT_RANGE = 0.3


class Pair(NamedTuple):
    """Moduli, adhesion, hardness, liquid and layer of a pair; NaN where a value is not assigned."""

    sphere_radius: float  # nm
    contact_modulus: float  # GPa
    solid_work: float  # J/m², of the solids without liquid
    assigned_range: float  # nm
    hamaker_constant: float  # nN nm
    retardation: float  # nm, inf without
    hardness: float  # GPa, assigned or estimated; inf if unknown
    yields: bool  # whether the hardness is assigned
    menisci: Menisci | None  # of condensed liquid
    layer: Film | None  # its thickness in nm

    def need(self, *names: str) -> None:
        """Raise unless each of these coordinates of a valid scan is assigned."""
        values = self._asdict() | {"work_of_adhesion": self.solid_work}
        schema.refuse_unassigned([name for name in names if math.isnan(values[name])])

    @property
    def work(self) -> float:
        """Work of adhesion, J/m²; of a humid pair that of the liquid and of the solids under it."""
        if self.menisci is None:
            return self.solid_work
        return self.menisci.work + self.menisci.share * self.solid_work

    @property
    def range(self) -> float:
        """Range of adhesion, nm."""
        return DEFAULT_RANGE if math.isnan(self.assigned_range) else self.assigned_range

    @property
    def closest_approach(self) -> float:
        """Closest approach of surfaces that attract by A/(6πu³), nm: √(A/(12πw)), or 0.165 if A is unknown."""
        if math.isnan(self.hamaker_constant):
            return CUT_OFF
        return closest_approach(self.hamaker_constant, self.solid_work)

    @property
    def attractions(self) -> list[tuple[float, float]]:
        """Work (J/m²) and range (nm) of each attraction: of the solids, and of condensed liquid."""
        if self.menisci is None:
            return [(self.solid_work, self.range)]
        return [(self.solid_work * self.menisci.share, self.range), (self.menisci.work, self.menisci.range)]

    def range_of(self, law: str) -> float:
        """Return the range (nm) of a law, see `ADHESION_LAWS`.

        With a Hamaker constant A and no range, "lennard_jones" has √(A/(16πw)), so that its attraction at large gaps is
        that of A.
        """
        is_known = not math.isnan(self.hamaker_constant) and self.solid_work > 0
        if ADHESION_LAWS[law].has_hamaker_tail and is_known and math.isnan(self.assigned_range):
            return math.sqrt(0.75) * self.closest_approach
        return self.range

    def contact_at_pull_off(self, radius, work):
        """Return the radius (nm) of JKR's contact at pull-off, and the contact modulus (GPa) at that size."""
        from ..kernels.halfspace.layered import contact_at_pull_off  # not at the top: it needs SciPy

        return contact_at_pull_off(radius, work, self.contact_modulus, self.layer)

    def tabor_parameters(self, radius) -> list:
        """Return Tabor's parameter (R w²/(E*² z₀³))^{1/3} of spheres of a radius (nm), for each attraction."""
        moduli = [self.contact_at_pull_off(radius, work)[1] for work, _ in self.attractions]
        return [
            np.cbrt(radius * work**2 / (modulus**2 * length**3))
            for (work, length), modulus in zip(self.attractions, moduli)
        ]

    def smooth_pull_off(self, *, stiff: bool) -> float:
        """Return the pull-off force (nN) of the sphere on a smooth flat: Bradley's of stiff bodies, else JKR's."""
        return (2.0 if stiff else 1.5) * math.pi * self.work * self.sphere_radius


def read_pair(ds: xr.Dataset, *needed: str, dry: bool = False, half_space: bool = False) -> Pair:
    """Return the pair of a Dataset; raise if a needed value is not assigned, for liquid, or for a layer."""
    schema.need_assigned(ds, *needed)
    layer = film_of(ds)
    menisci = menisci_of(ds)
    if half_space and layer is not None:
        raise Refusal(
            "layer",
            "a half space",
            f"a layer of {layer.thickness:.3g} nm, which this formula does not include",
            "take `direct`, `adhesive` or `rigid`, or assign the pair without a layer",
        )
    if dry and menisci is not None:
        raise Refusal(
            "humidity",
            "a dry pair",
            f"condensed liquid (Kelvin radius {menisci.kelvin_radius:.3g} nm), which this law of adhesion "
            "does not include",
            "take `rigid` or `adhesive`, or assign the pair without humidity",
        )

    def value(name: str, otherwise: float = np.nan) -> float:
        return float(ds[name]) if name in ds.coords and ds[name].ndim == 0 else otherwise

    return Pair(
        sphere_radius=value("sphere_radius"),
        contact_modulus=value("contact_modulus"),
        solid_work=value("work_of_adhesion"),
        assigned_range=value("adhesion_range"),
        hamaker_constant=value("hamaker_constant"),
        retardation=value("retardation", np.inf),
        hardness=value("hardness", value("hardness_estimate", np.inf)),
        yields="hardness" in ds.coords,
        menisci=menisci,
        layer=layer,
    )


def closest_approach(constant: float, work: float) -> float:
    """Return the closest approach (nm) of a Hamaker constant (nN nm) and a work of adhesion (J/m²)."""
    return math.sqrt(constant / (12 * math.pi * work)) if work > 0 else math.inf
