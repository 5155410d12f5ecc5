"""Smooth laws of adhesion across a gap u ≥ 0: sums of up to three terms, each of any size and range.

exponential     t = (w/ρ) exp(−u/ρ)                                              cut at 12 ρ
van der Waals   t = (8w/3z₀) [(z₀/z)³ − (z₀/z)⁹],  z = z₀ + u                    largest 1.026 w/z₀, at z = 3^{1/6} z₀
step            t = σ up to the gap a, σ (1 − s)² with s = (u − a)/(b − a) from there to b, 0 beyond

The second is the attraction between two half spaces of Lennard-Jones atoms (Israelachvili; Greenwood 1997). The
surfaces are hard at z₀, below which they would repel. The third is Dugdale's law with a cohesive zone's edge of finite
width; it also represents the tension of condensed water (σ = γ/r_K up to about h_c) and, with a = 0, adhesion of short
range.

``smooth_law`` builds a law from its terms. Solvers do not see the terms: they call ``traction`` (t and −dt/du) and
``remaining_work`` (∫ t du beyond a gap), and read the fields of `SmoothLaw`.

Unit cells and unit modulus: tractions in nm (t dx/E*), w in nm² (w dx/E*).
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel

#: Gap (in ρ) at which the exponential is cut off.
CUT = 12.0

#: Gap (in z₀) at which the second term is cut off.
TAIL = 11.0

#: Largest traction of the second term over w/z₀, and its largest |dt/du| over w/z₀², at contact.
_STRENGTH = 16.0 / (9.0 * 3.0**0.5)
WALL = 16.0


class Term(NamedTuple):
    """One term: the exponential's w and ρ, the second one's w and z₀, or the step's σ, a and b."""

    size: float  # w, nm², or σ, nm
    near: float  # nm
    far: float = 2.0  # nm


class SmoothLaw(NamedTuple):
    """A law in units of the cells."""

    exponential: Term
    waals: Term
    step: Term
    work: float  # whole work of separation, nm²
    strength: float  # largest traction, nm
    steepest: float  # largest |dt/du|, which the mesh must resolve
    onset: float  # gap at which loading begins, nm
    range: float  # gap beyond which the traction is 0, nm
    cut: float  # remaining work at the range, which is neglected, nm²


_NONE = Term(0.0, 1.0)


def smooth_law(*, exponential=_NONE, waals=_NONE, step=_NONE, cut=None):
    """Return the sum of some terms (tuples as in `Term`); ``cut`` is the range (nm), by default the terms'."""
    e, v, s = (Term(*(float(value) for value in term)) for term in (exponential, waals, step))
    strengths = e.size / e.near, _STRENGTH * v.size / v.near, s.size
    slopes = e.size / e.near**2, WALL * v.size / v.near**2, 2.0 * s.size / (s.far - s.near)
    is_given = [term.size > 0.0 for term in (e, v, s)]
    # gap at which loading begins and retraction ends, in lengths of the exponential or of the second term
    onset = 8.0
    onsets = (onset * e.near, onset * v.near, s.far)
    ranges = CUT * e.near, TAIL * v.near, s.far
    work = e.size + v.size + s.size * (2.0 * s.near + s.far) / 3.0
    whole = SmoothLaw(
        *(e, v, s, work, sum(strengths), sum(slopes)),
        max((x for x, present in zip(onsets, is_given) if present), default=0.0),
        np.inf,
        0.0,
    )
    reach = max((x for x, present in zip(ranges, is_given) if present), default=0.0) if cut is None else float(cut)
    return whole._replace(range=reach, cut=float(remaining_work(reach, whole)))


def without_range(w, fall):
    """Return the shortest-ranged law of work ``w`` on a mesh that resolves |dt/du| up to ``fall``."""
    end = np.sqrt(6.0 * w / fall)
    return smooth_law(step=(3.0 * w / end, 0.0, end))


def dugdale(w, length, fall):
    """Return a constant traction w/length up to a gap, with an edge of at most |dt/du| = ``fall``."""
    width = 2.0 * w / (length * fall)
    if width > 3.0 * length:
        return without_range(w, fall)
    return smooth_law(step=widened_step(w / length, length, width))


def widened_step(tension, length, width):
    """Return the `Term` of a tension up to a gap, its edge of a finite width, at the same work."""
    begin = length - width / 3.0
    return tension, begin, begin + width


#: Laws by name, of work w and length, whose edge is as steep as |dt/du| = ``fall`` where they have one.
LAWS = {
    "exponential": lambda w, length, fall: smooth_law(exponential=(w, length)),
    "jkr": lambda w, length, fall: without_range(w, fall),
    "dugdale": dugdale,
    "lennard_jones": lambda w, length, fall: smooth_law(waals=(w, length)),
}


@kernel
def traction(u, law):
    """Return t(u) ≥ 0, and −dt/du."""
    return traction_and_work(u, law)[:2]


@kernel
def remaining_work(u, law):
    """Return the work left to separate the surfaces from the gap u, nm²."""
    return traction_and_work(u, law)[2]


@kernel
def traction_and_work(u, law):
    """Return t(u), −dt/du and the work left to separate the surfaces, nm²."""
    if u >= law.range:
        return 0.0, 0.0, 0.0
    t = 0.0
    fall = 0.0
    remaining = -law.cut
    if law.exponential.size > 0.0:
        t, fall, work = _exponential(u, law.exponential)
        remaining += work
    if law.waals.size > 0.0:
        tension, slope, work = _van_der_waals(u, law.waals)
        t += tension
        fall += slope
        remaining += work
    if law.step.size > 0.0 and u < law.step.far:
        tension, slope, work = _step(u, law.step)
        t += tension
        fall += slope
        remaining += work
    return t, fall, remaining


@kernel
def _exponential(u, term):
    length = term.near
    part = term.size * np.exp(-u / length)
    return part / length, part / (length * length), part


@kernel
def _van_der_waals(u, term):
    length = term.near
    x = length / (length + u)
    x2 = x * x
    x3 = x * x * x
    x9 = x3 * x3 * x3
    scale = 8.0 * term.size / (3.0 * length)
    work = term.size * (4.0 * x2 - x2 * x2 * x2 * x2) / 3.0
    return scale * (x3 - x9), scale * (3.0 * x3 - 9.0 * x9) * x / length, work


@kernel
def _step(u, term):
    wide = term.far - term.near
    s = max((u - term.near) / wide, 0.0)
    slope = 2.0 * term.size * (1.0 - s) / wide if u >= term.near else 0.0
    return term.size * (1.0 - s) ** 2, slope, term.size * (max(term.near - u, 0.0) + wide * (1.0 - s) ** 3 / 3.0)
