"""Runs over radii, moduli and works of adhesion: the same as one by one, with less work."""

import functools

import numpy as np
import pytest
import xarray as xr

from roughxr import checkpointed, vary
from roughxr.mechanics.asperity.moments import rolling
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.elastic import direct

from .surfaces import glass_pair, rough, scan

RADII = [2000.0, 3000.0]
MODULI = [20.0, 40.0, 80.0]
WORKS = [0.5, 1.0]


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(64, rms=1.5, seed=5)))


CASES = [
    (direct, {"delta": [1.0, 3.0], "subregions": (2, 2)}),
    (superpose, {"delta": np.arange(-2, 5, 0.5), "subregions": (2, 2)}),
    (rolling, {"subregions": (2, 2), "directions": 5}),
]


@pytest.mark.parametrize(("solve", "options"), CASES)
def test_each_combination_is_the_solve_with_that_pair(surface, solve, options):
    varied = vary(surface, solve, sphere_radius=RADII, contact_modulus=MODULI, work_of_adhesion=WORKS, **options)
    for radius, modulus, work in [(2000.0, 80.0, 0.5), (3000.0, 20.0, 1.0), (3000.0, 40.0, 1.0)]:
        pair = {"sphere_radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
        single = solve(surface.assign_coords(pair), **options)
        part = varied.sel(pair)
        for name in {"force", "contact_area", "contacts", "resisting_moment"} & set(single):
            expected, values = xr.align(single[name], part[name], join="left")
            scale = float(abs(expected).max())
            np.testing.assert_allclose(values, expected, rtol=1e-5 if solve is direct else 1e-9, atol=1e-7 * scale)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_a_function_with_bound_options_is_varied_and_named(surface):
    bound = functools.partial(pull_off_map, subregions=(2, 2))
    varied = vary(surface, bound, work_of_adhesion=[0.5, 1.0])
    single = pull_off_map(surface.assign_coords(work_of_adhesion=1.0), subregions=(2, 2))
    np.testing.assert_allclose(varied.pull_off_force.sel(work_of_adhesion=1.0), single.pull_off_force)
    landing = surface.contact.placements(sphere_radius=1000.0, count=2)
    pressed = functools.partial(direct, delta=[2.0], subregions=([0.0], [0.0]))
    placed = vary(surface, pressed, indenter=landing)
    assert dict(placed.force.sizes) == {"placement": 2, "subregion": 1, "delta": 1}
    assert "direct" in str(placed.attrs["history"]) and "pull_off_map" in str(varied.attrs["history"])


def test_dimensions_are_those_given(surface):
    with pytest.raises(ValueError, match=r"fields: expected one sphere_radius.*found 2"):
        vary(surface, direct, sphere_radius=RADII, delta=[2.0], fields=True)
    varied = vary(surface, pull_off_map, work_of_adhesion=WORKS, subregions=(2, 2))
    assert varied.pull_off_force.dims == ("work_of_adhesion", "subregion")
    assert varied.pull_off_force.units == "nN"
    assert varied.work_of_adhesion.units == "J/m^2"
    assert float(varied.sphere_radius) == 3000.0


def test_parameters_are_a_run(tmp_path, surface):
    """All values in one archive, each solve with its checkpoints."""
    options = {"work_of_adhesion": WORKS, "delta": [0.0, 1.0], "subregions": (3, 3)}
    groups = checkpointed(
        lambda: {"solutions/energy": vary(surface, superpose, **options)},
        tmp_path / "run.nc",
        scan=surface,
        arguments=options,
    )
    assert dict(groups["solutions/energy"].force.sizes) == {"work_of_adhesion": 2, "subregion": 9, "delta": 2}
    assert sum("9/9 subregions" in line for line in groups["log"].message.values) == 2


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({}, "expected values of sphere_radius"),
        ({"sphere_radius": [3000.0, 2000.0]}, "ascending"),
        ({"work_of_adhesion": [0.1, 100.0]}, "as bodies have"),
    ],
)
def test_bad_parameters_are_refused_in_words(surface, values, says):
    with pytest.raises(ValueError, match=says):
        vary(surface, superpose, delta=[1.0], **values)


def test_displacements_that_would_differ_from_pair_to_pair_are_asked_for(surface):
    with pytest.raises(ValueError, match="delta: expected displacements in nm, since their default differs"):
        vary(surface, superpose, sphere_radius=[1000.0, 4000.0], subregions=(2, 2))
