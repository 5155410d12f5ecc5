"""Resting positions: closed forms for a few summits, symmetries, and independence of tiles and pixels."""

import warnings

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import roughxr
from roughxr.mechanics.asperity.catalogue import DoubtfulAsperities
from roughxr.mechanics.contact.adhesion import adhesive_and_moments
from roughxr.mechanics.kernels.halfspace.separation import distance_at_height
from roughxr.mechanics.kernels.topography import dilation
from roughxr.mechanics.kernels.topography.basins import drainage_basins
from roughxr.mechanics.kernels.topography.interpolation import band_limited
from roughxr.mechanics.particles.resting_places import resettled, resting

from .surfaces import glass_pair, rough, scan, unpressed

RADIUS = 3000.0


def caps(centres, pixel, *, radius=400.0, half=300.0):
    """Return spheres of a radius (nm) whose centres lie at height 0, on a ground far below."""
    n = int(2 * half / pixel) + 1
    axis = (np.arange(n) - (n - 1) / 2) * pixel
    x = axis[:, None]
    y = axis[None, :]
    r2 = [(x - a) ** 2 + (y - b) ** 2 for a, b in centres]
    summits = [np.sqrt(np.maximum(radius**2 - q, 0)) for q in r2]
    rounding = radius / 80  # of the valleys: heights between pixels would ring by a kink
    height = rounding * np.logaddexp.reduce([*summits, 0.8 * radius + 2e-5 * (x**2 + y**2)] / np.array(rounding))
    return glass_pair(scan(height, pixel), RADIUS)


def polygon(corners, ring, turn=0.3, off=(3.1, -7.4)):
    """Return the corners of a regular polygon of a circumradius (nm), turned and off the pixels."""
    angle = turn + 2 * np.pi * np.arange(corners) / corners
    return np.column_stack([off[0] + ring * np.cos(angle), off[1] + ring * np.sin(angle)])


def on_circle(ring, radius=400.0):
    """Return the height of the sphere's lowest point where it touches caps at a distance from its axis."""
    return np.sqrt((RADIUS + radius) ** 2 - ring**2) - RADIUS


def test_landings_are_any_places():
    scan_of_caps = caps(polygon(3, 150.0), 8.0)
    as_arrays = resting(scan_of_caps, landings=(["-0.01 um", 20.5], [0.0, 12.3]))
    places = {"subregion_x": ("subregion", [-10.0, 20.5]), "subregion_y": ("subregion", [0.0, 12.3])}
    as_dataset = resting(scan_of_caps, landings=xr.Dataset(coords=places))
    xr.testing.assert_equal(as_arrays, as_dataset)
    assert as_arrays.attrs["landings"] == 2


@pytest.mark.parametrize("corners", [3, 4])
def test_a_sphere_rests_in_the_middle_of_equal_summits(corners):
    pixel = 4.0
    ring = 150.0
    rests = resting(caps(polygon(corners, ring), pixel))
    assert rests.sizes["subregion"] == 1
    place = rests.isel(subregion=0)
    assert np.hypot(place.subregion_x - 3.1, place.subregion_y + 7.4) < 0.05 * pixel
    assert float(place.rest_height) == pytest.approx(on_circle(ring), abs=2e-3)
    assert int(place.supports) == corners
    at = np.hypot(place.support_x - 3.1, place.support_y + 7.4)[:corners]
    assert at.values == pytest.approx(ring * RADIUS / (RADIUS + 400.0), abs=0.2 * pixel)


def test_unequal_summits_shift_the_rest_as_the_sphere_through_three_points_says():
    x = polygon(3, 150.0)
    radii = np.array([400.0, 380.0, 420.0])
    pixel = 3.0
    n = 201
    axis = (np.arange(n) - 100) * pixel
    r2 = [(axis[:, None] - a) ** 2 + (axis - b) ** 2 for a, b in x]
    tops = [np.where(q < 150.0**2, np.sqrt(np.maximum(r**2 - q, 0)) - r, -25.0) for q, r in zip(r2, radii)]
    rest = resting(glass_pair(scan(np.max(tops, axis=0), pixel), RADIUS)).isel(subregion=0)
    from scipy.optimize import fsolve

    def equal(p):
        heights = [np.sqrt((RADIUS + r) ** 2 - (p[0] - a) ** 2 - (p[1] - b) ** 2) - r for (a, b), r in zip(x, radii)]
        return np.diff(heights)

    expected = fsolve(equal, x.mean(axis=0))
    assert np.hypot(rest.subregion_x - expected[0], rest.subregion_y - expected[1]) < 0.05 * pixel


def test_the_resting_moment_is_that_about_the_axis_of_each_pair():
    centres = polygon(3, 150.0, turn=np.pi / 6)
    surface = caps(centres, 2.5, radius=60.0, half=220.0).drop_vars("contact_modulus")
    surface = roughxr.assign_pair(surface, sphere_radius=RADIUS, contact_modulus=1e3, work_of_adhesion=1.35)
    place = resting(surface)
    assert place.sizes["subregion"] == 1
    held = roughxr.rolling(surface, directions=np.pi / 6 + np.pi / 3 * np.arange(6), subregions=place)
    assert int(held.contacts[0]) == 3
    pull_of_contact = float(held.pull_off_force[0]) / 3
    lever = 1.5 * 150.0 * RADIUS / (RADIUS + 60.0)  # of the third contact about the axis of two
    over_pairs = held.resisting_moment.values[0, 1::2]
    over_summits = held.resisting_moment.values[0, ::2]
    assert over_pairs == pytest.approx(pull_of_contact * lever, rel=0.04)  # small contacts
    assert np.ptp(over_pairs) < 0.02 * over_pairs.mean()
    assert (over_summits > over_pairs.max()).all()  # two contacts let go behind one


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.parametrize("law", ["auto", "jkr"])
@unpressed()
def test_the_lever_of_the_simulation_is_the_distance_of_the_foremost_of_three_equal_summits(law):
    surface = caps(polygon(3, 150.0, turn=np.pi / 6), 2.5, radius=60.0, half=220.0).drop_vars("contact_modulus")
    surface = roughxr.assign_pair(surface, sphere_radius=RADIUS, contact_modulus=40, work_of_adhesion=0.05)
    place = resting(surface)
    _, moments = adhesive_and_moments(surface, subregions=place, law=law, mesh=2, directions=12)
    assert int(moments.contacts[0]) == 3
    at = np.pi / 6 + 2 * np.pi / 3 * np.arange(3)
    foremost = np.cos(moments.direction.values[:, None] - at).max(axis=1) * 150.0 * RADIUS / (RADIUS + 60.0)
    assert moments.lever.values[0] == pytest.approx(foremost, rel=0.07)  # and the radius of a contact
    assert 0 < float(moments.lever_error[0]) < 0.1


def test_from_the_resting_positions_of_a_sphere_a_larger_one_rolls_to_its_own():
    surface = glass_pair(scan(rough(64, seed=1)), 1500.0)
    larger = surface.assign_coords(sphere_radius=1575.0)
    rests = resting(surface)
    rests = rests.where(~rests.truncated, drop=True)
    larger_rests = resting(larger)
    for ds, expected, moves in ((surface, rests, False), (larger, larger_rests, True)):
        settled = resettled(ds, rests)
        nearest = [
            float(np.hypot(expected.subregion_x - x, expected.subregion_y - y).min())
            for x, y in zip(settled.subregion_x.values, settled.subregion_y.values)
        ]
        assert np.max(nearest) < 0.05
        assert bool(abs(settled.subregion_x - rests.subregion_x).max() > 0.05) == moves


@unpressed()
def test_the_budget_of_a_particle_at_rest_lets_another_sphere_roll_to_its_own_rest():
    """Where the former sphere rested, a larger one lies on a single summit, and its pull-off seems to fall."""
    surface = caps(polygon(3, 150.0, turn=np.pi / 6), 2.5, radius=60.0, half=220.0).drop_vars("contact_modulus")
    surface["height"] = surface.height + 0.01 * surface.x  # a tilted ground: the rest depends on the radius
    surface = roughxr.assign_pair(surface, sphere_radius=RADIUS, contact_modulus=40, work_of_adhesion=0.05)
    options = {"places": 1, "mesh": roughxr.Mesh(2, accuracy=None), "settings": {"sphere radius": [1.1]}}
    slopes = [
        float(roughxr.error_budget(surface, subregions=at, **options).slope.sel(entry="sphere radius"))
        for at in (resting(surface), resting(surface).drop_vars("landing_share"))
    ]
    assert abs(slopes[0]) < 0.5 and slopes[1] < -3.0


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@pytest.mark.parametrize("turn", [np.pi / 6, 0.2])  # on a symmetry of the pixels, and off it
@unpressed()
def test_water_resists_by_the_distance_of_the_foremost_of_three_equal_summits(turn):
    surface = caps(polygon(3, 150.0, turn=turn), 2.5, radius=60.0, half=220.0).drop_vars("contact_modulus")
    bodies = {"sphere_radius": RADIUS, "contact_modulus": 40, "work_of_adhesion": 0}
    surface = roughxr.assign_pair(surface, **bodies, humidity=0.5)
    _, moments = adhesive_and_moments(surface, subregions=resting(surface), mesh=2, directions=12)
    assert int(moments.contacts[0]) == 3
    at = turn + 2 * np.pi / 3 * np.arange(3)
    foremost = np.cos(moments.direction.values[:, None] - at).max(axis=1) * 150.0 * RADIUS / (RADIUS + 60.0)
    assert moments.lever.values[0] == pytest.approx(foremost, rel=0.05)


@pytest.mark.parametrize("amplitude", [1.0, 8.0])
def test_an_egg_box_has_its_rests_in_the_valleys_and_equal_shares(amplitude):
    wave = 400.0
    pixel = 16.0
    axis = np.arange(125) * pixel
    height = amplitude * (np.cos(2 * np.pi * axis[:, None] / wave) + np.cos(2 * np.pi * axis / wave))
    rests = resting(glass_pair(scan(height, pixel), 1500.0))
    x0 = -62 * pixel
    assert rests.sizes["subregion"] == 25
    is_inner = np.maximum(abs(rests.subregion_x), abs(rests.subregion_y)) < 1.5 * wave
    inner = rests.where(is_inner, drop=True)
    assert inner.sizes["subregion"] == 9  # basins of the others end at the scan's edge
    for axis_name in ("subregion_x", "subregion_y"):
        phase = ((inner[axis_name].values - x0) / wave) % 1
        assert phase == pytest.approx(0.5, abs=0.05 * pixel / wave)
    assert inner.landing_share.values == pytest.approx(float(inner.landing_share.mean()), rel=0.03)


@pytest.mark.parametrize("name", ["tilted", "level", "bump"])
def test_where_nothing_holds_a_sphere_there_is_no_rest_and_it_is_said(name):
    axis = np.arange(60) * 5.0
    x = axis[:, None] - 147.0
    y = axis - 147.0
    height = {"tilted": 0.02 * x + 0.01 * y, "level": 0 * (x + y), "bump": 20 * np.exp(-(x**2 + y**2) / 60.0**2)}
    with pytest.warns(UserWarning, match="no resting position"):
        rests = resting(glass_pair(scan(height[name], 5.0)))
    assert rests.sizes["subregion"] == 0 and rests.attrs["share_off_scan"] == 1.0
    with pytest.raises(ValueError, match="found none"):
        roughxr.scans.regions.centres(rests, rests)


def test_basins_are_the_lowest_first_and_a_plateau_beside_lower_pixels_is_none():
    z = np.full((9, 20), 5.0)
    z[:, 0] = 9.0  # a rim, so that no pixel of the border but those at the right end is a minimum
    z[[0, -1]] = 9.0
    z[4, 3] = 2.0
    z[2:7, 8:13] = 4.0  # a minimum of 25 pixels, in a plateau that drains
    z[4, 16] = 1.0
    minima, shares = drainage_basins(z, (1.0, 1.0))
    assert minima.tolist() == [[4, 16], [4, 3], [4, 10]]
    assert shares.sum() <= 1 and (shares >= np.array([1, 1, 25]) / z.size).all()


def test_places_converge_with_the_pixel():
    exact = resting(_hills(4.0))
    errors = []
    for pixel in (16.0, 8.0):
        rests = resting(_hills(pixel))
        off = [np.hypot(rests.subregion_x - a, rests.subregion_y - b).min() for a, b in _inner(exact)]
        errors.append(float(np.median(off)))
    assert errors[1] < 0.1 * 8.0
    assert errors[1] < 0.5 * errors[0]


def _inner(ds):
    kept = ds.where(~ds.truncated, drop=True)
    return list(zip(kept.subregion_x.values, kept.subregion_y.values))


def _hills(pixel):
    """Return a sum of a few waves, longer than 200 nm, on pixels of any size."""
    rng = np.random.default_rng(3)
    axis = np.arange(-480.0, 480.1, pixel)
    height = 0.0
    for _ in range(20):
        (kx, ky) = 2 * np.pi * rng.uniform(-1, 1, 2) / 200.0
        phase = rng.uniform(0, 2 * np.pi)
        height = height + 2 * np.cos(kx * axis[:, None] + ky * axis + phase)
    return glass_pair(scan(height, pixel))


def _patches(surface, radius):
    """Return what a sphere may touch of a scan of 10 nm pixels, on cells of half a pixel."""
    z = band_limited(surface.height.values, 2)
    axes = [(axis.values[:, None] + [-2.5, 2.5]).ravel() for axis in (surface.x, surface.y)]
    reach = distance_at_height(np.ptp(z), radius)
    return dilation.patches(z, *axes, (5.0, 5.0), radius, reach), dilation.Ball(radius, 2.5, 2.5)


def test_every_rest_is_lower_than_all_around_it_and_stands_on_its_supports():
    surface = glass_pair(scan(rough(128, rms=3.0, smooth=2.0), 10.0))
    rests = resting(surface)
    assert rests.sizes["subregion"] > 20
    assert float(rests.landing_share.sum()) == pytest.approx(1.0)
    rows, ball = _patches(surface, RADIUS)
    for place in (rests.isel(subregion=k) for k in range(0, rests.sizes["subregion"], 5)):
        at = float(place.subregion_x), float(place.subregion_y)
        around = [(at[0] + r * np.cos(a), at[1] + r * np.sin(a)) for r in (1.0, 3.0) for a in np.arange(0, 6.28, 0.2)]
        there = np.array([dilation.touch(row, *at, ball)[0] for row in rows])
        near = rows[there > there.max() - 2.0]  # over 3 nm no height changes by 1 nm: slopes are below a third
        heights = [max(dilation.touch(row, *p, ball)[0] for row in near) for p in [at, *around]]
        assert heights[0] == pytest.approx(float(place.rest_height), abs=1e-9)
        assert min(heights[1:]) > heights[0]


_CHANGES = {
    "mirror": (lambda z: z[::-1], [-1, 1, 1]),
    "mirror along y": (lambda z: z[:, ::-1], [1, -1, 1]),
    "transpose": (np.transpose, 1),
}


@pytest.mark.parametrize("seed", [73, 94, 152])
@pytest.mark.parametrize("change", [*_CHANGES])
def test_linked_contacts_do_not_depend_on_orientation(seed, change):
    """One order of contacts gave four supports for three."""
    z = rough(24, rms=1.5, smooth=2.0, seed=seed)
    turn = _CHANGES[change][0]
    first, turned = (resting(glass_pair(scan(np.ascontiguousarray(k), 8.0), 800.0)) for k in (z, turn(z)))
    for name in ("supports", "landing_share"):
        np.testing.assert_allclose(np.sort(turned[name]), np.sort(first[name]), atol=1e-6)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    pixels=st.tuples(st.integers(12, 30), st.integers(12, 30)),
    radius=st.sampled_from([200.0, 500.0, 3000.0]),
    smooth=st.sampled_from([0.7, 1.0, 1.5, 2.5]),
    change=st.sampled_from([*_CHANGES]),
    scale=st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
)
def test_resting_positions_do_not_depend_on_orientation_or_unit_of_length(seed, pixels, radius, smooth, change, scale):
    """But for those that a push of half a pixel ends: rounding may."""
    z = rough(max(pixels), rms=4.0, smooth=smooth, seed=seed)[: pixels[0], : pixels[1]]
    turn, signs = _CHANGES[change]
    stable, places = _rests(z, 10.0, radius)
    stable_turned, places_turned = _rests(np.ascontiguousarray(turn(z)) * scale, 10.0 * scale, radius * scale)
    back = [part[:, [1, 0, 2]] if change == "transpose" else part * signs for part in (stable_turned, places_turned)]
    for expected, positions in ((stable, back[1] / scale), (back[0] / scale, places)):
        for place in expected:
            assert np.abs(positions - place).max(axis=1).min(initial=np.inf) < 0.05


def _rests(z, pixel, radius):
    """Return x, y and height (nm) of the resting positions to which pushed spheres return, and of all."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*no resting position|sphere_radius")
        surface = glass_pair(scan(z, pixel), radius)
        places = resting(surface)
    returns = np.ones(places.sizes["subregion"], bool)
    for x, y in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)) if returns.size else ():
        pushed = places.assign_coords(
            subregion_x=places.subregion_x + x * pixel, subregion_y=places.subregion_y + y * pixel
        )
        rolled = resettled(surface, pushed)
        off = [abs(rolled[f"subregion_{axis}"] - places[f"subregion_{axis}"]).values for axis in "xy"]
        returns &= np.max(off, axis=0) < 0.05 * pixel
    rows = np.column_stack([places[name].values for name in ("subregion_x", "subregion_y", "rest_height")])
    return rows[returns], rows


def test_shares_weigh_means_quantiles_intervals_and_fractions():
    surface = glass_pair(scan(rough(128, rms=3.0, smooth=2.0), 10.0))
    places = resting(surface)
    held = roughxr.rolling(surface, directions=8, subregions=places)
    assert held.landing_share.values == pytest.approx(places.landing_share.values)
    share = places.landing_share.values
    force = held.pull_off_force.values
    mean = (share * force).sum() / share.sum()
    assert mean != pytest.approx(force.mean(), rel=1e-4)
    table = roughxr.statistics.summary(held[["pull_off_force"]])
    assert float(table.pull_off_force.sel(statistic="mean")) == pytest.approx(mean)
    intervals = roughxr.statistics.bootstrap(held, "pull_off_force", statistics=["mean", "std", "q50"], resamples=99)
    assert float(intervals.estimate[0]) == pytest.approx(mean)
    assert type(intervals.attrs["missed_share"]) is float  # shown as a plain number
    copies = np.repeat(force, np.round(share * 200_000).astype(int))
    assert intervals.estimate.values[1:] == pytest.approx([copies.std(), np.median(copies)], rel=0.05)
    assert (intervals.low <= intervals.estimate).all() and (intervals.estimate <= intervals.high).all()
    assert float(roughxr.statistics.cdf(held, "pull_off_force").sel(pull_off_force=force[0])) == pytest.approx(
        share[force <= force[0]].sum()
    )
    resuspended = roughxr.particles.resuspension(held, friction_velocity=[0.3, 1.0])
    expected = (resuspended.remaining_at_place * places.landing_share).sum("subregion")
    assert resuspended.remaining.values == pytest.approx(expected.values)


def test_equal_shares_change_no_statistic():
    values = np.random.default_rng(0).lognormal(size=64)
    x, y = np.meshgrid(np.arange(8.0), np.arange(8.0))
    plain = xr.Dataset({"force": ("subregion", values)}, {"subregion_x": ("subregion", x.ravel())})
    plain = plain.assign_coords(subregion_y=("subregion", y.ravel()))
    shared = plain.assign_coords(landing_share=("subregion", np.full(64, 1 / 64)))
    unweighted, weighted = (
        roughxr.statistics.bootstrap(ds, "force", statistics=["mean", "std"], resamples=99) for ds in (plain, shared)
    )
    for name in ("estimate", "low", "high", "independent_places"):
        assert weighted[name].values == pytest.approx(unweighted[name].values)


def test_from_landings_spheres_roll_to_resting_positions_each_with_its_share():
    surface = glass_pair(scan(rough(96, rms=3.0, smooth=2.0), 10.0))
    rests = resting(surface, landings=(6, 6))
    spheres = 36 * (1 - rests.attrs["share_off_scan"]) * rests.landing_share.values
    np.testing.assert_allclose(spheres, np.round(spheres), atol=1e-9)
    assert spheres.min() > 0.5 and float(rests.landing_share.sum()) == pytest.approx(1.0)
    for x, y in ((-2.0, 1.0), (1.0, 2.0)):  # nm: a sphere that is pushed returns
        pushed = rests.assign_coords(subregion_x=rests.subregion_x + x, subregion_y=rests.subregion_y + y)
        rolled = resettled(surface, pushed)
        assert rolled.subregion_x.values == pytest.approx(rests.subregion_x.values, abs=0.05)
        assert rolled.subregion_y.values == pytest.approx(rests.subregion_y.values, abs=0.05)


def test_where_no_vertex_of_an_asperity_is_near_a_sphere_stays_where_it_rests():
    surface = glass_pair(scan(rough(64, seed=1)), 150.0)
    catalogue = surface.contact.asperities()
    rests = resting(surface)
    moved = resting(surface, on=catalogue.isel(asperity=[0]))
    assert np.isfinite(moved.rest_height).all()
    off = np.hypot(rests.subregion_x - catalogue.x[0], rests.subregion_y - catalogue.y[0])
    assert (off > 300.0).sum() > 5
    np.testing.assert_array_equal(moved.rest_height[off > 300.0], rests.rest_height[off > 300.0])


@pytest.mark.filterwarnings("default::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_spheres_that_rest_on_heights_but_not_on_asperities_are_warned_of():
    sample = roughxr.open_sample("rough").isel(x=slice(128), y=slice(128)).contact.level()
    pair = sample.contact.assign_pair(sphere_radius=500, materials="glass/silicon")
    with pytest.warns(DoubtfulAsperities, match="summits of the scan support a sphere at rest; take resting"):
        on_heights = pair.contact.rolling(subregions=pair.contact.resting(landings=(4, 4)))
    on_asperities = pair.contact.rolling(subregions=pair.contact.resting(landings=(4, 4), on=pair.contact.asperities()))
    assert float(on_asperities.contacts.mean()) > 2 * float(on_heights.contacts.mean())
