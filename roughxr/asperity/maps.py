"""The largest superposed pull at very many places, up to every pixel of a scan, found exactly and without a sweep."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..jobs import spread
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.units import Places
from .asperity_sum import ADHESIVE, DEFAULT, PULL_OFF, SumOptions, asperity_grid, largest_pulls, law_of, summands_of
from .expectation import expectation, warn_above_smooth

#: Centres in one task, which then takes some hundredths of a second.
_TILE = 512

EVERY_PIXEL = "every pixel"


def pull_off_map(
    ds: xr.Dataset,
    *,
    subregions: Places = EVERY_PIXEL,
    law: str | None = None,
    datum: str = "highest_peak",
) -> xr.Dataset:
    """Return the largest pull of the superposed asperities at each contact centre, whatever the displacement.

    The sum over asperities of `superpose` is minimised over all displacements, to rounding (with law="maugis" to 1e-6
    of an asperity's own pull): `kernels.asperity.largest_pull` says how.

    Parameters
    ----------
    ds : Dataset
        A scan, or an asperity catalogue, with an assigned pair and work of adhesion.
    subregions : "every pixel", (int, int), (array, array) or Dataset
        Contact centres, see `regions.centres`; every pixel needs a scan.
    law : {"jkr", "maugis"}, optional
        Adhesion without range or with the pair's, see `superpose`.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, see `superpose`.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_delta`` (nm), NaN where nothing pulls;
        ``contacts``, the number of asperities in contact there, and ``truncated``, whether one of them is at the scan's
        edge. Along (x, y) of the scan for every pixel, along ``subregion`` otherwise. Lazy where the scan is a dask
        array.

    Raises
    ------
    ValueError
        If no pair or no work of adhesion is assigned, the indenter is no sphere, or a name is unknown.

    See Also
    --------
    superpose : the whole curve of force over displacement, and the pull-off of other formulations.
    pull_off : the largest pull among the displacements of a sweep.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> found = pull_off_map(scan, subregions=(8, 8))
    >>> bool((found.pull_off_force > 0).all()), found.pull_off_force.units
    (True, 'nN')
    """
    schema.one_of(law or ADHESIVE[0], ADHESIVE, "law")
    summands = summands_of(ds, law, DEFAULT, datum)
    ds, law, options = summands.ds, summands.law, summands.options
    positions = _pixels(ds, subregions) if isinstance(subregions, str) else regions.centres(ds, subregions)
    out = _labelled(_records(positions, asperity_grid(summands.catalogue, options), options, summands.lazy), ds)
    out = _on_pixels(out, ds) if isinstance(subregions, str) else out.assign_coords(positions.coords)
    named = law_of(law, DEFAULT, options)
    out.attrs = {"datum": datum, "method": "superpose", **named, "missing": "NaN where no displacement pulls"}
    out.attrs |= expectation(summands.catalogue, options.law)
    arguments = {"subregions": subregions, **named, "datum": datum}
    out = schema.record(schema.label(out), "pull_off_map", ds, **arguments)
    out = spread.finish(out)
    if not summands.lazy:
        warn_above_smooth(out["pull_off_force"].values, summands.catalogue, law)
    return out


def _pixels(ds: xr.Dataset, subregions: str) -> xr.Dataset:
    schema.one_of(subregions, (EVERY_PIXEL,), "subregions")
    if "x" not in ds.dims:
        raise ValueError(f"subregions={EVERY_PIXEL!r}: expected a scan, found a catalogue, which has no pixels")
    x, y = np.meshgrid(ds["x"].values, ds["y"].values, indexing="ij")
    return xr.Dataset(coords={"subregion_x": ("subregion", x.ravel()), "subregion_y": ("subregion", y.ravel())})


def _records(positions: xr.Dataset, grid: Any, options: SumOptions, lazy: bool) -> Any:
    """Return one record for each centre, computed or lazy."""
    x, y = (positions[name].values.astype(float) for name in ("subregion_x", "subregion_y"))
    tiles = [(x[k : k + _TILE], y[k : k + _TILE]) for k in range(0, x.size, _TILE)]
    each = min(_TILE, x.size)
    record = np.dtype((PULL_OFF, (each,)))
    records = spread.task_results(_tile, tiles, record, grid, options, each, name="pull_off_map", each=each, lazy=lazy)
    return records.reshape(-1)[: x.size]


def _tile(x: np.ndarray, y: np.ndarray, grid: Any, options: SumOptions, size: int) -> np.ndarray:
    """Return the records of one tile, padded to its full size."""
    records = np.zeros(size, PULL_OFF)
    records[: x.size] = largest_pulls(x, y, grid, options)
    return records


def _labelled(records: Any, ds: xr.Dataset) -> xr.Dataset:
    out = xr.Dataset({name: ("subregion", records[name]) for name in PULL_OFF.fields or ()})
    return out.assign_coords(schema.travelling(ds))


def _on_pixels(out: xr.Dataset, ds: xr.Dataset) -> xr.Dataset:
    """Return variables along (x, y) that lie along ``subregion``, one for each pixel."""
    shape = ds.sizes["x"], ds.sizes["y"]
    folded = {name: (("x", "y"), array.data.reshape(shape)) for name, array in out.data_vars.items()}
    return xr.Dataset(folded, coords={**out.coords, "x": ds["x"], "y": ds["y"]})
