"""Measured pull-off forces: reading, comparison with predictions, and fits of the work of adhesion."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__package__, __file__)
