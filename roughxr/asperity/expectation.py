"""How far the superposed pull-off may be from that of the adhesive simulation at the same places.

Measured by ``tests/benchmarks/superposition_regime.py`` on self-affine surfaces (Hurst exponents 0.4 and 0.8, slopes of
0.03 to 0.3), each under two spheres with two works of adhesion: with a patch that suits the scan superposed over direct
was between 0.43 and 1.33 for nine surfaces of ten, and 0.32 to 0.90 for six others, which nothing was tuned on. Slope,
spacing, overlap and Tabor's parameter do not predict where in `LOW` to `HIGH` a surface lies. A patch wider than
`WIDEST` of the shortest wave adds a factor that grows with it, up to some forty on three waves.

Liquid (law "menisci") was compared with `rigid`, which sums every pixel (``--humid`` there). Neighbours' menisci merge,
and the sum counts what they share twice: their crowding is the area that all of them would wet, each whole, over that
of the surface. Below `CROWDED` the ratio was 0.72 to 1.5 in nine of ten; above it grows to 4.5, and the sum is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies.liquid import menisci_of, work_of
from ..kernels.asperity.laws import RANGED
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.verbs import warn
from .catalogue import RESOLVED

#: Superposed over direct pull-off: the median, and the 5 % and 95 % quantiles over surfaces.
RATIO, LOW, HIGH = 0.7, 0.3, 1.4

#: The same of liquid over the sum of pixels between rigid bodies, and the crowding from which it is refused.
LIQUID_RATIO, LIQUID_LOW, LIQUID_HIGH, CROWDED = 1.0, 0.6, 1.6, 2.0

#: Largest patch, over the shortest wave, for which the ratio was measured.
WIDEST = 0.8


def expectation(catalogue: xr.Dataset, law: str) -> dict[str, Any]:
    """Return what to expect of the pull-off from these asperities, as attributes of the sum."""
    if law == "menisci":
        return _attributes("of `rigid`", LIQUID_RATIO, LIQUID_LOW, LIQUID_HIGH, why=", since menisci merge")
    unknown = _unknown(catalogue, law)
    if unknown:
        return {"expectation": f"its ratio to the simulation with adhesion is not known: {unknown}"}
    return _attributes("of the adhesive simulation", RATIO, LOW, HIGH)


def _attributes(of: str, ratio: float, low: float, high: float, why: str = "") -> dict[str, Any]:
    words = f"pull-off over that {of} on such a surface: {ratio:.2g}, {low:g} … {high:g} for nine of ten surfaces{why}"
    return {
        "expectation": words,
        "expected_ratio": ratio,
        "expected_ratio_low": low,
        "expected_ratio_high": high,
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


def crowding(catalogue: xr.Dataset) -> float:
    """Return the area that the menisci of all asperities would wet, each whole, over that of the surface; 0 if dry."""
    if (menisci := menisci_of(catalogue)) is None:
        return 0.0
    (radius,) = schema.pair(catalogue, "sphere_radius")
    curvatures = [catalogue[name].values + 1 / radius for name in ("curvature_min", "curvature_max")]
    radii = 1 / np.sqrt(np.prod([curvature[curvatures[0] > 0] for curvature in curvatures], axis=0))
    x_low, x_high, y_low, y_high = regions.extent(catalogue)
    each = 2 * np.pi * menisci.height * float(np.median(radii)) if radii.size else 0.0
    return radii.size * each / ((x_high - x_low) * (y_high - y_low))


def refuse_crowded(catalogue: xr.Dataset) -> None:
    """Raise where the menisci of a catalogue's asperities would merge with their neighbours' all over."""
    if (share := crowding(catalogue)) > CROWDED:
        raise ValueError(
            f"humidity: expected separate menisci, found menisci that overlap: together they cover {share:.2g} times "
            "the surface, and a sum over asperities counts the overlap more than once; take `rigid` or `adhesive`, "
            "which count each pixel once, or a lower humidity"
        )


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
