"""The table of laws of adhesion: names, synonyms at every door, and what the kernels and the pages have of it."""

import functools
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import reference
from roughxr.application.cli import main
from roughxr.mechanics.asperity.asperity_sum import FORMULATIONS
from roughxr.mechanics.kernels.adhesion import potentials, traction_laws
from roughxr.mechanics.kernels.asperity.asperity_laws import RANGED
from roughxr.mechanics.vocabulary.adhesion_laws import (
    ADHESION_LAWS,
    AUTO,
    DUGDALE,
    EXPONENTIAL,
    HERTZ,
    JKR,
    LENNARD_JONES,
    laws_of,
)

from .surfaces import rough, scan

CONCEPTS = Path(__file__).parents[1] / "notebooks" / "site" / "concepts.md"

#: A soft pair, whose range of adhesion the pixels resolve by every law.
PAIR = {"sphere_radius": 300.0, "contact_modulus": 20.0, "work_of_adhesion": 0.02, "adhesion_range": 5.0}


def surface():
    return roughxr.assign_pair(scan(rough(16, rms=1.0, smooth=2.0, seed=3), pixel=8.0), **PAIR)


def curves():
    delta = np.linspace(6000.0, -4000.0, 600)
    contact = reference.jkr_sphere(delta[::-1], radius=2000, contact_modulus=0.0001, work_of_adhesion=0.05)
    force = contact.force.fillna(0.0).values[::-1] + np.random.default_rng(0).normal(0, 2.0, 600)
    made = {"piezo": ("sample", delta + force / 10.0, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})}
    return xr.Dataset(made)


VERBS = {
    "adhesive": lambda law: roughxr.adhesive(surface(), law=law, mesh=roughxr.Mesh(1, None, 2.0)),
    "rigid": lambda law: roughxr.rigid(surface(), law=law, delta=[0.0]),
    "superpose": lambda law: roughxr.superpose(surface(), law=law, delta=[1.0, 4.0]),
    "pull_off_map": lambda law: roughxr.pull_off_map(surface(), law=law, subregions=(2, 2)),
    "fit_curve": lambda law: roughxr.measured.fit_curve(
        curves(), sphere_radius="2 um", spring_constant="10 N/m", law=law
    ),
}
SYNONYMS = [
    (verb, name, synonym)
    for verb in VERBS
    for name in laws_of(verb)
    for synonym in (*ADHESION_LAWS[name].synonyms, name.upper().replace("_", "-"))
]


@functools.cache
def result_by_name(verb, name):
    """Return the result of a verb by the name of a law, computed once for all its synonyms."""
    return VERBS[verb](name)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("verb", "name", "synonym"), SYNONYMS)
def test_a_synonym_gives_the_result_of_the_name(verb, name, synonym):
    by_name = result_by_name(verb, name)
    by_synonym = VERBS[verb](synonym)
    xr.testing.assert_identical(by_name.drop_attrs(), by_synonym.drop_attrs())
    assert by_synonym.attrs.get("law") == by_name.attrs.get("law") != synonym


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_without_a_law_names_those_that_it_has(verb):
    for name in (*ADHESION_LAWS, "sticky"):
        if name in laws_of(verb):
            continue
        with pytest.raises(ValueError, match="law: expected one of") as refused:
            VERBS[verb](name)
        assert re.findall(r"'(\w+)'", str(refused.value)) == [*laws_of(verb), name]


def test_a_misspelt_synonym_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match=r"found 'mauguis' \(did you mean maugis\?\)"):
        roughxr.superpose(surface(), law="mauguis", delta=[1.0])


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_other_functions_take_synonyms():
    options = {"rms": 0.3, "length": 0.3}
    assert reference.gaussian_work(law="LJ", **options) == reference.gaussian_work(law=LENNARD_JONES, **options)
    table = roughxr.formulas(surface(), law="van der Waals", mesh=1, subregions=(1, 1))
    assert float(table.formula_ratio[0]) == 1
    unchanged = {"modulus": [1.0]}
    budget = roughxr.error_budget(surface(), law="griffith", mesh=1, places=1, subregions=(1, 1), settings=unchanged)
    assert budget.attrs["law"] == JKR


def test_the_shell_names_the_laws_of_the_simulation(tmp_path, capsys):
    surface().drop_attrs(deep=False).to_netcdf(tmp_path / "scan.nc")
    pair = ["--sphere-radius", "300", "--materials", "glass"]
    assert main(["run", str(tmp_path / "scan.nc"), *pair, "--law", "hertz", "-o", str(tmp_path / "o.nc")]) == 1
    message = capsys.readouterr().err
    assert "--law: expected one of" in message
    assert all(repr(name) in message for name in laws_of("adhesive"))


def test_kernels_have_the_laws_of_their_verbs():
    assert {*traction_laws.LAWS, AUTO} == set(laws_of("adhesive"))
    assert set(potentials.POTENTIALS) == set(laws_of("rigid"))
    assert {*RANGED, JKR, HERTZ} == set(laws_of("superpose"))
    assert {*ADHESION_LAWS[JKR].formulations} == {*FORMULATIONS}


def test_no_name_or_synonym_stands_for_two_laws():
    names = [text for name, row in ADHESION_LAWS.items() for text in (name, *row.synonyms)]
    assert len(names) == len(set(names))


def test_a_largest_cell_is_as_stiff_as_the_steepest_slope():
    """|dt/du| of a law on unit cells is at most 1 where w/length² is the row's; beyond, no constant part remains."""
    for name in (EXPONENTIAL, LENNARD_JONES):
        law = traction_laws.LAWS[name](ADHESION_LAWS[name].largest_cell, 1.0, np.inf)
        assert law.steepest == pytest.approx(1)
    wide, wider = (traction_laws.LAWS[DUGDALE](w * ADHESION_LAWS[DUGDALE].largest_cell, 1.0, 0.125) for w in (0.9, 1))
    assert wide.step.near > wider.step.near == 0


def test_the_page_of_lengths_has_every_law_of_contact():
    rows = re.findall(r"^\| `(\w+)`.*\|$", CONCEPTS.read_text(encoding="utf-8"), re.MULTILINE)
    assert {*laws_of("adhesive"), *laws_of("superpose")} - {AUTO, HERTZ} <= set(rows)
    assert not {synonym for row in ADHESION_LAWS.values() for synonym in row.synonyms} & set(rows)
