"""Archives: one NetCDF-4 file for a run, with a group for each Dataset."""

from .application.archive import *  # noqa: F403
from .application.archive import __all__ as __all__
from .mechanics.vocabulary.calls import public_functions

globals().update(public_functions(globals(), __all__, __name__))
