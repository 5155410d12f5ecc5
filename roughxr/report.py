"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page."""

from .application.report import *  # noqa: F403
from .application.report import __all__ as __all__
