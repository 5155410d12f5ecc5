"""The sources of error of a pull-off: one table for the error budget, the best estimate, the answer and the pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

#: Keys of the sources that are no change of an assumption: the choice of places; the roughness that the scan does not
#: show; the energy that the law of thin menisci neglects; how hard the sphere was pressed, where a pull-off is a range.
PLACES = "places"
UNSEEN = "unseen roughness"
SECOND_SCAN_NOISE = "noise of the second scan"
THIN = "thin menisci"

MESH = "mesh"
PRESSING = "pressing"
RANGE = "range of adhesion"

#: Pixel (nm) of a second scan that is advised, largest part of the first scan's pixel, and least width in pixels of the
#: first scan.
SECOND_SCAN_PIXEL = 2.0
SECOND_SCAN_PART = 0.5
SECOND_SCAN_WIDTH = 10

#: What gives the effect of unseen roughness.
ONE_SCAN = "surfaces"
SECOND_SCAN = "second scan"
MEASURED = "measured"

#: Half width of a normal 95 % interval, in standard deviations.
HALF_WIDTH = 1.96

#: Radius (nm) of the tip whose effect is removed.
TIP_RADIUS = 10.0


class ErrorSource(NamedTuple):
    """A source of error, and the change of its assumption by one standard deviation."""

    settings: tuple = ()  # changes by about one standard deviation; empty if the error is no change of an assumption
    is_ratio: bool = False  # the setting multiplies a parameter, so that the pull-off has a slope with it
    is_of_scan: bool = False  # of the surface and its simulation; else of the pair of bodies


#: By key, with the uncertainties of a careful experiment. The range is only increased: a shorter one would need finer
#: cells and eight times the time. Modulus and radius are changed in one direction only, which saves a sixth of the time
#: without a change of the result.
ERROR_SOURCES = {
    MESH: ErrorSource((2,), is_of_scan=True),
    "preload": ErrorSource((0.1,), is_of_scan=True),
    "levelling": ErrorSource(("quadratic",), is_of_scan=True),
    "interpolation": ErrorSource(("splines",), is_of_scan=True),
    "tip radius": ErrorSource((TIP_RADIUS,), is_of_scan=True),
    "noise": ErrorSource((1.0,), is_of_scan=True),
    RANGE: ErrorSource((4 / 3,), is_ratio=True),
    "work of adhesion": ErrorSource((0.8, 1.2), is_ratio=True),
    "modulus": ErrorSource((1.1,), is_ratio=True),
    "layer thickness": ErrorSource((0.9, 1.1), is_ratio=True),
    "sphere radius": ErrorSource((1.05,), is_ratio=True),
    "hardness": ErrorSource((0.75, 1.25), is_ratio=True),
    "humidity": ErrorSource((-0.05, 0.05)),
    "contact angle": ErrorSource((-5.0, 5.0)),
    PRESSING: ErrorSource(is_of_scan=True),
    PLACES: ErrorSource(),
    THIN: ErrorSource(),
    UNSEEN: ErrorSource(),
    SECOND_SCAN_NOISE: ErrorSource(is_of_scan=True),
}

#: Standard deviation of the range of adhesion, as a factor, of van der Waals attraction and of an assigned range.
KNOWN_RANGE = 1.25

#: The same where the work of adhesion alone is assigned.
UNKNOWN_RANGE = 2.0

#: The sources that a budget computes by a change.
CHANGED = tuple(name for name, source in ERROR_SOURCES.items() if source.settings)


class KnownError(NamedTuple):
    """An error of the mean pull-off by one source, or by several, and from what it was computed.

    The fields from the third on are the variables of an error budget along ``entry``, under the same names.
    """

    below: float = np.nan  # standard deviation of ln(mean) towards smaller values
    above: float = np.nan  # and towards larger ones
    standard_error: float = np.nan  # of the standard deviation
    pull_off_change: float = np.nan  # relative, with its sign
    slope: float = np.nan  # d ln(mean) / d ln(parameter)
    known_bias: bool = False  # the change is subtracted from the mean
    places: int = 0  # at which the change is known
    tried_places: int = 0
    setting: str = ""  # of the change, a number as text or a key
    reason: str = ""  # of an error that is not known

    @property
    def std(self) -> float:
        """The mean of both standard deviations."""
        return (self.below + self.above) / 2

    def interval(self, mean: float) -> tuple[float, float]:
        """Return the ends of the 95 % interval of a mean with this error."""
        return mean * float(np.exp(-HALF_WIDTH * self.below)), mean * float(np.exp(HALF_WIDTH * self.above))


#: The fields of an error that are variables.
_VARIABLES = KnownError._fields[2:]


def symmetric_error(std: float, **basis) -> KnownError:
    """Return the error of a standard deviation of ln(mean)."""
    return KnownError(std, std, **basis)


def error_of_interval(mean: float, low: float, high: float) -> KnownError:
    """Return the error of a mean with a 95 % interval."""
    return KnownError(-float(np.log(low / mean)) / HALF_WIDTH, float(np.log(high / mean)) / HALF_WIDTH)


def total_error(errors: Iterable[KnownError]) -> KnownError:
    """Return the error by several independent sources; unknown errors are left out."""
    known = [error for error in errors if not np.isnan(error.std)]
    if not known:
        return KnownError()
    below, above = np.hypot.reduce([(error.below, error.above) for error in known]).tolist()
    std, standard_error = np.array([(error.std, error.standard_error) for error in known]).T
    # the square of a normal number of mean m and deviation s has the variance 4 m² s² + 2 s⁴
    spread = np.sqrt(((std**2 + 0.5 * standard_error**2) * standard_error**2).sum())
    return KnownError(below, above, float(spread) / max((below + above) / 2, 1e-300))


def total_bias(errors: Iterable[KnownError]) -> float:
    """Return the relative change of the mean by all known biases."""
    return float(np.prod([1 + error.pull_off_change for error in errors if error.known_bias])) - 1


def error_table(errors: Mapping[str, KnownError]) -> xr.Dataset:
    """Return errors by their sources as variables along ``entry``."""
    columns = {"relative_std": [error.std for error in errors.values()]}
    columns |= {name: [getattr(error, name) for error in errors.values()] for name in _VARIABLES}
    variables = {name: ("entry", values, {"units": "1"}) for name, values in columns.items()}
    return xr.Dataset(variables, {"entry": list(errors)})


def read_errors(ds: xr.Dataset) -> dict[str, KnownError]:
    """Return the errors of a result of `error_budget` or `extrapolated` by their sources, both sides equal."""
    names = [name for name in _VARIABLES if name in ds]
    rows = zip(ds["entry"].values, ds["relative_std"].values, *(ds[name].values for name in names))
    return {str(entry): symmetric_error(std, **dict(zip(names, row))) for entry, std, *row in rows}
