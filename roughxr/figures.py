"""Figures of results, one column of a paper wide, with units on every axis."""

from .application.figures import *  # noqa: F403
from .application.figures import __all__ as __all__
from .mechanics.vocabulary.calls import public_functions

globals().update(public_functions(globals(), __all__, __name__))
