"""`scale_dependence`: the pull-off over the shortest wavelength, with fine roughness added or filtered out."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from ..contact.adhesive_options import preload_problem
from ..contact.cycle import Adhesion
from ..contact.problem import Problem
from ..contact.regimes import need_sphere
from ..contact.subpixel import AddedRoughness, extrapolated_pull_off
from ..jobs import spread
from ..scans import regions, self_affine_fit, smooth
from ..scans.fine_scales import known_spectrum
from ..vocabulary import schema
from ..vocabulary.units import Places, Quantities, Quantity, whole_number


def scale_dependence(
    ds: xr.Dataset,
    *,
    shortest: Quantities | None = None,
    seeds: int = 4,
    subregions: Places = (2, 2),
    preload: Quantity = 0.0,
    hurst: float | None = None,
) -> xr.Dataset:
    """Return the simulated pull-off as a function of the shortest wavelength of the surface.

    Parameters
    ----------
    ds : Dataset
        A scan in memory with an assigned sphere and work of adhesion.
    shortest : array_like, optional
        Shortest wavelengths of the surface, nm, ascending; by default the shortest that the scan shows, half an octave
        and an octave below, and 2 and 4 pixels if those are longer. Below the shortest shown, roughness by the
        extrapolated spectrum is added; above, roughness is filtered out (`smooth`).
    seeds : int
        Number of random surfaces for each wavelength with added roughness.
    subregions : (int, int), (array, array) or Dataset
        As in `direct`.
    preload : number or quantity
        nN.
    hurst : float, optional
        Hurst exponent of the added roughness; by default that of the scan.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) along (subregion, shortest_kept, seed); without added roughness all seeds are equal. The
        scatter over seeds is that between surfaces that all agree with the scan. Attributes contain the extrapolated
        spectrum; a scan without a spectrum is refused.

    Notes
    -----
    From one wavelength to the next, finer roughness is added to a seed's surface, so that its curve is smooth. Added
    roughness covers all contacts of the sphere around each centre; the bodies yield at their hardness, if
    one is assigned or estimated.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> found = scan.contact.scale_dependence(shortest=[10, 100], seeds=1, subregions=(1, 1))
    >>> dict(found.pull_off_force.sizes)
    {'subregion': 1, 'shortest_kept': 2, 'seed': 1}
    """
    ds = schema.entered(ds)
    ds = need_sphere(ds).scan
    count = whole_number(seeds, "seeds", least=1)
    spectrum = self_affine_fit(ds, hurst=hurst)
    wavelengths = schema.ascending(_usual_wavelengths(ds, spectrum) if shortest is None else shortest, "nm", "shortest")
    centres = regions.centres(ds, subregions)
    forces = _simulated(_yielding(ds), centres, wavelengths, count, preload, known_spectrum(spectrum))
    out = xr.Dataset({"pull_off_force": (("subregion", "shortest_kept", "seed"), forces)})
    along = {"shortest_kept": wavelengths, "seed": np.arange(count)}
    out = out.assign_coords({**centres.coords, **along, **schema.pair_coordinates(ds)})
    out.attrs = {str(name): float(spectrum[name]) for name in spectrum.data_vars}
    arguments = {"shortest": wavelengths, "seeds": count, "subregions": subregions, "preload": preload, "hurst": hurst}
    return schema.record(schema.label(out), "scale_dependence", ds, **arguments)


def _usual_wavelengths(ds: xr.Dataset, spectrum: xr.Dataset) -> list[float]:
    """Return wavelengths (nm) below, at and above the shortest that a scan shows."""
    shown = float(spectrum["shortest_wavelength"])
    pixel = schema.square_pixel(ds)
    if not np.isfinite(float(spectrum["psd_plateau"])) or not np.isfinite(shown):
        raise ValueError("shortest: expected wavelengths in nm, since this scan has no spectrum to extrapolate")
    return [0.5 * shown, 0.5**0.5 * shown, shown, *(n * pixel for n in (2, 4) if n * pixel > 1.02 * shown)]


def _yielding(ds: xr.Dataset) -> xr.Dataset:
    """Return the scan with the hardness assigned or estimated, unless adhesion alone exceeds the estimate."""
    if "hardness" in ds.coords or "hardness_estimate" not in ds.coords:
        return ds
    estimate = float(ds["hardness_estimate"])
    return ds if estimate <= preload_problem(ds)[1].largest_tension else ds.assign_coords(hardness=estimate)


def _simulated(ds, centres, wavelengths, seeds, preload, model) -> np.ndarray:
    """Return the simulated pull-off (place, wavelength, seed), smooth surfaces first: their depths are guesses."""
    problem, adhesion = preload_problem(ds, preload=preload)
    if problem.depth_factor > 1:
        raise ValueError("layer: expected one that does not bulge, found a nearly incompressible one; take adhesive")
    guess = float(problem.steps[-1]), 0.0
    out = []
    for shortest in wavelengths[::-1]:
        longest = max(shortest, model.shown)
        patches = _patches(smooth(ds, shortest=longest), problem, centres)
        count = seeds if shortest < longest else 1  # without added roughness all seeds are equal
        pulls = _solved(patches, count, guess, problem, adhesion, AddedRoughness(model, longest, shortest))
        if np.isfinite(pulls).any():
            guess = 1.3 * float(np.nanmax(pulls[..., 1])) + 0.05, float(np.nanmean(pulls[..., 0]))
        out.append(np.broadcast_to(pulls[..., 0], (len(patches), seeds)))
    return np.stack(out[::-1], axis=1)


def _patches(ds: xr.Dataset, problem: Problem, centres: xr.Dataset) -> list[tuple]:
    """Return the heights around each place, their first pixel's position, the pixel and the place (nm)."""
    reach = problem.indenter.half_width(float(problem.steps[-1])) + 8 * problem.pixel
    windows, _ = regions.windows(ds, centres, reach)
    x = ds["x"].values
    y = ds["y"].values
    heights = ds["height"].values
    positions = zip(windows, centres["subregion_x"].values, centres["subregion_y"].values)
    return [
        (
            heights[window.rows, window.columns],
            (float(x[window.rows][0]), float(y[window.columns][0])),
            problem.pixel,
            (float(centre_x), float(centre_y)),
        )
        for window, centre_x, centre_y in positions
    ]


def _solved(
    patches: list[tuple],
    seeds: int,
    guess: tuple[float, float],
    problem: Problem,
    adhesion: Adhesion,
    added: AddedRoughness,
) -> np.ndarray:
    """Return pull-off (nN), depth (nm) and number of cells (place, seed, 3); NaN where a second guess fails, too."""
    depth, pull = guess
    pulls = np.full((len(patches) * seeds, 3), np.nan)
    for factor in (1.0, 2.0):
        failed = np.flatnonzero(np.isnan(pulls[:, 0]))
        tasks = [
            (*patches[k // seeds], k % seeds, factor * depth, pull, problem, adhesion, added) for k in failed.tolist()
        ]
        if tasks:
            pulls[failed] = spread.task_results(extrapolated_pull_off, tasks, (3,), name="scale_dependence")
    return pulls.reshape(len(patches), seeds, 3)


def mean_over_wavelengths(ds: xr.Dataset) -> xr.DataArray:
    """Return the mean pull-off (shortest_kept, seed) over the places known at every wavelength; if none, over all."""
    force = ds["pull_off_force"].transpose("subregion", "shortest_kept", "seed")
    everywhere = force.notnull().all(["shortest_kept", "seed"]).values
    return (force.isel(subregion=everywhere) if everywhere.any() else force).mean("subregion")


def quietly(solve: Callable, *arguments: Any, **options: Any) -> Any:
    """Return the result of a solve without its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return solve(*arguments, **options)
