"""Statistics over places: pull-off forces, distributions and their uncertainty."""

from .mechanics.statistics import *  # noqa: F403
from .mechanics.statistics import __all__ as __all__
from .mechanics.vocabulary.calls import public_functions

globals().update(public_functions(globals(), __all__, __name__))
