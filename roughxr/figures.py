"""Figures of results, one column of a paper wide, with units on every axis."""

from .application.figures import *  # noqa: F403
from .application.figures import __all__ as __all__
