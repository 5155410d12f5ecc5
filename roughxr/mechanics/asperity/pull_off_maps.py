"""The exact pull-off from superposed asperities at very many places, up to every pixel of a scan, without a sweep."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from ..jobs import spread
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Places
from .asperity_sum import DEFAULT, PULL_OFF, SumOptions, exact_pull_offs, law_attributes, read_summands
from .expectation import expectation, warn_above_smooth

EVERY_PIXEL = "every pixel"


@schema.recorded
def pull_off_map(
    ds: xr.Dataset,
    *,
    subregions: Places = EVERY_PIXEL,
    law: str | None = None,
) -> xr.Dataset:
    """Return the exact pull-off of the superposed asperities at each contact centre.

    The sum over asperities of `superpose`, on retraction, is minimised over all displacements, to rounding (with
    law="dugdale" to 1e-6 of an asperity's pull-off).

    Parameters
    ----------
    ds : Dataset
        A scan, or an asperity catalogue, with an assigned pair and work of adhesion.
    subregions : "every pixel", (int, int), (array, array) or Dataset
        Contact centres, by default every pixel, which needs a scan.
    law
        As in `superpose`, but with adhesion.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_delta`` (nm), NaN without adhesion; ``contacts``,
        the number of asperities in contact at pull-off, and ``truncated``, whether any of them is at the scan's edge.
        Along (x, y) of the scan for every pixel, along ``subregion`` otherwise. Lazy if the scan is a dask array. The
        attribute ``expected_ratio`` is that to the pull-off of `adhesive`, as in `superpose`.

    Raises
    ------
    ValueError
        If no pair with a work of adhesion is assigned, or every pixel is requested of a catalogue.

    Notes
    -----
    A map shows where the sum is large, not how hard the sphere sticks at a pixel: by place it agrees with the
    simulation less than in the mean of many places, and may rank the places otherwise (see the page on physics).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> pulls = scan.contact.pull_off_map(subregions=(8, 8))
    >>> bool((pulls.pull_off_force > 0).all()), pulls.pull_off_force.units
    (True, 'nN')
    """
    summands = read_summands(ds, law, DEFAULT, verb="pull_off_map")
    ds = summands.ds
    law = summands.law
    options = summands.options
    places, x, y = _places(ds, subregions)
    # number of centres in a task, which then takes some hundredths of a second
    tile = 512
    tiles = [(x[k : k + tile], y[k : k + tile]) for k in range(0, x.size, tile)]
    tile_size = min(tile, x.size)
    solve = partial(spread.task_results, name="pull_off_map", each=tile_size, lazy=summands.lazy)
    records = solve(_tile, tiles, np.dtype((PULL_OFF, (tile_size,))), summands.prepared.grid, options, tile_size)
    records = records.reshape(-1)[: x.size]
    shape = tuple(places.sizes.values())
    columns = {name: (list(places.sizes), records[name].reshape(shape)) for name in PULL_OFF.fields or ()}
    out = xr.Dataset(columns, {**places.coords, **schema.pair_coordinates(ds)})
    out.attrs = {"datum": "highest_peak", "method": "superpose", **law_attributes(law, DEFAULT, options)}
    out.attrs |= {"missing": "NaN where nothing adheres"} | expectation(summands.catalogue, options.law)
    out = spread.finish(schema.label(out))
    if not summands.lazy:
        warn_above_smooth(out["pull_off_force"].values, summands.catalogue, law)
    return out


def _places(ds: xr.Dataset, subregions: Places) -> tuple[xr.Dataset, np.ndarray, np.ndarray]:
    """Return the contact centres as coordinates, and x and y of each, nm."""
    if not isinstance(subregions, str):
        places = regions.centres_of(ds, subregions)
        return places, *regions.points(places).T.copy()
    schema.one_of(subregions, (EVERY_PIXEL,), "subregions")
    if "x" not in ds.dims:
        raise Refusal(f"subregions={EVERY_PIXEL!r}", "a scan", "a catalogue, which has no pixels")
    x, y = np.meshgrid(ds["x"].values, ds["y"].values, indexing="ij")
    return xr.Dataset(coords={axis: ds[axis].variable for axis in "xy"}), x.ravel(), y.ravel()


def _tile(x: np.ndarray, y: np.ndarray, grid: Any, options: SumOptions, size: int) -> np.ndarray:
    """Return the records of one tile, padded to its full size; a task."""
    records = np.zeros(size, PULL_OFF)
    records[: x.size] = exact_pull_offs(x, y, grid, options)
    return records
