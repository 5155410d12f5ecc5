"""Adhesion handed to discrete-element codes: each code's own formula gives the pull-off force back."""

import re

import numpy as np
import pytest
import xarray as xr

from roughxr import particles, schema

RADIUS = 2000.0
PULLS = np.array([50.0, 100.0, 200.0, 300.0, 450.0, 900.0])


@pytest.fixture
def pulls():
    forces = {"pull_off_force": ("subregion", PULLS), "pull_off_delta": ("subregion", np.zeros(6))}
    pair = {"sphere_radius": RADIUS, "contact_modulus": 40.0, "work_of_adhesion": 0.1}
    return schema.label(xr.Dataset(forces, coords=pair))


def numbers(pattern: str, text: str) -> np.ndarray:
    return np.array([float(value) for value in re.findall(pattern, text)])


def test_jkr_of_lammps_gives_the_mean_of_each_class(pulls):
    text = particles.to_dem(pulls, code="lammps", classes=3)
    gamma = numbers(r"granular jkr \S+ \S+ \S+ (\S+)", text)
    assert 3 * np.pi * gamma * RADIUS == pytest.approx([75.0, 250.0, 675.0], rel=1e-5)
    (modulus,) = set(numbers(r"granular jkr (\S+)", text))
    assert modulus / (2 * (1 - 0.3**2)) == pytest.approx(40e9, rel=1e-5)


@pytest.mark.parametrize("shares", [np.ones(6) / 6, np.array([0.3, 0.05, 0.05, 0.1, 0.1, 0.4])])
@pytest.mark.parametrize("classes", [1, 4, 5])
def test_classes_keep_the_mean_over_the_particles(pulls, classes, shares):
    """Where they cut places, and where places hold unequal shares of the particles."""
    text = particles.to_dem(pulls.assign_coords(landing_share=("subregion", shares)), code="lammps", classes=classes)
    gamma = numbers(r"granular jkr \S+ \S+ \S+ (\S+)", text)
    assert 3 * np.pi * gamma.mean() * RADIUS == pytest.approx(shares @ PULLS, rel=1e-5)
    assert numbers(r"mean (\S+) N,", text) * 1e9 == pytest.approx([shares @ PULLS], rel=1e-4)
    law = particles.parameters(pulls.assign_coords(landing_share=("subregion", shares)))
    ratio = float(law.adhesion_mean) * 1.5 * np.pi * 0.1 * RADIUS
    assert np.log(ratio) == pytest.approx(shares @ np.log(PULLS))


def test_lines_for_lammps_can_be_included_where_the_atoms_exist(pulls):
    commands = {line.split()[0] for line in particles.to_dem(pulls, code="lammps").splitlines()}
    assert commands == {"#", "group", "fix"}  # units are not allowed after the box, nor groups before it


def test_what_cannot_be_handed_over_is_refused(pulls):
    with pytest.raises(
        ValueError, match=r"code: expected one of lammps, liggghts, rock_n_roll, found .*; for other codes write"
    ):
        particles.to_dem(pulls, code="lamps")
    classes = particles.to_dem(pulls.isel(subregion=slice(3)), code="lammps")  # as many classes as there are places
    assert "group class3 " in classes and "group class4 " not in classes


@pytest.mark.parametrize("young_modulus", [None, 0.1])
def test_the_energy_density_of_liggghts_gives_the_pull_off_of_its_published_force(pulls, young_modulus):
    """Hertz less k times the area of the spheres' intersection, drawn over all overlaps."""
    text = particles.to_dem(pulls, code="liggghts", classes=1, young_modulus=young_modulus)
    density = numbers(r"cohesion1 equal (\S+)", text)[0]
    modulus = 40e9 if young_modulus is None else 0.1e9 / (2 * (1 - 0.3**2))
    radius = RADIUS * 1e-9
    overlap = (np.pi * density / modulus) ** 2 * radius * np.linspace(0, 4, 4001)
    area = np.pi * (2 * radius * overlap - overlap**2)
    force = 4 / 3 * modulus * np.sqrt(radius) * overlap**1.5 - density * area
    assert -force.min() * 1e9 == pytest.approx(PULLS.mean(), rel=1e-3)
    energy = PULLS / (4 * np.pi * RADIUS)
    assert numbers(r"mean (\S+) J/m", text)[0] == pytest.approx(energy.mean(), rel=1e-4)
    assert numbers(r"deviation (\S+) J/m", text)[0] == pytest.approx(energy.std(ddof=1), rel=0.1)
