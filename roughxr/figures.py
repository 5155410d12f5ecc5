"""Figures of results, one column of a paper wide, with units on every axis."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__package__, __file__)
