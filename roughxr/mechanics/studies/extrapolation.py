"""`extrapolated`: the pull-off of the real surface, from that as scanned and the effect of finer roughness.

The real pull-off is the mean as scanned, over all places, times a factor. With one scan, the centre and the ends of the
factor are those of measured surfaces, by the number of octaves that the scan does not show: nothing that a picture
shows orders them (``tests/benchmarks/real_below_the_pixel.py``). With a second, finer scan, the factor is the ratio of
two pull-offs of it: as it is, and as the first scan would show it. Below the pixels of the second scan, the octaves
count as below those of the first. Measured pull-offs of another pair or radius give the factor as their ratio to the
simulation. All this holds for particles at rest as for probes, but that one scan cannot predict where they rest.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..contact.adhesion import adhesive
from ..contact.adhesive_options import read_preloads
from ..contact.mesh import FRONT, MOST_REFINED, Mesh, read_mesh
from ..contact.regimes import need_sphere
from ..scans import regions
from ..specimen import Specimen
from ..statistics.means import mean_pull_off, pressed_means
from ..statistics.sampling import SHARE, at_first_preload
from ..vocabulary import schema
from ..vocabulary.error_sources import (
    HALF_WIDTH,
    MEASURED,
    MESH,
    ONE_SCAN,
    PLACES,
    PRESSING,
    SECOND_SCAN,
    SECOND_SCAN_NOISE,
    SECOND_SCAN_PART,
    SECOND_SCAN_PIXEL,
    UNSEEN,
    KnownError,
    error_of_interval,
    error_table,
    read_errors,
    symmetric_error,
    total_error,
)
from ..vocabulary.numbers import format_number
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import without_warnings
from ..vocabulary.units import Places, Quantity, positive, whole_number
from .assumptions import CHANGES, noise_limit
from .finer_scan import SecondScan, second_scan
from .uncertainty_budget import budget_of, stated_mesh_error

#: Change of ln(pull-off) by each octave of wavelengths that a scan does not show: centre, and lower end of 95 %.
_CENTRE_OF_OCTAVE = -0.2
_LOWEST_OF_OCTAVE = -1.1

#: Upper end of ln(factor): finer roughness hardly raises a force, in however many octaves.
_HIGHEST = 0.19

#: Fewest octaves that tip and noise hide, on however fine pixels.
_FEWEST_OCTAVES = 1.5

#: Distance of both ends of ln(factor) by a second scan, for each octave that it shows and the first does not.
_SECOND_OF_OCTAVE = 0.3

#: Shortest wavelength (nm) of continuum theory, and the shortest and longest that maps could test.
_SHORTEST_WAVELENGTH = 0.5
TESTED = (6.0, 64.0)

#: Pixels of the shortest wavelength that a scan contains.
_PIXELS_PER_WAVELENGTH = 2.0

#: Places along each axis at which a second scan is solved.
_SECOND_PLACES = (3, 3)

#: Standard deviation of ln(factor) from one pair and radius to another on one surface. On any three of four surfaces
#: it is 0.24 to 0.34 (``tests/benchmarks/calibrated_factor.py``).
_TRANSFER_ERROR = 0.35

#: Pixels of a scan in one of the pixel series, and number of places at which the series is solved.
_SERIES = (2, 4)
_SERIES_PLACES = 9

#: Fewest pixels along a side of a scan of the series.
_FEWEST_PIXELS = 8


class RoughnessFactor(NamedTuple):
    """The effect of unseen roughness on the pull-off: ln of the factor, and its error."""

    log: float
    error: KnownError
    source: str  # ONE_SCAN, SECOND_SCAN or MEASURED


@schema.recorded
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
        A second scan of the same surface on finer pixels, of any part of it. Its width should be that of the
        sphere's radius or more. It narrows the interval most. A warning states heights, slopes or a skewness that
        differ from those of the first scan; its plane is subtracted.
    measured : Dataset, optional
        Result of `compare` for measured pull-offs of another pair or radius on this surface, and their simulation by
        `adhesive` on this scan. Their ratio calibrates the factor of a fixed probe.
    force_std : float
        Relative standard deviation of the ratio beside its scatter, such as that of a spring constant or of the
        work of adhesion of the measured pair: 0.1 for 10 %.
    shortest : number or quantity, optional
        Shortest wavelength of the surface, nm, where it is known; by default 0.5 nm, where continuum theory ends.
        Wavelengths below 6 nm could not be tested: an octave is assumed to count a quarter of the octave above.
    places : int
        Number of places at which the errors of pair and tip are solved.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) of the real surface along ``subregion``; ``pull_off_mean`` with ``pull_off_low`` and
        ``pull_off_high``, its 95 % interval by all errors; ``scanned_mean`` (nN), that of `adhesive` at the same
        places, and ``roughness_factor`` with its ends ``roughness_low`` and ``roughness_high``; the product of both is
        the mean. ``relative_std`` along ``entry``, the standard deviations of ln(mean), with the other variables of
        `error_budget`, and ``remaining_std``, those that remain once the source of an error is measured, or a second
        scan taken; ``narrowed_low`` and
        ``narrowed_high``, the interval after the step that narrows it most, which the attribute ``narrowing_source``
        names. ``pull_off_on_pixels`` (nN) along ``pixel_size``: the mean as scanned, and on every second and fourth
        pixel of the scan. The attributes state the ``shortest`` wavelength, and ``noise_limit`` (nm) where
        noise cannot be distinguished from roughness.

    Raises
    ------
    ValueError
        Where the scan is synthetic, or flat; where the places are too few for an interval, or are resting positions
        without a second scan; where ``finer`` is not finer, too small, or not of the same surface.

    Notes
    -----
    With one scan: ln(factor) = −0.2 n, between −1.1 n and 0.19, with n the number of octaves from two pixels of the
    scan to ``shortest``, at least 1.5, which tip and noise hide on any pixels. On measured surfaces, nothing that a
    picture shows narrows these ends: neither how much roughness it shows, nor the pull-off on larger pixels.

    With a second scan: factor = F(finer) / F(finer as shown by ``ds``), both at nine places, where "shown" means
    sampled on the pixels of ``ds``. Wavelengths at which the noise of the second scan exceeds its roughness are removed
    first. Roughness below is counted in octaves, as with one scan. The ratio takes the place of the factor of one scan;
    measured pull-offs do, too. Both together are averaged in ln, weighted by the inverse variances.

    On finer roughness, a particle rolls on to other resting positions and is supported otherwise, which one scan cannot
    predict. The factor by a second scan holds for it as for a probe.

    The places' relative scatter is that of the surface as scanned.

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
    return out.merge(pixel_series(scan, solved, force, mesh.step), combine_attrs="override")


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
    _need_interval(scanned)
    factor, unseen_errors = _unseen_factor(ds, solved, end, finer, measured, force_std)
    errors = _seen_errors(pull_off, scanned, budget) | unseen_errors
    remaining = dict.fromkeys(errors, symmetric_error(0.0)) | {UNSEEN: factor.error}
    remaining |= _after_second_scan(ds, finer, end)
    out = _estimate(pull_off, scanned, factor, errors, remaining)
    out["finest_shown"] = _shown_wavelength(ds)
    out.attrs["shortest"] = end
    if (noise_rms := noise_limit(ds)) > read_pair(ds).range:
        out.attrs["noise_limit"] = noise_rms
    return schema.label(out)


def _estimate(
    pull_off: xr.Dataset,
    scanned: xr.Dataset,
    factor: RoughnessFactor,
    errors: dict[str, KnownError],
    remaining: dict[str, KnownError],
) -> xr.Dataset:
    """Return the pull-off times the factor, with its interval, and that after the step that narrows it most."""
    narrowed = {name: total_error((errors | {name: remaining[name]}).values()) for name in errors}
    step = min(narrowed, key=lambda name: narrowed[name].std)
    intervals = {"pull_off": total_error(errors.values()), "narrowed": narrowed[step], "roughness": factor.error}
    ratio = float(np.exp(factor.log))
    mean = float(scanned["pull_off_force"])
    out = xr.Dataset(
        {
            "pull_off_force": ratio * pull_off["pull_off_force"],
            "pull_off_mean": ratio * mean,
            "scanned_mean": mean,
            "roughness_factor": ratio,
            "smooth_share": float(scanned["smooth_share"]),
        }
    )
    for name, error in intervals.items():
        out[f"{name}_low"], out[f"{name}_high"] = error.interval(ratio if name == "roughness" else ratio * mean)
    out = out.merge(error_table(errors))
    out["remaining_std"] = ("entry", [remaining[name].std for name in errors])
    if PRESSING in errors:
        out["pressed_pull_off_force"] = ratio * pull_off["pressed_pull_off_force"]
    out.attrs = {"narrowing_source": step, "unseen_by": factor.source}
    return out


def _need_interval(scanned: xr.Dataset) -> None:
    """Raise where a mean has no interval, since its places are too few."""
    if np.isfinite(scanned["low"]):
        return
    places = int(scanned["places"])
    independent = float(scanned["independent_places"])
    raise Refusal(
        "subregions",
        "enough independent places for an interval",
        f"{places} that adhere" + f", {format_number(independent, digits=2)} of them independent" * (places > 1),
        "take a larger grid or a larger scan",
    )


def _seen_errors(pull_off: xr.Dataset, scanned: xr.Dataset, budget: xr.Dataset | None) -> dict[str, KnownError]:
    """Return the errors of the pull-off as scanned: of a budget, of its places, and of ranges by pressing."""
    budgeted = {} if budget is None else read_errors(budget)
    errors = {name: error for name, error in budgeted.items() if np.isfinite(error.std)}
    mean, low, high = (float(scanned[name]) for name in ("pull_off_force", "low", "high"))
    places = error_of_interval(mean, low, high)
    errors[PLACES] = errors.get(PLACES, places)._replace(
        below=places.below,
        above=places.above,
        places=int(scanned["places"]),
        tried_places=int(scanned["solved_places"]),
    )
    if MESH not in errors:
        errors[MESH] = stated_mesh_error(pull_off)
    if pressed := pressed_means(pull_off):
        errors[PRESSING] = error_of_interval(mean, *pressed)
    return errors


def _after_second_scan(ds: xr.Dataset, finer: xr.Dataset | None, end: float) -> dict[str, KnownError]:
    """Return what a second scan on the advised pixels leaves of the error of unseen roughness, if it is advised."""
    if finer is not None or SECOND_SCAN_PART * max(schema.pixel(ds)) < SECOND_SCAN_PIXEL:
        return {}
    second = second_scan_factor(0.0, _shown_wavelength(ds), _PIXELS_PER_WAVELENGTH * SECOND_SCAN_PIXEL, end)
    return {UNSEEN: second.error}


def pixel_series(ds: xr.Dataset, solved: xr.Dataset, preload: float, longest_step: float | None) -> xr.Dataset:
    """Return the mean pull-off as scanned and on every second and fourth pixel of the scan, by a sample of places.

    ``longest_step`` is that of the simulation ``solved`` (nm), as of `Mesh`. Empty for resting positions, which larger
    pixels move, and where the pixels are too few.
    """
    steps = [step for step in _SERIES if min(ds["height"].shape) >= _FEWEST_PIXELS * step]
    if SHARE in solved.coords or not steps:
        return xr.Dataset()
    pull_off = at_first_preload(solved)
    base = regions.sample(pull_off, _SERIES_PLACES)
    law = solved.attrs["law"]
    cells = int(base["mesh"].max())
    forces = [base["pull_off_force"].values]
    for step in steps:
        coarse = ds.isel(x=slice(step // 2, None, step), y=slice(step // 2, None, step))
        mesh = Mesh(min(cells * step, MOST_REFINED) or FRONT, None, longest_step)
        centres = regions.centres(coarse, base)
        on_step = without_warnings(adhesive, coarse, subregions=centres, preload=preload, law=law, mesh=mesh)
        forces.append(at_first_preload(on_step)["pull_off_force"].values)
    everywhere = np.isfinite(forces).all(axis=0)
    if not everywhere.any():
        return xr.Dataset()
    means = np.mean(forces, axis=1, where=everywhere)
    sizes = max(schema.pixel(ds)) * np.array([1, *steps])
    mean = float(mean_pull_off(pull_off)["pull_off_force"])
    series = {"pull_off_on_pixels": ("pixel_size", mean * means / means[0])}
    return schema.label(xr.Dataset(series, {"pixel_size": sizes}))


def _shown_wavelength(ds: xr.Dataset) -> float:
    """Return the shortest wavelength that a scan's pixels can show, nm."""
    return _PIXELS_PER_WAVELENGTH * max(schema.pixel(ds))


def _unseen_factor(
    ds: xr.Dataset,
    solved: xr.Dataset,
    end: float,
    finer: xr.Dataset | None,
    measured: xr.Dataset | None,
    force_std: float,
) -> tuple[RoughnessFactor, dict[str, KnownError]]:
    """Return the effect of unseen roughness down to an end (nm), and its errors, also by the noise of a second scan."""
    shown = _shown_wavelength(ds)
    unseen = one_scan_factor(unseen_octaves(shown, end))
    errors = {}
    if finer is not None:
        second = second_scan(ds, finer)
        log, noise = second_scan_ratio(second, solved.attrs["law"])
        unseen = second_scan_factor(log, shown, second.shown_wavelength, end)
        errors[SECOND_SCAN_NOISE] = symmetric_error(noise)
    if measured is not None and SHARE not in solved.coords and unseen.error.std > 0:
        by_forces = _measured_factor(measured, force_std)
        unseen = by_forces if finer is None else _combined_factor(unseen, by_forces)
    return unseen, {UNSEEN: unseen.error} | errors


def without_estimate(ds: xr.Dataset, reason: str) -> xr.Dataset:
    """Return the result of `extrapolated` where there is no estimate: no numbers, and the reason."""
    out = xr.Dataset(dict.fromkeys(("pull_off_mean", "pull_off_low", "pull_off_high"), np.nan))
    return schema.label(out.assign_coords(schema.pair_coordinates(ds)).assign_attrs(reason=reason))


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


def unseen_octaves(longest: float, end: float) -> float:
    """Return the octaves of wavelengths that a scan does not show, from its longest unseen to the end (nm).

    Of untested ones, each is assumed to count a quarter of that above: an integral of wavelength² over octaves.
    """
    if end >= longest:
        return 0.0
    least = TESTED[0]
    tested = np.log2(max(longest, least) / max(end, least))
    untested = (min(longest, least) / least) ** 2 - (min(end, least) / least) ** 2
    return max(float(tested + untested / (2 * np.log(2))), _FEWEST_OCTAVES)


def one_scan_factor(octaves: float, source: str = ONE_SCAN) -> RoughnessFactor:
    """Return the effect of so many unseen octaves, by measured surfaces."""
    log = _CENTRE_OF_OCTAVE * octaves
    highest = _HIGHEST if octaves > 0 else 0.0
    error = KnownError((log - _LOWEST_OF_OCTAVE * octaves) / HALF_WIDTH, (highest - log) / HALF_WIDTH)
    return RoughnessFactor(log, error, source)


def second_scan_factor(log: float, longest: float, second_longest: float, end: float) -> RoughnessFactor:
    """Return the effect of wavelengths down to an end (nm), of which a second scan shows those above its own longest.

    ``log`` is ln of the ratio of its pull-offs as it is, and as the first scan would show it.
    """
    octaves = unseen_octaves(longest, end)
    hidden = min(max(unseen_octaves(second_longest, end), _FEWEST_OCTAVES), octaves)
    below = one_scan_factor(hidden, SECOND_SCAN)
    shown = symmetric_error(_SECOND_OF_OCTAVE * (octaves - hidden) / HALF_WIDTH)
    return RoughnessFactor(log + below.log, total_error([shown, below.error]), SECOND_SCAN)


def _measured_factor(measured: xr.Dataset, force_std: float) -> RoughnessFactor:
    """Return the effect of unseen roughness as the ratio of measured to simulated pull-offs."""
    measured = schema.in_package_units(measured)
    if "ratio" not in measured or "mean" not in measured["statistic"]:
        raise Refusal("measured", "a result of `compare` with the mean", "no ratio of means")
    mean = measured.sel(statistic="mean")
    ratio, low, high = (float(mean[name]) for name in ("ratio", "ratio_low", "ratio_high"))
    if not np.isfinite([ratio, low, high]).all():
        raise Refusal("measured", "an interval of the ratio", "none", "measure more places")
    scatter = error_of_interval(ratio, low, high).std
    error = total_error(map(symmetric_error, (scatter, force_std, _TRANSFER_ERROR)))
    return RoughnessFactor(float(np.log(ratio)), error, MEASURED)


def _combined_factor(first: RoughnessFactor, second: RoughnessFactor) -> RoughnessFactor:
    """Return the mean of two estimates of one factor, weighted by their inverse variances.

    Estimates of one surface may be wrong in the same way, so that agreement does not narrow the error. The source is
    that of the second.
    """
    weights = np.array([first.error.std, second.error.std]) ** -2
    ends = [(factor.log, factor.error.below, factor.error.above) for factor in (first, second)]
    log, below, above = np.average(ends, axis=0, weights=weights).tolist()
    return RoughnessFactor(log, KnownError(below, above), second.source)


def second_scan_ratio(second: SecondScan, law: str) -> tuple[float, float]:
    """Return ln(ratio) of the mean pull-offs of a second scan as it is and as shown, and its error by noise."""
    centres = regions.centres(second.finer, _SECOND_PLACES)

    def solve(scan: xr.Dataset) -> np.ndarray:
        return at_first_preload(without_warnings(adhesive, scan, subregions=centres, law=law))["pull_off_force"].values

    fine, noisier, *coarse = (solve(scan) for scan in (second.finer, second.noisier, *second.as_shown))
    both = np.isfinite([fine, noisier, *coarse]).all(axis=0)
    if both.sum() < 2:
        raise Refusal("finer", "two places that adhere", int(both.sum()), "take a wider second scan")
    ratio = fine[both].mean() / np.mean(coarse, axis=0)[both].mean()
    return float(np.log(ratio)), float(abs(np.log(noisier[both].mean() / fine[both].mean())))
