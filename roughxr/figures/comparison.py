"""Methods side by side: superposed asperities against the direct simulation."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .style import BLACK, BLUE, GREY, VERMILION, Axes, axes, label_axis, legend, log_ticks, styled


@styled
def method_comparison(ds: xr.Dataset, *, mark: float | None = None, ax: Axes | None = None):
    """Draw superposed over direct force against displacement: places, their middle half, and their median.

    Parameters
    ----------
    ds : Dataset
        From `force_ratio`.
    mark : float, optional
        A displacement (nm) to mark, for example the one from which they are said to differ.
    ax : Axes, optional

    Returns
    -------
    Axes
        The ratio on a logarithmic axis, unit 1; the band of agreement is grey.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> rows = ("subregion", "delta"), [[0.0, 0.05, 1.0]]
    >>> ds = xr.Dataset({"force_difference": rows}, {"delta": [1.0, 2.0, 3.0]}, {"agree_within": 0.1})
    >>> method_comparison(ds, ax=Figure().subplots()).get_ylabel()
    'superposed / direct force'
    """
    ax = axes(ax)
    ratio = (1 + ds["force_difference"]).transpose("delta", "subregion").clip(min=1e-3)
    delta, within = ds["delta"].values, ds.attrs["agree_within"]
    ax.axhspan(1 - within, 1 + within, color=GREY, alpha=0.25, linewidth=0, label=f"within {100 * within:g} %")
    ax.plot(delta, ratio.values, color=BLUE, linewidth=0.35, alpha=0.5)
    ax.plot([], [], color=BLUE, linewidth=0.6, label=f"{ds.sizes['subregion']} places")
    held = ratio.notnull().any("subregion").values
    middle = ratio.isel(delta=held).quantile([0.25, 0.5, 0.75], "subregion").values
    ax.fill_between(delta[held], middle[0], middle[2], color=BLUE, alpha=0.25, linewidth=0, label="middle half")
    ax.plot(delta[held], middle[1], color=BLACK, linewidth=1.4, label="median")
    if mark is not None:
        ax.axvline(mark, color=VERMILION, linewidth=0.9, linestyle=(0, (4, 2)), label=f"{mark:.3g} nm")
    _ratio_axis(ax, ratio.values)
    label_axis(ax.xaxis, "delta")
    return legend(ax, loc="upper left", ncols=2)


def _ratio_axis(ax, ratio: np.ndarray):
    ax.set_yscale("log")
    high = float(np.nanmax(ratio, initial=1.2))
    ax.set_ylim(max(0.5 * float(np.nanmin(ratio, initial=1.0)), 0.05), max(3 * high, 3.0))
    log_ticks(ax.yaxis, (1, 2, 5) if high < 50 else (1,))
    ax.set_ylabel("superposed / direct force")
