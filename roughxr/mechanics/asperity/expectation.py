"""The expected ratio of the superposed pull-off to that of the adhesive simulation at the same places.

Measured by ``tests/benchmarks/superposition_regime.py`` on self-affine surfaces (Hurst exponents 0.4 and 0.8, slopes of
0.03 to 0.3), each under two spheres with two works of adhesion, with patch="auto": the ratio was between `LOW` and
`HIGH` in 155 of 160 means over four places, and at 438 of 480 single places (at 153 of the 160 that were drawn after
the limits had been set). Slope, spacing, overlap and Tabor's parameter do not predict it within this range. A patch
wider than 0.8 of the shortest wavelength increases the ratio further, and so does debris.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from ..vocabulary.text import warn
from .catalogue import RESOLVED, DoubtfulAsperities

#: Superposed pull-off over that of the simulation, median of places.
RATIO = 0.8

#: Lower end of that ratio at nine of ten places.
LOW = 0.3

#: Upper end of that ratio at nine of ten places.
HIGH = 1.4


def expectation(catalogue: xr.Dataset, law: str) -> dict[str, float | str]:
    """Return, as attributes, the expected pull-off from these asperities over that of `adhesive`, or why it is unknown.

    ``unknown_by`` is "law", of which ``formulas`` is the kernel's name, "patch" or "pixels", of which the shortest
    wavelength has ``wavelength_pixels``.
    """
    if law not in ("energy", "self_similar"):
        return {"unknown_by": "law", "formulas": law}
    if "shortest_wavelength" not in catalogue.coords:
        return {"unknown_by": "patch"}
    if not (pixels := float(catalogue["shortest_wavelength"] / catalogue["pixel"])) >= RESOLVED:
        return {"unknown_by": "pixels", "wavelength_pixels": pixels}
    return {"expected_ratio": RATIO, "expected_low": LOW, "expected_high": HIGH}


def warn_above_smooth(force: np.ndarray, catalogue: xr.Dataset, law: str) -> None:
    """Warn of pull-off forces (nN) above that of the same sphere on a smooth flat, with the probable cause."""
    smooth = read_pair(catalogue).smooth_pull_off(stiff=ADHESION_LAWS[law].has_range)
    above = np.asarray(force) > smooth
    if smooth > 0 and above.any():
        width = 2 * float(catalogue["patch_radius"])
        shortest = float(catalogue.coords.get("shortest_wavelength", np.nan))
        cause = "contacts overlap, and each is counted in full; use `adhesive`"
        # largest patch, over the shortest wavelength, for which the ratio was measured
        if not width <= 0.8 * shortest:
            cause = f"a patch of {width:.3g} nm may be too wide for this surface; take asperities(patch='auto')"
        warn(
            f"{int(above.sum())} of {above.size} superposed pull-offs exceed that of the sphere on a smooth flat, "
            f"{smooth:.4g} nN (by up to {100 * np.nanmax(force) / smooth - 100:.2g} %): {cause}",
            DoubtfulAsperities,
        )
