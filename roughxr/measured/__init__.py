"""Measured beside predicted: pull-off forces from the instrument, compared with those that a scan predicts."""

from .comparison import against
from .opening import open_pull_off

__all__ = ["against", "open_pull_off"]
