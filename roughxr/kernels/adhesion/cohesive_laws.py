"""Cohesive laws: the traction between two surfaces across a gap u, with the same work of separation w for all ranges.

plateau       t = σ₀ up to a gap d, then falling with slope c to 0 at d + σ₀/c        w = σ₀ (d + σ₀/2c)
exponential   t = (w/ρ) exp(−u/ρ), cut off at 12 ρ (6·10⁻⁶ of w)                      σ₀ = w/ρ

griffith      d = 0, σ₀ = √(2c E*w/dx): no range but the mesh's
dugdale       σ₀ given, h = w/σ₀ = d + σ₀/2c: Dugdale's step at h (Maugis 1992), spread as far as the mesh needs;
              with a strength that leaves no plateau it is the Griffith limit's law

On a mesh the edge of a contact moves from cell to cell, and should do so evenly. If each cell let go at once, at
√(E*w/(0.473 dx)), the criterion of Pohrt & Popov (2015), the edge would hold on too long, by 11 % of a sphere's
pull-off at ten cells. By the coefficients of strips, an edge row along the grid resists with 0.58 E*/dx. With a
traction that falls about as fast, cells still let go one by one, and a sphere's pull-off depends on its position on the
grid. With half of that (``SOFTENING``) three rows let go together and the edge moves evenly; with still less, the zone
that lets go is too wide for narrow contacts.

This zone costs additional energy, proportional to the length of the outline, as a line tension. It raises the pull-off
of a round contact by ``LINE`` over its radius in cells, less where the zone is no longer small beside the contact
(``NARROW``), as in Maugis's theory. ``toughness`` subtracts both from w, so that the path is that of an edge without
width. ``python tests/benchmarks/line_tension.py`` shows how the numbers (``tuning``) are found, and how accurate they
are on ellipses, which they were not found from.

Contacts with the exponential law are followed by Newton's method (``smooth_path``), not cell by cell. The law is here
to compare the two solvers on the same mesh: ``tests/test_adhesion_smooth.py`` compares their forces, ``python
tests/benchmarks/adhesive_engine.py`` their times.

Given: gap u and w. Sought: the traction t(u), and the work W(u) = ∫ t du from u to infinity. Unit cells and unit
modulus: gaps and tractions in nm (t dx/E*), works in nm² (w dx/E*). Sources: Griffith (1921), Maugis (1992); the line
tension is own.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .tuning import LINE, NARROW, SOFTENING

PLATEAU, EXPONENTIAL = range(2)

#: Range of the exponential law, in units of its length.
_CUT = 12.0

#: Smallest number of cells in a process zone.
LEAST_ZONE = 2.0


class CohesiveLaw(NamedTuple):
    """A law in units of the cells."""

    code: int
    strength: float  # σ₀, nm
    range: float  # gap beyond which nothing pulls, nm
    length: float  # ρ of the exponential, or the plateau's d, nm
    anywhere: bool  # whether all cells attract, or only those beside constrained cells
    softening: float = SOFTENING  # slope at which the traction falls on the mesh, E*/dx (``tuning``)
    line: float = LINE  # strength of the line tension
    narrow: float = NARROW  # cells


def griffith(w, softening=SOFTENING, line=LINE, narrow=NARROW):
    """Return the law of the Griffith limit for w (nm²)."""
    strength = float(np.sqrt(2.0 * softening * w))
    return CohesiveLaw(PLATEAU, strength, strength / softening, 0.0, False, softening, line, narrow)


def finite_range(name, w, strength):
    """Return a law of finite range for w (nm²) and its largest traction (nm)."""
    length = w / strength
    if name == "exponential":
        return CohesiveLaw(EXPONENTIAL, strength, _CUT * length, length, True)
    fall = strength / SOFTENING
    return CohesiveLaw(PLATEAU, strength, length + 0.5 * fall, length - 0.5 * fall, True)


def process_zone(contact_modulus, w, strength):
    """Return the length (nm) of Dugdale's zone at the edge of a large contact, π E* w/(4 σ₀²)."""
    return np.pi * contact_modulus * w / (4.0 * strength**2)


@kernel
def toughness(radius, law):
    """Return the factor on w at the edge of a contact of this radius (cells)."""
    return 1.0 - law.line / (radius + law.narrow)


@kernel
def line_energy(cells, radius, law):
    """Return the energy, in w, that the line tension took from the adhesion of a contact as it grew to this size.

    With r = √(cells/π), and the radius growing in proportion to r at constant shape, it is the integral of 1 −
    toughness over the cells.
    """
    r = np.sqrt(cells / np.pi)
    g = radius / r
    return 2.0 * np.pi * law.line / g**2 * (radius - law.narrow * np.log(1.0 + radius / law.narrow))


@kernel
def traction(u, law, root):
    """Return t(u) >= 0 and dt/du; ``root`` is the square root of the factor on w."""
    x = u / root
    if x >= law.range:
        return 0.0, 0.0
    if law.code == EXPONENTIAL:
        t = law.strength * np.exp(-x / law.length)
        return root * t, -t / law.length
    if x <= law.length:
        return root * law.strength, 0.0
    return root * law.softening * (law.range - x), -law.softening


@kernel
def remaining_work(u, law, root):
    """Return the work left to separate the surfaces from the gap u, nm²."""
    x = u / root
    if x >= law.range:
        return 0.0
    if law.code == EXPONENTIAL:
        return root * root * law.strength * law.length * np.exp(-x / law.length)
    fall = law.range - max(x, law.length)
    return root * root * (0.5 * law.softening * fall * fall + law.strength * max(law.length - x, 0.0))


@kernel
def balance(pressure, u, stiffness, law, root):
    """Return the only gap u' ≥ 0 at which one cell alone is in balance, p + m (u' − u) + t(u') = 0."""
    end = law.range * root
    free = u - pressure / stiffness
    if free >= end:
        return free
    if law.code == EXPONENTIAL:
        return _exponential_balance(pressure, u, stiffness, law, root)
    flat = free - root * law.strength / stiffness
    if flat <= root * law.length:
        return max(flat, 0.0)
    return max((stiffness * free - law.softening * end) / (stiffness - law.softening), 0.0)


@kernel
def _exponential_balance(pressure, u, stiffness, law, root):
    held = min(u, law.range * root)
    for _ in range(30):
        t, slope = traction(held, law, root)
        change = (pressure + stiffness * (held - u) + t) / max(stiffness + slope, 0.1 * stiffness)
        held = max(held - change, 0.0)
        if abs(change) < 1e-13 * law.length:
            break
    return held
