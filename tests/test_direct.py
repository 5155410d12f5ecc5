"""Direct simulation with labels: units, windows, edges, schedulers, laziness, and errors at the door."""

import warnings

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr.mechanics.bodies.pair import assign_pair
from roughxr.mechanics.contact.elastic import direct

from . import half_space as kalker
from .surfaces import glass_pair, rough, scan

E = 39.407


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(96, rms=1.5, seed=11)))


def hertz(delta):
    return 4 / 3 * E * np.sqrt(3000) * np.asarray(delta) ** 1.5


def test_smooth_sphere_is_hertz():
    deltas = [5, 5.08, 10, 15]
    solution = direct(glass_pair(scan(np.zeros((81, 81)))), delta=deltas)
    np.testing.assert_allclose(solution.force[0], hertz(deltas), rtol=1e-3)
    assert solution.converged.all() and not solution.truncated.any()


def test_the_exact_sphere_is_softer_than_its_paraboloid():
    """By some 5e-4 at 15 nm, as the sphere's height exceeds the paraboloid's by a part r²/4R²."""
    flat = glass_pair(scan(np.zeros((81, 81))))
    sphere = direct(flat, delta=[15]).force.item()
    paraboloid = scan(-(flat.x.values[:, None] ** 2 + flat.y.values**2) / 6000)
    pair = assign_pair(scan(np.zeros((81, 81))), indenter=paraboloid, young_modulus=75, poisson_ratio=0.22)
    softer = 1 - sphere / direct(pair, delta=[15]).force.item()
    assert softer == pytest.approx(5e-4, abs=1e-4)


def test_fields_add_up_and_meet_the_conditions(surface):
    solution = direct(surface, delta=[6, 12], subregions=(2, 2), fields=True).stack(case=("subregion", "delta"))
    pixel = 9.77
    np.testing.assert_allclose(solution.pressure.sum(("x", "y")) * pixel**2, solution.force, rtol=1e-9)
    touching = solution.pressure > 0
    assert float(np.abs(solution.gap.where(touching)).max()) <= 1e-6 * 12
    assert float(solution.gap.min()) >= -1e-6 * 12


def test_the_window_holds_the_overlap_beyond_the_tile(surface):
    """A tile is 120 nm wide, the overlap 600: the tile only places the centre."""
    tiled = direct(surface, delta=[15], subregions=(8, 8)).isel(subregion=27)
    centre = [float(tiled.subregion_x)], [float(tiled.subregion_y)]
    x, y = np.meshgrid(surface.x - centre[0][0], surface.y - centre[1][0], indexing="ij")
    r2 = x**2 + y**2
    separation = surface.height.values.max() - surface.height.values + r2 / (3000 + np.sqrt(3000**2 - r2))
    whole = kalker.solve(separation, 15.0, 9.77, float(surface.contact_modulus))
    assert tiled.force.item() == pytest.approx(whole.force, rel=2e-6)
    assert direct(surface, delta=[15], subregions=centre).force.item() == pytest.approx(whole.force, rel=2e-6)


def test_contact_at_the_scans_edge_is_marked():
    flat = glass_pair(scan(np.zeros((96, 96))))
    middle, corner = (
        direct(flat, delta=[5], subregions=([0.0, -460.0], [0.0, -460.0]))
        .isel(delta=0)[["truncated", "force"]]
        .to_array()
        .T.values
    )
    assert not middle[0] and corner[0]
    assert corner[1] < middle[1]


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_nothing_touched_is_zero_force_not_missing(surface):
    solution = direct(surface, delta=[-3, 0.0])
    assert (solution.force == 0).all() and (solution.contact_area == 0).all() and solution.converged.all()


def test_displacements_that_touch_nothing_at_most_places_are_told_once(surface):
    with pytest.warns(
        UserWarning, match=r"nothing touches at \d of 9 places, down to 0.5 nm .*first_contact"
    ) as warned:
        solution = direct(surface, delta=[0.2, 0.5], subregions=(3, 3))
    assert len(warned) == 1 and int((solution.contact_area.sel(delta=0.5) > 0).sum()) < 5
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        direct(surface, subregions=(3, 3))
        direct(surface, delta=[0.2, 0.5], subregions=(3, 3), datum="first_contact")


def test_first_contact_datum_counts_from_the_first_touch(surface):
    solution = direct(surface, delta=[1e-9, 4.0], subregions=(3, 3), datum="first_contact")
    assert (solution.force > 0).all()
    assert (solution.force.sel(delta=1e-9) < 1e-3).all()
    assert solution.attrs["datum"] == "first_contact"


def test_load_control_is_the_inverse_of_displacement_control(surface):
    loads = [100.0, 5000.0]
    by_load = direct(surface, load=loads, subregions=(2, 2), fields=True)
    assert by_load.force.dims == ("subregion", "load")
    np.testing.assert_allclose(by_load.force, np.broadcast_to(loads, (4, 2)), rtol=1e-6)
    for k in range(4):
        back = direct(surface, delta=by_load.delta[k].values, subregions=(2, 2)).isel(subregion=k)
        np.testing.assert_allclose(back.force, loads, rtol=1e-5)


def test_any_indenter_works_as_well_as_the_sphere(surface):
    """A sphere given as a height map presses as the sphere does."""
    axis = np.arange(-60, 61) * 9.77 / 2
    r2 = axis[:, None] ** 2 + axis**2
    ball = xr.DataArray(7 - r2 / (3000 + np.sqrt(3000**2 - r2)), coords={"x": axis, "y": axis}, dims=("x", "y"))
    mapped = assign_pair(surface, indenter=ball, young_modulus=75, poisson_ratio=0.22)
    expected, by_map = (direct(ds, delta=[5, 10], subregions=(2, 2)) for ds in (surface, mapped))
    np.testing.assert_allclose(by_map.force, expected.force, rtol=1e-6)
    assert direct(mapped, load=[1000.0]).converged.all()


def test_an_indenter_with_a_flat_end():
    axis = np.arange(-20, 21) * 9.77
    punch = xr.DataArray(np.zeros((41, 41)), coords={"x": axis, "y": axis}, dims=("x", "y"))
    mapped = assign_pair(scan(np.zeros((61, 61))), indenter=punch, young_modulus=75, poisson_ratio=0.22)
    solution = direct(mapped, delta=[1.0])
    assert solution.converged.all()
    assert solution.contact_area.item() == pytest.approx((41 * 9.77) ** 2)


# ---------------------------------------------------------------- dask


@pytest.mark.parametrize("options", [{"delta": [4.0]}, {"load": [100.0]}, {"delta": [4.0], "datum": "first_contact"}])
def test_heights_are_loaded_and_solves_stay_lazy(surface, options):
    computed = []

    def counting(graph, keys, **kwargs):
        computed.append(keys)
        return dask.get(graph, keys, **kwargs)

    with dask.config.set(scheduler=counting):
        solution = direct(surface.chunk(x=32), subregions=(2, 2), **options)
    assert solution.force.chunks is not None and len(computed) == 1  # the heights alone
    with dask.config.set(scheduler="synchronous"):
        expected = direct(surface, subregions=(2, 2), **options)
        np.testing.assert_array_equal(solution.force.compute(), expected.force)


# ---------------------------------------------------------------- the door


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"delta": [1.0, np.nan]}, "finite"),
        ({"delta": [2.0, 1.0]}, "ascending"),
        ({"delta": [1], "load": [1]}, "either delta or load, found both"),
        ({"load": [-5.0]}, "positive"),
        ({"delta": [1], "datum": "lowest"}, "'highest_peak'"),
        ({"delta": [1], "subregions": (0, 2)}, "from 1 to 96"),
        ({"delta": [1], "subregions": 8}, "(8, 8)"),
        ({"delta": [1], "subregions": ([1e6], [0.0])}, "outside"),
    ],
)
def test_bad_options_are_refused_in_words(surface, options, says):
    with pytest.raises(ValueError, match=says.replace("(", r"\(").replace(")", r"\)")):
        direct(surface, **options)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
@pytest.mark.parametrize("verb", ["direct", "adhesive"])
def test_a_displacement_of_the_size_of_the_sphere_is_asked_about(verb):
    """5 µm in place of 5 nm, on a sphere of 3 µm; what the surface's relief explains is not."""
    ds = glass_pair(scan(rough(32, seed=1)), 3000.0)
    solve = getattr(ds.contact, verb)
    options = {"law": "jkr", "mesh": 1} if verb == "adhesive" else {}
    question = r"delta: 5,?000 nm is more than a tenth of the sphere's radius.*is this intended"
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "delta:")
        with pytest.raises(UserWarning, match=question):
            solve(delta="5 um", subregions=(1, 1), **options)
        solve(delta=[5.0, 20.0], subregions=(1, 1), **options)
