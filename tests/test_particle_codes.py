"""Adhesion handed to discrete-element codes: each code's own formula gives the pull-off force back."""

import re

import numpy as np
import pytest
import xarray as xr

from roughxr import particles, schema

RADIUS, PULLS = 2000.0, np.array([50.0, 100.0, 200.0, 300.0, 450.0, 900.0])


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


def test_dmt_of_4c_has_the_mean_and_spread(pulls):
    text = particles.to_dem(pulls, code="4c")
    energy = numbers(r"SURFACE_ENERGY: (\S+)", text)
    spread = numbers(r"STDDEV: (\S+)", text)
    assert 4 * np.pi * energy * RADIUS == pytest.approx([PULLS.mean()], rel=1e-5)
    assert 4 * np.pi * spread * RADIUS == pytest.approx([PULLS.std(ddof=1)], rel=1e-5)
    assert numbers(r"CUTOFF_FACTOR: (\S+)", text) * spread < energy  # no negative surface energy is drawn


def test_sjkr_of_liggghts_pulls_at_most_with_the_pull_off_force(pulls):
    text = particles.to_dem(pulls, code="liggghts", classes=2)
    density = np.array([float(value) for value in text.splitlines()[-1].split()])[:2]
    overlap = np.linspace(0, 1e-7, 200_001)  # m
    radius = RADIUS * 1e-9
    area = np.pi * (radius**2 - (radius - overlap) ** 2)
    for k, pull in zip(density, (PULLS[:3].mean(), PULLS[3:].mean())):
        force = 4 / 3 * 40e9 * np.sqrt(radius) * overlap**1.5 - k * area
        assert -force.min() * 1e9 == pytest.approx(pull, rel=2e-3)


@pytest.mark.parametrize("code", ["mercurydpm", "yade"])
def test_one_species_for_each_class(pulls, code):
    text = particles.to_dem(pulls, code=code, classes=2)
    found = numbers(r"AdhesionForceMax\((\S+)\);" if code == "mercurydpm" else r"pull-off (\S+) N", text)
    assert found == pytest.approx(np.array([PULLS[:3].mean(), PULLS[3:].mean()]) * 1e-9, rel=1e-4)


def test_what_cannot_be_handed_over_is_refused(pulls):
    with pytest.raises(ValueError, match="code: expected one of 'lammps'"):
        particles.to_dem(pulls, code="lamps")
    with pytest.raises(ValueError, match="classes: expected at most 6, the number of places that pull, found 7"):
        particles.to_dem(pulls, code="lammps", classes=7)
    few = particles.to_dem(pulls.isel(subregion=slice(3)), code="lammps")  # no classes asked for: as many as there are
    assert "group class3 " in few and "group class4 " not in few
