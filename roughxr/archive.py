"""Archives: one NetCDF-4 file for a run, with a group for each Dataset."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__package__, __file__)
