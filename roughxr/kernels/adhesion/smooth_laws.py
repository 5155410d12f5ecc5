"""Smooth laws of adhesion across a gap u ≥ 0, all with the work of separation w, whatever their range.

exponential     t = (w/ρ) exp(−u/ρ)                                              largest traction w/ρ, where it touches
van der Waals   t = (8w/3z₀) [(z₀/z)³ − (z₀/z)⁹],  z = z₀ + u                    1.026 w/z₀, at z = 3^{1/6} z₀

The second is the attraction between two half spaces of Lennard-Jones atoms (Israelachvili; Greenwood 1997). The
surfaces are taken as hard at z₀, closer than which they would repel. Beyond ``range`` nothing pulls: there t drops to
zero, from e⁻¹² of the largest under the first law, and from 1.6·10⁻³ under the second, at eleven z₀.

Unit cells and unit modulus: tractions in nm (t dx/E*), w in nm² (w dx/E*).
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel

EXPONENTIAL, VAN_DER_WAALS = range(2)

#: Codes of the laws, by name.
NAMES = {"exponential": EXPONENTIAL, "van_der_waals": VAN_DER_WAALS}

#: Gap, in lengths of the law, beyond which nothing pulls.
CUT = (12.0, 11.0)

#: Largest traction over w/length.
_STRENGTH = (1.0, 16.0 / (9.0 * 3.0**0.5))


class SmoothLaw(NamedTuple):
    """A law in units of the cells."""

    code: int
    work: float  # w, nm²
    length: float  # ρ or z₀, nm
    strength: float  # largest traction, nm
    range: float  # nm
    cut: float  # the work left beyond the range, which is not counted, nm²


def smooth_law(name, w, length, cut=None):
    """Return the law of this name with the work of separation w (nm²) and its length ρ or z₀ (nm).

    ``cut`` is the gap, in lengths, beyond which nothing pulls; the work left there is not counted.
    """
    code = NAMES[name]
    reach = (CUT[code] if cut is None else cut) * length
    whole = SmoothLaw(code, float(w), float(length), _STRENGTH[code] * w / length, np.inf, 0.0)
    return whole._replace(range=reach, cut=float(remaining_work(reach, whole)))


@kernel
def traction(u, law):
    """Return t(u) ≥ 0, and the slope −dt/du at which it falls."""
    if u >= law.range:
        return 0.0, 0.0
    if law.code == EXPONENTIAL:
        t = law.strength * np.exp(-u / law.length)
        return t, t / law.length
    x = law.length / (law.length + u)
    x3 = x * x * x
    x9 = x3 * x3 * x3
    scale = 8.0 * law.work / (3.0 * law.length)
    return scale * (x3 - x9), scale * (3.0 * x3 - 9.0 * x9) * x / law.length


@kernel
def remaining_work(u, law):
    """Return the work left to separate the surfaces from the gap u, nm²."""
    if u >= law.range:
        return 0.0
    if law.code == EXPONENTIAL:
        return law.work * np.exp(-u / law.length) - law.cut
    x = law.length / (law.length + u)
    x2 = x * x
    return law.work * (4.0 * x2 - x2 * x2 * x2 * x2) / 3.0 - law.cut
