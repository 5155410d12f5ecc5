"""How two surfaces pull on each other across a gap u: laws whose work of separation is w whatever their range.

plateau       t = σ₀ up to a gap d, then falling with slope c to 0 at d + σ₀/c        w = σ₀ (d + σ₀/2c)
exponential   t = (w/ρ) exp(−u/ρ), cut off at 12 ρ (6·10⁻⁶ of w)                      σ₀ = w/ρ

On a mesh a front moves from cell to cell. It does so evenly, neither ahead of its due nor late, where the traction
falls as fast as a straight edge row resists, with a slope c: the row begins to open at σ₀ and is free just
when the next begins. For a front along the grid c = 0.5801, as the coefficients of strips give; along a diagonal 0.80
for one row of corners and 0.48 for two together. With 0.5 a sphere's force varied least as its front crossed the cells.
A law that falls faster holds on too long: all
or nothing at √(E*w/(0.473 dx)), the criterion of Pohrt & Popov (2015), by 11 % of a sphere's pull-off at ten cells.

griffith      d = 0, σ₀ = √(2c E*w/dx): no range but the mesh's
dugdale       σ₀ given, h = w/σ₀ = d + σ₀/2c: Dugdale's step at h (Maugis 1992), spread as far as the mesh needs;
              with a strength that leaves no plateau it is the Griffith limit's law

The front of a set of cells lies inside its outline: by 0.117 dx, as the stiffness of discs of cells shows, from one
single cell to thousands. A round contact of n cells is thus smaller than it counts, and so is what a cell's
leaving takes from it: by the part 0.117 √(π/n). The zone in which the front's cells let go, about a cell and a half
wide, helps a small contact to hold as in Maugis's theory: another 0.048 √(π/n), found on JKR's sphere and checked on
ellipses. ``toughness`` lowers w by both: 1.6 % at a radius of ten cells.

Unit cells and unit modulus: tractions in nm (t dx/E*), w in nm² (w dx/E*).
"""

from typing import NamedTuple

import numpy as np

from .jit import kernel

PLATEAU, EXPONENTIAL = range(2)

#: Laws of finite range by name.
COHESIVE = {"dugdale": PLATEAU, "exponential": EXPONENTIAL}

#: How fast a traction may fall with the gap: about the stiffness of an edge row.
SOFTENING = 0.5

#: How far the front lies within the outline of its cells, in cells.
INSET = 0.117

#: What the front's own width adds to that in the balance of energy, in cells.
WIDTH = 0.048

#: Range of the exponential law in its length.
_CUT = 12.0

#: Cells that a process zone must span at least.
LEAST_ZONE = 2.0


class Law(NamedTuple):
    """A law in units of the cells."""

    code: int
    strength: float  # σ₀, nm
    range: float  # gap at which nothing pulls any more, nm
    length: float  # ρ of the exponential, or the plateau's d, nm
    anywhere: bool  # whether cells far from any contact attract, or a front's neighbours only


def griffith(w):
    """Return the law of the Griffith limit for w (nm²)."""
    strength = float(np.sqrt(2.0 * SOFTENING * w))
    return Law(PLATEAU, strength, strength / SOFTENING, 0.0, False)


def cohesive(name, w, strength):
    """Return a law of finite range for w (nm²) and its largest traction (nm)."""
    length = w / strength
    if name == "exponential":
        return Law(EXPONENTIAL, strength, _CUT * length, length, True)
    fall = strength / SOFTENING
    return Law(PLATEAU, strength, length + 0.5 * fall, length - 0.5 * fall, True)


def process_zone(contact_modulus, w, strength):
    """Return the length (nm) of Dugdale's zone at the edge of a large contact, π E* w/(4 σ₀²)."""
    return np.pi * contact_modulus * w / (4.0 * strength**2)


@kernel
def toughness(cells):
    """Return the factor on w at the edge of a contact of so many cells."""
    return 1.0 - (INSET + WIDTH) * np.sqrt(np.pi / max(cells, 1.0))


@kernel
def effective_part(root):
    """Return the part of a contact's cells that its effective area is, for the root of its toughness."""
    return (1.0 - INSET / (INSET + WIDTH) * (1.0 - root * root)) ** 2


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
    return root * SOFTENING * (law.range - x), -SOFTENING


@kernel
def remaining_work(u, law, root):
    """Return the work that is left to separate the surfaces from the gap u, nm²."""
    x = u / root
    if x >= law.range:
        return 0.0
    if law.code == EXPONENTIAL:
        return root * root * law.strength * law.length * np.exp(-x / law.length)
    fall = law.range - max(x, law.length)
    return root * root * (0.5 * SOFTENING * fall * fall + law.strength * max(law.length - x, 0.0))


@kernel
def balance(pressure, u, stiffness, law, root):
    """Return the gap u' ≥ 0 at which one cell alone is in balance, p + m (u' − u) + t(u') = 0: there is only one."""
    end = law.range * root
    free = u - pressure / stiffness
    if free >= end:
        return free
    if law.code == EXPONENTIAL:
        return _exponential_balance(pressure, u, stiffness, law, root)
    flat = free - root * law.strength / stiffness
    if flat <= root * law.length:
        return max(flat, 0.0)
    return max((stiffness * free - SOFTENING * end) / (stiffness - SOFTENING), 0.0)


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
