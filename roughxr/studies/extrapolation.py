"""`extrapolated`: the pull-off of the real surface, from that as scanned and the effect of finer roughness.

The real pull-off is the mean as scanned, over all places, times a factor. With one scan, unseen roughness lowers the
pull-off by a part of what the roughness seen lowers it: with u = ln(smooth flat / as scanned), ln(factor) = −a h u. The
effect of an octave falls with its wavelength: h = 1 − shortest / longest unseen wavelength. The constants are those of
measured surfaces, of which coarse images were solved (``tests/benchmarks/real_below_the_pixel.py``). With a second,
finer scan, the factor is the ratio of two pull-offs of it: as it is, and as the first scan would show it. Measured
pull-offs of another pair or radius give the factor as their ratio to the simulation. Several estimates of the factor
are combined, each weighted by the inverse of its variance. Particles at rest take the ratio of the second scan alone
(``tests/benchmarks/particles_below_the_pixel.py``).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..contact.adhesion import adhesive
from ..contact.adhesive_options import read_preloads
from ..contact.mesh import Mesh, read_mesh
from ..contact.regimes import need_sphere
from ..scans import level, regions
from ..scans.editing import on_square_pixels
from ..specimen import Specimen
from ..statistics.headline import HALF_WIDTH, mean_pull_off, mesh_error
from ..statistics.sampling import SHARE, at_first_preload
from ..vocabulary import schema
from ..vocabulary.error_sources import (
    MESH,
    PLACES,
    SAMPLING,
    SECOND_SCAN_PART,
    SECOND_SCAN_PIXELS,
    SECOND_SCAN_WIDTH,
    UNSEEN,
)
from ..vocabulary.numbers import number
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import without_warnings
from ..vocabulary.units import Places, Quantity, positive, whole_number
from .assumptions import CHANGES, noise_limit
from .uncertainty_budget import budget_of

#: ln(factor) = −_FALL h u of one scan, with the standard deviation h √((_MISSED b)² + (_SCATTER u)²) for wavelengths to
#: b; _MISSED is in 1/nm. Set on AFM maps by ``tests/benchmarks/real_below_the_pixel.py``.
_FALL = 0.39
_MISSED = 0.0093
_SCATTER = 0.49

#: Shortest wavelength (nm) of continuum theory, and the shortest and longest that the maps could test.
_SHORTEST_WAVELENGTH = 0.5
_TESTED = (6.0, 64.0)

#: Pixels of the shortest wavelength that a scan contains.
_PIXELS_PER_WAVELENGTH = 2.0

#: The same of a second scan, at h = 1, beyond the scatter of its places.
_LEAST_SECOND_SCATTER = 0.17
_SECOND_SCATTER = 0.27

#: Places of the first pixels of a second scan as the first would show it, in pixels: results are means over both.
_PHASES = (0.25, 0.75)

#: Places along each axis at which a second scan is solved.
_SECOND_PLACES = (3, 3)

#: Standard deviation of ln(factor) of particles at rest by a second scan, beyond the scatter of its places.
_RESTING_SCATTER = 0.2

#: Standard deviation of ln(factor) from one pair and radius to another on one surface. On any three of four surfaces
#: it is 0.24 to 0.34 (``tests/benchmarks/calibrated_factor.py``).
_TRANSFER_ERROR = 0.35

#: Largest ratio of heights or slopes of the second scan to those of all parts of the first one as large.
_LARGEST_RATIO = 2.0


class RoughnessFactor(NamedTuple):
    """The effect of unseen roughness on the pull-off."""

    log: float  # ln of the factor
    error: float  # its standard deviation
    source: str  # in words


def extrapolated(
    ds: xr.Dataset | Specimen,
    *,
    subregions: Places = (4, 4),
    preload: Quantity = 0.0,
    law: str = "auto",
    mesh: Mesh | int | str = "auto",
    finer: xr.Dataset | None = None,
    measured: xr.Dataset | None = None,
    force_std: float = 0.0,
    shortest: Quantity | None = None,
    places: int = 4,
) -> xr.Dataset:
    """Return the pull-off of the real surface, with the effect of roughness finer than the scan and all known errors.

    Parameters
    ----------
    ds : Dataset
        A levelled scan with an assigned sphere and work of adhesion.
    subregions : (int, int), (array, array) or Dataset
        Contact centres, by default a grid of 4 × 4: places of a fixed probe, or `resting` positions with a second scan.
    preload, law, mesh
        As in `adhesive`, which solves the surface as scanned.
    finer : Dataset, optional
        A second scan of the same surface on finer pixels, levelled, of any part of it. Its width should be that of the
        sphere's radius or more. It narrows the interval most.
    measured : Dataset, optional
        Result of `compare` for measured pull-offs of another pair or radius on this surface, and their simulation by
        `adhesive` on this scan. Their ratio calibrates the factor of a fixed probe.
    force_std : float
        Relative standard deviation of the ratio beside its scatter, such as that of a spring constant or of the
        work of adhesion of the measured pair: 0.1 for 10 %.
    shortest : number or quantity, optional
        Shortest wavelength of the surface, nm, where it is known; by default 0.5 nm, where continuum theory ends.
    places : int
        Number of places at which the errors of pair and tip are solved.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) of the real surface along ``subregion``; ``pull_off_mean`` with ``pull_off_low`` and
        ``pull_off_high``, its 95 % interval by all errors; ``scanned_mean`` (nN), that of `adhesive` at the same
        places, and ``roughness_factor``, whose product is the mean; ``relative_std`` along ``entry``, the standard
        deviations of ln(mean), and ``remaining_std``, those that remain once the source of an error is measured, or
        a second scan taken. The attributes ``known`` and ``assumed`` state what the scan shows, and the factor.

    Raises
    ------
    ValueError
        Where the scan is synthetic, or flat; where the places are too few for an interval, or are resting positions
        without a second scan; where ``finer`` is not finer, too small, or not of the same surface.

    Notes
    -----
    With one scan: factor = (F(scan) / F(smooth flat))^0.3h, with h = 1 − a/b for unseen wavelengths from a to b.
    Factors of measured surfaces scatter by the effect of the roughness seen, and the interval with them.

    With a second scan: factor = F(finer) / F(finer as shown by ``ds``), both at nine places, where "shown" means
    sampled on the pixels of ``ds``. Roughness below the pixels of the second scan is estimated as with one scan. The
    result is the mean of this factor and that of one scan, in ln, weighted by the inverse variances; so is that of
    measured pull-offs, whose ratio to the simulation depends on pair and radius by a factor of 2 at 95 %.

    On finer roughness, a particle rolls on to other resting positions and is supported otherwise, which one scan cannot
    predict. The factor by a second scan holds for it as for a probe.

    The places' relative scatter is that of the surface as scanned: on AFM maps 0.7 to 1.7 times the true one.

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> real = scan.contact.extrapolated(subregions=(3, 3), mesh=2, places=1)
    >>> bool(real.pull_off_low < real.pull_off_mean < real.pull_off_high)
    True
    >>> bool(np.isclose(real.pull_off_mean, real.scanned_mean * real.roughness_factor))
    True
    """
    scan = need_sphere(ds).scan
    refuse_synthetic(scan, finer)
    count = whole_number(places, "places", least=1)
    centres = regions.centres(scan, subregions)
    _refuse_resting(centres, finer)
    solved = without_warnings(adhesive, scan, subregions=centres, preload=preload, law=law, mesh=mesh)
    mesh = read_mesh(mesh, Mesh())
    force = float(read_preloads(preload)[0])
    budget = budget_of(scan, solved, places=count, preload=force, mesh=mesh, only=CHANGES)
    estimates: dict[str, Any] = {"finer": finer, "measured": measured, "force_std": force_std, "shortest": shortest}
    out = real_pull_off(scan, solved, budget, **estimates)
    arguments = {"subregions": subregions, "preload": preload, "law": law, "mesh": mesh, "places": count}
    return schema.record(out, "extrapolated", scan, **estimates, **arguments)


def real_pull_off(
    ds: xr.Dataset,
    solved: xr.Dataset,
    budget: xr.Dataset | None,
    *,
    finer: xr.Dataset | None = None,
    measured: xr.Dataset | None = None,
    force_std: float = 0.0,
    shortest: Quantity | None = None,
) -> xr.Dataset:
    """Return the result of `extrapolated` from the simulation of the surface as scanned and its error budget.

    Without a budget, the interval contains the errors of places, mesh and unseen roughness alone.
    """
    schema.need_assigned(ds, "sphere_radius")
    refuse_synthetic(ds, finer)
    _refuse_resting(solved, finer)
    if not float(ds["height"].std()) > 0:
        raise Refusal("height", "roughness", "a flat scan", "adhesive gives its pull-off")
    end = _SHORTEST_WAVELENGTH if shortest is None else positive(shortest, "nm", "shortest")
    pull_off = at_first_preload(solved)
    scanned = mean_pull_off(pull_off)
    mean, low, high = (float(scanned[name]) for name in ("pull_off_force", "low", "high"))
    if np.isnan(low):
        places = int(scanned["places"])
        independent = float(scanned["independent_places"])
        raise Refusal(
            "subregions",
            "enough independent places for an interval",
            f"{places} that adhere" + f", {number(independent, digits=2)} of them independent" * (places > 1),
            "take a larger grid or a larger scan",
        )
    lowering = -float(np.log(scanned["smooth_share"]))
    unseen = _unseen_factor(ds, solved, scanned, end, finer, measured, force_std)
    errors = {PLACES: np.log(high / low) / (2 * HALF_WIDTH), UNSEEN: unseen.error, **_pair_errors(budget)}
    if not np.isfinite(errors.get(MESH, np.nan)):
        errors[MESH] = float(np.nan_to_num(mesh_error(pull_off))) / HALF_WIDTH
    shared = HALF_WIDTH * float(np.hypot.reduce([error for name, error in errors.items() if name != PLACES]))
    factor = float(np.exp(unseen.log))
    remaining = {UNSEEN: unseen.error}
    if finer is None and SECOND_SCAN_PART * max(schema.pixel(ds)) >= SECOND_SCAN_PIXELS[0]:
        second = RoughnessFactor(unseen.log, second_scan_error(lowering), "by a second scan")
        remaining[UNSEEN] = _combined_factor(unseen, second).error
    shown = _PIXELS_PER_WAVELENGTH * max(schema.pixel(ds))
    out = xr.Dataset(
        {
            "pull_off_force": factor * pull_off["pull_off_force"],
            "pull_off_mean": factor * mean,
            "pull_off_low": factor * mean * np.exp(-np.hypot(np.log(mean / low), shared)),
            "pull_off_high": factor * mean * np.exp(np.hypot(np.log(high / mean), shared)),
            "scanned_mean": mean,
            "roughness_factor": factor,
            "finest_shown": shown,
            "smooth_share": float(scanned["smooth_share"]),
            "relative_std": ("entry", list(errors.values())),
            "remaining_std": ("entry", [remaining.get(name, 0.0) for name in errors]),
        },
        {"entry": list(errors), **pull_off["pull_off_force"].coords},
    )
    out.attrs = _sentences(ds, shown, unseen)
    if budget is None:
        out.attrs["assumed"] += " The errors of the pair are not included."
    return schema.label(out)


def _unseen_factor(
    ds: xr.Dataset,
    solved: xr.Dataset,
    scanned: xr.Dataset,
    end: float,
    finer: xr.Dataset | None,
    measured: xr.Dataset | None,
    force_std: float,
) -> RoughnessFactor:
    """Return the effect of unseen roughness down to an end (nm), by one scan, a second one, and measured forces."""
    lowering = -float(np.log(scanned["smooth_share"]))
    is_at_rest = SHARE in solved.coords
    unseen = one_scan_factor(lowering, max(schema.pixel(ds)), end)
    if finer is not None:
        second = _second_scan_factor(ds, finer, solved.attrs["law"], lowering, end, is_at_rest)
        unseen = second if is_at_rest else _combined_factor(unseen, second)
    if measured is not None and not is_at_rest:
        by_forces = _measured_factor(measured, force_std)
        if finer is not None:
            by_forces = by_forces._replace(source=f"{unseen.source} and {by_forces.source}")
            by_forces = _combined_factor(unseen, by_forces)
        unseen = by_forces if unseen.error > 0 else unseen  # with the factor of one scan it is no better
    return unseen


def _sentences(ds: xr.Dataset, shown: float, unseen: RoughnessFactor) -> dict[str, str]:
    """Return what is known from the scan, and what is assumed of finer roughness, in words."""
    factor = float(np.exp(unseen.log))
    spread = np.exp(HALF_WIDTH * unseen.error)
    ends = " … ".join(number(limit, digits=2) for limit in (factor / spread, factor * spread))
    known = f"The scan resolves wavelengths of {number(shown, 'nm')} (2 pixels) and longer."
    if (noise := noise_limit(ds)) > read_pair(ds).range:
        known += f" Noise cannot be distinguished from roughness: it may reach {number(noise, 'nm', 2)}."
    assumed = f"Finer roughness multiplies the pull-off by {number(factor, digits=2)} ({ends}), {unseen.source}."
    return {"known": known, "assumed": assumed}


def without_estimate(ds: xr.Dataset, reason: str) -> xr.Dataset:
    """Return the result of `extrapolated` where there is no estimate: no numbers, and the reason."""
    out = xr.Dataset(dict.fromkeys(("pull_off_mean", "pull_off_low", "pull_off_high"), np.nan))
    sentence = f"The effect of finer roughness is not included: {reason}."
    return schema.label(out.assign_coords(schema.pair_coordinates(ds)).assign_attrs(known=sentence, assumed=""))


def refuse_synthetic(*scans: xr.Dataset | None) -> None:
    """Raise if a scan is synthetic."""
    if any(scan is not None and schema.is_synthetic(scan) for scan in scans):
        raise Refusal(
            "", "a measured scan", "a synthetic one, which has no real surface", "adhesive gives its pull-off"
        )


def _refuse_resting(places: xr.Dataset, finer: xr.Dataset | None) -> None:
    """Raise where the places are resting positions of free particles, without a second scan."""
    if SHARE in places.coords and finer is None:
        raise Refusal(
            "finer",
            "a second scan for resting positions",
            "none",
            "on finer roughness a particle rolls on to other ones, and adheres up to several times as much",
        )


def _pair_errors(budget: xr.Dataset | None) -> dict[str, float]:
    """Return the standard deviations of ln(mean) by the entries of a budget other than the choice of places."""
    if budget is None:
        return {}
    errors = budget["relative_std"].to_series().drop(SAMPLING, errors="ignore").dropna()
    return {str(name): np.log1p(error) for name, error in errors.items()}


def one_scan_factor(lowering: float, pixel: float, end: float) -> RoughnessFactor:
    """Return the effect of wavelengths from two pixels to an end (nm), by measured surfaces.

    ``lowering`` is ln(pull-off from a smooth flat / pull-off as scanned).
    """
    longest = _PIXELS_PER_WAVELENGTH * pixel
    part = 1 - min(end / longest, 1.0)
    seen = max(lowering, 0.0)
    source = "by the effect of the roughness seen, as on measured surfaces"
    if longest > _TESTED[1] or end < _TESTED[0]:
        source += f", tested on wavelengths of {_TESTED[0]:g} to {_TESTED[1]:g} nm and extrapolated beyond"
    return RoughnessFactor(-_FALL * part * seen, part * float(np.hypot(_MISSED * longest, _SCATTER * seen)), source)


def _second_scan_factor(
    ds: xr.Dataset,
    finer: xr.Dataset,
    law: str,
    lowering: float,
    end: float,
    is_at_rest: bool,
) -> RoughnessFactor:
    """Return the effect of the wavelengths that the first scan does not show, by a second one."""
    log, scatter = second_scan_ratio(ds, finer, law)
    below = one_scan_factor(lowering - log, max(schema.pixel(finer)), end)
    beyond = _RESTING_SCATTER if is_at_rest else second_scan_error(lowering)
    width = number(min(regions.sides(finer)), "nm")
    source = f"by a second scan, {width} wide on pixels of {number(max(schema.pixel(finer)), 'nm')}"
    return RoughnessFactor(log + below.log, float(np.hypot.reduce([scatter, beyond, below.error])), source)


def _measured_factor(measured: xr.Dataset, force_std: float) -> RoughnessFactor:
    """Return the effect of unseen roughness as the ratio of measured to simulated pull-offs."""
    measured = schema.entered(measured)
    if "ratio" not in measured or "mean" not in measured["statistic"]:
        raise Refusal("measured", "a result of `compare` with the mean", "no ratio of means")
    mean = measured.sel(statistic="mean")
    ratio, low, high = (float(mean[name]) for name in ("ratio", "ratio_low", "ratio_high"))
    if not np.isfinite([ratio, low, high]).all():
        raise Refusal("measured", "an interval of the ratio", "none", "measure more places")
    scatter = np.log(high / low) / (2 * HALF_WIDTH)
    error = float(np.hypot.reduce([scatter, force_std, _TRANSFER_ERROR]))
    return RoughnessFactor(float(np.log(ratio)), error, "by measured pull-offs")


def _combined_factor(first: RoughnessFactor, second: RoughnessFactor) -> RoughnessFactor:
    """Return the mean of two estimates of one factor, weighted by their inverse variances.

    Estimates of one surface may be wrong in the same way, so that agreement does not narrow the error. Where the first
    is exact, nothing is unseen. The source is that of the second.
    """
    if first.error == 0:
        return first
    errors = np.array([first.error, second.error])
    log = float(np.average([first.log, second.log], weights=errors**-2))
    error = np.average(errors, weights=errors**-2)
    return RoughnessFactor(log, float(error), second.source)


def second_scan_error(lowering: float) -> float:
    """Return the standard deviation of ln(factor) by a second scan, beyond the scatter of its places."""
    return float(np.hypot(_LEAST_SECOND_SCATTER, _SECOND_SCATTER * max(lowering, 0.0)))


def second_scan_ratio(ds: xr.Dataset, finer: xr.Dataset, law: str) -> tuple[float, float]:
    """Return ln(ratio) of the mean pull-offs of a second scan as it is and as shown, and its error."""
    finer, shown = second_scan(ds, finer)
    centres = regions.centres(shown[0], _SECOND_PLACES)
    fine, *coarse = (
        at_first_preload(without_warnings(adhesive, scan, subregions=centres, law=law))["pull_off_force"].values
        for scan in (finer, *shown)
    )
    both = np.isfinite([fine, *coarse]).all(axis=0)
    if both.sum() < 2:
        raise Refusal("finer", "two places that adhere", int(both.sum()), "take a wider second scan")
    fine = fine[both]
    as_shown = np.mean(coarse, axis=0)[both]
    ratio = fine.mean() / as_shown.mean()
    scatter = (fine - ratio * as_shown).std(ddof=1) / np.sqrt(fine.size) / fine.mean()
    return float(np.log(ratio)), float(scatter)


def second_scan(ds: xr.Dataset, finer: xr.Dataset) -> tuple[xr.Dataset, list[xr.Dataset]]:
    """Return a second, finer scan with the pair of the first, as it is and as the first would show it.

    Raise where it is not finer, too small, or not of the same surface.
    """
    finer = on_square_pixels(schema.validate(finer, "scan"))[["height"]].reset_coords(drop=True)
    finer = finer.assign_coords(schema.pair_coordinates(ds))
    shown = [_as_shown(finer, ds, phase) for phase in _PHASES]
    _refuse_other_surface(ds, shown[0])
    return finer, shown


def _as_shown(finer: xr.Dataset, ds: xr.Dataset, phase: float) -> xr.Dataset:
    """Return a finer scan sampled on pixels as large as those of a coarser one, from a part of a pixel on."""
    step = schema.square_pixel(ds)
    fine = schema.square_pixel(finer)
    if not fine < step:
        raise Refusal("finer", f"pixels smaller than {step:.3g} nm", f"{fine:.3g} nm")
    axes = {}
    for axis in "xy":
        low = float(finer[axis][0])
        high = float(finer[axis][-1])
        count = int((high - low) / step)
        if count < SECOND_SCAN_WIDTH:
            raise Refusal(
                "finer",
                f"a side of {SECOND_SCAN_WIDTH * step:.3g} nm or more, ten pixels of the first scan",
                f"{high - low:.3g} nm",
            )
        axes[axis] = low + step * (phase + np.arange(count))
    return schema.label(finer.interp(axes, assume_sorted=True).assign_attrs(finer.attrs))


def _refuse_other_surface(ds: xr.Dataset, shown: xr.Dataset) -> None:
    """Raise where heights or slopes of a second scan differ from those of all parts of the first one as large."""
    sides = [min(shown.sizes[axis], ds.sizes[axis]) for axis in "xy"]
    tiles = [
        ds.isel(x=slice(i, i + sides[0]), y=slice(j, j + sides[1]))
        for i in range(0, ds.sizes["x"] - sides[0] + 1, sides[0])
        for j in range(0, ds.sizes["y"] - sides[1] + 1, sides[1])
    ]
    parts = np.array([_heights_and_slopes(tile) for tile in tiles])
    for name, units, value, rms_of_parts in zip(("heights", "slopes"), ("nm", ""), _heights_and_slopes(shown), parts.T):
        low = rms_of_parts.min() / _LARGEST_RATIO
        high = rms_of_parts.max() * _LARGEST_RATIO
        if not low <= value <= high:
            raise Refusal(
                "finer",
                f"a scan of the same surface, whose parts as large as this have {name} of rms "
                f"{number(rms_of_parts.min(), units)} to {number(rms_of_parts.max(), units)} at equal pixels",
                number(value, units),
            )


def _heights_and_slopes(scan: xr.Dataset) -> tuple[float, float]:
    """Return the root mean squares of a scan's heights (nm) and slopes, less its plane."""
    heights = level(scan)["height"].values
    steps = schema.pixel(scan)
    slopes = [np.diff(heights, axis=axis) / step for axis, step in enumerate(steps)]
    return float(heights.std()), float(np.sqrt(np.mean([np.mean(slope**2) for slope in slopes])))
