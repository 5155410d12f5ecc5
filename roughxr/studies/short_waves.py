"""How waves shorter than the scan shows would change the pull-off: added below its pixels, or cut off above them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..contact.adhesion import settling
from ..contact.regimes import in_memory
from ..contact.rigid.bodies import rigid
from ..contact.subpixel import Below
from ..scans import add_fine_roughness, crop, regions, self_affine_fit, smooth
from ..scans.fine_scales import known_spectrum
from ..vocabulary import schema
from ..vocabulary.units import Places, Quantity, whole_number
from .extrapolation import Question, Surface, next_guess, with_hardness

METHODS = ("rigid", "adhesive")

#: Between rigid bodies finer scales are added around a centre out to where the sphere has risen by this height (nm).
_RISE_AT_EDGE = 30.0

#: Largest cells (nm), between rigid bodies, on which finer scales are added and cut off.
_LARGEST_CELL = 1.0

#: Cells along the shortest added wave.
_PER_WAVE = 8


class _Rigid(NamedTuple):
    """How the pull between rigid bodies is summed on each surface."""

    spectrum: xr.Dataset
    seeds: int
    options: dict[str, Any]


def scale_dependence(
    ds: xr.Dataset,
    *,
    shortest: Sequence[Any] | Any,
    seeds: int = 4,
    subregions: Places = (2, 2),
    method: str = "rigid",
    law: str | None = None,
    preload: Quantity | None = None,
    hurst: float | None = None,
) -> xr.Dataset:
    """Return the pull-off as a function of the shortest wavelength that the surface has.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an assigned sphere and work of adhesion.
    shortest : array_like
        Shortest wavelengths of the surface, nm, ascending. One longer than the shortest that the scan shows is made by
        cutting off shorter waves (`smooth`), a shorter one by adding waves that continue the scan's spectrum
        (`add_fine_roughness`).
    seeds : int
        Number of random surfaces for each wavelength at which waves are added.
    subregions : (int, int), (array, array) or Dataset
        Contact centres.
    method : {"rigid", "adhesive"}
        Between rigid bodies (`rigid`), or by the simulation with adhesion, solved as in `extrapolated`.
    law : str, optional
        Law of attraction for "rigid", by default "hamaker".
    preload : number or quantity, optional
        Preload for "adhesive", nN; by default 0.
    hurst : float, optional
        Hurst exponent of the added roughness; by default that of the scan.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) along (subregion, shortest_kept, seed); where waves are cut off all seeds are equal.
        The scatter over seeds is that between surfaces that all agree with the scan. Attributes hold the spectrum that
        was extrapolated.

    Raises
    ------
    ValueError
        As for `rigid`, `adhesive` and `add_fine_roughness`.

    Notes
    -----
    From one wavelength to the next a seed's waves stay and finer ones are added, so that its curve is smooth. They are
    added around each centre: between rigid bodies out to where the sphere has risen by 30 nm, in the simulation as far
    as the sphere can reach. Beyond that rigid bodies face a plane, and the simulation leaves the surface out.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> found = scale_dependence(scan, shortest=[10, 100], seeds=2, subregions=(1, 1))
    >>> dict(found.pull_off_force.sizes)
    {'subregion': 1, 'shortest_kept': 2, 'seed': 2}
    """
    ds = schema.entered(ds)
    ds = in_memory(ds).scan
    schema.one_of(method, METHODS, "method")
    waves, count = schema.ascending(shortest, "nm", "shortest"), whole_number(seeds, "seeds", least=1)
    spectrum = self_affine_fit(ds, hurst=hurst)
    centres = regions.centres(ds, subregions)
    if method == "rigid":
        schema.refuse_unused("method='rigid'", preload=preload)
        law = law or "hamaker"
        way = _Rigid(spectrum, count, {"delta": [0.0], "law": law})
        forces = np.stack([_on_surfaces(ds, centres, wave, way) for wave in waves], axis=1)
    else:
        schema.refuse_unused("method='adhesive'", law=law)
        law, preload = "exponential", 0.0 if preload is None else preload
        forces = _simulated(with_hardness(ds)[0], centres, waves, count, preload, known_spectrum(spectrum))
    out = xr.Dataset({"pull_off_force": (("subregion", "shortest_kept", "seed"), forces)})
    along = {"shortest_kept": waves, "seed": np.arange(count)}
    out = out.assign_coords({**centres.coords, **along, **schema.travelling(ds)})
    out.attrs = {"method": method, "law": law} | {str(name): float(spectrum[name]) for name in spectrum.data_vars}
    arguments = {"shortest": waves, "seeds": count, "subregions": subregions, "method": method, "law": law}
    return schema.record(schema.label(out), "scale_dependence", ds, **arguments, preload=preload, hurst=hurst)


def _simulated(ds, centres, waves, seeds, preload, model) -> np.ndarray:
    """Return the simulated pull-off (place, wave, seed), smooth surfaces first: they tell how deep the next ones go."""
    problem, adhesion = settling(ds, preload=preload)
    out, guess, places = [], None, range(centres.sizes["subregion"])
    for wave in waves[::-1]:
        longest = max(wave, model.shown)
        surface = Surface(smooth(ds, shortest=longest), problem, centres)
        count = seeds if wave < longest else 1  # without added waves all seeds are the same surface
        pulls = surface.solve(Question(problem, adhesion, Below(model, longest, wave)), places, count, guess)
        guess = next_guess(pulls, guess)
        out.append(np.broadcast_to(pulls[..., 0], (len(places), seeds)))
    return np.stack(out[::-1], axis=1)


def _on_surfaces(ds: xr.Dataset, centres: xr.Dataset, wave: float, way: _Rigid) -> np.ndarray:
    """Return the pull between rigid bodies (place, seed) on surfaces with one shortest wave."""
    (radius,) = schema.pair(ds, "sphere_radius")
    half = max(np.sqrt(2 * radius * _RISE_AT_EDGE), 8 * max(schema.pixel(ds)))
    places = zip(centres["subregion_x"].values, centres["subregion_y"].values)
    return np.array(
        [_over_seeds(crop(ds, x=(x - half, x + half), y=(y - half, y + half)), (x, y), wave, way) for x, y in places]
    )


def _over_seeds(part: xr.Dataset, centre: tuple[float, float], wave: float, way: _Rigid) -> np.ndarray:
    """Return the pull at a place on surfaces with one shortest wave, one for each seed."""
    at: dict[str, Any] = {"subregions": ([centre[0]], [centre[1]])}
    side = schema.square_pixel(part)
    cells = int(np.ceil(side / _LARGEST_CELL))
    if wave >= float(way.spectrum["shortest_wavelength"]):
        smoother = smooth(part, shortest=wave)
        return np.full(way.seeds, float(rigid(smoother, refine=cells, **at, **way.options).pull_off_force[0]))
    cells = max(cells, int(np.ceil(_PER_WAVE * side / wave)))
    finer = (
        add_fine_roughness(part, shortest=wave, seed=seed, refine=cells, spectrum=way.spectrum)
        for seed in range(way.seeds)
    )
    return np.array([float(quietly(rigid, surface, **at, **way.options).pull_off_force[0]) for surface in finer])


def mean_over_waves(ds: xr.Dataset) -> xr.DataArray:
    """Return the mean pull-off (shortest_kept, seed) over the places that are known at every wave.

    A place that is missing at some waves would move the mean there, whatever the waves do. Where no place is known at
    all of them, all count.

    Examples
    --------
    >>> force = (("subregion", "shortest_kept", "seed"), [[[1.0], [2.0]], [[9.0], [float("nan")]]])
    >>> mean_over_waves(xr.Dataset({"pull_off_force": force})).values.ravel().tolist()
    [1.0, 2.0]
    """
    force = ds["pull_off_force"].transpose("subregion", "shortest_kept", "seed")
    everywhere = force.notnull().all(["shortest_kept", "seed"]).values
    return (force.isel(subregion=everywhere) if everywhere.any() else force).mean("subregion")


def quietly(solve: Callable, *arguments: Any, **options: Any) -> Any:
    """Return the result of a solve on one of many surfaces without its warnings, since only the change matters."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return solve(*arguments, **options)
