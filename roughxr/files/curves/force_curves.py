"""The pull-off force of each retraction in force-distance curves, and its uncertainty due to noise and baseline."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import RoughxrWarning, warn
from ...mechanics.vocabulary.units import Quantity, converted, positive, single
from .baselines import (
    Baseline,
    bin_means,
    extrapolated_level,
    last_step,
    least_error_line,
    line_through,
    median,
    rounding_noise,
    sample_noise,
    straight_baseline,
    white_noise,
    with_choice_error,
)
from .sharp_steps import Step, contact_end, sharpest_step, smallest_detected_pull

#: Smallest number of samples of a retraction.
_LEAST_SAMPLES = 50

#: Smallest number of samples of its baseline.
_LEAST_BASELINE = 10

#: Smallest number of samples of the part in contact.
_LEAST_PRESSED = 5

#: A pull-off is measured if the force is so many standard deviations of the noise below the baseline, …
_SIGNIFICANCE = 5.0

#: … and so many standard errors of the baseline.
_BASELINE_SIGNIFICANCE = 2.5

#: A jump takes at most this many samples.
_LONGEST_JUMP = 10

#: A straight stretch is the baseline if it is this share of the travel after the lowest force.
_PLAIN = 0.8

#: Parabola through the lowest force: most samples on either side.
_HALF_WIDTH = 41

#: Fewest samples of that parabola.
_LEAST_LOW = 8

#: Largest heights above the lowest sample, in standard deviations.
_SAMPLE_SPREADS = (4.0, 6.0)

#: Largest height above the parabola's vertex, in standard deviations.
_PARABOLA_SPREAD = 2.5

#: Number of iterations of the parabola.
_ROUNDS = 6

#: Rise of the force above the lowest sample, in standard deviations of the noise, by which a surface has detached.
_DETACHED = 6.0

#: Number of bins of the free part whose highest level is a reading.
_FREE_BINS = 20

#: Share of those bins, farthest from the surface, that shows the interference.
_FAR = 0.3

#: Why a curve has no pull-off, in its ``reason``.
_SHORT = f"fewer than {_LEAST_SAMPLES} samples"
_SHORT_BASELINE = f"fewer than {_LEAST_BASELINE} samples in the baseline"
_NO_RETRACTION = "the piezo does not retract from the first sample to the last"
_CONSTANT = "the force is the same at all samples"
_PRESSED_LAST = "the force is largest at the far end; the piezo may have the opposite sign"
_NOT_PRESSED = "the force is lowest at the first sample; it may have the opposite sign"
_NO_RISE = "the force does not rise in contact"
_NO_PULL = "no pull exceeds the noise"
_SATURATED = "the detector's range ends before the largest pull"

#: Samples before and after a rupture.
_RUPTURE_SAMPLES = 4

#: Height of a rupture in standard deviations of the difference of both sides.
_RUPTURE_SIGNIFICANCE = 6.0

#: A steady change of the force on either side of a rupture is at most this part as high.
_STEADY = 0.5


#: Share of the travel that may contain the baseline, or the two shares between which it lies, from the far end.
_Stretch = float | tuple[float, float]


class ImplausibleCurves(RoughxrWarning):
    """Force-distance curves were read as their file states, but no surface could give such curves.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.ImplausibleCurves)  # stop instead of warning
    """


class _CurveResults(NamedTuple):
    """The results of one retraction, by their names in a Dataset."""

    pull_off_force: float = np.nan
    pull_off_standard_error: float = np.nan
    pull_off_at_most: float = np.nan
    pull_off_at_least: float = np.nan
    pull_off_distance: float = np.nan
    work_of_separation: float = np.nan
    largest_rupture: float = np.nan
    ruptures: float = np.nan
    detection_limit: float = np.nan
    force_noise: float = np.nan
    contact_point: float = np.nan
    contact_slope: float = np.nan
    baseline_offset: float = np.nan
    baseline_tilt: float = np.nan
    reason: str = ""


@schema.recorded
def curves_pull_off(
    ds: xr.Dataset, *, spring_constant: Quantity | None = None, baseline: float | tuple[float, float] = 1.0
) -> xr.Dataset:
    """Return the pull-off forces of force-distance curves.

    Parameters
    ----------
    ds : Dataset
        ``piezo`` (units of a length, growing towards the surface, from any zero) and either ``force`` or ``deflection``
        (> 0 for repulsion). Along ``sample`` or (subregion, sample) they are retractions, from the largest contact
        force on; along (subregion, branch, sample) the branch "retraction" is used. Coordinates of places are kept.
    spring_constant : number or quantity, optional
        N/m, if ``ds`` does not state it; needed for deflections. For forces it is used to subtract the bending of the
        cantilever from the distance.
    baseline : float or pair of floats
        Share of the travel, farthest from the surface, that may contain the baseline. Or the baseline itself, (from,
        to): the stretch between two shares of the travel, from the far end, through which a straight line is the
        baseline, such as (0, 0.4) for the farthest 40 %.

    Returns
    -------
    Dataset
        Along ``subregion``: ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_standard_error``, its standard
        error due to noise and baseline; ``pull_off_at_most``, the limit of a curve without a detected pull, and
        ``pull_off_at_least``, that of a curve whose detector is saturated, NaN for all others; ``pull_off_distance``
        (nm), from zero force to the largest tension, less the bending of the cantilever if its spring constant is
        known; ``work_of_separation``
        (nN nm), done by the piezo against the adhesion force; ``largest_rupture`` (nN) and ``ruptures``, the largest
        sudden loss of tension and their number, which need no baseline; ``detection_limit`` (nN), the smallest pull
        that would be detected in the curve, or less where the pull is more than four times as large;
        ``force_noise`` (nN); ``contact_point`` (nm), the piezo's travel at zero force; ``contact_slope`` (nN/nm), in
        the upper half of the contact; ``baseline_offset`` (nN) at the contact point and ``baseline_tilt`` (nN/nm), of
        the line to subtract from the recorded force; ``reason``, why a curve has no pull-off, which is then NaN.

    Warns
    -----
    ImplausibleCurves
        If the median slope in contact is more than 1.1 times the spring constant: the sensitivity is then too large.

    Notes
    -----
    A line through the longest straight stretch from the far end is the baseline of a curve that has one. Interference
    bends it: then a jump is read beside itself, against the force of the free cantilever just after it, which a local
    polynomial extrapolates; the error contains the rms of the interference about a straight line. Without a jump, the
    line is the one whose error is least. So each curve gives a force with an error, or a limit: leaving out curves
    with a large error would leave out the small pulls. A pull is also detected by the step in which it ends, whatever
    the drift around it: a step that is higher than any other of the curve by five times what steps of the far part are.
    A step in contact is none.

    Where the force returns slowly, and no jump ends the tension, the line and the highest level of the free part are
    two readings: their mean is taken, and half of their difference is part of the error. So are a rise of the force
    after a jump, beyond tilt and interference, and the difference of two parabolas through the lowest samples. On made
    curves with a slow return, or a jump and a slow return, 87 to 99 % of the pulls lie within two standard errors.

    The limit of a curve is the size of the smallest pulls that are detected at six places where they are added to the
    curve itself. They grow as fast as the force in contact falls, and end in a jump: a tail without a jump may hide
    below slow drift. On soft curves with drift of up to 25 standard deviations of the noise
    ``tests/benchmarks/censored_curves.py --soft`` prints how often limits and means hold.

    On made curves with interference of 0.5 to 20 % of the pull, tilt and drift, 99 to 100 % of the pulls lie within
    two standard errors (92 to 98 % if the interference has kinks), and the bias of their mean is at most 2 %, 3.5 %
    with kinks. Pulls of 6 to 20 standard deviations of the noise do in 88 to 95 %; their bias is at most 4 %. Of
    curves without a pull, at most 1 % give a force if the interference is a sine of 1 to 30 standard deviations of
    the noise, up to 16 % if it has kinks (``tests/benchmarks/made_curves.py``). Interference that goes on in
    contact, of 5 or 20 % of the pull, changes ``contact_slope`` by 5 or 17 %, and the pull-off force within its
    error.
    The uncertainty does not include that of the parabola through the samples before the jump, about 0.1 % for a sphere
    on a soft lever.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> piezo = np.linspace(20.0, -80.0, 400)
    >>> force = np.where(piezo > -10.0, 2.0 * piezo, 0.0) + 0.01 * piezo + 3.0
    >>> force += np.random.default_rng(0).normal(0.0, 0.1, 400)
    >>> curve = xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})})
    >>> pull = roughxr.measured.curves_pull_off(curve)
    >>> bool(abs(pull.pull_off_force[0] - 20) < 0.6), round(float(pull.contact_slope[0]), 1)
    (True, 2.0)
    """
    ds = schema.entered_dataset(ds, "force_curve")
    stretch = _stated_stretch(baseline)
    recorded, stiffness = recorded_curves(ds, spring_constant)
    retraction = recorded.sel(branch="retraction") if "branch" in recorded.dims else recorded
    pulls = [
        evaluated_retraction(z, f, stiffness, stretch)
        for z, f in zip(retraction["piezo"].values, retraction["force"].values)
    ]
    out = at_places(dict(zip(_CurveResults._fields, map(list, zip(*pulls)))), ds)
    _warn_of_slope(out["contact_slope"].values, stiffness)
    out.attrs = {"measured": "force-distance curves", "baseline": stretch, "missing": "NaN where reason says why"}
    out.attrs |= {} if np.isinf(stiffness) else {"spring_constant": stiffness}
    return schema.label(out)


def _stated_stretch(baseline: Any) -> float | tuple[float, float]:
    """Return the share of the travel that may contain the baseline, or the ends of the baseline; raise if wrong."""
    if not isinstance(baseline, (tuple, list, np.ndarray)):
        return single(baseline, "1", "baseline", "a share of the travel, or two", lambda share: 0 < share <= 1)
    if len(baseline) == 2:
        near_end = single(baseline[1], "1", "baseline", "a share of the travel", lambda share: 0 < share <= 1)
        expected = f"a share of the travel below {near_end:g}"
        return single(baseline[0], "1", "baseline", expected, lambda share: 0 <= share < near_end), near_end
    raise Refusal("baseline", "one share of the travel, or two", f"{len(baseline)}")


def at_places(columns: Mapping[str, Any], ds: xr.Dataset) -> xr.Dataset:
    """Return results of curves along ``subregion``, at the places of the curves."""
    out = xr.Dataset({name: ("subregion", values) for name, values in columns.items()})
    if "subregion" not in ds.dims:
        return out
    places = {name: ds[name] for name in ("subregion", "subregion_x", "subregion_y") if name in ds.coords}
    return out.assign_coords({"subregion": np.arange(out.sizes["subregion"]), **places})


def _warn_of_slope(slopes: np.ndarray, stiffness: float) -> None:
    """Warn if forces rise faster in contact than the cantilever can bend."""
    times = np.median(slopes[np.isfinite(slopes)]) / stiffness if np.isfinite(slopes).any() else 0.0
    # factor that allows for errors: in contact the force cannot rise faster than the cantilever's spring constant
    if times > 1.1:
        warn(
            f"in contact the force rises by {times * stiffness:.3g} nN per nm of the piezo's travel, {times:.2f} times "
            "the spring constant: the sensitivity (nm/V) is too large by that factor at least, and so are the forces",
            ImplausibleCurves,
        )


def recorded_curves(ds: xr.Dataset, spring_constant: Any) -> tuple[xr.Dataset, float]:
    """Return travel and force along (subregion, …, sample), and the stiffness (inf if unknown)."""
    name = "force" if "force" in ds else "deflection"
    for axis in ("piezo", name):
        dims = tuple(ds[axis].dims) if axis in ds else ()
        if "sample" not in dims or not set(dims) <= {"subregion", "branch", "sample"}:
            shape = f"dimensions {dims}" if axis in ds else f"variables {', '.join(map(str, ds.data_vars))}"
            raise Refusal(axis, "it along 'sample' or ('subregion', 'sample')", shape)
    stiffness = _stiffness(ds, spring_constant)
    if name == "deflection" and np.isinf(stiffness):
        raise Refusal("spring_constant", "it in N/m to make forces of deflections", "none")
    force = converted(ds["force"], "nN", "force") if name == "force" else converted(ds[name], "nm", name) * stiffness
    pair = xr.broadcast(converted(ds["piezo"], "nm", "piezo"), force)
    both = [axis if "subregion" in axis.dims else axis.expand_dims("subregion") for axis in pair]
    out = xr.Dataset(dict(zip(("piezo", "force"), both))).transpose("subregion", ..., "sample")
    if "branch" in out.dims and "retraction" not in out.get_index("branch"):
        raise Refusal("branch", "'retraction' among them", out["branch"].values.tolist())
    return out.astype(float), stiffness


def _stiffness(ds: xr.Dataset, spring_constant: Any) -> float:
    """Return the spring constant (nN/nm) that is stated or given, inf without any."""
    stated = ds.attrs.get("spring_constant", np.inf)
    if spring_constant is None:
        return float(stated)
    stiffness = positive(spring_constant, "nN/nm", "spring_constant")
    if np.isfinite(stated) and not np.isclose(stiffness, stated, rtol=1e-6, atol=0):
        raise Refusal(
            "spring_constant", f"{stated:.6g} N/m, as the curves state", f"{stiffness:.6g} N/m", "leave it out"
        )
    return stiffness


def evaluated_retraction(z: np.ndarray, force: np.ndarray, stiffness: float, share: _Stretch) -> _CurveResults:
    """Return the results of one retraction."""
    time = np.flatnonzero(np.isfinite(z) & np.isfinite(force))
    z = z[time]
    force = force[time]
    reason = _unusable(z, share)
    if reason:
        return _CurveResults(reason=reason)
    if np.ptp(force) == 0:
        return _CurveResults(reason=_CONSTANT)
    if _is_pressed_at_the_end(force):
        return _CurveResults(reason=_PRESSED_LAST)
    pull = retraction_pull(z, force, share)
    lowest, line = pull.lowest, pull.line
    flat = force - line.force(z)
    heights = [rupture.height for rupture in _ruptures(force, white_noise(force))]
    result = _CurveResults(
        largest_rupture=max(heights, default=np.nan),
        ruptures=len(heights),
        detection_limit=_detection_limit(z, force, share, pull, flat),
        force_noise=line.noise,
        baseline_tilt=line.tilt,
    )
    zero = _last_repulsive(flat, lowest if pull.is_measured else flat.size, line.noise)
    if zero is not None:
        result = result._replace(**_contact(z, flat, zero, line))
    if result.contact_slope <= 0:
        return result._replace(reason=_NO_RISE)
    if not pull.is_measured:
        return result._replace(pull_off_at_most=result.detection_limit, reason=_NO_PULL)
    if zero is None and lowest < flat.size // 100:
        return result._replace(reason=_NOT_PRESSED)
    result = result._replace(**_measured_pull(time, z, force, pull, isinstance(share, tuple)))
    if zero is None or result.reason:
        return result
    return result._replace(
        pull_off_distance=float(z[zero] - z[lowest] + (flat[lowest] - flat[zero]) / stiffness),
        work_of_separation=np.trapezoid(flat[zero:], z[zero:]),
    )


def _measured_pull(time: np.ndarray, z: np.ndarray, force: np.ndarray, pull: Pull, is_stated: bool) -> dict[str, Any]:
    """Return a pull with its standard error, or its least size if the detector is saturated."""
    line = pull.line
    minimum, own_error = _largest_tension(time, force - line.force(z), pull)
    if _is_saturated(force, pull.lowest, z <= line.end):
        return {"pull_off_at_least": -minimum, "reason": _SATURATED}
    has_one_level = pull.step is not None or is_stated or line.spread > 0
    slow_return = 0.0 if has_one_level else _slow_return(force, z, pull) / 2
    error = float(np.linalg.norm([own_error, pull.error, line.spread, slow_return]))
    return {"pull_off_force": slow_return - minimum, "pull_off_standard_error": error}


def _largest_tension(time: np.ndarray, flat: np.ndarray, pull: Pull) -> tuple[float, float]:
    """Return the lowest force of a pull above its baseline, and its standard error by the samples around it."""
    if pull.step is not None:  # the drift around it would tilt a parabola
        return -pull.step.height, pull.step.error
    readings = [_minimum(time, flat, pull.lowest, pull.end, pull.line.noise, spread) for spread in _SAMPLE_SPREADS]
    (minimum, error), (other, _) = readings
    return minimum, np.hypot(error, minimum - other)


def _slow_return(force: np.ndarray, z: np.ndarray, pull: Pull) -> float:
    """Return how far the force rises above the baseline of the pull, beyond tilt and interference, nN."""
    highest, interference = _free_levels(force, pull.lowest)
    # over the whole free part a tilt rises by this much
    tilted = interference / _FAR
    return max(highest - float(pull.line.force(z[pull.lowest])) - tilted, 0.0)


def _detection_limit(z: np.ndarray, force: np.ndarray, share: _Stretch, pull: Pull, flat: np.ndarray) -> float:
    """Return the smallest pull that would be detected in a retraction, nN."""
    # a pull that exceeds its threshold by this factor exceeds the smallest detected one
    if pull.is_measured and (pull.depth > 4 * pull.threshold or flat.size - pull.end < _LEAST_SAMPLES):
        return pull.threshold
    noise = sample_noise(force)
    contact = contact_end(force)
    if pull.is_measured:
        width = 8  # samples whose mean is above half of the pull before its tension begins
        before = np.flatnonzero(bin_means(flat[: pull.lowest], width) > -pull.depth / 2)
        contact = int(before[-1] + 1) * width if before.size else 0
        rest = np.r_[:contact, pull.end : flat.size]
        z, force = z[rest], force[rest]
    return smallest_detected_pull(force, contact, noise, lambda pulled: retraction_pull(z, pulled, share))


def _is_pressed_at_the_end(force: np.ndarray) -> bool:
    """Return whether the force rises at the last samples alone, as on an approach."""
    level = median(force)
    rise = median(force[-5:]) - level
    # no tilt, which would change the first samples as much, and more than noise
    return abs(median(force[:5]) - level) < 0.1 * rise and rise > 20 * sample_noise(force)


class Pull(NamedTuple):
    """The lowest force of a retraction."""

    lowest: int  # sample
    depth: float  # below the baseline, nN
    line: Baseline
    error: float  # of the baseline there, nN
    significance: float  # standard errors of the baseline by which the force has to be lower
    end: int  # first sample after the detachment
    step: Step | None = None  # that shows the detachment, whatever the baseline

    @property
    def is_measured(self) -> bool:
        """Whether the force is lower than noise and baseline explain, or rises in a higher step."""
        return self.step is not None or self.depth - self.line.spread >= self.threshold

    @property
    def threshold(self) -> float:
        """The smallest depth that noise and baseline do not explain, nN."""
        if self.step is not None:
            return self.step.threshold
        return max(_SIGNIFICANCE * self.line.noise, self.significance * self.error)


def retraction_pull(z: np.ndarray, force: np.ndarray, share: _Stretch) -> Pull:
    """Return the lowest force of a retraction, above the baseline whose error holds there."""
    if isinstance(share, tuple):
        return _pull_above_stretch(z, force, share)
    lowest, recovery = _lowest_sample(force)
    far = _far_part(z, force, share, recovery)
    pull = _pull_at(z, force, lowest, far)
    if pull.is_measured:
        return pull
    step = sharpest_step(force, far.noise)
    if step is None or step.first <= far.start:
        return pull
    at = z[step.first]
    if far.is_plain(z, at) and step.level - step.height / 2 > far.line.force(at):  # in contact
        return pull
    # interference may recover more than a weak pull, which ends in a step
    return _pull_at(z, force, _foot(force, step.first), far, step)


def _free_levels(force: np.ndarray, first: int) -> tuple[float, float]:
    """Return the highest force of the free part from a sample on, and its range over the far part, without noise."""
    after = bin_means(force[first:], max((force.size - first) // _FREE_BINS, 1))
    if not after.size:
        return -np.inf, 0.0
    return float(after.max()), float(np.ptp(after[int((1 - _FAR) * after.size) :]))


def _pull_above_stretch(z: np.ndarray, force: np.ndarray, stretch: tuple[float, float]) -> Pull:
    """Return the lowest force before a stretch, above the straight line through the stretch."""
    far = _in_stretch(z, stretch)
    first = int(np.argmax(far))
    noise = sample_noise(force)

    def line_at(travel: float) -> Baseline:
        return least_error_line(z[far], force[far], noise, travel, shortest=1.0)

    flat = force - line_at(float(z[first])).force(z)
    lowest = int(np.argmin(flat[: max(first, 1)]))
    line = line_at(float(z[lowest]))
    depth = float(line.force(z[lowest]) - force[lowest])
    end = _detachment_sample(force, lowest, noise)
    return Pull(lowest, depth, line, line.error(z[lowest]), _BASELINE_SIGNIFICANCE, end)


def _in_stretch(z: np.ndarray, share: _Stretch) -> np.ndarray:
    """Return which samples lie in a stretch, or in a share of the travel from its far end."""
    far_end, near_end = share if isinstance(share, tuple) else (0.0, share)
    position = (z - z.min()) / np.ptp(z)
    return (position >= far_end) & (position <= near_end)


def _foot(force: np.ndarray, end: int) -> int:
    """Return the lowest sample before a loss of tension."""
    first = max(end - _LONGEST_JUMP, 0)
    return first + int(np.argmin(force[first:end]))


class _FarPart(NamedTuple):
    """The part of a retraction in which its baseline is searched, and what does not depend on the lowest sample."""

    start: int  # first sample
    after_losses: int  # first sample after all losses of tension
    losses: list[_Rupture]
    recovery: float  # largest, of the force, nN
    noise: float  # nN
    line: Baseline  # straight
    others: list[Baseline]  # through other stretches

    def is_plain(self, z: np.ndarray, at: float) -> bool:
        """Return whether the longest straight stretch is the baseline at a travel."""
        return bool(self.line.longest - z[-1] >= _PLAIN * (at - z[-1]))


def _far_part(z: np.ndarray, force: np.ndarray, share: float, recovery: float) -> _FarPart:
    """Return the far part, a share of the travel."""
    noise = white_noise(force)
    losses = _ruptures(force, noise)
    start = int(np.argmax(z <= z.min() + share * np.ptp(z)))
    after_losses = max([start, *(rupture.end for rupture in losses)])
    after_losses = after_losses if force.size - after_losses >= _LEAST_SAMPLES else start
    line, others = straight_baseline(z[after_losses:], force[after_losses:], z.size)
    return _FarPart(start, after_losses, losses, recovery, max(noise, rounding_noise(force)), line, others)


def _pull_at(z: np.ndarray, force: np.ndarray, lowest: int, far: _FarPart, step: Step | None = None) -> Pull:
    """Return the pull at a sample, after which the force may have a step."""
    at = z[lowest]
    straight = with_choice_error(far.line, far.others, at)
    first = _first_free_sample(force, lowest, far) if step is None else step.first
    first = max(first, far.start)
    significance = _BASELINE_SIGNIFICANCE
    line = straight
    is_plain = far.is_plain(z, at)
    if not is_plain and (step is not None or _has_jumped(z, force, lowest, first)):
        line = _line_after_jump(z, force, lowest, first, straight, far)
    elif not is_plain:
        line = _line_of_tail(z, force, at, straight, far)
        # a smooth depth beyond 1 / 0.8 of the largest recovery of the force is the tilt of the line, or of a wave
        is_tilt = 0.8 * (line.force(at) - force[lowest]) > far.recovery
        significance = np.inf if is_tilt else significance
        line = _between(line, at, _free_levels(force, lowest)[0])
    if step is not None:
        line = line._replace(centre=at, level=step.level)
    depth = float(line.force(at) - force[lowest])
    end = _detachment_sample(force, lowest, far.noise) if step is None else step.first
    return Pull(lowest, depth, line, line.error(at), significance, end, step)


def _between(line: Baseline, at: float, level: float) -> Baseline:
    """Return a baseline half-way to another reading of its level at a travel."""
    half = (level - line.force(at)) / 2
    return line._replace(level=line.level + half, spread=abs(half))


def _line_of_tail(z: np.ndarray, force: np.ndarray, at: float, straight: Baseline, far: _FarPart) -> Baseline:
    """Return the baseline at a travel before which no jump ends the tension: it ends in a tail, or in a wave."""
    free = slice(far.after_losses, None)
    wavy = least_error_line(z[free], force[free], far.noise, at)
    # a line describes interference if its stretch is this many times as long as the longest straight one
    is_wave = wavy.end - z[-1] > 1.5 * (straight.longest - z[-1])
    if not is_wave or straight.error(at) < wavy.error(at):
        return straight
    error = np.hypot(wavy.error(at), (straight.force(at) - wavy.force(at)) / 2)  # of a tail, or of a wave
    return wavy._replace(level_error=error)


def _lowest_sample(force: np.ndarray) -> tuple[int, float]:
    """Return the sample from which the force recovers most, whatever the baseline, and by how much."""
    # number of bins in which the largest recovery of the force is sought
    width = max(1, force.size // 400)
    level = bin_means(force, width)
    recovery = np.maximum.accumulate(level[::-1])[::-1] - level
    near = int(np.argmax(recovery)) * width
    lowest = max(near - width, 0) + int(np.argmin(force[max(near - width, 0) : near + 2 * width]))
    return lowest, recovery.max()


def _first_free_sample(force: np.ndarray, lowest: int, far: _FarPart) -> int:
    """Return the first sample after the jump; the size without a jump.

    The jump follows the lowest force at once on a soft cantilever, later on a stiff one.
    """
    first = _detachment_sample(force, lowest, far.noise)
    if first > lowest + _LONGEST_JUMP:
        later = [rupture for rupture in far.losses if rupture.end > lowest]
        first = max(later, key=lambda rupture: rupture.height).end if later else force.size
    return first


def _span(count: int) -> int:
    """Return the number of samples whose median is the level after a jump, of ``count`` free ones."""
    return max(count // 50, 5)


def _has_jumped(z: np.ndarray, force: np.ndarray, lowest: int, first: int) -> bool:
    """Return whether one jump ends most of the tension."""
    span = _span(force.size - first)
    if force.size - first < 4 * span:
        return False
    tilt, offset = line_through(z[first:], force[first:])
    flat = force[first:] - offset - tilt * z[first:]
    jump = median(force[first : first + span]) - force[lowest]
    later = float(bin_means(flat, span).max()) - median(flat[:span])
    # a jump is complete if it is this share of the depth of the lowest sample
    return jump >= 0.5 * (jump + later)


def _line_after_jump(
    z: np.ndarray, force: np.ndarray, lowest: int, first: int, straight: Baseline, far: _FarPart
) -> Baseline:
    """Return the baseline at the lowest sample by the force after the jump.

    A later loss of tension shows that the jump was not the last: then either the samples after it are extrapolated,
    or its height is added, with half of it as the error. The interference about a straight line is an error, too.
    Where a long stretch is straight within the noise, the curve may have a tail, and the middle is taken.
    """
    at = z[lowest]
    tilt, offset = line_through(z[first:] - at, force[first:])
    flat = force - offset - tilt * (z - at)
    later = [rupture for rupture in far.losses if rupture.end > first + _RUPTURE_SAMPLES]
    free = _free_level(flat, lowest, first, later, straight.force(at) - offset, far.noise)
    if not free.error < np.inf:
        return straight
    if free.beyond > first and straight.error(at) < free.error:
        # a kink of interference looks like a slow step: the middle is taken
        unsure = 0.0 if later else free.tension / 2
        error = np.hypot(straight.level_error, unsure)
        return straight._replace(level=straight.level - unsure, level_error=error)
    level = free.level
    doubt = max(abs(level) / 2 if free.beyond == first else 0.0, float(flat[free.beyond :].std()))
    half_tail = _half_tail(straight, z[-1], at, straight.force(at) - offset - level, free.error)
    level += half_tail
    error = np.hypot(free.error, doubt)
    length = z[first] - z[-1]
    interference = np.sqrt(6) * flat[first:].std()  # of two periods or so
    tilt_error = np.hypot(far.noise * np.sqrt(12 / flat[first:].size), interference) / length
    noise = max(far.noise, straight.noise)
    return Baseline(
        at, offset + level, tilt, error, tilt_error, z[free.beyond], straight.longest, noise, abs(half_tail)
    )


def _half_tail(straight: Baseline, far_end: float, at: float, tail: float, error: float) -> float:
    """Return half of the difference between two levels, 0 where it is no tail of a weak tension."""
    # a stretch this long, as a share of the free part, may end in the tail of a weak tension that no jump ends
    is_long = straight.longest - far_end > 0.4 * (at - far_end)
    return tail / 2 if is_long and abs(tail) > 2 * np.hypot(straight.error(at), error) else 0.0


class _FreeLevel(NamedTuple):
    """The force of the free cantilever at the lowest sample, less a straight line; nN."""

    level: float
    error: float
    tension: float  # left after the jump, if the straight baseline is right
    beyond: int  # first sample after all losses of tension


def _free_level(
    flat: np.ndarray, lowest: int, first: int, later: list[_Rupture], straight_level: float, noise: float
) -> _FreeLevel:
    """Return the level by the samples after the jump, or by those after later losses of tension."""
    level, error = extrapolated_level(flat[first:], first - lowest, noise)
    tension = straight_level - level
    count, height = last_step(flat[first:], noise)
    beyond = max([first + count, *(rupture.end + 1 for rupture in later)])
    tension_after = max(height, sum(rupture.height for rupture in later))
    levels = [(np.hypot(error, tension_after / 2), level + tension_after)]
    if beyond > first:
        level, error = extrapolated_level(flat[beyond:], beyond - lowest, noise)
        levels.append((error, level))
    error, level = min(levels)
    return _FreeLevel(level, error, tension, beyond)


class _Rupture(NamedTuple):
    """A sudden loss of tension."""

    end: int  # first sample after it
    height: float  # nN


def _ruptures(force: np.ndarray, noise: float) -> list[_Rupture]:
    """Return the sudden rises of the force on retraction."""
    n = _RUPTURE_SAMPLES
    sums = np.cumsum(np.append(0.0, force))
    means = (sums[n:] - sums[:-n]) / n
    rise = means[n + 1 :] - means[: -n - 1]  # over one sample, which may be from within the rupture
    significant = rise > _RUPTURE_SIGNIFICANCE * (noise * np.sqrt(2 / n))
    if not significant.any():
        return []
    spread = median(np.abs(rise - median(rise))) / 0.6745  # larger than white noise gives if correlated
    distance = 2 * n + 1
    neighbour = np.zeros(rise.size)
    neighbour[:-distance] = rise[distance:]
    neighbour[distance:] = np.maximum(neighbour[distance:], rise[:-distance])
    sudden = significant & (rise > _RUPTURE_SIGNIFICANCE * spread) & (neighbour < _STEADY * rise)
    edges = np.flatnonzero(np.diff(sudden, prepend=False, append=False))
    return [_Rupture(int(end) + n, float(rise[start:end].max())) for start, end in zip(edges[::2], edges[1::2])]


def _unusable(z: np.ndarray, share: _Stretch) -> str:
    """Return why a retraction with this travel cannot be used, else empty."""
    if z.size < _LEAST_SAMPLES:
        return _SHORT
    if z[0] <= z[-1]:
        return _NO_RETRACTION
    return _SHORT_BASELINE if _in_stretch(z, share).sum() < _LEAST_BASELINE else ""


def _last_repulsive(flat: np.ndarray, end: int, noise: float) -> int | None:
    """Return the last repulsive sample before the largest tension, None if none exceeds the noise."""
    if flat[:end].max(initial=0.0) <= _SIGNIFICANCE * noise:
        return None
    if end < flat.size:
        return int(np.flatnonzero(flat[:end] > 0)[-1])
    return int(np.argmax(flat <= 0)) - 1 if flat[0] > 0 else None


def _contact(z: np.ndarray, flat: np.ndarray, zero: int, line: Baseline) -> dict[str, Any]:
    """Return the contact point, the slope in the upper half of the contact, and the baseline at the contact point."""
    drop = flat[zero] - flat[zero + 1]
    point = float(z[zero] + (z[zero + 1] - z[zero]) * (flat[zero] / drop if drop > 0 else 0.0))
    upper = np.flatnonzero(flat[: zero + 1] > 0.5 * flat[: zero + 1].max())
    enough = upper.size >= _LEAST_PRESSED and np.ptp(z[upper]) > 0
    slope = line_through(z[upper], flat[upper])[0] if enough else np.nan
    return {"contact_point": point, "contact_slope": slope, "baseline_offset": float(line.force(point))}


def _is_saturated(force: np.ndarray, at: int, far: np.ndarray) -> bool:
    """Return whether the detector is saturated: the lowest force is one value over many samples."""
    equal = _longest_run(force[max(at - 200, 0) : at + 200] == force.min())
    # saturated detector: this many samples have the lowest force, and the baseline has fewer than half as many equal
    # ones
    return equal >= 8 and equal >= 2 * (1 + _longest_run(np.diff(force[far]) == 0))


def _longest_run(true: np.ndarray) -> int:
    """Return the length of the longest run of true values."""
    return max((len(list(run)) for value, run in groupby(true) if value), default=0)


class _Minimum(NamedTuple):
    """The lowest point of a parabola through samples; nN."""

    force: float
    error: float
    reach: tuple[int, int]  # range of the samples whose force is nearly as low


def _minimum(
    time: np.ndarray, force: np.ndarray, at: int, end: int, noise: float, spread: float
) -> tuple[float, float]:
    """Return the lowest force before ``end`` and its standard error, by a parabola through the samples around it.

    Select samples by the parabola, not by their own noise: dropping those lifted by noise would bias the result.
    ``time`` is the recorded number of each sample, which has gaps where samples are missing, and no noise.
    """
    ends = max(at - _HALF_WIDTH, 0), min(at + _HALF_WIDTH, end)
    first, last = _range_around(np.abs(force[:end] - force[at]) > spread * noise, at)
    steep = end == force.size and last - first < _LEAST_LOW
    best = _Minimum(np.nan, np.inf, (0, 0))
    used = slice(0)
    for _ in range(_ROUNDS):
        first, last = max(first, ends[0]), min(last, ends[1])
        first = max(min(first, last - _LEAST_LOW), 0)
        if used == slice(first, last):  # and so are all further parabolas
            break
        used = slice(first, last)
        if steep or last - first < _LEAST_LOW:
            steps = np.abs(np.diff(force[max(at - 1, 0) : min(at + 2, end)]))
            return float(force[at]), np.hypot(noise, steps.max(initial=0.0) / np.sqrt(12))
        is_detached = ends[1] == end < force.size
        low = _parabola(time, force, used, (min(first, ends[0]), ends[1]), noise, detached=is_detached)
        best = low if low.error < best.error else best
        first, last = low.reach
    return best.force, best.error


def _range_around(away: np.ndarray, at: int) -> tuple[int, int]:
    """Return the range of samples around one between those that are away from it."""
    before = np.flatnonzero(away[:at])
    after = np.flatnonzero(away[at + 1 :])
    return (int(before[-1]) + 1 if before.size else 0), (at + 1 + int(after[0]) if after.size else away.size)


def _detachment_sample(force: np.ndarray, at: int, noise: float) -> int:
    """Return the first sample after the detachment, which is one much larger step."""
    gone = np.flatnonzero(force[at:] - force[at] > _DETACHED * noise)
    if not gone.size:
        return force.size
    end = at + int(gone[0])
    before = np.abs(np.diff(force[max(2 * at - end - _LEAST_LOW, 0) : at + 1])).max(initial=0.0)
    return end if np.diff(force[at : end + 1]).max() > 2 * before else force.size


def _parabola(
    time: np.ndarray, force: np.ndarray, used: slice, ends: tuple[int, int], noise: float, *, detached: bool
) -> _Minimum:
    """Return the lowest point, between the ends, of a parabola through the used samples."""
    powers = np.arange(3)
    centre = (time[used.start] + time[used.stop - 1]) / 2
    x = (time - centre) / (time[used.stop - 1] - centre)  # from -1 to 1
    design = x[used, None] ** powers
    covariance = np.linalg.inv(design.T @ design)
    coefficients = covariance @ (force[used] @ design)
    height = x[slice(*ends), None] ** powers @ coefficients
    used_height = design @ coefficients
    lowest = used.start + int(np.argmin(used_height))
    vertex = x[lowest]
    if coefficients[2] > 0:
        vertex = np.clip(-coefficients[1] / (2 * coefficients[2]), -1.0, 1.0)
    row = vertex**powers
    low = row @ coefficients
    first, last = _range_around(height - low > _PARABOLA_SPREAD * noise, lowest - ends[0])
    if detached:
        sharp = 0.0
        beyond = x[ends[1]] ** powers
        unseen = max(float((row - beyond) @ coefficients), 0.0)
        row = (row + beyond) / 2 if unseen else row
        shape_error = unseen / np.sqrt(12)
    else:
        # a sharp minimum between two lines is lower than the parabola by 0.2 of the rise to its ends; a round minimum
        # is not. Half of this, with an error of the whole, since one side may be steeper.
        sharp = 0.1 * max(float(used_height[0] + used_height[-1]) / 2 - low, 0.0)
        shape_error = 2 * sharp
    error = np.hypot(noise * np.sqrt(row @ covariance @ row), shape_error)
    return _Minimum(float(row @ coefficients) - sharp, error, (ends[0] + first, ends[0] + last))
