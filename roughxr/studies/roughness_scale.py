"""`scale_dependence`: the pull-off over the shortest wavelength, with fine roughness added or filtered out."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..contact.adhesion_on_cells import resolving_cell
from ..contact.adhesive_options import preload_problem, window_half_width
from ..contact.batch import Case, pull_offs
from ..contact.mesh import MOST_REFINED, Mesh
from ..contact.problem import places
from ..contact.regimes import need_sphere
from ..scans import regions, self_affine_fit, smooth
from ..scans.fine_scales import Spectrum, known_spectrum, with_fine_roughness
from ..specimen import specimen_of
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Places, Quantities, Quantity, whole_number


def scale_dependence(
    ds: xr.Dataset,
    *,
    shortest: Quantities | None = None,
    seeds: int = 4,
    subregions: Places = (2, 2),
    preload: Quantity = 0.0,
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
        Contact centres, by default a grid of 2 × 2.
    preload : number or quantity
        nN.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) along (subregion, shortest_kept, seed); without added roughness all seeds are equal. The
        scatter over seeds is that between surfaces that all agree with the scan. Attributes contain the extrapolated
        spectrum; a scan without a spectrum is refused.

    Raises
    ------
    ValueError
        If the scan has no spectrum to extrapolate and ``shortest`` is not stated.

    Notes
    -----
    Each surface is solved as by `adhesive`, on eight cells or more along its shortest wavelength. From one wavelength
    to the next, finer roughness is added to a seed's surface, so that its curve is smooth.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> scales = scan.contact.scale_dependence(shortest=[10, 100], seeds=1, subregions=(1, 1))
    >>> dict(scales.pull_off_force.sizes)
    {'subregion': 1, 'shortest_kept': 2, 'seed': 1}
    """
    ds = need_sphere(schema.entered(ds)).scan
    count = whole_number(seeds, "seeds", least=1)
    spectrum = self_affine_fit(ds)
    wavelengths = schema.ascending(_usual_wavelengths(ds, spectrum) if shortest is None else shortest, "nm", "shortest")
    centres = regions.centres(ds, subregions)
    forces = _simulated(ds, centres, wavelengths, count, preload, known_spectrum(spectrum))
    out = xr.Dataset({"pull_off_force": (("subregion", "shortest_kept", "seed"), forces)})
    along = {"shortest_kept": wavelengths, "seed": np.arange(count)}
    out = out.assign_coords({**centres.coords, **along, **schema.pair_coordinates(ds)})
    out.attrs = {str(name): float(spectrum[name]) for name in spectrum.data_vars}
    arguments = {"shortest": wavelengths, "seeds": count, "subregions": subregions, "preload": preload}
    return schema.record(schema.label(out), "scale_dependence", ds, **arguments)


def _usual_wavelengths(ds: xr.Dataset, spectrum: xr.Dataset) -> list[float]:
    """Return wavelengths (nm) below, at and above the shortest that a scan shows."""
    shown = float(spectrum["shortest_wavelength"])
    pixel = schema.square_pixel(ds)
    if not np.isfinite(float(spectrum["psd_plateau"])) or not np.isfinite(shown):
        raise Refusal("shortest", "wavelengths in nm, since this scan has no spectrum to extrapolate")
    return [0.5 * shown, 0.5**0.5 * shown, shown, *(n * pixel for n in (2, 4) if n * pixel > 1.02 * shown)]


def _simulated(
    ds: xr.Dataset, centres: xr.Dataset, wavelengths: np.ndarray, seeds: int, preload: Quantity, model: Spectrum
) -> np.ndarray:
    """Return the simulated pull-off (place, wavelength, seed), nN."""
    specimen = specimen_of(ds)
    problem, adhesion = preload_problem(specimen, preload=preload, law="auto", mesh=Mesh(MOST_REFINED, None))
    # least number of cells along the shortest wavelength
    cells_per_wavelength = 8
    least = cells_per_wavelength * problem.pixel / MOST_REFINED
    if wavelengths[0] < least:
        raise Refusal("shortest", f"wavelengths of {least:g} nm or more", f"{wavelengths[0]:g} nm")
    half_width = window_half_width(specimen, problem, adhesion)
    windows, _ = regions.windows(ds, centres, half_width)
    largest_cell = min(adhesion.first_cell, resolving_cell(adhesion, problem))
    cases = []
    order = []
    for at, shortest in enumerate(wavelengths):
        surface = smooth(ds, shortest=max(shortest, model.shown))
        cell = min(largest_cell, shortest / cells_per_wavelength)
        n = min(int(np.ceil(problem.pixel / cell)), MOST_REFINED)
        for place, window in enumerate(windows):
            part = surface.isel(x=window.rows, y=window.columns)
            for seed in range(seeds if shortest < model.shown else 1):
                rough, _ = with_fine_roughness(part, model, shortest, seed, n)
                (at_place,), _ = places(specimen_of(rough), centres.isel(subregion=[place]), half_width)
                fine = problem._replace(pixel=problem.pixel / n, refine=1)
                cases.append(Case(at_place, fine, adhesion._replace(refine=1)))
                order.append((place, at, seed))
    forces = np.full((len(windows), wavelengths.size, seeds), np.nan)
    forces[tuple(np.transpose(order))] = pull_offs(cases)
    is_shown = wavelengths >= model.shown  # all seeds are equal
    forces[:, is_shown] = forces[:, is_shown, :1]
    return forces


def mean_over_wavelengths(ds: xr.Dataset) -> xr.DataArray:
    """Return the mean pull-off (shortest_kept, seed) over the places known at every wavelength; if none, over all."""
    force = ds["pull_off_force"].transpose("subregion", "shortest_kept", "seed")
    everywhere = force.notnull().all(["shortest_kept", "seed"]).values
    return (force.isel(subregion=everywhere) if everywhere.any() else force).mean("subregion")
