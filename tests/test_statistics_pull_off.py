"""One verb for the pull-off of every kind of solution: sweeps, cycles of `adhesive`, elastic sweeps."""

import warnings
from functools import partial

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.adhesion import adhesive
from roughxr.mechanics.contact.elastic import direct
from roughxr.statistics import bootstrap, fit, pdf, pull_off, reduction, summary

from .surfaces import glass_pair, rough, scan

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")

#: The limit without range on the pixels as they are.
by_cells = partial(adhesive, law="jkr", mesh=1)

ELASTIC = np.arange(0.0, 12.0, 0.5)


@pytest.fixture(scope="module")
def ground():
    return glass_pair(scan(rough(64, rms=1.0, smooth=5.0, seed=3)))


@pytest.fixture(scope="module")
def cycle(ground):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return by_cells(ground, delta=[-30.0, 0.0, 6.0], subregions=(2, 2))


@pytest.fixture(scope="module")
def elastic(ground):
    return direct(ground, delta=ELASTIC, subregions=(2, 2))


def test_a_cycle_has_its_own_events(cycle):
    """From all of its steps: the three displacements asked for know nothing of the largest pull."""
    pulls = cycle.contact.pull_off()
    xr.testing.assert_equal(pulls.pull_off_force, cycle.pull_off_force)
    xr.testing.assert_equal(pulls.pull_off_delta, cycle.pull_off_delta)
    assert pulls.bracketed.all()
    assert pulls.pull_off_force.dims == ("subregion",)
    on_the_grid = pull_off(cycle.drop_vars(["pull_off_force", "complete"]))
    assert (on_the_grid.pull_off_force.max("branch").fillna(0) < pulls.pull_off_force).all()


def test_a_largest_pull_at_the_turning_point_is_not_bracketed(cycle):
    """Nor is one of a cycle that was not followed to its end."""
    early = cycle.assign_coords(delta=[-30.0, -20.0, float(cycle.pull_off_delta.max())])
    assert pull_off(early).bracketed.sum() == 3
    assert not pull_off(cycle.assign(complete=~cycle.complete)).bracketed.any()


def test_where_nothing_is_touched_there_is_no_pull_off(ground):
    pulls = pull_off(by_cells(ground, delta=[-30.0, -25.0]))
    assert pulls.pull_off_force.isnull().all() and pulls.pull_off_delta.isnull().all()
    assert not pulls.bracketed.any()


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@pytest.mark.parametrize("method", ["sweep", "cycle"])
def test_statistics_take_the_result_of_every_method(ground, cycle, method):
    sticky = superpose(ground, delta=np.arange(-3, 8, 0.1), subregions=(2, 2))
    pulls = pull_off({"sweep": sticky, "cycle": cycle}[method])
    mean = float(pulls.pull_off_force.mean())
    assert summary(pulls).pull_off_force.sel(statistic="mean").item() == pytest.approx(mean)
    assert bootstrap(pulls, "pull_off_force").estimate.sel(statistic="mean").item() == pytest.approx(mean)
    assert np.isfinite(pdf(pulls, "pull_off_force")).all()
    assert (reduction(pulls).pull_off_ratio > 0).all()
    assert fit(pulls, "pull_off_force", simulations=19).location.sel(law="normal").item() == pytest.approx(mean)


@pytest.mark.parametrize("elastic_sweep", [direct, lambda *a, **k: superpose(*a, law="hertz", **k)])
def test_a_sweep_that_cannot_pull_says_what_to_do(ground, elastic_sweep):
    dry = elastic_sweep(ground, delta=[1.0, 5.0])
    for ds in (dry, dry.chunk(subregion=1)):
        with pytest.raises(ValueError, match="found one without; solve with adhesion"):
            pull_off(ds)


def test_a_pull_off_has_no_pull_off(ground):
    sticky = superpose(ground, delta=np.arange(-3, 8, 0.5))
    with pytest.raises(ValueError, match="it contains pull-off forces already"):
        pull_off(pull_off(sticky))


def test_the_answer_is_the_mean_with_its_interval_in_a_suitable_unit_and_as_data():
    force = np.array([[1200.0, np.nan, 900.0, 1500.0], [1.0, 2.0, 3.0, 4.0]])
    pull = xr.Dataset({"pull_off_force": (("preload", "subregion"), force, {"units": "nN"})}, {"preload": [0.0, 500.0]})
    answer = roughxr.answer(pull.assign(pull_off_error=(("preload", "subregion"), np.full((2, 4), -0.02))))
    assert answer.sentence.startswith("Mean pull-off 1.20 µN (95 % interval ")
    assert "3 places of 4" in answer.sentence and "± 2 % numerical error" in answer.sentence
    assert float(answer.pull_off_force) == 1200 and int(answer.places) == 3 and float(answer.mesh_error) == 0.02
    assert float(answer.low) < 900 and float(answer.high) > 1500  # three places show no tail
    assert answer.pull_off_force.units == answer.low.units == "nN"
    single = roughxr.answer(pull.isel(preload=[1], subregion=[0]))
    assert np.isnan(single.low) and single.sentence.startswith("Mean pull-off 1 nN (1 place)")
    with pytest.raises(ValueError, match="at least one place that adheres"):
        roughxr.answer(pull * np.nan)
    with pytest.raises(ValueError, match="at least one place that adheres"):
        roughxr.answer(pull.assign(pull_off_force=-pull.pull_off_force))


@pytest.mark.parametrize(("method", "times"), [("rigid", 2.0), ("adhesive", 1.5)])
def test_a_smooth_flat_holds_all_of_what_a_smooth_flat_holds_and_cells_too_coarse_are_told(method, times):
    pair = {"sphere_radius": 500.0, "work_of_adhesion": 0.06}
    smooth = times * np.pi * 0.06 * 500.0
    pull = xr.Dataset({"pull_off_force": ("subregion", [smooth])}, pair, {"method": method})
    assert float(reduction(pull).pull_off_ratio[0]) == pytest.approx(1.0)
    assert float(roughxr.answer(pull).smooth_share) == pytest.approx(1.0)
    answer = roughxr.answer(1.22 * pull.assign(cell_error=("subregion", [0.22 / 1.22])).assign_attrs(method=method))
    assert "overestimated by about 22 % due to the size of cells" in answer.sentence
    assert float(answer.mesh_error) == pytest.approx(0.22)


def test_the_cells_error_of_rigid_bodies_reaches_the_answer():
    """Heights of a plane: 2πwR, were it not for the cells."""
    nm = {"units": "nm"}
    axes = {name: (name, np.arange(48) * 8.0, nm) for name in ("x", "y")}
    flat = xr.Dataset({"height": (("x", "y"), np.zeros((48, 48)), nm)}, axes)
    pair = flat.contact.assign_pair(sphere_radius=500, materials="silica/silicon")
    solved = pair.contact.rigid(subregions=([180.0], [180.0]))
    answer = solved.contact.answer()
    smooth = 2 * np.pi * 500 * float(pair.work_of_adhesion)
    assert float(answer.pull_off_force) / (1 + float(answer.mesh_error)) == pytest.approx(smooth, rel=0.02)
    assert "shaped to fit the sphere: use adhesive, or a finer mesh" in answer.sentence


def test_what_has_several_answers_says_which_ways_there_are():
    several = xr.Dataset({"pull_off_force": (("scan", "subregion"), np.ones((2, 3)))})
    with pytest.raises(ValueError, match=r"isel.scan=0., or statistics.pooled.pull, 'pull_off_force'"):
        roughxr.answer(several)
    with pytest.raises(ValueError, match=r"several along humidity; take one by isel.*bootstrap"):
        roughxr.answer(several.rename(scan="humidity"))
    with pytest.raises(ValueError, match="run adhesive, rigid or superpose first"):
        roughxr.answer(xr.Dataset({"height": (("x", "y"), np.ones((2, 2)))}))


def test_a_mean_over_places_is_no_place():
    pull = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0])}, {"subregion": [0, 1, 2]})
    with pytest.raises(ValueError, match="expected places along subregion"):
        roughxr.answer(pull.mean("subregion"))
    assert int(roughxr.answer(pull.isel(subregion=0)).places) == 1
