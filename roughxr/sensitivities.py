"""What matters: the pull-off of the same places, computed again under each assumption that could be another.

One factor is changed at a time, from the scan and the pair as given; the others stay.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from . import regions, schema
from .catalogue import asperities
from .contact.superposition import superpose
from .scans import level
from .statistics import bootstrap, pull_off
from .tip import erode, tip_flags

#: What is tried for each factor: fit window in pixels, how its vertex is placed, levelling, pixels joined, height
#: step (nm), radius of the tip taken off (nm), factors on work of adhesion and on contact modulus.
SETTINGS: dict[str, tuple] = {
    "fit window": (3, 5, 7),
    "vertex": ("pixel",),
    "levelling": ("plane", "quadratic", "cubic"),
    "pixel": (2, 4),
    "height step": (0.1, 0.5, 1.0),
    "tip radius": (5.0, 10.0, 20.0),
    "surface energy": (0.5, 2.0),
    "modulus": (0.5, 2.0),
}


class _Case(NamedTuple):
    factor: str
    words: str
    scan: xr.Dataset
    patch: int
    vertex: str = "fitted"


def sensitivity(
    ds: xr.Dataset,
    *,
    subregions: Any = None,
    delta: Any = None,
    patch: int = 5,
    formulation: str = "energy",
    settings: Mapping[str, Sequence] | None = None,
) -> xr.Dataset:
    """Return how the pull-off force changes with each assumption.

    Parameters
    ----------
    ds : Dataset
        A scan with a pair that adheres.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`; the same in all cases.
    delta : array_like, optional
        Displacements, nm, counted from each place's first touch; by default 161 from where a smooth sphere lets
        go to four times as deep, and no less than the heights' standard deviation.
    patch : int
        Fit window of the base case.
    formulation : str
        As for `superpose`.
    settings : mapping of str to sequence, optional
        What to try for each factor, by default ``SETTINGS``: "fit window" (pixels), "vertex" (as for
        `asperities`), "levelling" ("plane", "quadratic" or "cubic"), "pixel" (so many joined along each axis),
        "height step" (nm, rounding), "tip radius" (nm, of a tip taken off the scan), "surface energy" and
        "modulus" (factors).

    Returns
    -------
    Dataset
        Along ``case``, the first of them the base: ``pull_off_mean``, its ends ``pull_off_mean_low`` and
        ``pull_off_mean_high`` (95 %, block bootstrap), ``pull_off_std``, ``pull_off_median`` (nN), ``asperities``,
        ``unbracketed`` (places whose sweep was too short), and ``sharper_than_tip``, the share of asperities
        flagged (NaN but for the tip); coordinates ``factor`` and ``setting``.

    Raises
    ------
    ValueError
        If no pair with adhesion is assigned, or a factor is not known.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.synthetic.self_affine((64, 64), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.2)
    >>> found = sensitivity(scan, subregions=(3, 3), settings={"surface energy": [2.0]})
    >>> found.setting.values.tolist(), bool(found.pull_off_mean[1] > found.pull_off_mean[0])
    (['as given', '× 2'], True)
    """
    ds = schema.validate(ds, "scan")
    for factor in settings or ():
        schema.one_of(factor, SETTINGS, "settings")
    places = regions.centres(ds, subregions)
    deltas = _sweep(ds) if delta is None else schema.ascending(delta, "nm", "delta")
    cases = list(_cases(ds, SETTINGS if settings is None else settings, patch))
    image = asperities(ds, patch=patch)
    rows = [_computed(case, places, deltas, formulation, image) for case in cases]
    out = xr.concat(rows, dim="case").assign_coords(
        factor=("case", [case.factor for case in cases]), setting=("case", [case.words for case in cases])
    )
    arguments = {"delta": deltas, "patch": patch, "formulation": formulation, "settings": settings}
    return schema.record(schema.label(out), "sensitivity", ds, subregions=subregions, **arguments)


def _sweep(ds: xr.Dataset) -> np.ndarray:
    """Return displacements from first touch within which every pull-off should lie."""
    radius, modulus, work = schema.pair(ds, *schema.PAIR)
    if work <= 0:
        raise ValueError("expected a pair with work_of_adhesion > 0, found 0; assign one with assign_pair")
    end = (np.pi**2 * work**2 * radius / modulus**2) ** (1 / 3)  # JKR's own displacement, within a factor of two
    return np.linspace(-2 * end, max(4 * end, float(ds["height"].std())), 161)


def _cases(ds: xr.Dataset, settings: Mapping[str, Sequence], patch: int) -> Iterator[_Case]:
    yield _Case("base", "as given", ds, patch)
    for factor, values in settings.items():
        for value in values:
            if factor == "fit window":
                yield _Case(factor, f"{value} pixels", ds, value)
            elif factor == "vertex":
                yield _Case(factor, value, ds, patch, vertex=value)
            else:
                words, changed = _CHANGES[factor](ds, value)
                yield _Case(factor, words, changed, patch)


def _levelled(ds: xr.Dataset, method: str) -> tuple[str, xr.Dataset]:
    how = {"method": "polynomial", "order": 3} if method == "cubic" else {"method": method}
    return method, level(ds, **how)


def _coarser(ds: xr.Dataset, count: int) -> tuple[str, xr.Dataset]:
    pixel = count * schema.pixel(ds)[0]
    return f"{pixel:.3g} nm", schema.label(ds.coarsen(x=count, y=count, boundary="trim").mean())


def _rounded(ds: xr.Dataset, step: float) -> tuple[str, xr.Dataset]:
    return f"{step:g} nm", ds.assign(height=(np.round(ds["height"] / step) * step).assign_attrs(ds["height"].attrs))


def _without_tip(ds: xr.Dataset, radius: float) -> tuple[str, xr.Dataset]:
    return f"{radius:g} nm", erode(ds, tip_radius=radius).assign_coords(tip_radius=radius)


def _scaled(name: str) -> Callable:
    """Return the change that multiplies a coordinate of the pair."""
    return lambda ds, factor: (f"× {factor:g}", ds.assign_coords({name: ds[name] * factor}))


_CHANGES: dict[str, Callable[[xr.Dataset, Any], tuple[str, xr.Dataset]]] = {
    "levelling": _levelled,
    "pixel": _coarser,
    "height step": _rounded,
    "tip radius": _without_tip,
    "surface energy": _scaled("work_of_adhesion"),
    "modulus": _scaled("contact_modulus"),
}


def _computed(case: _Case, places: xr.Dataset, deltas: np.ndarray, formulation: str, image: xr.Dataset) -> xr.Dataset:
    """Return one case's numbers."""
    catalogue = asperities(case.scan, patch=case.patch, vertex=case.vertex)
    options = {"formulation": formulation, "datum": "first_contact"}
    pull = pull_off(superpose(catalogue, delta=deltas, subregions=places, **options))
    found = bootstrap(pull, "pull_off_force", statistics=["mean", "std", "q50"]).drop_vars("independent_places")
    ends = found.sel(resampling="block", statistic="mean")
    values = {
        "pull_off_mean": found["estimate"].sel(statistic="mean"),
        "pull_off_mean_low": ends["low"],
        "pull_off_mean_high": ends["high"],
        "pull_off_std": found["estimate"].sel(statistic="std"),
        "pull_off_median": found["estimate"].sel(statistic="q50"),
        "asperities": catalogue.sizes["asperity"],
        "unbracketed": (~pull["bracketed"]).sum(),
        "sharper_than_tip": _hidden(case, image),
    }
    return xr.Dataset({name: ((), float(value)) for name, value in values.items()})


def _hidden(case: _Case, image: xr.Dataset) -> float:
    """Return the share of the image's asperities that are sharper than the tip taken off."""
    if "tip_radius" not in case.scan.coords:
        return np.nan
    return float(tip_flags(image, tip_radius=case.scan["tip_radius"].item())["sharper_than_tip"].mean())
