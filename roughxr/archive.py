"""Archives: one NetCDF-4 file for a run, with a group for each Dataset."""

from .application.archive import load, save

__all__ = [
    "load",
    "save",
]
