"""Solves that have not converged say so, warn once, and no event rests on them."""

import warnings

import numpy as np
import pytest
import xarray as xr

from roughxr import direct, pull_off, rolling
from roughxr.mechanics.kernels.halfspace import displacement_control
from roughxr.statistics import force_ratio

from .surfaces import glass_pair, rough, scan


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(32, rms=1.5, seed=5)))


def told(solve, *arguments, **options):
    """Return a result and what it warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = solve(*arguments, **options)
    return solution, [str(warning.message) for warning in caught if "have not converged" in str(warning.message)]


def test_direct_warns_once_and_what_rests_on_it_is_missing(surface, monkeypatch):
    deltas = np.linspace(1.0, 8.0, 12)
    good, nothing = told(direct, surface, delta=deltas, subregions=(2, 2))
    monkeypatch.setitem(displacement_control.sweep_arrays.__kwdefaults__, "max_iterations", 3)
    poor, said = told(direct, surface, delta=deltas, subregions=(2, 2))
    lost = int((~poor.converged).sum())
    assert good.converged.all() and not nothing and lost > 0
    assert len(said) == 1 and f"direct: {lost} of 48 solutions have not converged" in said[0]
    beside = force_ratio(good, poor)
    np.testing.assert_array_equal(beside.force_direct.isnull(), ~poor.converged)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_a_sweep_has_no_pull_off_where_its_largest_pull_has_not_converged():
    force = xr.DataArray([[1.0, -5.0, -2.0], [1.0, -5.0, -2.0]], dims=("subregion", "delta"))
    solved = xr.DataArray([[True, True, False], [True, False, True]], dims=("subregion", "delta"))
    ds = xr.Dataset({"force": force, "converged": solved}, {"delta": [0.0, 1.0, 2.0]})
    np.testing.assert_array_equal(pull_off(ds).pull_off_force, [5.0, np.nan])


def test_a_moment_rests_on_converged_states_alone():
    x = np.arange(-4.0, 5.0)
    near = np.hypot(*np.meshgrid(x, x)) < 2.5
    pressure = np.where(near, -1.0, 0.0)[None, None] * np.array([1.0, 0.5])[None, :, None, None]
    axes = ("subregion", "branch", "delta", "x", "y")
    state = np.stack([pressure, pressure], 1)
    ds = xr.Dataset(
        {
            "pressure": (axes, state),
            "gap": (axes, np.where(near, 0.0, 1.0) * np.ones_like(state)),
            "force": (axes[:3], state.sum((-1, -2))),
            "contact_area": (axes[:3], np.full((1, 2, 2), float(near.sum()))),
            "converged": (axes[:3], np.ones((1, 2, 2), bool)),
            "pull_off_force": ("subregion", [21.0]),
            "pull_off_delta": ("subregion", [0.0]),
        },
        {
            "branch": ["loading", "retraction"],
            "delta": [0.0, 1.0],
            "x": x,
            "y": x,
            "subregion": [0],
            "subregion_x": ("subregion", [0.0]),
            "subregion_y": ("subregion", [0.0]),
            "contact_modulus": 10.0,
            "work_of_adhesion": 0.1,
        },
        {"method": "adhesive", "law": "exponential"},
    )
    rolled, said = told(rolling, ds, directions=4)
    assert rolled.resisting_moment.notnull().all() and rolled.converged.all() and not said
    lost = ds.assign(converged=ds.converged.copy(data=[[[True, True], [False, True]]]))
    rolled, said = told(rolling, lost, directions=4)
    assert rolled.resisting_moment.isnull().all() and not rolled.converged.any() and len(said) == 1
