"""Condensed liquid between rigid bodies at one place: drawn off fast, the work of it, and the error of thin menisci.

Slowly drawn off, liquid evaporates so that Kelvin's radius stays (`kernels.adhesion.rigid` sums that law). Drawn off
fast, each bridge keeps its volume: with A(l) the area below a level l over contact at the turning point, the level at
which it stands after a rise z, and its pull, are

    l A(l) − ∫₀ˡ A dl′ + z A(l) = the same at z = 0,     γ (cos θ₁ + cos θ₂) A(l)/(l + z − 2f)

(for a sphere: Rabinovich, Esayanur & Moudgil, Langmuir 21 (2005) 10992). Where a bridge splits, its parts stay at one
pressure, and none breaks. The next order of a thin meniscus is the energy ε L of its edge of length L (own;
`bodies.liquid.Menisci.edge`), which takes ε dL/dh off the pull; exact menisci (`reference.meniscus_sphere`) differ from
the law by this to a few per cent of it for r_K < R/20.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import potentials
from ..kernels.adhesion import rigid as kernels

#: Levels at which the area of a bridge is tabulated, and rises (in heights of a meniscus) over which work is summed.
_LEVELS, _RISES = 65, np.geomspace(1e-3, 3e3, 61)

#: Relative change of the level by which the growth of the edge is found.
_LEVEL_STEP = 0.1


def relative_error(
    cells: kernels.Cells, delta: float, law: potentials.Potential, menisci: Menisci, cell, pull
) -> float:
    """Return the part of a pull (nN) at a displacement that thin menisci leave out, from the growth of their edge."""
    step = _LEVEL_STEP * menisci.height
    high, low = (kernels.wet_area(cells, law.wet + delta + one)[1] for one in (step, -step))
    return abs(menisci.edge * cell * (high - low) / (2 * step)) / pull


def slow_work(separation: np.ndarray, delta: float, law: potentials.Potential, area: float) -> float:
    """Return the work (nN nm) to draw off from a displacement at constant humidity, of a window of separations."""
    gaps = np.maximum(separation[np.isfinite(separation)] - delta, kernels.floor(law))
    return area * float(potentials.energy(gaps, law).sum())


class Bridges(NamedTuple):
    """Bridges of constant volume, from the displacement (nm) at which they turned back."""

    turned: float
    label: np.ndarray  # number of the bridge in each cell, 0 where there is none
    levels: np.ndarray  # nm over contact
    areas: np.ndarray  # nm² below each level, (bridge, level)
    law: potentials.Potential
    menisci: Menisci
    area: float  # nm², of a cell

    def pulls(self, separation: np.ndarray, cells: kernels.Cells, deltas: np.ndarray) -> np.ndarray:
        """Return the pull (nN) at displacements (nm) up to the turning point."""
        return np.array([self._pull(separation, cells, float(delta)) for delta in deltas])

    def work(self, separation: np.ndarray, cells: kernels.Cells) -> float:
        """Return the work (nN nm) to draw off from the turning point."""
        from scipy.integrate import simpson

        rises = self.menisci.height * _RISES
        pulls = self.pulls(separation, cells, self.turned - rises)
        return float(pulls[0] * rises[0] + simpson(pulls * rises, x=np.log(rises)))

    def _pull(self, separation, cells, delta) -> float:
        rise, law = self.turned - delta, self.law
        level, areas = self._after(rise)
        liquid, film = self.menisci, 2 * self.menisci.film
        height = liquid.height - film
        pull = liquid.tension * height / liquid.kelvin_radius * float(np.sum(areas / (level + rise - film)))
        contact = law.wet - liquid.height
        levels = np.append(-np.inf, level + contact + self.turned)[self.label]
        covered = kernels.wetted_parts(cells, levels)
        known = np.isfinite(separation)
        gaps = np.maximum(separation[known] - delta, kernels.floor(law))
        solids = potentials.tractions(gaps, law._replace(wet=-np.inf))
        return pull + self.area * float(np.sum(solids * (1 - (1 - law.share) * covered[known])))

    def _after(self, rise: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the level (nm over contact at the turning point) and area (nm²) of each bridge after a rise."""
        steps = 0.5 * (self.areas[:, 1:] + self.areas[:, :-1]) * np.diff(self.levels)
        below = np.pad(np.cumsum(steps, axis=1), ((0, 0), (1, 0)))
        volumes = self.levels * self.areas - below
        found = [np.interp(volume[-1], volume + rise * area, self.levels) for volume, area in zip(volumes, self.areas)]
        areas = [np.interp(level, self.levels, area) for level, area in zip(found, self.areas)]
        return np.array(found), np.array(areas)


def bridges(cells: kernels.Cells, delta: float, law: potentials.Potential, menisci: Menisci, area: float) -> Bridges:
    """Return the bridges that stand in equilibrium at a displacement (nm)."""
    from scipy.ndimage import label

    level = np.full(cells.mean.shape, law.wet + delta)
    labels, count = label(kernels.wetted_parts(cells, level) > 0, structure=np.ones((3, 3)))
    levels, inside = np.linspace(0.0, menisci.height, _LEVELS), labels > 0
    areas = np.zeros((count, _LEVELS))
    for k, one in enumerate(levels):
        parts = kernels.wetted_parts(cells, level - menisci.height + one)
        areas[:, k] = area * np.bincount(labels[inside], parts[inside], count + 1)[1:]
    return Bridges(delta, labels, levels, areas, law, menisci, area)
