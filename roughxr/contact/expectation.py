"""What a sum of asperities may be expected to be worth beside the adhesive simulation of the same places.

``tests/benchmarks/superposition_regime.py`` measured it: self-affine surfaces of Hurst exponents 0.4 and 0.8, two
roll-offs, two cutoffs and two rms heights (slopes of 0.03 to 0.3), each under two spheres with two works of adhesion.
With the patch that suits the scan, superposed over direct pull-off, each the mean over four places, lies from `LOW` to
`HIGH` for nine surfaces of ten; neither slope, spacing, overlap nor Tabor's parameter tells in advance where. The least
stand where the sphere, nearly on one contact, holds almost what it does on a flat. A patch wider than `WIDEST` of the
shortest wave adds a factor that grows with it, to some forty on three waves.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import xarray as xr

from .. import schema
from ..catalogue import RESOLVED

#: Superposed over direct pull-off: the middle, and what one surface of twenty falls below, and one exceeds.
RATIO, LOW, HIGH = 0.83, 0.5, 1.4

#: Patch over shortest wave that a fitted patch has at most.
WIDEST = 0.8


def expectation(catalogue: xr.Dataset, law: str) -> dict[str, Any]:
    """Return what to expect of the pull-off from these asperities, as attributes of the sum.

    Parameters
    ----------
    catalogue : Dataset
        Asperities.
    law : str
        The kernel's: the rule was measured with "energy".

    Returns
    -------
    dict
        ``expectation``, a sentence; with it ``expected_ratio``, ``expected_ratio_low`` and ``expected_ratio_high`` of
        superposed over direct pull-off where they are known.
    """
    unknown = _unknown(catalogue, law)
    if unknown:
        return {"expectation": f"not known how near this comes to an adhesive simulation: {unknown}"}
    words = f"pull-off over that of the adhesive simulation on such a surface: {RATIO:.2g}, {LOW:g} … {HIGH:g}"
    known = {"expected_ratio": RATIO, "expected_ratio_low": LOW, "expected_ratio_high": HIGH}
    return {"expectation": f"{words} in nine of ten", **known}


def _unknown(catalogue: xr.Dataset, law: str) -> str:
    """Return why nothing is known, empty where something is."""
    if law not in ("energy", "self_similar", "johnson_greenwood"):
        return f"measured for law='jkr' with adhesion corrected, not for {law!r}"
    if "shortest_wavelength" not in catalogue.coords:
        return "the patch was chosen without regard to the scan's shortest wave; take patch='auto'"
    wave, pixel = float(catalogue["shortest_wavelength"]), float(catalogue["pixel"])
    if not wave >= RESOLVED * pixel:
        return f"the scan does not resolve its summits, whose shortest wave spans {wave / pixel:.2g} pixels"
    return ""


def warn_above_smooth(force: np.ndarray, catalogue: xr.Dataset, law: str) -> None:
    """Warn of pulls (nN, positive) that exceed the same sphere's from a smooth flat, and of what makes them."""
    radius, work = schema.pair(catalogue, "sphere_radius", "work_of_adhesion")
    factor = 2.0 if law == "maugis" else 1.5
    smooth = factor * np.pi * work * radius
    above = np.asarray(force) > smooth
    if smooth > 0 and above.any():
        warnings.warn(
            f"{int(above.sum())} of {above.size} superposed pull-offs exceed what the sphere holds on a smooth flat "
            f"(largest {np.nanmax(force) / smooth:.2g} times {factor:g} πwR = {smooth:.4g} nN): {_excess(catalogue)}",
            stacklevel=3,
        )


def _excess(catalogue: xr.Dataset) -> str:
    width = 2 * float(catalogue["patch_radius"])
    wave = float(catalogue.coords.get("shortest_wavelength", np.nan))
    if width > WIDEST * wave:
        return f"a patch of {width:.3g} nm is too wide for waves of {wave:.3g} nm; take patch='auto'"
    if np.isnan(wave):
        return f"a patch of {width:.3g} nm may be too wide for this surface; take patch='auto'"
    return "contacts that overlap are each counted as if whole; take `adhesive`"
