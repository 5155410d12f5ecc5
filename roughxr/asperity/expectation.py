"""How far the superposed pull-off may be from that of the adhesive simulation at the same places.

Measured by ``tests/benchmarks/superposition_regime.py`` on self-affine surfaces (Hurst exponents 0.4 and 0.8, slopes of
0.03 to 0.3), each under two spheres with two works of adhesion: with a patch that suits the scan superposed over direct
was between 0.43 and 1.33 for nine surfaces of ten, and 0.32 to 0.90 for six others, which nothing was tuned on. Slope,
spacing, overlap and Tabor's parameter do not predict where in `LOW` to `HIGH` a surface lies. A patch wider than
`WIDEST` of the shortest wave adds a factor that grows with it, up to some forty on three waves.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies.liquid import work_of
from ..kernels.asperity.laws import RANGED
from ..vocabulary import schema
from ..vocabulary.text import warn
from .catalogue import RESOLVED

#: Superposed over direct pull-off: the median, and the 5 % and 95 % quantiles over surfaces.
RATIO, LOW, HIGH = 0.7, 0.3, 1.4

#: Largest patch, over the shortest wave, for which the ratio was measured.
WIDEST = 0.8


def expectation(catalogue: xr.Dataset, law: str) -> dict[str, Any]:
    """Return what to expect of the pull-off from these asperities, as attributes of the sum."""
    unknown = _unknown(catalogue, law)
    if unknown:
        return {"expectation": f"its ratio to the simulation with adhesion is not known: {unknown}"}
    words = "pull-off over that of the adhesive simulation on such a surface"
    return {
        "expectation": f"{words}: {RATIO:.2g}, {LOW:g} … {HIGH:g} for nine of ten surfaces",
        "expected_ratio": RATIO,
        "expected_ratio_low": LOW,
        "expected_ratio_high": HIGH,
    }


def _unknown(catalogue: xr.Dataset, law: str) -> str:
    """Return the reason why no ratio is known, empty where one is."""
    if law not in ("energy", "self_similar"):
        return f"it was measured for the corrected formulas, not for {law!r}"
    if "shortest_wavelength" not in catalogue.coords:
        return "the patch was chosen without regard to the scan's shortest wave; take asperities(patch='auto')"
    wave, pixel = float(catalogue["shortest_wavelength"]), float(catalogue["pixel"])
    if not wave >= RESOLVED * pixel:
        return f"the shortest wave of the scan spans {wave / pixel:.2g} pixels, too few to resolve its summits"
    return ""


def warn_above_smooth(force: np.ndarray, catalogue: xr.Dataset, law: str) -> None:
    """Warn of pulls (nN, positive) that exceed that of the same sphere on a smooth flat, and say what causes them."""
    (radius,), work = schema.pair(catalogue, "sphere_radius"), work_of(catalogue)
    factor = 2.0 if law in RANGED else 1.5
    smooth = factor * np.pi * work * radius
    above = np.asarray(force) > smooth
    if smooth > 0 and above.any():
        warn(
            f"{int(above.sum())} of {above.size} superposed pull-offs exceed that of the sphere on a smooth flat, "
            f"{factor:g} πwR = {smooth:.4g} nN (by up to {100 * np.nanmax(force) / smooth - 100:.2g} %): "
            f"{_excess(catalogue)}"
        )


def _excess(catalogue: xr.Dataset) -> str:
    width = 2 * float(catalogue["patch_radius"])
    wave = float(catalogue.coords.get("shortest_wavelength", np.nan))
    if width > WIDEST * wave:
        return f"a patch of {width:.3g} nm is too wide for waves of {wave:.3g} nm; take asperities(patch='auto')"
    if np.isnan(wave):
        return f"a patch of {width:.3g} nm may be too wide for this surface; take asperities(patch='auto')"
    return "contacts overlap, and each is counted in full; take `adhesive`"
