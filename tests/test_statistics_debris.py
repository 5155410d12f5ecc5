"""Debris found by rule: all of it, hardly anything else; and means of two populations, whose areas are known."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from datasets.make_glass import particle_centres
from roughxr.mechanics.scans.landings import debris_landings
from roughxr.statistics import bootstrap, summary


def test_the_six_particles_of_the_twin_are_found_and_nothing_else():
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, contact_modulus=40.0)
    centres = roughxr.scans.regions.centres(scan, (8, 8))
    nearest = {
        int(np.hypot(centres.subregion_x - x, centres.subregion_y - y).argmin("subregion"))
        for x, y in particle_centres()
    }
    assert set(np.flatnonzero(centres.on_debris)) == nearest and len(nearest) == 6


def test_the_share_of_a_needle_is_the_area_within_which_the_sphere_touches_it():
    """A sphere touches a needle of height h over level ground within a distance √(2Rh)."""
    axis = np.arange(200) * 5.0
    height = np.random.default_rng(0).normal(0.0, 0.01, (200, 200))
    height[80, 120] = 25.0
    places = (np.array([400.0, 400.0, 400.0]), np.array([600.0, 600 + 215.0, 600 + 235.0]))
    share, flags = debris_landings(height, (axis, axis), places, 1000.0)
    assert share == pytest.approx(np.pi * 2 * 1000 * 25 / 1000**2, rel=0.03)  # the root is 224 nm
    assert flags.tolist() == [True, True, False]


@pytest.mark.parametrize("radius", [100.0, 700.0, 5000.0])
def test_surfaces_without_debris_have_no_landings_on_it(radius):
    shares = []
    for seed in range(10):
        rolloff = (90.0, 350.0)[seed % 2]
        scan = roughxr.scans.synthetic.self_affine((128, 128), 12, rms=3, hurst=0.65, rolloff=rolloff, seed=700 + seed)
        scan = scan.contact.assign_pair(sphere_radius=radius, contact_modulus=40.0, work_of_adhesion=0.1)
        shares.append(float(roughxr.scans.regions.centres(scan, (2, 2)).debris_share))
    assert np.sort(shares)[-2] == 0.0  # at most one of ten has a summit that far out


def two_populations(values, on_debris, share, smooth=40.0):
    """Return pull-off forces off and on debris, whose share of the area is known, and a smooth flat's as given."""
    coords = {"on_debris": ("subregion", on_debris), "debris_share": share}
    coords |= {"sphere_radius": smooth / (1.5 * np.pi), "work_of_adhesion": 1.0}
    return xr.Dataset({"pull_off_force": ("subregion", values, {"units": "nN"})}, coords)


def test_the_mean_is_that_of_two_populations_weighted_by_their_areas():
    ds = two_populations([1.0, 2.0, 3.0, 10.0, 20.0], [False, False, False, True, True], 0.05)
    mean = 0.95 * 2 + 0.05 * 15
    estimate = bootstrap(ds, statistics=["mean"]).isel(statistic=0)
    assert float(estimate.estimate) == pytest.approx(mean)
    assert float(summary(ds).pull_off_force.sel(statistic="mean")) == pytest.approx(mean)
    assert float(roughxr.answer(ds).pull_off_force) == pytest.approx(mean)
    assert float(estimate.low) < mean < float(estimate.high)


def test_without_a_place_on_debris_its_force_is_that_of_a_smooth_flat_at_most():
    ds = two_populations(np.full(9, 2.0) + 0.01 * np.arange(9), np.zeros(9, bool), 0.1)
    clean = bootstrap(ds.drop_vars("debris_share"), statistics=["mean"]).isel(statistic=0)
    interval = bootstrap(ds, statistics=["mean"]).isel(statistic=0)
    assert float(interval.high) == pytest.approx(0.9 * float(clean.high) + 0.1 * 40.0)
    assert float(interval.low) == pytest.approx(0.9 * float(clean.low))


@pytest.mark.parametrize("side", [3, 6])
def test_intervals_of_means_with_debris_hold(side):
    """Debris on a tenth of the area, with ten times the force: nine of ten places are given an interval that holds."""
    rng = np.random.default_rng(side)
    x, y = (axis.ravel() * 500.0 for axis in np.mgrid[:side, :side])
    held = []
    for _ in range(80):
        on_debris = rng.uniform(size=side**2) < 0.1
        values = np.where(on_debris, 10.0, 1.0) * rng.gamma(6.0, 1 / 6, side**2)
        ds = two_populations(values, on_debris, 0.1)
        ds = ds.assign_coords(subregion_x=("subregion", x), subregion_y=("subregion", y))
        interval = bootstrap(ds, statistics=["mean"], resamples=99).isel(statistic=0)
        if interval.low.notnull():
            held.append(bool(interval.low <= 1.9 <= interval.high))
    assert len(held) >= 72 and np.mean(held) >= 0.9


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_intervals_of_places_on_a_surface_with_particles_hold_its_mean():
    """Grids of 9, 16 and 36 of the 1296 places whose superposed pull-off has the mean."""
    scan = roughxr.scans.synthetic.self_affine((128, 128), 16, rms=1.2, hurst=0.7, rolloff=250, cutoff=60, seed=31)
    particles = [(350.0, 420.0), (1500.0, 700.0), (900.0, 1700.0)]
    squares = [(scan.x - x) ** 2 + (scan.y - y) ** 2 for x, y in particles]
    height = scan.height + sum(14 * np.exp(-((square / 60**2) ** 2)) for square in squares)
    scan = scan.assign(height=height.assign_attrs(scan.height.attrs))
    scan = scan.contact.assign_pair(sphere_radius=1500, contact_modulus=40.0, work_of_adhesion=0.1)
    everywhere = scan.contact.pull_off_map(subregions=(36, 36))
    mean = float(everywhere.pull_off_force.mean())
    assert float(everywhere.debris_share) == pytest.approx(float(everywhere.on_debris.mean()), rel=0.1)
    assert 0.02 < float(everywhere.debris_share) < 0.12
    number = np.arange(36**2).reshape(36, 36)
    held = []
    for step, offset in ((12, 1), (12, 5), (12, 10), (9, 0), (9, 4), (9, 8), (6, 1), (6, 3), (6, 5)):
        places = everywhere.isel(subregion=number[offset::step, (offset + 2) % step :: step].ravel())
        interval = bootstrap(places, statistics=["mean"], resamples=99).isel(statistic=0)
        held.append(float(interval.low) <= mean <= float(interval.high))
    assert sum(held) >= 8


def test_values_alone_state_which_debris_they_cannot_show():
    """Of 9 independent places none is on debris of a share p with a probability (1 − p)⁹: 5 % for p = 28 %."""
    alone = xr.Dataset({"pull_off_force": ("subregion", np.linspace(1.0, 2.0, 9), {"units": "nN"})})
    sentence = "Debris on less than 28 % of the surface may be missed by 9 places"
    assert bootstrap(alone, statistics=["mean"]).attrs["missed_share"] == pytest.approx(1 - 0.05 ** (1 / 9))
    mean = roughxr.mechanics.statistics.means.mean_pull_off(alone)
    assert sentence in " ".join(roughxr.application.headline.answer_lines(mean))
    classified = alone.assign_coords(on_debris=("subregion", np.zeros(9, bool)), debris_share=0.0)
    assert "missed_share" not in bootstrap(classified, statistics=["mean"]).attrs
