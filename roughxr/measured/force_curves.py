"""The pull-off force of each retraction in force-distance curves, and its uncertainty due to noise and baseline."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.text import warn
from ..vocabulary.units import Quantity, converted, positive, single
from .baselines import Baseline, fitted_baseline

#: Smallest numbers of samples: of a retraction, of its baseline, and of the part in contact.
_LEAST_SAMPLES, _LEAST_BASELINE, _LEAST_PRESSED = 50, 10, 5

#: A pull-off is significant if the force is this many standard deviations of the noise below the baseline.
_SIGNIFICANCE = 5.0

#: Largest effect of the choice of the baseline on the pull-off force, relative.
_LARGEST_CHOICE = 0.4

#: Parabola through the lowest force: most samples on either side, fewest in all; largest height above the lowest
#: sample, then above the vertex, in standard deviations; number of iterations.
_HALF_WIDTH, _LEAST_LOW, _SAMPLE_SPREAD, _PARABOLA_SPREAD, _ROUNDS = 41, 8, 4.0, 2.5, 6

#: A sharp minimum between two lines is lower than the parabola by 0.2 of the rise to its ends; a round minimum is not.
#: Subtract half of this, with an equal error.
_SHARP = 0.1

#: Saturated detector: this many samples have the lowest force, and the baseline has fewer than half as many equal ones.
_SATURATED_RUN = 8

#: Factor that allows for errors: in contact the force cannot rise faster than the cantilever's spring constant.
_LARGEST_SLOPE = 1.1


#: A rupture: samples before and after it, and its height in standard deviations of their difference; a steady change
#: of the force is at most this part as high on either side.
_RUPTURE_SAMPLES, _RUPTURE_SIGNIFICANCE, _STEADY = 4, 6.0, 0.5


class ImplausibleCurves(UserWarning):
    """Force-distance curves were read as their file states, but no surface could give such curves."""


class _Retraction(NamedTuple):
    """The results of one retraction, by their names in a Dataset."""

    pull_off_force: float = np.nan
    pull_off_uncertainty: float = np.nan
    pull_off_distance: float = np.nan
    work_of_separation: float = np.nan
    largest_rupture: float = np.nan
    ruptures: float = np.nan
    force_noise: float = np.nan
    contact_point: float = np.nan
    contact_slope: float = np.nan
    baseline_offset: float = np.nan
    baseline_tilt: float = np.nan
    reason: str = ""


def curves_pull_off(ds: xr.Dataset, *, spring_constant: Quantity | None = None, baseline: float = 1.0) -> xr.Dataset:
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
    baseline : float
        Share of the travel, farthest from the surface, that may contain the baseline: the longest stretch from the far
        end that a line fits within the noise.

    Returns
    -------
    Dataset
        Along ``subregion``: ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_uncertainty``, its standard
        error due to noise, baseline and the choice of its stretch; ``pull_off_distance`` (nm), from zero force to the
        largest tension, less the bending of the cantilever if its spring constant is known; ``work_of_separation``
        (nN nm), done by the piezo against the adhesion force; ``largest_rupture`` (nN) and ``ruptures``, the largest
        sudden loss of tension and their number, which need no baseline; ``force_noise`` (nN); ``contact_point`` (nm),
        the piezo's travel at zero force; ``contact_slope`` (nN/nm), in the upper half of the contact;
        ``baseline_offset`` (nN) at the contact point and ``baseline_tilt`` (nN/nm), of the line to subtract from the
        recorded force; ``reason``, why a curve has no pull-off, which is then NaN.

    Warns
    -----
    ImplausibleCurves
        If the median slope in contact is more than 1.1 times the spring constant: the sensitivity is then too large.

    Notes
    -----
    The uncertainty does not include that of the parabola through the samples before the jump, about 0.1 % for a sphere
    on a soft lever.

    Examples
    --------
    >>> piezo = np.linspace(20.0, -80.0, 400)
    >>> force = np.where(piezo > -10.0, 2.0 * piezo, 0.0) + 0.01 * piezo + 3.0
    >>> force += np.random.default_rng(0).normal(0.0, 0.1, 400)
    >>> curve = xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})})
    >>> pull = curves_pull_off(curve)
    >>> bool(abs(pull.pull_off_force[0] - 20) < 0.6), round(float(pull.contact_slope[0]), 1)
    (True, 2.0)
    """
    ds = schema.entered(ds)
    single(baseline, "1", "baseline", "a share of the travel", lambda share: 0 < share <= 1)
    recorded, stiffness = recorded_curves(ds, spring_constant)
    retraction = recorded.sel(branch="retraction") if "branch" in recorded.dims else recorded
    pulls = [
        evaluated_retraction(z, f, stiffness, baseline)
        for z, f in zip(retraction["piezo"].values, retraction["force"].values)
    ]
    out = xr.Dataset({name: ("subregion", list(values)) for name, values in zip(_Retraction._fields, zip(*pulls))})
    places = {name: ds[name] for name in ("subregion", "subregion_x", "subregion_y") if name in ds.coords}
    out = out.assign_coords({"subregion": np.arange(len(pulls)), **places} if "subregion" in ds.dims else {})
    _warn_of_slope(out["contact_slope"].values, stiffness)
    out.attrs = {"measured": "force-distance curves", "baseline": baseline, "missing": "NaN where reason says why"}
    out.attrs |= {} if np.isinf(stiffness) else {"spring_constant": stiffness}
    return schema.record(schema.label(out), "curves_pull_off", ds, spring_constant=spring_constant, baseline=baseline)


def _warn_of_slope(slopes: np.ndarray, stiffness: float) -> None:
    """Warn if forces rise faster in contact than the cantilever can bend."""
    times = float(np.median(slopes[np.isfinite(slopes)])) / stiffness if np.isfinite(slopes).any() else 0.0
    if times > _LARGEST_SLOPE:
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
            raise ValueError(f"{axis}: expected it along 'sample' or ('subregion', 'sample'), found {shape}")
    stiffness = _stiffness(ds, spring_constant)
    if name == "deflection" and np.isinf(stiffness):
        raise ValueError("spring_constant: expected it in N/m to make forces of deflections, found none")
    force = converted(ds["force"], "nN", "force") if name == "force" else converted(ds[name], "nm", name) * stiffness
    pair = xr.broadcast(converted(ds["piezo"], "nm", "piezo"), force)
    both = [axis if "subregion" in axis.dims else axis.expand_dims("subregion") for axis in pair]
    out = xr.Dataset(dict(zip(("piezo", "force"), both))).transpose("subregion", ..., "sample")
    if "branch" in out.dims and "retraction" not in out.get_index("branch"):
        raise ValueError(f"branch: expected 'retraction' among them, found {out['branch'].values.tolist()}")
    return out.astype(float), stiffness


def _stiffness(ds: xr.Dataset, given: Any) -> float:
    """Return the spring constant (nN/nm) that is stated or given, inf without any."""
    stated = ds.attrs.get("spring_constant", np.inf)
    if given is None:
        return float(stated)
    stiffness = positive(given, "nN/nm", "spring_constant")
    if np.isfinite(stated) and not np.isclose(stiffness, stated, rtol=1e-6, atol=0):
        raise ValueError(f"spring_constant: the curves state {stated:.6g} N/m, found {stiffness:.6g}; leave it out")
    return stiffness


def evaluated_retraction(z: np.ndarray, force: np.ndarray, stiffness: float, share: float) -> _Retraction:
    """Return the results of one retraction."""
    known = np.isfinite(z) & np.isfinite(force)
    z, force = z[known], force[known]
    reason = _unusable(z, share)
    if reason:
        return _Retraction(reason=reason)
    largest, number = _ruptures(force)
    line = fitted_baseline(z, force, share)
    flat, far = force - line.force(z), z <= line.end
    at = int(np.argmin(flat))
    pull = _Retraction(
        largest_rupture=largest, ruptures=number, force_noise=line.noise, baseline_tilt=float(line.coefficients[1])
    )
    pulled = -flat[at] >= _SIGNIFICANCE * np.hypot(line.noise, line.error(z[at]))
    zero = _last_repulsive(flat, at if pulled else flat.size, line.noise)
    if zero is not None:
        pull = pull._replace(**_contact(z, flat, zero, line))
    if not pulled or zero is None:
        return pull._replace(reason="never pressed" if pulled else "no pull exceeds the noise")
    if pull.contact_slope <= 0:
        return pull._replace(reason="the force does not rise in contact")
    if far[at] or line.choice_error(z[at]) > _LARGEST_CHOICE * -flat[at]:
        return pull._replace(reason="the pull reaches into the baseline")
    if _is_saturated(force, at, far):
        return pull._replace(reason="the detector's range ends before the largest pull")
    travel = float(z[zero] - z[at] + (flat[at] - flat[zero]) / stiffness)
    work = float(np.trapezoid(flat[zero:], z[zero:]))
    if work < -_SIGNIFICANCE * line.work_error(z[zero:]):
        return pull._replace(reason="the baseline is curved by more than the pull of the surface")
    lowest, own = _minimum(z, flat, at, line.noise)
    uncertainty = float(np.linalg.norm([own, line.error(z[at]), line.choice_error(z[at])]))
    return pull._replace(
        pull_off_force=-lowest, pull_off_uncertainty=uncertainty, pull_off_distance=travel, work_of_separation=work
    )


def _ruptures(force: np.ndarray) -> tuple[float, int]:
    """Return the largest sudden rise of the force on retraction, NaN without any, and the number of rises."""
    n = _RUPTURE_SAMPLES
    noise = float(np.median(np.abs(np.diff(force, 2)))) / 0.6745 / np.sqrt(6)
    sums = np.r_[0.0, np.cumsum(force)]
    means = (sums[n:] - sums[:-n]) / n
    rise = means[n + 1 :] - means[: -n - 1]  # over one sample, which may be from within the rupture
    padding = np.zeros(2 * n + 1)
    neighbour = np.maximum(np.r_[rise[2 * n + 1 :], padding], np.r_[padding, rise[: -2 * n - 1]])
    spread = float(np.median(np.abs(rise - np.median(rise)))) / 0.6745  # larger than white noise gives if correlated
    significant = rise > _RUPTURE_SIGNIFICANCE * max(noise * np.sqrt(2 / n), spread)
    sudden = significant & (neighbour < np.maximum(_STEADY * rise, 3 * noise))
    starts = np.flatnonzero(np.diff(np.r_[0, sudden]) == 1)
    return (float(rise[sudden].max()) if starts.size else np.nan), int(starts.size)


def _unusable(z: np.ndarray, share: float) -> str:
    """Return why a retraction with this travel cannot be used, else empty."""
    if z.size < _LEAST_SAMPLES:
        return f"fewer than {_LEAST_SAMPLES} samples"
    if z[0] <= z[-1]:
        return "the piezo does not retract from the first sample to the last"
    in_baseline = int((z < z.min() + share * np.ptp(z)).sum())
    return f"fewer than {_LEAST_BASELINE} samples in the baseline" if in_baseline < _LEAST_BASELINE else ""


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
    slope = float(np.polyfit(z[upper] - z[upper[0]], flat[upper], 1)[0]) if enough else np.nan
    return {"contact_point": point, "contact_slope": slope, "baseline_offset": float(line.force(point))}


def _is_saturated(force: np.ndarray, at: int, far: np.ndarray) -> bool:
    """Return whether the detector is saturated: the lowest force is one value over many samples."""
    equal = _longest_run(force[max(at - 200, 0) : at + 200] == force.min())
    return equal >= max(_SATURATED_RUN, 2 * (1 + _longest_run(np.diff(force[far]) == 0)))


def _longest_run(true: np.ndarray) -> int:
    """Return the length of the longest run of true values."""
    ends = np.flatnonzero(np.diff(np.concatenate(([0], true.astype(int), [0]))))
    return int((ends[1::2] - ends[::2]).max(initial=0))


class _Minimum(NamedTuple):
    """The lowest point of a parabola through samples; nN."""

    force: float
    error: float
    reach: tuple[int, int]  # range of the samples whose force is nearly as low


def _minimum(z: np.ndarray, force: np.ndarray, at: int, noise: float) -> tuple[float, float]:
    """Return the lowest force and its standard error, by a parabola through the samples around it.

    Select samples by the parabola, not by their own noise: dropping those lifted by noise would bias the result.
    """
    end = _detachment_sample(force, at, noise)
    ends = max(at - _HALF_WIDTH, 0), min(at + _HALF_WIDTH, end)
    first, last = _samples_near(force[:end], at, noise)
    steep = end == force.size and last - first < _LEAST_LOW
    for _ in range(_ROUNDS):
        first, last = max(first, ends[0]), min(last, ends[1])
        first = max(min(first, last - _LEAST_LOW), 0)
        if steep or last - first < _LEAST_LOW:
            step = abs(force[at] - force[at - 1])
            return float(force[at]), float(np.hypot(noise, step / np.sqrt(12)))
        low = _parabola(z, force, slice(first, last), (min(first, ends[0]), ends[1]), noise, detached=ends[1] == end)
        first, last = low.reach
    return low.force, low.error


def _samples_near(force: np.ndarray, at: int, noise: float) -> tuple[int, int]:
    """Return the range of samples around the lowest that equal it within the noise."""
    away = np.abs(force - force[at]) > _SAMPLE_SPREAD * noise
    before, after = np.flatnonzero(away[:at]), np.flatnonzero(away[at:])
    return (int(before[-1]) + 1 if before.size else 0), (at + int(after[0]) if after.size else force.size)


def _detachment_sample(force: np.ndarray, at: int, noise: float) -> int:
    """Return the first sample after the detachment, which is one much larger step."""
    gone = np.flatnonzero(force[at:] - force[at] > 2 * _SAMPLE_SPREAD * noise)
    if not gone.size:
        return force.size
    end = at + int(gone[0])
    before = np.abs(np.diff(force[max(2 * at - end - _LEAST_LOW, 0) : at + 1])).max(initial=0.0)
    return end if np.diff(force[at : end + 1]).max() > 2 * before else force.size


def _parabola(
    z: np.ndarray, force: np.ndarray, used: slice, ends: tuple[int, int], noise: float, *, detached: bool
) -> _Minimum:
    """Return the lowest point, between the ends, of a parabola through the used samples."""
    scale = float(np.abs(z[used] - z[used].mean()).max())
    x = (z[slice(*ends)] - z[used].mean()) / scale
    design = np.c_[np.ones(x.size), x, x**2]
    own = slice(used.start - ends[0], used.stop - ends[0])
    coefficients, *_ = np.linalg.lstsq(design[own], force[used], rcond=None)
    lowest = own.start + int(np.argmin(design[own] @ coefficients))
    where = (
        np.clip(-coefficients[1] / (2 * coefficients[2]), x[own].min(), x[own].max())
        if coefficients[2] > 0
        else x[lowest]
    )
    high = np.flatnonzero(design @ coefficients - _parabola_terms(where) @ coefficients > _PARABOLA_SPREAD * noise)
    before, after = high[high < lowest], high[high > lowest]
    reach = (int(before[-1]) + 1 if before.size else 0), (int(after[0]) if after.size else x.size)
    row, unseen = _parabola_terms(where), 0.0
    if detached:
        beyond = _parabola_terms(2 * x[-1] - x[-2])
        unseen = max(float((row - beyond) @ coefficients), 0.0)
        row = (row + beyond) / 2 if unseen else row
    error = noise * np.sqrt(row @ np.linalg.inv(design[own].T @ design[own]) @ row)
    rise = float(np.median((design[own] @ coefficients)[[0, -1]]) - _parabola_terms(where) @ coefficients)
    sharp = 0.0 if detached else _SHARP * max(rise, 0.0)
    return _Minimum(
        float(row @ coefficients) - sharp,
        float(np.linalg.norm([error, sharp, unseen / np.sqrt(12)])),
        (ends[0] + reach[0], ends[0] + reach[1]),
    )


def _parabola_terms(x: float) -> np.ndarray:
    return np.array([1.0, x, x**2])
