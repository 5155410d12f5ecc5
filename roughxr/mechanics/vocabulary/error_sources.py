"""The sources of error of a pull-off: one table for the error budget, the best estimate, the answer and the pages."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: Keys of the sources that are no change of an assumption: the choice of places, in the best estimate and in the
#: budget; the roughness that the scan does not show; the energy that the law of thin menisci neglects; how hard the
#: sphere was pressed, where a pull-off is a range.
PLACES = "places"
SAMPLING = "sampling"
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

#: What gives the effect of unseen roughness, in words.
ONE_SCAN = "surfaces"
SECOND_SCAN = "second scan"
MEASURED = "measured"
UNSEEN_WORDS = {
    ONE_SCAN: "as on 19 of 20 measured surfaces",
    SECOND_SCAN: "by a second scan",
    MEASURED: "by measured pull-offs",
}

#: Half width of a normal 95 % interval, in standard deviations.
HALF_WIDTH = 1.96

#: Radius (nm) of the tip whose effect is removed.
TIP_RADIUS = 10.0


class ErrorSource(NamedTuple):
    """A source of error: what narrows the interval, and the change of its assumption by one standard deviation."""

    remedy: str  # empty if nothing narrows it
    settings: tuple = ()  # changes by about one standard deviation; empty if the error is no change of an assumption
    words: str = ""  # of a change
    is_ratio: bool = False  # the setting multiplies a parameter, so that the pull-off has a slope with it
    is_of_scan: bool = False  # of the surface and its simulation; else of the pair of bodies
    label: str = ""  # in a sentence, where the key is not


#: By key, with the uncertainties of a careful experiment. The range is only increased: a shorter one would need finer
#: cells and eight times the time. Modulus and radius are changed in one direction only, which saves a sixth of the time
#: without a change of the result.
ERROR_SOURCES = {
    MESH: ErrorSource("a finer mesh", (2,), "cells and steps smaller by a factor of {}", is_of_scan=True),
    "preload": ErrorSource("a measured preload", (0.1,), "preload {}", is_of_scan=True),
    "levelling": ErrorSource(
        "a larger scan, whose background is known", ("quadratic",), "another levelling: {}", is_of_scan=True
    ),
    "interpolation": ErrorSource(
        "a scan with finer pixels", ("splines",), "heights between pixels interpolated by {}", is_of_scan=True
    ),
    "tip radius": ErrorSource(
        "a sharper tip", (TIP_RADIUS,), "effect of a tip of {} radius removed from the scan", is_of_scan=True
    ),
    "noise": ErrorSource(
        "less noise, by several scans or a slower one",
        (1.0,),
        "noise of {} added, as much as neighbouring lines allow",
        is_of_scan=True,
    ),
    RANGE: ErrorSource("a known adhesion range of this pair", (4 / 3,), "range of adhesion {}", True),
    "work of adhesion": ErrorSource(
        "a measured work of adhesion of this pair, for example by pull-off forces",
        (0.8, 1.2),
        "work of adhesion {}",
        True,
    ),
    "modulus": ErrorSource("a measured modulus of the softer body", (1.1,), "contact modulus {}", True),
    "layer thickness": ErrorSource("a measured thickness of the layer", (0.9, 1.1), "layer thickness {}", True),
    "sphere radius": ErrorSource("a measured radius of the sphere", (1.05,), "radius {}", True),
    "hardness": ErrorSource("a measured hardness of the softer body", (0.75, 1.25), "hardness {}", True),
    "humidity": ErrorSource("a measured humidity", (-0.05, 0.05), "humidity {}"),
    "contact angle": ErrorSource("measured contact angles", (-5.0, 5.0), "contact angles {}"),
    PRESSING: ErrorSource("a stated preload", is_of_scan=True),
    PLACES: ErrorSource("more places, or a larger scan"),
    THIN: ErrorSource(""),
    SAMPLING: ErrorSource("more places, or a larger scan", label="choice of places"),
    UNSEEN: ErrorSource("a second scan{width} on pixels of {pixels}"),
    SECOND_SCAN_NOISE: ErrorSource("a second scan with less noise", is_of_scan=True),
}

#: Standard deviation of the range of adhesion, as a factor, of van der Waals attraction and of an assigned range.
KNOWN_RANGE = 1.25

#: The same where the work of adhesion alone is assigned.
UNKNOWN_RANGE = 2.0

#: The sources that a budget computes by a change.
CHANGED = tuple(name for name, source in ERROR_SOURCES.items() if source.settings)


class KnownError(NamedTuple):
    """Distances of ln(mean) from the ends of its 95 % interval, by one error or by several."""

    below: float
    above: float

    @property
    def std(self) -> float:
        """The standard deviation of ln(mean), if both ends were equally far."""
        return (self.below + self.above) / (2 * HALF_WIDTH)


def symmetric_error(deviation: float) -> KnownError:
    """Return the error of a standard deviation of ln(mean)."""
    return KnownError(HALF_WIDTH * deviation, HALF_WIDTH * deviation)


def total_error(*errors: KnownError) -> KnownError:
    """Return the error by several independent ones."""
    return KnownError(*np.hypot.reduce(errors).tolist())


def total_std(deviations: Any) -> float:
    """Return the standard deviation by several independent ones; unknown ones are left out."""
    return float(np.hypot.reduce(np.nan_to_num(deviations)))
