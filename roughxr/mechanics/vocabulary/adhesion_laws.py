"""The laws of adhesion, in one table for all verbs, the shell and the pages.

A new law is one row of `ADHESION_LAWS`, and a function of its name in the kernels of the verbs that have it:
``kernels.adhesion.traction_laws`` (`adhesive`), ``kernels.adhesion.potentials`` (`rigid`),
``kernels.asperity.asperity_laws`` (sums over asperities).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .refusal import Refusal
from .text import did_you_mean

AUTO = "auto"
EXPONENTIAL = "exponential"
JKR = "jkr"
DUGDALE = "dugdale"
LENNARD_JONES = "lennard_jones"
HAMAKER = "hamaker"
DMT = "dmt"
HERTZ = "hertz"

#: Tabor's parameter from which on the range of adhesion may be neglected, as in JKR's theory (Johnson & Greenwood,
#: J. Colloid Interface Sci. 192 (1997) 326); below, the error of that limit is some per cent or more.
SHORT_RANGE = 5.0

#: Tabor's parameter below which bodies hardly deform, as in DMT's theory (the same authors).
LONG_RANGE = 0.1


class AdhesionLaw(NamedTuple):
    """A law of adhesion: what it is called, which verbs have it, and what they need to know of it."""

    help: str  # one line
    verbs: tuple[str, ...]
    synonyms: tuple[str, ...] = ()  # understood as input
    length: str = ""  # meaning of its length, in nm; empty without range
    largest_cell: float = math.inf  # of `adhesive`, over E* length²/w
    refused_cell: float = 1.0  # from which on cells are refused, over the largest
    has_edge: bool = False  # the traction of `adhesive` ends abruptly, and is extrapolated in the width of its edge
    rival: str = EXPONENTIAL  # the law of `adhesive` for cells that do not resolve this one
    takes_liquid: bool = False  # attracts beyond menisci, too
    adheres: bool = True
    has_closest_approach: bool = False  # its length is the closest approach, and not the range
    has_hamaker_tail: bool = False  # at large gaps it attracts as Hamaker's constant states, and is cut off there
    formulations: tuple[str, ...] = ()  # of elliptic asperities, that its sums take

    @property
    def has_range(self) -> bool:
        """Whether it attracts across gaps."""
        return bool(self.length)


#: All laws by name. The largest cell is as stiff as the steepest slope of the traction: larger ones let the edge of a
#: contact jump from cell to cell, which overestimates the pull-off (on the glass twin by 4 to 7 times at cells of 3.7,
#: by some per cent at 0.9 and 0.5). That of an edge leaves part of the constant tension beside the wider edge. Of the
#: exponential law, which mesh="auto" refines, cells are refused at which pull-offs would be many times too large, and
#: Newton's method hardly converges.
ADHESION_LAWS = {
    AUTO: AdhesionLaw("chosen by Tabor's parameter", ("adhesive", "fit_curve")),
    EXPONENTIAL: AdhesionLaw(
        "the traction falls by a factor of e over the range",
        ("adhesive", "rigid"),
        length="ρ, the gap over which the traction falls by a factor of e",
        largest_cell=1.0,
        refused_cell=20.0,
        rival=JKR,
        takes_liquid=True,
    ),
    JKR: AdhesionLaw(
        "the limit of zero range, by Griffith, or Johnson, Kendall and Roberts",
        ("adhesive", "superpose", "pull_off_map", "fit_curve"),
        ("griffith", "johnson_kendall_roberts"),
        has_edge=True,
        formulations=("energy", "published", "self_similar"),
    ),
    DUGDALE: AdhesionLaw(
        "a constant tension up to a gap, by Dugdale and Maugis",
        ("adhesive", "rigid", "superpose", "pull_off_map", "fit_curve"),
        ("maugis", "maugis_dugdale"),
        length="the largest attracting gap; of asperities and fitted curves z₀, 1.03 times that gap",
        largest_cell=0.1875,
        has_edge=True,
        formulations=("energy", "self_similar"),
    ),
    LENNARD_JONES: AdhesionLaw(
        "the 9-3 potential of two half spaces",
        ("adhesive", "rigid"),
        ("lj", "9_3"),
        length="z₀ of the potential, where the bodies touch",
        largest_cell=1 / 16,
        has_hamaker_tail=True,
    ),
    HAMAKER: AdhesionLaw(
        "van der Waals attraction beyond a closest approach",
        ("rigid",),
        ("van_der_waals", "vdw"),
        length="the closest approach z₀",
        has_closest_approach=True,
    ),
    DMT: AdhesionLaw(
        "the limit of long range, by Derjaguin, Muller and Toporov",
        ("fit_curve",),
        ("derjaguin_muller_toporov",),
        length="z₀, for Tabor's parameter only",
    ),
    HERTZ: AdhesionLaw("no adhesion", ("superpose",), adheres=False, formulations=("energy", "published")),
}

_NAMES = {synonym: name for name, row in ADHESION_LAWS.items() for synonym in (name, *row.synonyms)}


def laws_of(verb: str) -> tuple[str, ...]:
    """Return the names of the laws that a verb has."""
    return tuple(name for name, row in ADHESION_LAWS.items() if verb in row.verbs)


def read_law(law: Any, verb: str) -> str:
    """Return the name of a law, given by name or synonym; raise if the verb does not have it.

    Examples
    --------
    >>> read_law("Griffith", "adhesive"), read_law("Lennard-Jones", "rigid")
    ('jkr', 'lennard_jones')
    """
    names = laws_of(verb)
    text = str(law).strip().lower().replace("-", "_").replace(" ", "_")
    name = _NAMES.get(text, text)
    if name in names:
        return name
    listed = f"one of {', '.join(map(repr, names))}"
    if name in ADHESION_LAWS:
        raise Refusal("law", listed, f"{law!r}", f"only {' and '.join(ADHESION_LAWS[name].verbs)} takes it")
    spellings = [spelling for spelling, meant in _NAMES.items() if meant in names]
    raise Refusal("law", listed, f"{law!r}{did_you_mean(law, spellings)}")


def law_by_tabor(tabor: float) -> str:
    """Return the law of a sphere with Tabor's parameter: JKR's, DMT's, or Dugdale's between them."""
    if tabor > SHORT_RANGE:
        return JKR
    return DMT if tabor < LONG_RANGE else DUGDALE
