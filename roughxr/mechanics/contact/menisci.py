"""Condensed liquid between rigid bodies at one place: its work, and the error of the law of thin menisci.

On slow retraction the liquid evaporates at constant Kelvin radius (`kernels.adhesion.rigid` sums this law). The
next-order correction to thin menisci is the energy ε L of their edge of length L (derived here;
`bodies.liquid.Menisci.edge`). It lowers the capillary force by ε dL/dh, h the gap. For r_K < R/20 the corrected force
agrees within a few per cent with exact menisci (`reference.meniscus_sphere`).
"""

from __future__ import annotations

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import potentials
from ..kernels.adhesion import rigid as kernels


def relative_error(
    cells: kernels.Cells, delta: float, law: potentials.Potential, menisci: Menisci | None, cell, force
) -> float:
    """Return the relative error of thin menisci in a capillary force (nN), from the change of their edge length."""
    if menisci is None:
        return 0.0
    # relative step of the level for the derivative of the edge length
    step = 0.1 * menisci.height
    high, low = (kernels.wetted_area(cells, law.filled + delta + change)[1] for change in (step, -step))
    return abs(menisci.edge * cell * (high - low) / (2 * step)) / force


def work(separation: np.ndarray, delta: float, law: potentials.Potential, area: float) -> float:
    """Return the work (nN nm) to retract from a displacement at constant humidity, of a window of separations."""
    gaps = np.maximum(separation[np.isfinite(separation)] - delta, kernels.smallest_gap(law))
    return area * float(potentials.energy(gaps, law).sum())
