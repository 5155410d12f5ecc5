"""roughxr: how hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface."""

from ._version import __version__
from .scans.samples import open_sample

__all__ = ["__version__", "open_sample"]
