"""Mesh and steps of the simulation with adhesion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ..vocabulary.calls import checked_class
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import RoughxrWarning
from ..vocabulary.units import fraction, positive, whole_number

#: In place of cells: the edge of the contact is followed as that of one region (`edge_front`).
FRONT = "front"

#: Largest number of cells along a side of a pixel.
MOST_REFINED = 16


class UnresolvedContact(RoughxrWarning):
    """A pull-off of one mesh that does not resolve the contacts, or states no error.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.UnresolvedContact)  # stop instead of warning
    """


class TooManyCells(Refusal):
    """The mesh has more cells within reach of the law than can be solved."""


@checked_class
@dataclass(frozen=True)
class Mesh:
    """Mesh and steps of the simulation with adhesion.

    Attributes
    ----------
    cells : "auto", "front" or int
        "front": in place of cells, the edge of the contact of a soft sphere is followed as that of one region. Else
        each pixel is divided into cells × cells cells, with heights interpolated without wavelengths below two pixels.
        "auto": at each place the mesh is refined until the pull-off changes by less than ``accuracy``: twice,
        unless the contact is resolved by so many cells that one agreement is no chance.
    accuracy : float or None
        Relative change of the pull-off, from cells twice as large, below which "auto" stops. The stated error may be
        larger, without range three times as large. None: take the coarsest mesh on which the law can be
        solved, without an estimate of its error, in a fifth of the time or less.
    step : number, quantity or None
        Longest step of the displacement, nm. None: 0.83 of the pair's range of adhesion (0.25 nm for the usual 0.3),
        or a fortieth of JKR's displacement δ_c of the sphere, whichever is longer. Retraction takes half of it, and
        shorter steps at the end of a branch of solutions, or if a larger tension may lie between two states.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.Mesh(4, step="0.1 nm")
    Mesh(cells=4, accuracy=0.05, step=0.1)
    """

    cells: int | str = "auto"
    accuracy: float | None = 0.05
    step: Any = None

    def __post_init__(self):
        if isinstance(self.cells, str) and self.cells not in ("auto", FRONT):
            raise Refusal("mesh", f"'auto', 'front' or a whole number from 1 to {MOST_REFINED}", f"{self.cells!r}")
        if not isinstance(self.cells, str):
            object.__setattr__(self, "cells", whole_number(self.cells, "mesh", least=1, most=MOST_REFINED))
        if self.accuracy is not None:
            object.__setattr__(self, "accuracy", fraction(self.accuracy, "accuracy"))
        if self.step is not None:
            object.__setattr__(self, "step", positive(self.step, "nm", "step"))


def read_mesh(mesh: Mesh | int | str | None, usual: Mesh) -> Mesh:
    """Return a `Mesh`, or the usual one with another refinement, as in ``mesh=4``."""
    if mesh is None:
        return usual
    return mesh if isinstance(mesh, Mesh) else replace(usual, cells=mesh)
