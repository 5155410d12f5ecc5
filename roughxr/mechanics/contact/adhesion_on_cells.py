"""The attraction of a pair as it is solved: its law, on the cells of a mesh, and the cells that resolve it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import traction_laws
from ..vocabulary.adhesion_laws import ADHESION_LAWS, EXPONENTIAL
from .problem import Problem

#: Largest slope |dt/du| of the traction at an edge, over E*/dx; the wider edge has half of it.
_EDGE_SLOPE = 0.25

#: Least width of the edge of condensed liquid, over its height, at the same work. Changes the wetted area by 0.1 %.
_LIQUID_EDGE = 0.25

#: Sides of cells (nm) among which the largest is chosen on a layer.
_CELLS = np.geomspace(1e-3, 1e4, 701)

#: Work of separation in place of zero, nm².
_NO_WORK = 1e-12

#: Without moments of rolling.
NO_DIRECTIONS = np.zeros(0)


class Adhesion(NamedTuple):
    """Law of adhesion, loading, and accuracy of the pull-off."""

    work: float  # J/m²
    law: str
    length: float  # nm, see `ADHESION_LAWS`; NaN without range
    preloads: np.ndarray  # nN, ascending; empty where the indenter turns back at the last displacement
    refine: int  # 0: refine until ``accuracy`` is met
    accuracy: float  # NaN: take the first mesh, without an estimate of its error
    step: float  # nm
    cycles: int = 1  # at each place, each on the shape left by the cycle before
    liquid: Menisci | None = None  # condensed between the bodies; ``work`` is then that of the solids outside it
    first_cell: float = np.inf  # nm, of the coarsest mesh of "auto" with an accuracy, or without range
    presses: bool = False  # whether each pull-off is compared with that of a sphere pressed as hard as it holds
    capture: float | None = None  # nm, gap at which the pair's attraction snaps surfaces together; without range only
    by_front: bool = False  # whether the edge is followed as that of one region, where that is valid
    on_cells: bool = True  # whether places are solved on cells, if not by their front
    directions: np.ndarray = NO_DIRECTIONS  # rad, of rolling, in which moments of the retraction's states are kept
    tabor: float = np.nan  # Tabor's parameter that decided between the laws; NaN where it did not

    @property
    def whole_work(self) -> float:
        """The whole work to separate the bodies, that of liquid included, J/m²."""
        return self.work + (self.liquid.work if self.liquid else 0.0)

    @property
    def largest_tension(self) -> float:
        """The largest tension of a law with a range, GPa."""
        return self.work / self.length + (self.liquid.capillary_pressure if self.liquid else 0.0)


def law_on_cells(adhesion: Adhesion, problem: Problem, steepness: float = 1.0) -> traction_laws.SmoothLaw:
    """Return the law on unit cells of unit modulus; ``steepness`` is the slope of an edge over the mesh's largest."""
    per_unit = problem.dx / problem.contact_modulus
    slope = _EDGE_SLOPE * (problem.film.stiffness if problem.film else 1.0)
    w = adhesion.work * per_unit
    if adhesion.liquid is not None:
        return _law_with_liquid(w, adhesion.length, adhesion.liquid, per_unit, slope)
    if w == 0:
        return traction_laws.smooth_law(exponential=(_NO_WORK, 1.0))
    return traction_laws.LAWS[adhesion.law](w, adhesion.length, slope * steepness)


def _law_with_liquid(w: float, length: float, liquid: Menisci, per_unit: float, slope) -> traction_laws.SmoothLaw:
    """Return the sum of the solids' and the liquid's tractions, the liquid's edge as steep as the mesh resolves."""
    tension, height = liquid.capillary_pressure * per_unit, liquid.height
    width = np.clip(2.0 * tension / slope, _LIQUID_EDGE * height, 3.0 * height)
    solids = {EXPONENTIAL: (w, length)} if w > 0 else {}
    return traction_laws.smooth_law(step=traction_laws.widened_step(tension, height, width), **solids)


def interaction_range(adhesion: Adhesion, problem: Problem) -> float:
    """Return the gap (nm) beyond which the traction is 0."""
    return law_on_cells(adhesion, problem, 0.5).range


def resolving_cell(adhesion: Adhesion, problem: Problem) -> float:
    """Return the largest cells (nm) on which adhesion can be solved."""
    cell, liquid = largest_cell(adhesion, problem), adhesion.liquid
    cell = min(cell, adhesion.first_cell) if np.isinf(cell) else cell
    if liquid is None:
        return cell
    # an edge twice as wide as the liquid is high; `_law_with_liquid` bears three times
    return min(cell, _EDGE_SLOPE * problem.softest * liquid.height / liquid.capillary_pressure)


def largest_cell(adhesion: Adhesion, problem: Problem) -> float:
    """Return the largest cells (nm) that are stiffer than the slope of the traction; inf without range."""
    law = ADHESION_LAWS[adhesion.law]
    if not law.has_range or adhesion.work == 0:
        return np.inf
    largest = law.largest_cell * problem.contact_modulus * adhesion.length**2 / adhesion.work
    if problem.layer is None:
        return largest
    softening = problem.layer.softening(0.5 * _CELLS)  # of cells as contacts of half their side
    stiff = np.flatnonzero(_CELLS * softening <= largest)
    return largest / softening[stiff[-1] if stiff.size else 0]
