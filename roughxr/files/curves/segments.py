"""Approach and retraction among the segments of a recorded curve: holds, creep and modulation belong to neither."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

#: A segment is a hold if it travels less than this share of the longest one.
_HOLD_TRAVEL = 0.02

#: The part of a ramp, as shares of its travel, whose straight line is extended to the hold.
_LINE = (0.1, 0.3)


def approach_and_retraction(
    piezo: np.ndarray, number: np.ndarray | None = None, paused: np.ndarray | None = None
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return the samples of the approach and of the retraction after it, None for a branch that is not there.

    ``piezo`` grows towards the surface. ``number`` is the file's number of each sample's segment, ``paused`` is True in
    segments that the file names a pause. A ramp with a pause in it is joined without the pause.
    """
    if not np.isfinite(piezo).any():
        return None, None
    ramps = _ramps(piezo, number, paused)
    travels = np.array([piezo[ramp[-1]] - piezo[ramp[0]] for ramp in ramps])
    main = np.abs(travels) > _HOLD_TRAVEL * np.abs(travels).max(initial=0.0)
    ramps = [ramp for ramp, is_main in zip(ramps, main) if is_main]
    joined = _joined(ramps, travels[main] > 0)
    rises = np.array([piezo[ramp[-1]] - piezo[ramp[0]] for ramp in joined])
    retraction = _last_main(-rises)
    approach = _last_main(rises[:retraction])
    return tuple(None if k is None else joined[k] for k in (approach, retraction))  # type: ignore[return-value]


def _joined(ramps: list[np.ndarray], rises: np.ndarray) -> list[np.ndarray]:
    """Return ramps with successive ones of one direction joined."""
    starts = np.flatnonzero(np.diff(rises, prepend=~rises[:1]))
    return [np.concatenate(ramps[first:end]) for first, end in pairwise([*starts, len(ramps)])]


def _last_main(travels: np.ndarray) -> int | None:
    """Return the last number of those that travel forward, at least half as far as the longest."""
    longest = travels.max(initial=0.0)
    # an earlier ramp is taken instead of the last one if the last one travels less than this share of the longest
    return max((k for k, travel in enumerate(travels) if 0 < 0.5 * longest <= travel), default=None)


def _ramps(piezo: np.ndarray, number: np.ndarray | None, paused: np.ndarray | None) -> list[np.ndarray]:
    """Return the samples of each ramp, in order: within the file's segments, in one direction, without holds."""
    cuts = [] if number is None else (np.flatnonzero(np.diff(number)) + 1).tolist()
    whole = np.nanmax(piezo) - np.nanmin(piezo)
    ramps = []
    for first, end in pairwise([0, *cuts, piezo.size]):
        segment = np.arange(first, end)
        segment = segment[np.isfinite(piezo[segment])]
        if segment.size and not (paused is not None and paused[first]):
            # a change of direction counts if the piezo goes back by this share of the curve's whole travel
            ramps += [_without_holds(piezo, part) for part in _monotonic(piezo, segment, 0.1 * whole)]
    return ramps


def _monotonic(piezo: np.ndarray, part: np.ndarray, reversal: float) -> list[np.ndarray]:
    """Return a part cut where the piezo turns back by more than ``reversal``."""
    z = piezo[part] if piezo[part[-1]] >= piezo[part[0]] else -piezo[part]
    loss = np.maximum.accumulate(z) - z
    bottom = int(np.argmax(loss))
    if loss[bottom] <= reversal:
        return [part]
    top = int(np.argmax(z[: bottom + 1]))
    pieces = (part[: top + 1], part[top + 1 : bottom + 1], part[bottom + 1 :])
    return [ramp for piece in pieces if piece.size for ramp in _monotonic(piezo, piece, reversal)]


def _without_holds(piezo: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return a ramp without the holds at its ends, where the piezo only creeps."""
    z = piezo[part] if piezo[part[-1]] >= piezo[part[0]] else -piezo[part]
    begin = _hold_end(z)
    end = z.size - _hold_end(-z[::-1])
    return part[begin:end] if begin < end else part


def _hold_end(z: np.ndarray) -> int:
    """Return the number of samples before a rise begins, 0 without a hold: the rise's straight line meets the hold."""
    rise = z[-1] - z[0]
    low, high, top = (int(np.argmax(z >= z[0] + share * rise)) for share in (*_LINE, 1 - _LINE[0]))
    ramp_samples = (top - low) / (1 - 2 * _LINE[0])
    # A stretch at either end of a ramp is a hold if it lasts longer than this share of the ramp: a sine turns in 0.12
    hold_time = 0.15
    if high == low or low <= hold_time * ramp_samples:
        return 0
    speed = (z[high] - z[low]) / (high - low)
    begin = low - round(float((z[low] - np.median(z[:low])) / speed))
    if not hold_time * ramp_samples < begin <= low:
        return 0
    creep = np.median(z[3 * begin // 4 : begin]) - np.median(z[: begin // 4 + 1])
    return begin if abs(creep) <= _HOLD_TRAVEL * rise else 0
