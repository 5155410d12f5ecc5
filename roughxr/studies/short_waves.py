"""How waves shorter than the scan shows would change the pull-off: added below its pixels, or cut off above them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..contact.adhesion import MOST_REFINED, adhesive, window_half_width
from ..contact.regimes import in_memory
from ..contact.rigid_bodies import rigid
from ..scans import add_fine_roughness, crop, regions, self_affine_fit, smooth
from ..vocabulary import schema
from ..vocabulary.units import whole_number
from ..vocabulary.verbs import verb

METHODS = ("rigid", "adhesive")

#: Around a rigid body finer scales are added out to where the indenter has risen by this height (nm).
_RISE = 30.0

#: Largest cells (nm), between rigid bodies, on which finer scales are added and cut off.
_CELL = 1.0

#: Cells along the shortest added wave: for rigid bodies, and for the simulation, whose pressures are smoother.
_PER_WAVE = {"rigid": 8, "adhesive": 4}

#: A cut-off within this factor of the shortest wave that the scan shows leaves the scan as it is.
_ALIKE = 0.01


class _Method(NamedTuple):
    """How the pull-off is computed on each surface."""

    method: str
    spectrum: xr.Dataset
    seeds: int
    half: float  # nm: half-width of the part of the scan around a place
    cells: int  # along a side of a pixel, at least
    options: dict[str, Any]


@verb
def scale_dependence(
    ds: xr.Dataset,
    *,
    shortest: Sequence[Any] | Any,
    seeds: int = 4,
    subregions: Any = (2, 2),
    method: str = "rigid",
    law: str | None = None,
    preload: float = 0.0,
    refine: int | str = "auto",
    step: float = 0.4,
    hurst: float | None = None,
) -> xr.Dataset:
    """Return the pull-off as a function of the shortest wavelength that the surface has.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an assigned sphere and work of adhesion.
    shortest : array_like
        Cut-off wavelengths, nm, ascending. Above the shortest that the scan shows, shorter waves are cut off
        (`smooth`); below it, waves that continue its spectrum are added (`add_fine_roughness`).
    seeds : int
        Number of surfaces for each added roughness.
    subregions : (int, int), (array, array) or Dataset
        Contact centres.
    method : {"rigid", "adhesive"}
        Between rigid bodies, or by the simulation with adhesion on one mesh for each surface.
    law : str, optional
        See `rigid`, by default its "hamaker"; or the law of `adhesive`, by default "auto".
    preload, refine, step
        Options of `adhesive`: nN; cells along a side of a pixel, at least; nm.
    hurst : float, optional
        Hurst exponent of the added roughness; by default that of the scan.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) along (subregion, shortest_kept, seed); where waves are cut off all seeds are equal.
        The scatter over seeds is that of surfaces that agree with the scan. Attributes hold the spectrum that was
        continued.

    Raises
    ------
    ValueError
        As for `rigid`, `adhesive` and `add_fine_roughness`.

    Notes
    -----
    Fine waves are added around each centre: between rigid bodies out to where the sphere has risen by 30 nm, in the
    simulation as far as the sphere can reach. Further out the ground is a plane, or in the simulation left out. The
    simulation takes the scan as it is where the cut-off is that of the scan.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> found = scale_dependence(scan, shortest=[10, 100], seeds=2, subregions=(1, 1))
    >>> dict(found.pull_off_force.sizes)
    {'subregion': 1, 'shortest_kept': 2, 'seed': 2}
    """
    ds = in_memory(ds)
    schema.one_of(method, METHODS, "method")
    waves, count = schema.ascending(shortest, "nm", "shortest"), whole_number(seeds, "seeds", least=1)
    spectrum = self_affine_fit(ds, hurst=hurst)
    centres = regions.centres(ds, subregions)
    if method == "rigid":
        law, way = law or "hamaker", _rigid_method(ds, spectrum, count, law or "hamaker")
    else:
        options = {"law": law or "auto", "preload": preload, "step": step}
        way = _adhesive_method(ds, spectrum, count, refine, options, centres)
        law = way.options["law"]
    forces = np.stack([_on_surfaces(ds, centres, wave, way) for wave in waves], axis=1)
    out = xr.Dataset({"pull_off_force": (("subregion", "shortest_kept", "seed"), forces)})
    pair = {name: ds[name] for name in schema.TRAVELLING if name in ds.coords}
    out = out.assign_coords({**centres.coords, "shortest_kept": waves, "seed": np.arange(count), **pair})
    out.attrs = {"method": method, "law": law} | {str(name): float(spectrum[name]) for name in spectrum.data_vars}
    arguments = {"shortest": waves, "seeds": count, "subregions": subregions, "method": method, "law": law}
    arguments |= {} if method == "rigid" else {"preload": preload, "refine": refine, "step": step}
    return schema.record(schema.label(out), "scale_dependence", ds, **arguments, hurst=hurst)


def _rigid_method(ds: xr.Dataset, spectrum: xr.Dataset, seeds: int, law: str) -> _Method:
    (radius,) = schema.pair(ds, "sphere_radius")
    cells = int(np.ceil(schema.square_pixel(ds) / _CELL))
    options = {"delta": [0.0], "law": law}
    return _Method("rigid", spectrum, seeds, np.sqrt(2 * radius * _RISE), cells, options)


def _adhesive_method(ds, spectrum, seeds: int, refine: int | str, options: dict, centres: xr.Dataset) -> _Method:
    """Return how the simulation solves each surface: with the law and on the mesh that suit the scan itself."""
    first = centres.isel(subregion=[0])
    found = quietly(adhesive, ds, subregions=first, refine=refine, accuracy=None, **options)
    law, cells = found.attrs["law"], int(found["refinement"].max())
    half = window_half_width(ds, preload=options["preload"], law=law)
    return _Method("adhesive", spectrum, seeds, half, cells, options | {"law": law})


def _on_surfaces(ds: xr.Dataset, centres: xr.Dataset, wave: float, way: _Method) -> np.ndarray:
    """Return the pull-off (place, seed) on surfaces with one shortest wave."""
    shown = float(way.spectrum["shortest_wavelength"])
    if way.method == "adhesive" and wave >= shown * (1 - _ALIKE):
        kept = ds if wave <= shown * (1 + _ALIKE) else smooth(ds, shortest=wave)
        found = quietly(adhesive, kept, subregions=centres, refine=way.cells, **way.options)["pull_off_force"].values
        return np.repeat(found[:, None], way.seeds, axis=1)
    places = zip(centres["subregion_x"].values, centres["subregion_y"].values)
    return np.array([_over_seeds(_around(ds, x, y, way.half), (x, y), wave, way) for x, y in places])


def _around(ds: xr.Dataset, x: float, y: float, half: float) -> xr.Dataset:
    """Return the part of a scan around a place."""
    half = max(half, 8 * max(schema.pixel(ds)))
    return crop(ds, x=(x - half, x + half), y=(y - half, y + half))


def _over_seeds(part: xr.Dataset, centre: tuple[float, float], wave: float, way: _Method) -> np.ndarray:
    """Return the pull-off at a place on surfaces with one shortest wave, one for each seed."""
    at = {"subregions": ([centre[0]], [centre[1]])}
    if wave >= float(way.spectrum["shortest_wavelength"]):
        smoother = smooth(part, shortest=wave)
        return np.full(way.seeds, float(rigid(smoother, refine=way.cells, **at, **way.options).pull_off_force[0]))
    cells = max(way.cells, int(np.ceil(_PER_WAVE[way.method] * schema.square_pixel(part) / wave)))
    solve = rigid if way.method == "rigid" else adhesive
    options = way.options if way.method == "rigid" else way.options | {"refine": 1}
    cells = cells if way.method == "rigid" else min(cells, MOST_REFINED)
    finer = (
        add_fine_roughness(part, shortest=wave, seed=seed, refine=cells, spectrum=way.spectrum)
        for seed in range(way.seeds)
    )
    return np.array([float(quietly(solve, one, **at, **options).pull_off_force[0]) for one in finer])


def quietly(solve: Callable, *arguments: Any, **options: Any) -> Any:
    """Return the result of a solve on one of many surfaces without its warnings, since only the change matters."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return solve(*arguments, **options)
