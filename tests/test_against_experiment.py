"""Predictions beside published measurements: limits that are known, and facts that stand in files beside."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from .benchmarks import against_experiment as against
from .benchmarks import reeks_hall
from .surfaces import unpressed

INPUTS = {"ruby": 0.0, "spectrum": 0.5}


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with unpressed():
        yield


@pytest.mark.parametrize("law", [0.0, 1.0])
def test_a_sphere_on_a_smooth_film_has_the_whole_work_of_adhesion(monkeypatch, law):
    monkeypatch.setattr(against, "FILM", tuple((wave, 1e-9 * power) for wave, power in against.FILM))
    work, _ = against.on_diamond(1, 600, law=law, **INPUTS)
    assert work == pytest.approx(46.3, rel=0.01)


def test_a_rougher_ruby_and_a_rougher_film_adhere_less():
    works = [against.on_diamond(1, 600, law=1.0, **{**INPUTS, **more})[0] for more in ({}, {"ruby": 1.0})]
    assert 0 < works[1] < works[0] < 5


def test_the_share_of_fine_roughness_is_zero_where_there_is_none(monkeypatch):
    monkeypatch.setattr(against, "SHORT_WAVE", 64.0)  # nm, four cells of 16 nm
    (_, share) = against.on_diamond(1, 588, law=1.0, **INPUTS)
    assert share == pytest.approx(0, abs=1e-3)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_equally_rough_surfaces_are_told_apart_by_their_own_rms_alone():
    surface = {"pixel": 1.0, "hurst": 0.7, "rolloff": 50.0, "cutoff": 4.0}
    bodies = {"contact_modulus": 200.0, "work_of_adhesion": 0.1, "adhesion_range": 0.3, "hardness": 20.0}
    how = {"own_rms": 0.0, "radius": 500.0, "surface": surface, "bodies": bodies}
    assert against.divided(1, 64, (1.0, 1.0), **{**how, "radius": 200.0}) == (1.0,)
    (falls,) = against.divided(1, 96, (0.01, 1.0), **how)
    (hidden,) = against.divided(1, 192, (0.01, 1.0), **{**how, "own_rms": 5.0})
    assert falls > 3 and hidden == pytest.approx(1, abs=0.2)


def test_equal_spheres_without_own_roughness_are_those_of_the_floor_alone(monkeypatch):
    """The new prediction at the old inputs: sizes and shapes that do not vary leave one sphere on the same floor."""
    monkeypatch.setattr(against, "SPHERES", 3)
    inputs = {"rms": 15.0, "hurst": 0.7, "rolloff": 4000.0, "fine": 1.0}
    equal = against.equal_spheres(1, 64, **inputs)
    same = {"work": reeks_hall.WORK, "own_rms": 1e-6, "own_spread": 1.0, "sizes": 1.0}
    unequal = against.unequal_spheres(1, 64, **inputs, **same)
    assert unequal[0] == pytest.approx(equal[0], rel=0.25)  # 16 places in place of 64
    uneven = against.unequal_spheres(1, 64, **inputs, **{**same, "sizes": 1.3})
    assert uneven[1] > unequal[1]


def test_a_smooth_silica_sphere_rolls_at_the_moment_of_one_contact():
    smooth = {"rms": 2e-3, "hurst": 0.7, "rolloff": 400.0, "shortest": 200.0, "work": 0.063}
    (ratio,) = against.rolling_silica(1, 128, radius=1000.0, **smooth)
    pair = {"contact_modulus": 37.586, "work": 0.063, "radius": 500.0}
    contact_radius = (9 * np.pi * pair["work"] * pair["radius"] ** 2 / (8 * pair["contact_modulus"])) ** (1 / 3)
    assert ratio == pytest.approx(1.087872 * contact_radius / 1000.0, rel=0.05)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_smooth_spheres_pull_in_the_order_of_their_radii():
    smooth = {"least_rms": 1e-3, "ratio": 1.0, "hurst": 0.7, "rolloff": 200.0, "length": 0.5}
    assert against.glass_on_silicon(1, 48, **smooth) == (1.0,)


def test_a_prediction_that_contains_no_middle_run_misses():
    runs = against.Fact("velocity", 0.4, 0.9, 0.75)
    assert runs.judged(0.3, 1.0) == "agrees"
    assert runs.judged(0.7, 1.0) == "in part"
    assert runs.judged(0.8, 1.0) == "misses"


def test_the_film_is_that_of_its_container(shared_scans):
    film = against.film_of(shared_scans / "uncd_container_ccby.zip")
    waves, power = np.array(against.FILM).T
    np.testing.assert_allclose(2 * np.pi / film.wavevector, waves, rtol=0.001)
    np.testing.assert_allclose(film.psd, power, rtol=0.005)


def test_the_runs_are_those_that_were_digitised(shared_scans):
    path = shared_scans.parent / "measured" / "reeks_hall_2001.csv"
    if not path.exists():
        pytest.skip("the digitised runs are not part of the repository")
    runs = [(size, *reeks_hall.half_and_spread(*curve)) for (size, _), curve in reeks_hall.measured(path).items()]
    for fact, (size, column) in zip(against.RUNS, [(10, 1), (10, 2), (20, 1), (20, 2)]):
        values = sorted(run[column] for run in runs if run[0] == size)
        assert values == pytest.approx([fact.low, fact.middle, fact.high], abs=0.006)


def test_the_page_states_the_rank_correlations_of_the_notebook():
    """Every "(+0.8)" of the page is printed by the notebook, which computes them."""
    folder = Path(__file__).parents[1] / "notebooks"
    cells = json.loads((folder / "against-experiment.ipynb").read_text(encoding="utf-8"))["cells"]
    printed = "".join(line for cell in cells for output in cell.get("outputs", ()) for line in output.get("text", ()))
    table = printed.partition("depends_on")[2]
    page = (folder / "site" / "against-experiment.md").read_text(encoding="utf-8").partition("What limits")[2]
    stated = re.findall(r"\(([+−]0\.\d)\)", page)
    assert len(stated) >= 6 and all(correlation.replace("−", "-") in table for correlation in stated)
    humid = next(line for line in table.splitlines() if line.startswith("Çolak"))
    assert re.search(r"humidity (\S+),", humid)[1] == re.search(r"humid draws[^()]*\((\S+)\)", page)[1]
