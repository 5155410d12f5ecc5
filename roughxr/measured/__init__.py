"""Measured beside predicted: pull-off forces from the instrument, compared with those that a scan predicts."""

from .opening import open_pull_off

__all__ = ["open_pull_off"]
