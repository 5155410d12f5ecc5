"""Particles on a surface: resting positions, loads, detachment, and the fraction that remains."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__package__, __file__)
