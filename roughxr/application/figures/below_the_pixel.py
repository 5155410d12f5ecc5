"""The pull-off over the pixel of the scan, with the interval of the real surface beyond the last one."""

from __future__ import annotations

import xarray as xr

from ...mechanics.vocabulary.refusal import Refusal
from .style import BLUE, GREY, VERMILION, Axes, axes, label_axis, legend, log_ticks, styled


@styled
def force_over_pixel(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the mean pull-off of a scan on its pixels and on larger ones, and that of the real surface below them.

    The bar is the 95 % interval of the real surface, by all errors, and stands one octave below the scan's pixel.

    Parameters
    ----------
    ds : Dataset
        A result of `extrapolated`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=300, materials="glass")
    >>> real = scan.contact.extrapolated(subregions=(3, 3), mesh=2, places=1)
    >>> roughxr.figures.force_over_pixel(real).get_xlabel()
    'pixel size [nm]'
    """
    if "pull_off_on_pixels" not in ds:
        raise Refusal("", "a result of `extrapolated` with the pull-off on larger pixels", "none")
    ax = axes(ax)
    pixels = ds["pixel_size"].values
    forces = ds["pull_off_on_pixels"].values
    ax.plot(pixels, forces, "o-", color=BLUE, markersize=4, label="every pixel, second, fourth")
    best, low, high = (float(ds[f"pull_off_{name}"]) for name in ("mean", "low", "high"))
    below = pixels[0] / 2
    ax.plot([below, pixels[0]], [best, forces[0]], color=GREY, linewidth=0.8, linestyle=":")
    error = [[best - low], [high - best]]
    ax.errorbar([below], [best], error, fmt="s", color=VERMILION, capsize=3, label="real surface, 95 %")
    ax.set(xscale="log", yscale="log")
    ax.set_xticks(pixels, [f"{pixel:.4g}" for pixel in pixels])
    ax.set_xticks([], minor=True)
    log_ticks(ax.yaxis)
    label_axis(ax.yaxis, "pull_off_force")
    ax.set_xlabel("pixel size [nm]")
    return legend(ax)
