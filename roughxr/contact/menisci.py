"""Condensed liquid between rigid bodies at one place: the work of it, and the error of thin menisci.

Slowly drawn off, liquid evaporates so that Kelvin's radius stays (`kernels.adhesion.rigid` sums that law). The next
order of a thin meniscus is the energy ε L of its edge of length L (own; `bodies.liquid.Menisci.edge`), which takes
ε dL/dh off the pull; exact menisci (`reference.meniscus_sphere`) differ from the law by this to a few per cent of it
for r_K < R/20.
"""

from __future__ import annotations

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import potentials
from ..kernels.adhesion import rigid as kernels

#: Relative change of the level by which the growth of the edge is computed.
_LEVEL_STEP = 0.1


def relative_error(
    cells: kernels.Cells, delta: float, law: potentials.Potential, menisci: Menisci, cell, pull
) -> float:
    """Return the part of a pull (nN) at a displacement that thin menisci leave out, from the growth of their edge."""
    step = _LEVEL_STEP * menisci.height
    high, low = (kernels.wet_area(cells, law.filled + delta + change)[1] for change in (step, -step))
    return abs(menisci.edge * cell * (high - low) / (2 * step)) / pull


def work(separation: np.ndarray, delta: float, law: potentials.Potential, area: float) -> float:
    """Return the work (nN nm) to retract from a displacement at constant humidity, of a window of separations."""
    gaps = np.maximum(separation[np.isfinite(separation)] - delta, kernels.floor(law))
    return area * float(potentials.energy(gaps, law).sum())
