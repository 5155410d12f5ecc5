"""Asperities that yield under superposition: how far a sphere has flattened each of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from ..kernels.asperity import superposition as sums
from ..kernels.asperity.flattening import flattened
from ..kernels.asperity.laws import asperities_scales
from ..kernels.asperity.laws import law as read_law
from .asperity_sum import SumOptions, composite_curvatures

#: Bisection steps by which the displacement of a preload is found.
_HALVINGS = 60


class Yielding(NamedTuple):
    """At which pressure asperities yield, and where the sphere turns back."""

    pressure: float  # GPa, inf where all asperities stay elastic
    preload: float  # nN, NaN where the sphere turns back at the last displacement

    @property
    def yields(self) -> bool:
        """Whether asperities yield at all."""
        return bool(np.isfinite(self.pressure))

    @property
    def by_preload(self) -> bool:
        """Whether the sphere turns back at a force."""
        return not np.isnan(self.preload)


class Asperities(NamedTuple):
    """The peaks under a sphere before any contact."""

    A: np.ndarray  # half the principal curvatures with the sphere's, nm⁻¹
    B: np.ndarray
    stiffness: np.ndarray  # Hertz's force at 1 nm, nN
    contact: np.ndarray  # its area there, nm²
    hardness: Yielding

    def flattened(
        self, field: sums.Field, delta: np.ndarray, options: SumOptions, *, middle: bool = False
    ) -> sums.Field:
        """Return the field with each asperity pressed to its displacement (nm), ``middle`` as in the kernel."""
        curvature, drop = flattened(delta, self.stiffness, self.contact, self.hardness.pressure, middle=middle)
        law = options.kernel_law()
        scales = asperities_scales(
            curvature * self.A, curvature * self.B, options.contact_modulus, options.work_of_adhesion, law
        )
        return field._replace(depth=field.depth + drop, scales=scales)

    def force(self, delta: np.ndarray) -> float:
        """Return the sum of the asperities' forces (nN) on loading, without adhesion."""
        curvature, drop = flattened(delta, self.stiffness, self.contact, self.hardness.pressure)
        return float(np.sum(self.stiffness / np.sqrt(curvature) * np.clip(delta - drop, 0.0, None) ** 1.5))

    def turn(self, offset: np.ndarray, last: float) -> float:
        """Return the displacement (nm) at which the preload is reached, or the last one."""
        if not self.hardness.by_preload or offset.size == 0:
            return last
        low, high = float(offset.min()), float(offset.min()) + 1.0
        while self.force(high - offset) < self.hardness.preload:
            high += high - low
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.force(middle - offset) < self.hardness.preload else (low, middle)
        return high


def asperities_of(catalogue: xr.Dataset, options: SumOptions, hardness: Yielding) -> Asperities:
    """Return the peaks of a catalogue, in the order of `asperity_sum.catalogue_field`."""
    A, B = composite_curvatures(catalogue, options)
    scales = asperities_scales(A, B, options.contact_modulus, 0.0, read_law("hertz"))
    peaks = np.isfinite(scales.P)
    contact = np.pi * scales.axis_ratio * scales.a**2
    return Asperities(A[peaks], B[peaks], scales.P[peaks], contact[peaks], hardness)
