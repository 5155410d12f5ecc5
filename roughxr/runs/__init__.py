"""Runs: computations that survive what happens to them, resume, and leave one machine.

loop        what a run does: `checkpointed`, from an empty disk to a whole archive
checkpoint  what a run keeps until then, in one file, which is also its lock
identity    what makes two runs the same
parameters  runs over radii, moduli and works of adhesion: `vary`
"""

from .loop import checkpointed
from .parameters import vary

__all__ = ["checkpointed", "vary"]
