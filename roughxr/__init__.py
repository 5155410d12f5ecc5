"""roughxr: how hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface."""

from ._version import __version__

__all__ = ["__version__"]
