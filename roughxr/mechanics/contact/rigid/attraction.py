"""The attraction between rigid bodies: the options of `rigid`, read once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...bodies.liquid import Menisci
from ...bodies.pair_record import DEFAULT_RANGE
from ...kernels.adhesion import potentials
from ...specimen import Specimen
from ...vocabulary.adhesion_laws import ADHESION_LAWS
from ...vocabulary.refusal import Refusal
from ..problem import Problem

#: Largest share of the adhesion force from beyond the scan; otherwise a place is truncated.
BEYOND_EDGE = 0.01

#: Gaps of the nearest cell, in ε, at which the largest force by Lennard-Jones is searched.
NEAREST_GAPS = np.linspace(0.31, 1.35, 27)


class Options(NamedTuple):
    """The law of attraction and its options."""

    law: potentials.Potential
    area: float  # nm², of a pixel
    mean_height: float  # nm, of the scan, which is its mean plane beyond the window
    menisci: Menisci | None = None  # the liquid between the bodies, if there is any


def read_options(specimen: Specimen, law: str) -> Options:
    """Return the options of `rigid`; raise if nothing attracts."""
    pair = specimen.pair
    pair.need("work_of_adhesion")
    w = pair.solid_work
    menisci = pair.menisci
    if not w > 0 and menisci is None:
        raise Refusal("work_of_adhesion", "more than 0 J/m² for bodies that attract", f"{w:g}")
    length = pair.closest_approach if ADHESION_LAWS[law].has_closest_approach else pair.range_of(law)
    potential = potentials.potential(law, w, length if w > 0 else DEFAULT_RANGE, pair.retardation)
    if menisci is not None:
        potential = potentials.with_liquid(potential, menisci.height, menisci.capillary_pressure, menisci.share)
    mean_height = float(specimen.heights.mean())
    return Options(potential, specimen.pixel**2, mean_height, menisci)


def window_half_width(specimen: Specimen, problem: Problem) -> float:
    """Return the half-width of the windows, nm."""
    # rise of the indenter at the window's edge: this many nm or this many ranges of heights, whichever is more. The
    # surface beyond is taken as its mean plane.
    return problem.indenter.half_width(max(300.0, 10.0 * float(np.ptp(specimen.heights))))


def interpolated_pull_off(deltas: np.ndarray, attractions: np.ndarray) -> tuple[float, float]:
    """Return the largest attraction and its displacement, by the quartic through five evenly spaced values."""
    best = int(np.clip(attractions.argmax(), 2, attractions.size - 3))
    quartic = np.polynomial.Polynomial.fit(np.arange(-2.0, 3.0), attractions[best - 2 : best + 3], 4).convert()
    turns = quartic.deriv().roots()
    inside = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) <= 2)]
    x = max([*inside, -2.0, 2.0], key=quartic)
    return float(quartic(x)), float(deltas[best] + (deltas[1] - deltas[0]) * x)
