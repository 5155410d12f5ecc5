"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__package__, __file__)
