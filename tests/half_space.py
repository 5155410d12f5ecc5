"""Solutions of the half space with their fields, for one displacement or several, for tests and benchmarks."""

from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.halfspace.displacement_control import (
    AREA,
    CONVERGED,
    ELASTIC,
    FORCE,
    STATUS,
    Hardness,
    sweep_arrays,
)
from roughxr.mechanics.kernels.halfspace.load_control import loaded_arrays

__all__ = [
    "AREA",
    "CONVERGED",
    "ELASTIC",
    "FORCE",
    "STATUS",
    "Hardness",
    "Solution",
    "loaded",
    "solve",
    "sweep",
    "sweep_arrays",
]


class Solution(NamedTuple):
    """One contact on a window of dx × dx cells, and the outcome of its solve."""

    pressure: np.ndarray  #: GPa, >= 0 and at most the hardness
    displacement: np.ndarray  #: nm, on the overlap's bounding box; NaN elsewhere
    force: float  #: nN
    area: float  #: nm²
    status: int
    iterations: int  #: products A p
    residual: float  #: largest |g| in contact or of the wrong sign outside, over the deepest overlap
    hard_force: float  #: nN, of cells at the hardness or above
    hard_area: float  #: nm²
    dent: float  #: nm³, volume by which they gave way

    @property
    def converged(self):
        """Whether the tolerance was met."""
        return self.status == CONVERGED


def solve(separation, delta, dx, contact_modulus, **limits):
    """Return the contact at one displacement; options are those of `sweep_arrays`."""
    return sweep(separation, [delta], dx, contact_modulus, **limits)[0]


def sweep(separation, deltas, dx, contact_modulus, **limits):
    """Return the contact at each of ascending displacements."""
    return solutions(*sweep_arrays(separation, deltas, dx, contact_modulus, keep=len(deltas), **limits))


def loaded(separation, loads, dx, contact_modulus, **limits):
    """Return (delta, `Solution`) for each of ascending loads (nN > 0)."""
    deltas, *arrays = loaded_arrays(separation, loads, dx, contact_modulus, keep=len(loads), **limits)
    return list(zip(deltas.tolist(), solutions(*arrays)))


def solutions(records, pressures, displacements):
    """Return the `Solution` of each row."""
    return [
        Solution(p, u, force, area, int(status), int(iterations), *others)
        for p, u, (force, area, status, iterations, *others) in zip(pressures, displacements, records.tolist())
    ]
