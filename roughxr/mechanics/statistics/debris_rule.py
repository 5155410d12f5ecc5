"""Find places on debris: their highest peak is far above the median of the scan."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..scans.regions import points
from ..vocabulary import schema

#: Threshold above the median, in median absolute deviations: four standard deviations of a normal law.
THRESHOLD = 6.0


def debris(catalogue: xr.Dataset, subregions: xr.Dataset | None = None) -> xr.DataArray:
    """Return the asperities, or the subregions, that are debris: far higher than all others.

    Parameters
    ----------
    catalogue : Dataset
        Asperities.
    subregions : Dataset, optional
        Any Dataset with the contact centres ``subregion_x`` and ``subregion_y``. The rule is then applied to the
        highest asperity of each tile (the asperities nearest to its centre).

    Returns
    -------
    DataArray
        True if the height exceeds the median by more than six median absolute deviations (if more than half of the
        heights are equal, mean absolute deviations, scaled as for a normal law). On a surface without debris this is
        so for one tile in about 10⁴ (normal heights) to 150 (Gumbel's law). ``threshold_value`` and
        ``threshold_units`` state the limit, ``comment`` the rule.

    References
    ----------
    Leys et al., J. Exp. Soc. Psychol. 49 (2013) 764, doi:10.1016/j.jesp.2013.03.013, for the median absolute deviation
    against outliers; Iglewicz & Hoaglin (1993), How to detect and handle outliers, for the mean deviation in its place.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> places = {name: ("subregion", [0.0, 1, 2, 3]) for name in ("subregion_x", "subregion_y")}
    >>> at = {name: ("asperity", [0.0, 1, 2, 3]) for name in ("x", "y")}
    >>> catalogue = xr.Dataset({"height": ("asperity", [14.0, 15.0, 16.0, 27.0], {"units": "nm"})}, coords=at)
    >>> flags = roughxr.statistics.debris(catalogue, xr.Dataset(coords=places))
    >>> flags.values.tolist(), flags.threshold_value
    ([False, False, False, True], 21.5)
    """
    from scipy.spatial import cKDTree

    catalogue = schema.entered_dataset(catalogue, "asperities")
    subregions = schema.entered(subregions)
    values = catalogue["height"].values.astype(float)
    source = catalogue
    dim = "asperity"
    if subregions is not None:
        source = subregions
        dim = "subregion"
        tree = cKDTree(points(subregions))
        highest = np.full(tree.n, -np.inf)
        np.maximum.at(highest, tree.query(np.c_[catalogue["x"].values, catalogue["y"].values])[1], values)
        values = np.where(np.isfinite(highest), highest, np.nan)  # NaN for an empty tile
    median = np.nanmedian(values)
    off = np.abs(values - median)
    # mean over median absolute deviation of a normal law: the mean deviation is used if the median deviation is 0
    limit = float(median + THRESHOLD * (np.nanmedian(off) or np.nanmean(off) / (0.7979 / 0.6745)))
    out = xr.DataArray(values > limit, dims=dim, name="debris")
    out = out.assign_coords({key: source[key] for key in source.coords if source[key].dims == (dim,)})
    what = "highest asperity of the tile" if subregions is not None else "height"
    out.attrs = schema.attributes("debris") | {
        "comment": f"{what} above median + {THRESHOLD:g} median absolute deviations",
        "threshold_value": limit,
        "threshold_units": catalogue["height"].attrs.get("units", "1"),
    }
    return out
