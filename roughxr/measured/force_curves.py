"""Force-distance curves: the pull-off force of each retraction, with what noise and baseline leave uncertain.

Far from the surface only the instrument speaks: offset, drift, tilt and virtual deflection, a straight line in the
piezo's travel. It is fitted there and taken off everywhere.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import schema
from ..units import converted, fraction, positive

#: Samples of a retraction at least, and of its baseline.
_FEWEST, _FAR = 50, 10

#: A pull is one if it stands so many standard deviations of the noise below the baseline.
_STANDS_OUT = 5.0

#: Samples at most that tell the largest pull; within so many standard deviations of the lowest one.
_BOTTOM, _WITHIN = 41, 4.0


class _Pull(NamedTuple):
    """What one retraction tells; nN, nm."""

    force: float = np.nan
    uncertainty: float = np.nan
    distance: float = np.nan
    work: float = np.nan
    noise: float = np.nan
    reason: str = ""


def curves_pull_off(ds: xr.Dataset, *, spring_constant: Any = None, baseline: float = 0.3) -> xr.Dataset:
    """Return the pull-off of force-distance curves.

    Parameters
    ----------
    ds : Dataset
        ``piezo`` (units of a length, growing towards the surface, from any zero) and either ``force`` (units of a
        force, > 0 pushes) or ``deflection`` (units of a length, > 0 pushes), along ``sample`` or (subregion, sample):
        retractions, the first sample the most pressed. Coordinates of places come along.
    spring_constant : number or quantity, optional
        N/m; of deflections it must be given. Of forces it tells how far the cantilever gives way.
    baseline : float
        The part of the travel, the farthest, in which nothing but the instrument acts.

    Returns
    -------
    Dataset
        Along ``subregion``: ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_uncertainty``, its standard
        error by noise and baseline (not by the spring constant); ``pull_off_distance`` (nm), from where the force is
        zero to the largest pull, the cantilever's give taken off where its spring constant is known;
        ``work_of_separation`` (nN nm), done by the piezo against the pull; ``force_noise`` (nN); ``reason``, why a
        curve has no pull-off, which then is NaN.

    Raises
    ------
    ValueError
        If variables, dimensions or units are missing, or deflections have no spring constant.

    Notes
    -----
    A baseline that bends is not a straight line continued: what it is off at the pull-off is not in the uncertainty.

    Examples
    --------
    >>> piezo = np.linspace(20.0, -80.0, 400)
    >>> force = np.where(piezo > -10.0, 2.0 * piezo, 0.0) + 0.01 * piezo + 3.0
    >>> force += np.random.default_rng(0).normal(0.0, 0.1, 400)
    >>> curve = xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})})
    >>> found = curves_pull_off(curve)
    >>> bool(abs(found.pull_off_force[0] - 20) < 0.6), bool(found.pull_off_uncertainty[0] < 0.3)
    (True, True)
    """
    fraction(baseline, "baseline")
    piezo, force, stiffness = _read(ds, spring_constant)
    found = [_pull(z, f, stiffness, baseline) for z, f in zip(piezo, force)]
    names = (
        "pull_off_force",
        "pull_off_uncertainty",
        "pull_off_distance",
        "work_of_separation",
        "force_noise",
        "reason",
    )
    out = xr.Dataset({name: ("subregion", list(values)) for name, values in zip(names, zip(*found))})
    kept = {name: ds[name] for name in ("subregion", "subregion_x", "subregion_y") if name in ds.coords}
    out = out.assign_coords({"subregion": np.arange(len(found)), **kept} if "subregion" in ds.dims else {})
    out.attrs = {"measured": "force-distance curves", "baseline": baseline, "missing": "NaN where reason says why"}
    out.attrs |= {} if np.isinf(stiffness) else {"spring_constant": stiffness}
    return schema.record(schema.label(out), "curves_pull_off", ds, spring_constant=spring_constant, baseline=baseline)


def _read(ds: xr.Dataset, spring_constant: Any) -> tuple[np.ndarray, np.ndarray, float]:
    """Return travel and force along (subregion, sample), and the stiffness, inf where it is not known."""
    name = "force" if "force" in ds else "deflection"
    for one in ("piezo", name):
        if one not in ds or "sample" not in ds[one].dims or not set(ds[one].dims) <= {"subregion", "sample"}:
            found = (
                f"dimensions {tuple(ds[one].dims)}" if one in ds else f"variables {', '.join(map(str, ds.data_vars))}"
            )
            raise ValueError(f"{one}: expected it along 'sample' or ('subregion', 'sample'), found {found}")
    stiffness = np.inf if spring_constant is None else positive(spring_constant, "nN/nm", "spring_constant")
    if name == "deflection" and np.isinf(stiffness):
        raise ValueError("spring_constant: expected it in N/m to make forces of deflections, found none")
    force = converted(ds["force"], "nN", "force") if name == "force" else converted(ds[name], "nm", name) * stiffness
    both = xr.broadcast(converted(ds["piezo"], "nm", "piezo"), force)
    both = [one if "subregion" in one.dims else one.expand_dims("subregion") for one in both]
    piezo, force = (one.transpose("subregion", "sample").values.astype(float) for one in both)
    return piezo, force, stiffness


def _pull(z: np.ndarray, force: np.ndarray, stiffness: float, share: float) -> _Pull:
    """Return the pull-off of one retraction."""
    known = np.isfinite(z) & np.isfinite(force)
    z, force = z[known], force[known]
    if z.size < _FEWEST:
        return _Pull(reason=f"fewer than {_FEWEST} samples")
    if z[0] <= z[-1]:
        return _Pull(reason="the piezo does not retract from the first sample to the last")
    far = z < z.min() + share * np.ptp(z)
    if far.sum() < _FAR:
        return _Pull(reason=f"fewer than {_FAR} samples in the baseline")
    design = np.c_[np.ones(z.size), z - z[far].mean()]
    line, noise, covariance = _fitted(design[far], force[far])
    force = force - design @ line
    at = int(np.argmin(force))
    beside = float(np.sqrt(design[at] @ covariance @ design[at]))
    if -force[at] < _STANDS_OUT * np.hypot(noise, beside):
        return _Pull(noise=noise, reason="no pull stands out of the noise")
    if far[at] or not (force[:at] > 0).any():
        return _Pull(noise=noise, reason="the pull reaches into the baseline" if far[at] else "never pressed")
    lowest, own = _bottom(z, force, at, noise)
    zero = int(np.flatnonzero(force[:at] > 0)[-1])
    travel = float(z[zero] - z[at] + (force[at] - force[zero]) / stiffness)
    work = float(np.trapezoid(force[zero:], z[zero:]))
    return _Pull(-lowest, float(np.hypot(own, beside)), travel, work, noise)


def _fitted(design: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Return coefficients, standard deviation of the residual, and the coefficients' covariance."""
    found, *_ = np.linalg.lstsq(design, values, rcond=None)
    noise = float(np.sqrt(((values - design @ found) ** 2).sum() / (values.size - design.shape[1])))
    return found, noise, noise**2 * np.linalg.inv(design.T @ design)


def _bottom(z: np.ndarray, force: np.ndarray, at: int, noise: float) -> tuple[float, float]:
    """Return the least force and its standard error: of a parabola through the samples about the lowest one."""
    near = np.abs(force - force[at]) <= _WITHIN * noise
    first = at - int(np.argmin(near[: at + 1][::-1])) + 1 if not near[: at + 1].all() else 0
    last = at + (int(np.argmin(near[at:])) if not near[at:].all() else z.size - at)
    first, last = max(first, at - _BOTTOM), min(last, at + _BOTTOM)
    if last - first < 6:
        step = abs(force[at] - force[at - 1])  # it may have let go anywhere until the next sample
        return float(force[at]), float(np.hypot(noise, step / np.sqrt(12)))
    x = z[first:last] - z[at]
    x = x / np.abs(x).max()
    design = np.c_[np.ones(x.size), x, x**2]
    found, *_ = np.linalg.lstsq(design, force[first:last], rcond=None)
    where = np.clip(-found[1] / (2 * found[2]), x.min(), x.max()) if found[2] > 0 else x[np.argmin(design @ found)]
    row = np.array([1.0, where, where**2])
    inverse = np.linalg.inv(design.T @ design)
    return float(row @ found), float(noise * np.sqrt(row @ inverse @ row))
