"""Places on debris, found by a rule of medians: their highest peak is far above what is usual for the scan."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..vocabulary import schema
from .sampling import sample_dimension

#: Median absolute deviations above the median: four standard deviations of a normal law.
THRESHOLD = 6.0

#: Mean absolute deviation of a normal law over its median one: the mean stands in where the median is 0.
_MEAN_OVER_MEDIAN = 0.7979 / 0.6745


def debris(
    catalogue: xr.Dataset, subregions: xr.Dataset | None = None, *, name: str = "height", threshold: float = THRESHOLD
) -> xr.DataArray:
    """Return which asperities, or which subregions, are debris: far higher than all others.

    Parameters
    ----------
    catalogue : Dataset
        Asperities; without ``subregions``, anything with ``name`` along ``asperity`` or ``subregion``.
    subregions : Dataset, optional
        Anything with the contact centres ``subregion_x`` and ``subregion_y``. The highest asperity of each tile
        (those nearer to its centre than to any other) then stands for the tile.
    name : str
        Variable that is compared.
    threshold : float
        Debris is what exceeds the median by more than this many median absolute deviations. Where more than half of
        the values are equal, that deviation is 0, and the mean absolute one stands in, scaled as for a normal law. On
        a surface without debris the rule wrongly flags one tile in about 10⁴ (normal heights) to 150 (Gumbel's law).

    Returns
    -------
    DataArray
        True or False; False where there is nothing to compare. ``threshold_value`` and ``threshold_units`` hold the
        limit, ``comment`` the rule.

    Raises
    ------
    ValueError
        If there is no such variable, or the threshold is not positive.

    References
    ----------
    Leys et al., J. Exp. Soc. Psychol. 49 (2013) 764, for the median absolute deviation against outliers; Iglewicz &
    Hoaglin (1993), How to detect and handle outliers, for the mean one in its place.

    Examples
    --------
    >>> places = {name: ("subregion", [0.0, 1, 2, 3]) for name in ("subregion_x", "subregion_y")}
    >>> at = {name: ("asperity", [0.0, 1, 2, 3]) for name in ("x", "y")}
    >>> catalogue = xr.Dataset({"height": ("asperity", [14.0, 15.0, 16.0, 27.0], {"units": "nm"})}, coords=at)
    >>> flags = debris(catalogue, xr.Dataset(coords=places))
    >>> flags.values.tolist(), flags.threshold_value
    ([False, False, False, True], 21.5)
    """
    catalogue, subregions = schema.entered(catalogue), schema.entered(subregions)
    if not threshold > 0:
        raise ValueError(f"threshold: expected a positive number, found {threshold!r}")
    dim = sample_dimension(catalogue, name)
    values = np.asarray(catalogue[name].values, dtype=float) if subregions is None else highest(catalogue, subregions)
    source, dim = (catalogue, dim) if subregions is None else (subregions, "subregion")
    median = np.nanmedian(values)
    off = np.abs(values - median)
    limit = float(median + threshold * (np.nanmedian(off) or np.nanmean(off) / _MEAN_OVER_MEDIAN))
    out = xr.DataArray(values > limit, dims=dim, name="debris")
    out = out.assign_coords({key: source[key] for key in source.coords if source[key].dims == (dim,)})
    what = "highest asperity of the tile" if subregions is not None else name
    out.attrs = schema.attributes("debris") | {
        "comment": f"{what} above median + {threshold:g} median absolute deviations",
        "threshold_value": limit,
        "threshold_units": catalogue[name].attrs.get("units", "1"),
    }
    return out


def highest(catalogue: xr.Dataset, subregions: xr.Dataset) -> np.ndarray:
    """Return the height (nm) of each tile's highest asperity, NaN for an empty tile."""
    from scipy.spatial import cKDTree

    tree = cKDTree(np.c_[subregions["subregion_x"].values, subregions["subregion_y"].values])
    tile = tree.query(np.c_[catalogue["x"].values, catalogue["y"].values])[1]
    heights = np.full(tree.n, -np.inf)
    np.maximum.at(heights, tile, catalogue["height"].values)
    return np.where(np.isfinite(heights), heights, np.nan)
