"""Particles on a surface: resting positions, loads, detachment, and the fraction that remains."""

from .application.dem import to_dem
from .mechanics.particles import *  # noqa: F403
from .mechanics.particles import __all__ as _of_mechanics
from .mechanics.vocabulary.calls import public_functions

__all__ = [*_of_mechanics, "to_dem"]

globals().update(public_functions(globals(), __all__, __name__))
