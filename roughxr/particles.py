"""Particles on a surface: resting positions, loads, detachment, and the fraction that remains."""

from .mechanics.particles import *  # noqa: F403
from .mechanics.particles import __all__ as __all__
from .mechanics.vocabulary.calls import public_functions

globals().update(public_functions(globals(), __all__, __name__))
