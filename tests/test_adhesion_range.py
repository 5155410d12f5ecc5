"""How far adhesion reaches, and how hard the bodies are, is asked once, of the pair; every verb reads it there."""

import numpy as np
import pytest

import roughxr
from roughxr.mechanics.bodies.pair_record import read_pair
from roughxr.mechanics.scans.synthetic import self_affine


@pytest.fixture(scope="module")
def pair():
    ground = self_affine((48, 48), 5.0, rms=1, hurst=0.8, rolloff=100, cutoff=30, seed=2)
    return ground.contact.assign_pair(sphere_radius=300, contact_modulus=40, work_of_adhesion=0.1)


PLACES = {"subregions": (2, 1)}
VERBS = {
    "tabor": lambda ds: roughxr.reference.tabor(ds).tabor_parameter,
    "regime": lambda ds: ds.contact.regime(subregions=(1, 1), mesh=1).asperity_tabor,
    "superpose": lambda ds: ds.contact.superpose(delta=[8.0], law="dugdale", **PLACES).force,
    "pull_off_map": lambda ds: ds.contact.pull_off_map(law="dugdale", **PLACES).pull_off_force,
    "rigid exponential": lambda ds: ds.contact.rigid(law="exponential", delta=[0.0], **PLACES).pull_off_force,
    "rigid dugdale": lambda ds: ds.contact.rigid(law="dugdale", delta=[0.0], **PLACES).pull_off_force,
    "rigid lennard_jones": lambda ds: ds.contact.rigid(law="lennard_jones", delta=[0.0], **PLACES).pull_off_force,
    "formulas": lambda ds: ds.contact.formulas(subregions=(1, 1), law="exponential", mesh=1).pull_off_force[:1],
    "adhesive": lambda ds: ds.contact.adhesive(law="exponential", mesh=1, subregions=([120.0], [120.0])).pull_off_force,
}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("verb", VERBS)
def test_each_verb_reads_the_range_of_the_pair(pair, verb):
    """None assigned is 0.3 nm for all of them, and another range is another result."""
    bare, usual, far = (VERBS[verb](ds) for ds in (pair, *(pair.assign_coords(adhesion_range=z) for z in (0.3, 1.0))))
    np.testing.assert_array_equal(bare.values, usual.values)
    assert not np.isclose(far.values, usual.values, rtol=1e-3).any()


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_tabors_parameter_goes_with_the_range_to_the_minus_one(pair):
    """Ten times the range is a tenth of the parameter, in the table of asperities and in what is recommended."""
    far = pair.assign_coords(adhesion_range=3.0)
    for verb in ("tabor", "regime"):
        np.testing.assert_allclose(VERBS[verb](far).values, VERBS[verb](pair).values / 10, rtol=1e-12)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_a_range_far_above_what_summits_bend_is_not_said_to_be_none():
    """Soft summits whose adhesion reaches 5 nm: Tabor's parameter is 0.64, and no sum without range is recommended."""
    ground = self_affine((64, 64), 10.0, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=3)
    soft = ground.contact.assign_pair(sphere_radius=1000, contact_modulus=0.5, work_of_adhesion=0.1)
    near, far = (soft.assign_coords(adhesion_range=z).contact.regime(subregions=(1, 1), mesh=1) for z in (0.3, 5.0))
    assert float(near.asperity_tabor) > 5 > 1 > float(far.asperity_tabor)
    assert far.recommended.item() == "adhesive"


def test_the_closest_approach_of_a_hamaker_constant_is_another_length(pair):
    """A = 12π z₀² w: Hamaker's sum ends there whatever the range, and Lennard-Jones takes its length from it."""
    stated_both = pair.assign_coords(hamaker_constant=12 * np.pi * 0.2**2 * 0.1)
    solutions = [
        ds.contact.rigid(delta=[-9.0], **PLACES) for ds in (stated_both, stated_both.assign_coords(adhesion_range=2.0))
    ]
    np.testing.assert_array_equal(solutions[0].force, solutions[1].force)
    assert solutions[1].attrs["closest_approach"] == pytest.approx(0.2)
    assert read_pair(stated_both).range_of("lennard_jones") == pytest.approx(0.2 * np.sqrt(0.75))
    assert read_pair(stated_both).range == read_pair(stated_both).range_of("exponential") == 0.3
    assert read_pair(pair).range_of("lennard_jones") == 0.3
    assert read_pair(stated_both.assign_coords(adhesion_range=2.0)).range_of("lennard_jones") == 2.0
