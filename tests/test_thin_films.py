"""Thin soft films: law, steps and cells of adhesion follow the modulus at the size of the contact."""

import numpy as np
import pytest

import roughxr
from roughxr import Layer
from roughxr.mechanics.bodies.layer import film_of
from roughxr.mechanics.contact.adhesive_options import usual_step
from roughxr.mechanics.contact.mesh import UnresolvedContact
from roughxr.mechanics.kernels.halfspace.layered import contact_at_pull_off
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.specimen import specimen_of

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

FILM = {"young_modulus": 0.2, "poisson_ratio": 0.3}
BASE = {"young_modulus": 130.0, "poisson_ratio": 0.28}


def assigned(body, layer=None):
    """Return a rough scan with a glass sphere on a body, with or without a layer."""
    scan = self_affine((24, 24), 4.0, rms=1.0, hurst=0.8, rolloff=50, cutoff=16, seed=5)
    ratios = (0.22, body["poisson_ratio"])
    pair = {"young_modulus": (75.0, body["young_modulus"]), "poisson_ratio": ratios, "work_of_adhesion": 0.1}
    return scan.contact.assign_pair(sphere_radius=200, **pair, **({"layer": layer} if layer else {}))


@pytest.mark.parametrize(("thickness", "body"), [(1e-4, BASE), (1e5, FILM)], ids=["no film", "half space"])
def test_a_film_has_two_limits_for_law_and_steps(thickness, body):
    """Tabor's parameters and the step are those of the base below no film, and of the film's half space."""
    coated = assigned(BASE, Layer(1.0, **FILM)).assign_coords(layer_thickness=thickness)
    bare = assigned(body)
    parameters = (roughxr.reference.tabor(ds).tabor_parameter for ds in (coated, bare))
    np.testing.assert_allclose(*parameters, rtol=0.01)
    steps = [usual_step(specimen_of(ds)) for ds in (coated, bare)]
    assert steps[0] == pytest.approx(steps[1], rel=0.01)


def test_tabors_parameter_grows_with_the_thickness_of_a_soft_film():
    """From the base's to the film's, so that the range is neglected on thick films only."""
    medians = []
    for thickness in (0.1, 0.3, 1.0, 10.0, 100.0):
        parameters = roughxr.reference.tabor(assigned(BASE, Layer(thickness, **FILM))).tabor_parameter
        medians.append(float(parameters.median()))
    assert (np.diff(medians) > 0).all()
    assert medians[0] < 1 < 5 < medians[-1]


@pytest.mark.parametrize("ratio", [0.3, 0.499])
def test_the_contact_and_the_modulus_at_its_size_agree(ratio):
    """On soft and on stiff films, also nearly incompressible ones: the iteration has converged."""
    radius = np.array([10.0, 100.0, 1000.0])
    for young in (0.01, 1.0, 1000.0):
        film = film_of(assigned(BASE, Layer(3.0, young_modulus=young, poisson_ratio=ratio)))
        contact, modulus = contact_at_pull_off(radius, 0.1, 0.5, film)
        np.testing.assert_allclose(contact, (9 * np.pi * 0.1 * radius**2 / (8 * modulus)) ** (1 / 3), rtol=1e-3)
        np.testing.assert_allclose(modulus, 0.5 / film.softening(contact), rtol=1e-12)


def test_a_thin_film_pulls_off_by_the_range_of_the_pair():
    """By default as by the pair's own law on fine cells, within the stated error."""
    ds = assigned(BASE, Layer(0.2, **FILM))
    place = {"subregions": ([48.0], [48.0])}
    solution = ds.contact.adhesive(**place)
    finer = ds.contact.adhesive(law="exponential", mesh=8, **place)
    assert solution.attrs["law"] == "exponential"
    error = abs(float(solution.pull_off_force[0] / finer.pull_off_force[0]) - 1)
    assert error <= float(solution.pull_off_error[0]) < 0.2


def test_one_mesh_without_an_error_says_so():
    """By a law with a range it states none; cells that do not resolve the law are named."""
    options = {"law": "exponential", "subregions": ([48.0], [48.0]), "mesh": 1}
    with pytest.warns(UnresolvedContact, match="no error estimate"):
        assigned(BASE).contact.adhesive(**options)
    with pytest.warns(UnresolvedContact, match="do not resolve its traction"):
        assigned({"young_modulus": 1.0, "poisson_ratio": 0.3}).contact.adhesive(**options)
