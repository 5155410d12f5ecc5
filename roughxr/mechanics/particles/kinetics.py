"""Rock'n'Roll, quasi-static: the rate at which particles leave a wall in turbulence (Reeks & Hall 2001).

A particle rocks under a force of mean F and rms f F, f = 0.366, against an adhesion f_a at the same lever. With
x = (f_a − F)/(f F) it leaves at the rate

    p = (0.0413/2π) (u*²/ν) exp(−x²/2)/Φ(x),   at most 0.0413 u*²/(2πν),

where Φ is the cumulative normal distribution. Only the ratio of F and f_a matters.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantities, Quantity, factor, magnitude, positive
from .loads import FLOWS, Flow, lift, read_flow

#: rms of the removal force over its mean.
FLUCTUATION = 0.366

#: Frequency of the wall flow in units of u*²/ν.
FREQUENCY = 0.0413


def biasi_adhesion(radius: Quantity) -> tuple[np.ndarray, np.ndarray]:
    """Return the adhesion over that of a smooth contact, 3/2 π w r, by the fit of Biasi et al. to experiments.

    Parameters
    ----------
    radius : number or quantity
        nm.

    Returns
    -------
    tuple of two arrays
        Values, out to 8 standard deviations, and weights of a log-normal law of mean 0.016 − 0.0023 r^0.545
        and spread 1.8 + 0.136 r^1.4 (both geometric, r in µm).

    References
    ----------
    Biasi et al., J. Aerosol Sci. 32 (2001) 1175.

    Examples
    --------
    >>> import roughxr
    >>> values, weights = roughxr.particles.biasi_adhesion("5 um")
    >>> round(float(values[1000]), 7), round(float(weights.sum()), 6)
    (0.0104707, 1.0)
    """
    r = positive(radius, "nm", "radius") * factor("nm", "um")
    # largest radius, µm, for which the mean of Biasi's fit is positive
    largest_radius = (0.016 / 0.0023) ** (1 / 0.545)
    if r >= largest_radius:
        raise Refusal("radius", f"less than {largest_radius:.0f} µm for Biasi's fit", f"{r:g} µm")
    # logarithms of values, in standard deviations
    z = np.linspace(-8.0, 8.0, 2001)
    weights = np.exp(-0.5 * z * z)
    return (0.016 - 0.0023 * r**0.545) * (1.8 + 0.136 * r**1.4) ** z, weights / weights.sum()


def rock_n_roll(
    friction_velocity: Quantities,
    *,
    radius: Quantity,
    adhesion: Quantities,
    weights: ArrayLike | None = None,
    time: Quantities = 1.0,
    flow: str | Flow = "air",
) -> np.ndarray:
    """Return the fraction (friction_velocity, time) of particles that remain, by the original model of Reeks & Hall.

    Drag 32 ρ u*² r², Hall's lift, and a lever of r/100: F = F_L/2 + 100 F_D.

    Parameters
    ----------
    radius : number or quantity
        nm.
    adhesion, weights : array_like
        Samples of the pull-off force, nN, and their weights: computed ones, or `biasi_adhesion` times 3/2 π w r.
    friction_velocity, time, flow
        As in `resuspension`.

    Returns
    -------
    array

    References
    ----------
    Reeks & Hall, J. Aerosol Sci. 32 (2001) 1, doi:10.1016/S0021-8502(00)00063-X.

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> values, weights = roughxr.particles.biasi_adhesion("5 um")
    >>> adhesion = values * 1.5 * np.pi * 0.56 * 5000
    >>> left = roughxr.particles.rock_n_roll([1.0], radius="5 um", adhesion=adhesion, weights=weights)
    >>> round(float(left[0, 0]), 5)
    0.34026
    """
    speed = not_negative(friction_velocity, "m/s", "friction_velocity")
    seconds = not_negative(time, "s", "time")
    r = positive(radius, "nm", "radius")
    forces = np.atleast_1d(magnitude(adhesion, "nN", "adhesion"))
    fluid = read_flow(flow)
    pressure = fluid.density * speed**2 * factor("Pa", "GPa")
    # drag of Reeks & Hall over ρ u*² r², and lever of their model, r/a
    force = 0.5 * lift(speed, r, fluid._replace(lift="hall")) + 100.0 * 32.0 * pressure * r**2
    shares = None if weights is None else np.asarray(weights)
    return np.average(survival(force[:, None] / forces, speed, seconds, fluid), axis=1, weights=shares)


def not_negative(values: Any, units: str, name: str) -> np.ndarray:
    """Return ascending values that are not negative."""
    array = schema.ascending(values, units, name)
    if array[0] < 0:
        raise Refusal(name, "values that are not negative", f"{array[0]:g} {units}")
    return array


def survival(ratio: np.ndarray, speed: np.ndarray, seconds: np.ndarray, flow: Flow) -> np.ndarray:
    """Return the probability (speed, sample, time) that each sample remains, from its ratio F/f_a (speed, sample)."""
    return np.exp(-resuspension_rate(ratio, speed[:, None], flow)[..., None] * seconds)


def resuspension_rate(ratio: Any, speed: Any, flow: Flow = FLOWS["air"]) -> Any:
    """Return the rate p (1/s) from the ratio F/f_a (inf without resistance) and the friction velocity (m/s)."""
    from scipy.special import log_ndtr

    with np.errstate(divide="ignore"):
        x = np.minimum((1 / np.asarray(ratio, float) - 1) / FLUCTUATION, 1e6)
    largest_rate = FREQUENCY * speed**2 / (2 * np.pi * flow.viscosity)
    return largest_rate * np.exp(np.minimum(-0.5 * x * x - log_ndtr(x), 0.0))
