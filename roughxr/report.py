"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page."""

from .application.report import *  # noqa: F403
from .application.report import __all__ as __all__
from .mechanics.vocabulary.calls import public_functions

globals().update(public_functions(globals(), __all__, __name__))
