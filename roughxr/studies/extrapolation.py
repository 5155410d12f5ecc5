"""`extrapolated`: the pull-off with roughness finer than the scan, added until finer roughness has no effect.

Below the shortest wavelength that the scan shows correctly, parts of an octave are added one after the other, at a few
places, until the mean pull-off converges. All places are then solved with all wavelengths, and the few places again
with each assumption changed, for the interval of the mean.

Few real surfaces are Gaussian and self-affine, and pixels as large as a grain do not show the spectrum's slope. If a
scan shows no power law over two octaves, or a feature that no self-affine surface has, the truth lies between two
sides: the surface as scanned, without its noise, and this surface with Gaussian roughness of the usual slope added,
too much on the summits. With L = ln(scanned / added), the estimate is their geometric mean, or, if not Gaussian,
F = scanned · exp(−½ (1 − exp(−L))), at most e^½ below the scan: on real surfaces the pull-off stops falling, since
their fine roughness lies between the grains (``tests/benchmarks/real_below_the_pixel.py``).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from ..contact.adhesive_options import preload_problem
from ..contact.cycle import Adhesion
from ..contact.problem import Problem
from ..contact.regimes import need_sphere
from ..contact.subpixel import AddedRoughness, extrapolated_pull_off
from ..jobs import spread
from ..kernels.topography.random_surface import band_rms
from ..scans import regions, self_affine_fit, smooth
from ..scans.fine_scales import Spectrum, known_spectrum, rings, without_noise
from ..scans.self_affinity import unlike_self_affine
from ..scans.wavelength import scan_parts
from ..specimen import Specimen
from ..statistics import bootstrap
from ..statistics.sampling import by_share
from ..vocabulary import schema
from ..vocabulary.units import Places, Quantity, fraction, positive, whole_number

#: Number of parts in which an octave is added: to a power law, and to a real surface, whose estimate lies between both
#: sides. Shortest wavelength, nm, of continuum theory.
_PARTS_OF_POWER_LAW, _PARTS_OF_REAL, _SHORTEST_WAVELENGTH = 2, 1, 0.5

#: Rms of roughness without effect, over the range of adhesion or of a meniscus.
_NEGLIGIBLE_RMS = 0.1

#: Places at which the shortest wavelength with an effect and the effect of the assumptions are determined.
_PILOT_PLACES = 6

#: Mean number of cells of a place from which no further octave is added: it would take a minute for the few places.
_MOST_CELLS = 10_000

#: Factors on the range of adhesion and on the hardness, assigned or estimated: one standard deviation.
_RANGE_FACTOR, _HARDNESS_FACTOR, _ESTIMATE_FACTOR = 1.25, 1.1, 1.3

#: Pixels of the shortest wavelength that a microscope shows correctly: aliasing, averaging over a pixel and the kinks
#: that a tip leaves falsify shorter ones.
_TRUE_PIXELS = 4.0

#: Hurst exponent of roughness that is added to real surfaces: the mean fall of ln(energy) from one octave of their
#: wavelengths to the next shorter one is 1.21 ± 0.72, 2 H ln 2; nine maps give 1.34 ± 0.74 (the benchmark's
#: ``--spectra``).
REAL_HURST = 0.88

#: Standard deviations of ln(energy) of the octave below two pixels, and of the Hurst exponent over two octaves.
_REAL_ENERGY_ERROR, _REAL_HURST_ERROR = 0.35, 0.38

#: Roll-off over the shortest wavelength that the scan shows, of scans whose own slope is extrapolated.
_POWER_LAW = 4.0

#: Pixels along a side below which a scan is not coarsened by two for the test of self-affinity.
_LEAST_COARSENED = 64

#: Pixels of the shortest wavelength that a scan contains, along an axis and along a diagonal.
_TWO_PIXELS, _DIAGONAL = 2.0, 1.4

#: Largest ln(scanned / best estimate) of a surface that is not self-affine.
_LARGEST_FALL = 0.5

#: Margins of ln(truth) beyond the two sides on real surfaces: above the scan, whose valleys may be too sharp, and below
#: the added roughness.
_ABOVE_SCAN, _BELOW_ADDED = 0.2, 0.3

#: Fewer places do not show their correlation; they are taken as independent, since they lie far apart.
_FEWEST_CORRELATED = 16

_NO_HARDNESS = "the bodies stay elastic, since no hardness is known"


class Question(NamedTuple):
    """The problem, law and added roughness of the solution at a place."""

    problem: Problem
    adhesion: Adhesion
    below: AddedRoughness


def extrapolated(
    ds: xr.Dataset | Specimen,
    *,
    subregions: Places = None,
    seeds: int = 2,
    preload: Quantity = 0.0,
    shortest: Quantity | None = None,
    spectrum: xr.Dataset | None = None,
    accuracy: float = 0.1,
) -> xr.Dataset:
    """Return the simulated pull-off with the roughness extrapolated below what the scan shows, and its 95 % interval.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere and work of adhesion.
    subregions : (int, int), (array, array) or Dataset, optional
        As in `direct`.
    seeds : int
        Number of random surfaces that agree with the scan.
    preload : number or quantity
        As in `adhesive`, nN.
    shortest : number or quantity, optional
        Shortest wavelength of the surface, nm, where it is known; by default that below which roughness has no effect.
    spectrum : Dataset, optional
        A spectrum measured on finer pixels, used as far as it reaches: `combined_spectrum`, or `self_affine_fit` of a
        finer scan. A fit of this scan, or of one as coarse, replaces the usual one only if the scan is self-affine.
    accuracy : float
        Finer roughness has no effect where an octave more changes the mean pull-off by less than this part.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) along (subregion, seed); ``pull_off_mean`` with ``pull_off_lower`` and
        ``pull_off_upper``, its 95 % interval; ``shortest_wavelength`` (nm) of what was added; ``converged``;
        ``failed_solves``; ``relative_error`` along ``entry``, the standard deviations of ln(mean), those
        of the spectrum and of shorter wavelengths upwards only as far as the surface as scanned; ``scale_pull_off``
        along ``shortest_kept``, the mean at a few places as wavelengths are added. The attributes ``known`` and
        ``assumed`` state what the scan shows and what was added.

    Raises
    ------
    ValueError
        Where the scan is flat and so has no spectrum to extrapolate.

    Notes
    -----
    The law is exponential, with the pair's ``adhesion_range`` (0.3 nm unless given, and the liquid's);
    the hardness is the pair's, or the estimate for named materials. Wavelengths that the scan distorts, shorter than
    four pixels unless its spectrum ends before, are replaced. The interval contained the truth for 31 of 31 self-affine
    surfaces (``tests/benchmarks/below_the_pixel.py``). A scan that no self-affine surface would show (grains, steps,
    particles, a blunt tip, noise), or that shows no power law over two octaves, keeps all its wavelengths but its white
    noise. The estimate then lies between the surface as scanned and the scan with the usual fine roughness of real
    surfaces added, and the interval contains both (``tests/benchmarks/real_below_the_pixel.py``).

    The effect of octaves that would take too long is estimated from the last one's, as ``assumed`` states. Resting
    positions stay those of the scan; on fine roughness a particle would roll on to others, and adhere more.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> found = extrapolated(scan, subregions=(2, 1), seeds=1, shortest=10)
    >>> bool(found.pull_off_lower < found.pull_off_mean < found.pull_off_upper), float(found.shortest_wavelength)
    (True, 10.0)
    """
    ds, spectrum = schema.entered(ds), schema.entered(spectrum)
    ds = need_sphere(ds).scan
    count, accuracy = whole_number(seeds, "seeds", least=1), fraction(accuracy, "accuracy")
    end = None if shortest is None else positive(shortest, "nm", "shortest")
    own, pixel = known_spectrum(resolved_spectrum(ds)), max(schema.pixel(ds))
    model = own if spectrum is None else known_spectrum(spectrum, own.shown, own.lay)
    if not np.isfinite(model.plateau):
        raise ValueError("height: expected a spectrum to extrapolate, found none in a flat or nearly flat scan")
    measured = model.shortest_measured < _DIAGONAL * pixel
    unlike = "" if measured else _unlike_self_affine(ds, model.shown)
    between = not measured and (bool(unlike) or model.rolloff < _POWER_LAW * model.shown)
    bodies, hardness = with_hardness(ds)
    resolved = smooth(bodies, shortest=model.shown)
    if between:
        resolved, shown = without_noise(bodies), _TWO_PIXELS * pixel
        if model.shown > own.shown * (1 + 1e-9):  # stated by the fit, as for a blunt tip
            shown = model.shown
            bodies, resolved = (smooth(each, shortest=shown) for each in (bodies, resolved))
        model = _real_surface_spectrum(resolved, shown)
    centres = regions.centres(ds, subregions)
    problem, adhesion = preload_problem(bodies, preload=preload)
    surface = Surface(resolved, problem, centres)
    question = Question(problem, adhesion, AddedRoughness(model, model.shown, model.shown))
    pilot = _pilot(surface, question, _PARTS_OF_REAL if between else _PARTS_OF_POWER_LAW, end, accuracy)
    question = question._replace(below=question.below._replace(shortest=pilot.wavelengths[-1]))
    variants = _variants(surface, question, pilot, hardness, with_spectrum=not unlike)
    missing, sides = [_missing(surface, question, pilot, -1, count)], None
    if between:
        bare = question._replace(below=question.below._replace(shortest=model.shown))
        missing += [_missing(surface, bare, pilot, 0, 1)]
        noisy = question.below._replace(spectrum=_real_surface_spectrum(bodies, model.shown))
        unsmoothed, changed = Surface(bodies, problem, centres), question._replace(below=noisy)
        variants += [("noise", -1, unsmoothed.case(changed, pilot.places, pilot.seeds, pilot.guesses[-1]))]
    solved = solve_cases([*missing, *(case for *_, case in variants)])  # at once, so that no core waits between them
    changes = _changes(variants, solved[len(missing) :], pilot)
    entries = _entries(changes, pilot, with_spectrum=not unlike)
    forces = _completed(centres, pilot, -1, missing[0], solved[0], count) * np.exp(-pilot.rest[0])
    if between:
        scanned, added = _completed(centres, pilot, 0, missing[1], solved[1], 1), _mean(forces, centres)
        noisy_mean = added * np.exp(changes["noise"][0])
        sides = _two_sides(_mean(scanned, centres), added, noisy_mean, unlike, entries.pop("spectrum", 0.0))
        forces = sides.estimate(scanned, forces)
    entries |= _scatter(forces, centres)
    given = preload, subregions, count, end
    return _result(ds, forces, entries, pilot, model, centres, hardness, sides, given)


def not_extrapolated(ds: xr.Dataset, why: str) -> xr.Dataset:
    """Return the result of `extrapolated` for a scan that cannot be extrapolated: no numbers, and the reason."""
    names = ("pull_off_mean", "pull_off_lower", "pull_off_upper", "shortest_wavelength")
    out = xr.Dataset({**dict.fromkeys(names, np.nan), "converged": False})
    out = out.assign_coords(schema.travelling(ds))
    known = f"Roughness finer than the pixel is not included: {why}."
    return schema.label(out.assign_attrs(known=known, assumed=""))


def resolved_spectrum(ds: xr.Dataset) -> xr.Dataset:
    """Return the spectrum of the wavelengths that a scan shows correctly, from four pixels unless it ends before."""
    fitted = self_affine_fit(ds)
    shown, pixel = float(fitted["shortest_wavelength"]), max(schema.pixel(ds))
    if not np.isfinite(shown) or shown >= _TRUE_PIXELS * pixel or _lacks_short_wavelengths(ds, fitted):
        return fitted
    return self_affine_fit(ds, shown=_TRUE_PIXELS * pixel)


def _lacks_short_wavelengths(ds: xr.Dataset, fitted: xr.Dataset) -> bool:
    """Return whether a scan has far less power below its shortest wavelength than its extrapolated spectrum."""
    shown, pixel = float(fitted["shortest_wavelength"]), max(schema.pixel(ds))
    if shown < 2.2 * pixel:
        return False
    rest = ds["height"] - smooth(ds, shortest=shown)["height"]
    inner = rest.isel(x=slice(4, -4), y=slice(4, -4))
    return float(inner.std()) < 0.3 * band_rms(known_spectrum(fitted).density, shown, 2 * pixel)


def with_hardness(ds: xr.Dataset) -> tuple[xr.Dataset, str]:
    """Return the scan with the hardness that is used, and a sentence on it."""
    if "hardness" in ds.coords:
        return ds, f"hardness {float(ds['hardness']):.3g} GPa as assigned"
    if "hardness_estimate" not in ds.coords:
        return ds, _NO_HARDNESS
    estimate = float(ds["hardness_estimate"])
    if estimate <= preload_problem(ds)[1].largest_tension:
        words = "the tension of liquid and solids" if schema.is_wet(ds) else "the adhesive tension w/ρ"
        return ds, f"the bodies stay elastic, since {words} exceeds the estimated hardness of {estimate:.3g} GPa"
    return ds.assign_coords(hardness=estimate), f"hardness {estimate:.3g} GPa, an estimate"


class _Sides(NamedTuple):
    """The mean pull-off without and with Gaussian roughness added, and the estimate between them."""

    scanned: float  # nN, without the scan's noise
    added: float  # nN, without the scan's noise
    noisy: float  # nN, with roughness added to the scan and its noise
    fall: float  # ln(scanned / estimate)
    margin: float  # of ln(truth) below the added roughness
    reason: str

    def estimate(self, scanned: np.ndarray, added: np.ndarray) -> np.ndarray:
        """Return the estimate of each surface (place, seed) from its pull-offs."""
        share = min(self.fall / max(np.log(self.scanned / self.added), 1e-9), 1.0)
        return scanned ** (1 - share) * added**share

    def widths(self) -> tuple[float, float]:
        """Return the half widths of the 95 % interval of ln(estimate), downwards and upwards."""
        lowest = min(self.added, self.noisy)
        return float(np.log(self.scanned / lowest)) - self.fall + self.margin, self.fall + _ABOVE_SCAN


def _two_sides(scanned: float, added: float, noisy: float, unlike: str, spectrum_error: float) -> _Sides:
    """Return the estimate from the means without and with added roughness, and with both it and the noise (nN)."""
    ratio = max(float(np.log(scanned / added)), 0.0)
    if unlike:
        fall = _LARGEST_FALL * (1 - np.exp(-ratio / (2 * _LARGEST_FALL)))
        return _Sides(scanned, added, noisy, fall, _BELOW_ADDED, f"nearer to the scan, which shows {unlike}")
    fall = 0.5 * max(float(np.log(scanned / min(added, noisy))), 0.0)
    margin = max(_BELOW_ADDED, 1.96 * spectrum_error)
    return _Sides(scanned, added, noisy, fall, margin, "since the scan shows no power law over two octaves")


def _unlike_self_affine(ds: xr.Dataset, shown: float) -> str:
    """Return the feature that no self-affine surface has, on the scan's pixels or on pixels twice as large, or ""."""
    words = unlike_self_affine(ds, shown)
    if words or min(ds["height"].shape) < _LEAST_COARSENED:
        return words
    coarse = ds.coarsen(x=2, y=2, boundary="trim").mean()
    return unlike_self_affine(coarse, max(shown, _TRUE_PIXELS * max(schema.pixel(coarse))))


def _real_surface_spectrum(ds: xr.Dataset, shown: float) -> Spectrum:
    """Return a spectrum below a wavelength (nm), the energy as of the octave above it, the slope of real surfaces."""
    heights, steps = ds["height"].values, schema.pixel(ds)
    parts = scan_parts(heights)
    assert parts is not None  # no pixel is missing
    q, psd, _ = rings(parts.squares, steps)
    wavelength = 2 * np.pi / q
    finest = (wavelength >= shown * (1 - 1e-9)) & (wavelength < 2 * shown)
    energy = float((q * psd * np.gradient(q))[finest].sum()) / (2 * np.pi)
    ends = 2 * np.pi / (shown * np.array([2.0, 1.0]))
    slope = 2 * REAL_HURST
    amplitude = 2 * np.pi * energy * slope / (ends[0] ** -slope - ends[1] ** -slope)
    rolloff = 1e4 * shown  # far beyond all wavelengths that are added
    plateau = amplitude * (rolloff / (2 * np.pi)) ** (2 + slope)
    return Spectrum(plateau, rolloff, REAL_HURST, shown, _REAL_ENERGY_ERROR, _REAL_HURST_ERROR)


class Surface:
    """The places of a scan, each with the heights around it."""

    def __init__(self, ds: xr.Dataset, problem: Problem, centres: xr.Dataset):
        if problem.depth_factor > 1:
            raise ValueError(
                "layer: expected one that does not bulge, found a nearly incompressible one; take adhesive"
            )
        self.depth = float(problem.steps[-1])
        reach = problem.indenter.half_width(self.depth) + 8 * problem.pixel
        windows, _ = regions.windows(ds, centres, reach)
        axes, heights = (ds["x"].values, ds["y"].values), ds["height"].values
        at = zip(windows, centres["subregion_x"].values, centres["subregion_y"].values)
        self.patches = [
            (
                heights[window.rows, window.columns],
                (float(axes[0][window.rows][0]), float(axes[1][window.columns][0])),
                problem.pixel,
                (float(x), float(y)),
            )
            for window, x, y in at
        ]

    def solve(self, question: Question, places, seeds: int, guess=None) -> np.ndarray:
        """Return pull-off, depth and number of cells (place, seed, 3); both of the former may be guessed."""
        return solve_cases([self.case(question, places, seeds, guess)])[0].reshape(len(places), seeds, 3)

    def case(self, question: Question, places, seeds: int, guess) -> Case:
        """Return the case of a question at some places on some random surfaces."""
        return Case(self, question, [(int(place), seed) for place in places for seed in range(seeds)], guess)


class Case(NamedTuple):
    """A question on some surfaces, pairs of place and seed, with a guess of depth and pull-off if there is any."""

    surface: Surface
    question: Question
    pairs: list[tuple[int, int]]
    guess: tuple[float, float] | None

    def tasks(self, depth_factor: float) -> list[tuple]:
        """Return the tasks of the pairs, the guess of the depth multiplied by a factor."""
        depth, pull = self.guess or (self.surface.depth, 0.0)
        return [
            (*self.surface.patches[place], seed, depth_factor * depth, pull, *self.question)
            for place, seed in self.pairs
        ]


def solve_cases(cases: list[Case]) -> list[np.ndarray]:
    """Return pull-off, depth and number of cells (pair, 3) of each case, all solved in one batch.

    A solve that fails is tried once more from another guess; NaN where this fails, too.
    """
    tasks = [task for case in cases for task in case.tasks(1.0)]
    pulls = np.array(spread.task_results(extrapolated_pull_off, tasks, (3,), name="extrapolated")).reshape(-1, 3)
    if (failed := np.flatnonzero(np.isnan(pulls[:, 0]))).size:
        deeper = [task for case in cases for task in case.tasks(2.0)]
        again = [deeper[k] for k in failed]
        pulls[failed] = spread.task_results(extrapolated_pull_off, again, (3,), name="extrapolated")
    return np.split(pulls, np.cumsum([len(case.pairs) for case in cases])[:-1])


def next_guess(pulls: np.ndarray, before: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return the depth (nm) and pull-off (nN) to expect of rougher surfaces."""
    if not np.isfinite(pulls).any():
        return before
    return 1.3 * float(np.nanmax(pulls[..., 1])) + 0.05, float(np.nanmean(pulls[..., 0]))


class _Pilot(NamedTuple):
    """The pull-offs at a few places as wavelengths are added."""

    places: np.ndarray
    wavelengths: list[float]  # nm, falling
    pulls: list[np.ndarray]  # nN, (place, seed) at each
    guesses: list[tuple[float, float] | None]  # depth (nm) and pull-off (nN) at each
    parts: int  # of an octave, from one wavelength to the next
    converged: bool
    change: float  # of ln(mean) by the last octave, where shorter wavelengths may follow
    rest: tuple[float, float] = (0.0, 0.0)  # fall of ln(mean) by octaves that would take too long, and its error

    @property
    def seeds(self) -> int:
        """The number of random surfaces at each place."""
        return self.pulls[-1].shape[1]

    @property
    def means(self) -> np.ndarray:
        """The mean pull-off at each wavelength, nN."""
        return _means(self.pulls)


def _pilot(surface: Surface, question: Question, parts: int, end, accuracy: float) -> _Pilot:
    """Add parts of an octave, one after the other, until the mean pull-off settles."""
    count = len(surface.patches)
    places = np.unique(np.linspace(0, count - 1, min(count, _PILOT_PLACES)).round().astype(int))
    seeds, below = max(1, -(-_PILOT_PLACES // places.size)), question.below
    model, length = below.spectrum, question.adhesion.main_range
    wavelengths, forces, converged = [below.longest], [], False
    guesses: list[tuple[float, float] | None] = [None]
    costly = False
    smallest = _SHORTEST_WAVELENGTH if end is None else min(end, below.longest)
    while True:
        shorter = question._replace(below=below._replace(shortest=wavelengths[-1]))
        pulls = surface.solve(shorter, places, seeds, guesses[-1])
        forces.append(pulls[..., 0])
        guesses.append(next_guess(pulls, guesses[-1]))
        if end is None:
            low = band_rms(model.density, wavelengths[-1], wavelengths[-1] / 2) < _NEGLIGIBLE_RMS * length
            converged = low or _has_converged(_means(forces), parts, accuracy)
            costly = len(forces) > parts and bool(np.nanmean(pulls[..., 2]) > _MOST_CELLS)
        if converged or costly or wavelengths[-1] <= smallest * (1 + 1e-9):
            break
        wavelengths.append(max(wavelengths[-1] * 0.5 ** (1 / parts), smallest))
    last = _means(forces)[-parts - 1 :]
    change = abs(np.log(last[-1] / last[0])) if end is None and len(last) > parts else 0.0
    rest = (0.0, 0.0)
    if costly and not converged:
        rest = _rest(max(np.log(last[0] / last[-1]), 0.0), model.hurst, np.log2(wavelengths[-1] / smallest))
    return _Pilot(places, wavelengths, forces, guesses[1:], parts, converged or end is not None, change, rest)


def _rest(change: float, hurst: float, octaves: float) -> tuple[float, float]:
    """Return the fall of ln(mean) by octaves that follow one that changed it, and its standard deviation.

    Octave by octave the fall decreases at least as the amplitude of the roughness, and at most as its energy.
    """
    ratios = 2.0 ** (-max(hurst, 0.3) * np.array([1, 2]))
    by_amplitude, by_energy = change * ratios * (1 - ratios**octaves) / (1 - ratios)
    return 0.5 * (by_amplitude + by_energy), 0.5 * (by_amplitude - by_energy)


def _missing(surface: Surface, question: Question, pilot: _Pilot, at: int, seeds: int) -> Case:
    """Return the case of all places that the pilot did not solve at a wavelength."""
    left = np.ones((len(surface.patches), seeds))
    left[pilot.places, : pilot.seeds] = 0.0
    return Case(surface, question, [(int(place), int(seed)) for place, seed in np.argwhere(left)], pilot.guesses[at])


def _completed(
    centres: xr.Dataset, pilot: _Pilot, at: int, missing: Case, solved: np.ndarray, seeds: int
) -> np.ndarray:
    """Return the pull-offs (place, seed) of all places at a wavelength of the pilot, with those that it lacked."""
    out = np.full((centres.sizes["subregion"], seeds), np.nan)
    out[pilot.places, : pilot.seeds] = pilot.pulls[at][:, :seeds]
    for pair, (pull, *_) in zip(missing.pairs, solved):
        out[pair] = pull
    return out


def _means(pulls: list[np.ndarray]) -> np.ndarray:
    """Return the mean of each array over the surfaces that are solved in all of them."""
    stacked = np.stack(pulls)
    solved = np.isfinite(stacked).all(axis=0)
    return stacked[:, solved].mean(axis=1) if solved.any() else np.full(len(pulls), np.nan)


def _has_converged(means: np.ndarray, parts: int, accuracy: float) -> bool:
    """Return whether neither the last octave nor its parts changed the mean by more than the accuracy."""
    return len(means) > parts + 1 and bool(np.ptp(np.log(means[-parts - 1 :])) < accuracy)


def _variants(
    surface: Surface, question: Question, pilot: _Pilot, hardness: str, *, with_spectrum: bool
) -> list[tuple[str, int, Case]]:
    """Return a case for each assumption, at the pilot's places, with its name and the pilot's entry to compare with.

    Those of the law and the bodies are solved an octave before the last wavelength, where a place takes a fifth of the
    time; that of the spectrum at the last, to which its error grows.
    """
    before = max(len(pilot.wavelengths) - 1 - pilot.parts, 0)
    problem, adhesion, below = question
    coarser = question._replace(below=below._replace(shortest=pilot.wavelengths[before]))
    longer = adhesion._replace(length=adhesion.length * _RANGE_FACTOR)  # a shorter range needs finer cells
    questions = [("range of adhesion", before, coarser._replace(adhesion=longer))]
    if with_spectrum:
        tilted = [below._replace(spectrum=below.spectrum._replace(tilt=tilt)) for tilt in (-1.0, 1.0)]
        questions += [("spectrum", -1, question._replace(below=each)) for each in tilted]
    if problem.yielding:
        harder = problem.hardness * (_ESTIMATE_FACTOR if "estimate" in hardness else _HARDNESS_FACTOR)
        questions += [("hardness", before, coarser._replace(problem=problem._replace(hardness=harder)))]
    return [
        (name, at, surface.case(changed, pilot.places, pilot.seeds, pilot.guesses[at]))
        for name, at, changed in questions
    ]


def _changes(variants: list[tuple[str, int, Case]], solved: list[np.ndarray], pilot: _Pilot) -> dict[str, list[float]]:
    """Return the changes of ln(mean) by each assumption, on the surfaces of the pilot."""
    changes: dict[str, list[float]] = {name: [] for name, *_ in variants}
    for (name, at, _), pulls in zip(variants, solved):
        before = pilot.pulls[at]
        changes[name].append(float(np.diff(np.log(_means([before, pulls[:, 0].reshape(before.shape)])))[0]))
    return changes


def _entries(changes: dict[str, list[float]], pilot: _Pilot, *, with_spectrum: bool) -> dict[str, float]:
    """Return the standard deviations of ln(mean) by the assumptions."""
    out = {name: float(np.sqrt(np.mean(np.square(some)))) for name, some in changes.items() if name != "noise"}
    if with_spectrum or pilot.rest[0]:
        out["finer roughness"] = pilot.rest[1] or 0.5 * pilot.change
    return out


def _mean(forces: np.ndarray, centres: xr.Dataset) -> float:
    """Return the mean over places and surfaces, by the shares of particles at the places where there are any."""
    labelled = xr.DataArray(forces, centres.coords, ("subregion", "seed"))
    return float(by_share(labelled).mean())


def _scatter(forces: np.ndarray, centres: xr.Dataset) -> dict[str, float]:
    """Return the standard deviations of ln(mean) by the choice of places and of surfaces."""
    labelled = xr.DataArray(forces, centres.coords, ("subregion", "seed"), name="pull_off_force")
    means, mean = labelled.mean("seed").to_dataset(), _mean(forces, centres)
    count, seeds, sampling = int(means["pull_off_force"].count()), forces.shape[1], np.nan
    if count > 1:
        sample = means if count >= _FEWEST_CORRELATED else means.drop_vars(["subregion_x", "subregion_y"])
        interval = bootstrap(sample, "pull_off_force", statistics=["mean"], fewest=0).isel(statistic=0)
        sampling = float(np.log(interval["high"] / interval["low"])) / (2 * 1.96)
    within = labelled.var("seed", ddof=1).mean() if seeds > 1 else labelled.var()
    return {"places": sampling, "seeds": float(np.sqrt(within * (1 + 1 / seeds) / max(count, 1)) / mean)}


def _result(ds, forces, entries, pilot: _Pilot, model, centres, hardness, sides: _Sides | None, given) -> xr.Dataset:
    preload, subregions, seeds, end = given
    mean, (below, above) = _mean(forces, centres), _spreads(entries, pilot, sides)
    if sides is not None:
        entries = entries | {"spectrum": 0.5 * sum(sides.widths()) / 1.96}
    added = band_rms(model.density, model.shown, pilot.wavelengths[-1])
    out = xr.Dataset(
        {
            "pull_off_force": (("subregion", "seed"), forces),
            "pull_off_mean": mean,
            "pull_off_lower": mean * np.exp(-below),
            "pull_off_upper": mean * np.exp(above),
            "shortest_wavelength": pilot.wavelengths[-1],
            "converged": pilot.converged,
            "added_rms": added,
            "failed_solves": int(np.isnan(forces).sum()),
            "relative_error": ("entry", list(entries.values())),
            "scale_pull_off": ("shortest_kept", pilot.means),
        },
        {
            "entry": list(entries),
            "shortest_kept": pilot.wavelengths,
            "seed": np.arange(forces.shape[1]),
            **centres.coords,
        },
    )
    out = out.assign_coords(schema.travelling(ds))
    pixels = model.shown / max(schema.pixel(ds))
    known = f"The scan resolves wavelengths of {model.shown:.3g} nm ({pixels:.2g} pixels) and longer."
    if model.measured is not None:
        last = 2 * np.pi * float(np.exp(-model.measured[0][-1]))
        known += f" Other measurements of the surface give its spectrum down to {last:.3g} nm."
    if failed := int(np.isnan(forces).sum()):
        known += f" {failed} of {forces.size} solves failed, also from another guess, and are not in the mean."
    goes_on = f"its spectrum is extrapolated (Hurst exponent {model.hurst:.2g} ± {model.hurst_error:.2g}) "
    assumed = f"Below, {goes_on}down to {pilot.wavelengths[-1]:.2g} nm{_stop_reason(pilot, end)}; {hardness}."
    if sides is not None:
        last = pilot.wavelengths[-1]
        assumed = (
            f"Below, roughness with the slope of real surfaces (Hurst exponent {model.hurst:.2g}) was added down to "
            f"{last:.2g} nm{_stop_reason(pilot, end)}: {sides.added:.3g} nN, and {sides.scanned:.3g} nN without. "
            f"The estimate lies between both, {sides.reason}; {hardness}."
        )
    out.attrs = {"known": known, "assumed": assumed, "longest_added": model.shown}
    arguments = {"preload": preload, "subregions": subregions, "seeds": seeds, "shortest": end}
    return schema.record(schema.label(out), "extrapolated", ds, **arguments)


def _spreads(entries: dict[str, float], pilot: _Pilot, sides: _Sides | None) -> tuple[float, float]:
    """Return the half widths of the interval of ln(mean), downwards and upwards: at most to the mean as scanned."""
    spread = {name: 1.96 * value for name, value in entries.items() if np.isfinite(value)}
    if sides is not None:
        rest = float(np.hypot.reduce(list(spread.values())))
        below, above = sides.widths()
        return float(np.hypot(below, rest)), float(np.hypot(above, rest))
    below = float(np.hypot.reduce(list(spread.values())))
    if (took := float(np.log(pilot.means[0] / pilot.means[-1])) + pilot.rest[0]) > 0:
        spread |= {"spectrum": min(spread["spectrum"], took), "finer roughness": 1.96 * pilot.rest[1]}
    return below, float(np.hypot.reduce(list(spread.values())))


def _stop_reason(pilot: _Pilot, end: float | None) -> str:
    """Return why no shorter wavelengths were added."""
    if end is not None:
        return ", as requested"
    if pilot.rest[0]:
        factor = f"a factor of {np.exp(-pilot.rest[0]):.2f}"
        return f" (finer roughness would take too long; its effect, {factor}, follows from the last octave's)"
    return ", below which roughness has no effect" if pilot.converged else ", where continuum theory ends"
