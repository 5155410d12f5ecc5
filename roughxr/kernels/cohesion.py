"""How two surfaces pull on each other across a gap u: laws whose work of separation is w whatever their range.

linear        t = σ₀ (1 − u/h)              w = σ₀ h/2
dugdale       t = σ₀                        w = σ₀ h        (Maugis 1992)
exponential   t = (w/ρ) exp(−u/ρ)           σ₀ = w/ρ        (cut off at 12 ρ: 6·10⁻⁶ of w)

In the Griffith limit there is no range: a front moves where it frees w per area. On a mesh a front moves from cell to
cell. The linear law that lets a straight front move evenly, neither ahead of its due nor late, is the one whose
softening equals the stiffness c with which a straight edge row resists: then at σ₀ = √(2c E*w/dx) the row
begins to open, and it is free just when the next row begins. For a front along the grid c = 0.5801, as
comes out of the coefficients of strips (``tests/test_adhesive.py``); less for other directions, whence 0.5.
The criterion of Pohrt & Popov (2015), all or nothing at √(E*w/(0.473 dx)), holds on far longer.

The front of a set of cells lies inside its outline: by 0.117 dx, as the stiffness of discs of cells shows, from one
single cell to thousands. A round contact of n cells is thus smaller than it counts, and so is what a cell's
leaving takes from it; ``toughness`` lowers w accordingly, by 0.117 √(π/n): 1.2 % at a radius of ten cells.

Unit cells and unit modulus: tractions in nm (t dx/E*), w in nm² (w dx/E*).
"""

from typing import NamedTuple

import numpy as np

from .jit import kernel

LINEAR, DUGDALE, EXPONENTIAL = range(3)

#: Laws of finite range by name.
COHESIVE = {"dugdale": DUGDALE, "exponential": EXPONENTIAL}

#: Softening of the Griffith limit's law: the stiffness of an edge row, least over directions.
SOFTENING = 0.5

#: How far the front lies within the outline of its cells, in cells.
INSET = 0.117

#: Range of the exponential law in its length.
_CUT = 12.0

#: Cells that a process zone must span at least.
LEAST_ZONE = 2.0


class Law(NamedTuple):
    """A law in units of the cells."""

    code: int
    strength: float  # σ₀, nm
    range: float  # gap at which nothing pulls any more, nm
    length: float  # ρ of the exponential, nm; else the range
    anywhere: bool  # whether cells far from any contact attract, or a front's neighbours only


def griffith(w):
    """Return the law of the Griffith limit for w (nm²)."""
    strength = float(np.sqrt(2.0 * SOFTENING * w))
    reach = strength / SOFTENING
    return Law(LINEAR, strength, reach, reach, False)


def cohesive(name, w, strength):
    """Return a law of finite range for w (nm²) and its largest traction (nm)."""
    length = w / strength
    return Law(COHESIVE[name], strength, length if name == "dugdale" else _CUT * length, length, True)


def process_zone(contact_modulus, w, strength):
    """Return the length (nm) of Dugdale's zone at the edge of a large contact, π E* w/(4 σ₀²)."""
    return np.pi * contact_modulus * w / (4.0 * strength**2)


@kernel
def toughness(cells):
    """Return the factor on w at the edge of a contact of so many cells."""
    return 1.0 - INSET * np.sqrt(np.pi / max(cells, 1.0))


@kernel
def traction(u, law, root):
    """Return t(u) >= 0 and dt/du; ``root`` is the square root of the factor on w."""
    x = u / root
    if x >= law.range:
        return 0.0, 0.0
    if law.code == LINEAR:
        slope = law.strength / law.range
        return root * (law.strength - slope * x), -slope
    if law.code == DUGDALE:
        return root * law.strength, 0.0
    t = law.strength * np.exp(-x / law.length)
    return root * t, -t / law.length


@kernel
def remaining_work(u, law, root):
    """Return the work that is left to separate the surfaces from the gap u, nm²."""
    x = u / root
    if x >= law.range:
        return 0.0
    if law.code == EXPONENTIAL:
        return root * root * law.strength * law.length * np.exp(-x / law.length)
    if law.code == DUGDALE:
        return root * root * law.strength * (law.range - x)
    return root * root * 0.5 * law.strength * (law.range - x) ** 2 / law.range


@kernel
def balance(pressure, u, stiffness, law, root):
    """Return the gap u ≥ 0 at which one cell alone is in balance, p + m (u' − u) + t(u') = 0, near to u.

    Where the law ends abruptly there may be two such gaps; the cell stays on its side of the end.
    """
    free = u - pressure / stiffness
    end = law.range * root
    if free >= end and (u >= end or law.code == LINEAR):
        return free
    if law.code == EXPONENTIAL:
        held = min(u, end)
        for _ in range(30):
            t, slope = traction(held, law, root)
            change = (pressure + stiffness * (held - u) + t) / max(stiffness + slope, 0.1 * stiffness)
            held = max(held - change, 0.0)
            if abs(change) < 1e-13 * law.length:
                break
        return free if held >= end else held
    slope = law.strength / law.range if law.code == LINEAR and law.range > 0.0 else 0.0
    held = (stiffness * u - pressure - root * law.strength) / (stiffness - slope)
    if held >= end:
        return free
    return max(held, 0.0)
