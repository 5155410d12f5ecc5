"""Surfaces and pairs of bodies for the tests."""

from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
import xarray as xr

from roughxr import scans
from roughxr.mechanics.bodies.pair import assign_pair
from roughxr.mechanics.contact import refinement
from roughxr.mechanics.contact.rigid.bodies import rigid


@contextmanager
def bare_runs(*without):
    """Run without figures and without parts, by default the extrapolation below the pixel: they have own tests."""
    from roughxr.application.runs import analysis

    parts = [part for part in analysis.PARTS if part.name not in (without or ("extrapolated",))]
    with (
        patch("roughxr.application.report.report_page._pictures", lambda run, figures: []),
        patch.dict(analysis.execute.__kwdefaults__, draw_figures=lambda run: iter(())),
        patch.object(analysis, "PARTS", parts),
    ):
        yield


@contextmanager
def unpressed():
    """Solve no sphere once more after it was pressed as hard as it holds, which takes as long as the pull-off."""
    with (
        patch.object(refinement, "_presses_once", lambda adhesion: False),
        patch.object(refinement, "_pressed_pull_offs", lambda place, problem, adhesion, cycles: cycles.pull_offs),
    ):
        yield


def scan(height, pixel=9.77, **attrs):
    """Return heights (nm) as a scan, the middle of the map at x = y = 0."""
    height = np.asarray(height, dtype=float)
    axes = {name: (name, (np.arange(n) - (n - 1) / 2) * pixel, {"units": "nm"}) for name, n in zip("xy", height.shape)}
    return xr.Dataset({"height": (("x", "y"), height, {"units": "nm"})}, coords=axes, attrs=attrs)


def as_measured(ds):
    """Return a synthetic surface as a measured one, whose real surface is estimated."""
    return ds.assign_attrs(synthetic="no")


def rigid_pull_off(ds, wave, *, law="exponential", subregions=(1, 1)):
    """Return the mean pull-off (nN) of rigid bodies on a scan without wavelengths below ``wave`` (nm)."""
    pixel = float(ds.x[1] - ds.x[0])
    cells = int(np.ceil(max(8 * pixel / wave, pixel)))  # of 1 nm at most
    smooth = scans.smooth(ds, shortest=wave)
    return float(rigid(smooth, subregions=subregions, delta=[0.0], law=law, mesh=cells).pull_off_force.mean())


def rotated(ds):
    """Return a scan of square pixels after a quarter turn anticlockwise."""
    return scan(np.rot90(ds["height"].values, axes=(0, 1)), float(ds["x"][1] - ds["x"][0])).assign_coords(
        {name: ds[name] for name in ds.coords if ds[name].ndim == 0}
    )


def glass_pair(ds, sphere_radius=3000.0):
    """Return the scan with the paper's pair of bodies: glass on glass."""
    return assign_pair(ds, sphere_radius=sphere_radius, young_modulus=75, poisson_ratio=0.22, surface_energy=0.6747)


def rough(n, *, rms=2.0, smooth=3.0, seed=0):
    """Return an n × n Gaussian surface of given rms (nm), smoothed over some pixels."""
    from scipy.ndimage import gaussian_filter

    field = gaussian_filter(np.random.default_rng(seed).standard_normal((n, n)), smooth, mode="wrap")
    return field * (rms / field.std())


def sphere_gap(n, dx, radius=3000.0):
    """Return the separation (nm) of a paraboloid centred on an n × n window."""
    x = (np.arange(n) - (n - 1) / 2) * dx
    return (x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius)
