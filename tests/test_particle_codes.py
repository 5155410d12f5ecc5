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


def test_what_cannot_be_handed_over_is_refused(pulls):
    with pytest.raises(ValueError, match="code: expected one of 'lammps'"):
        particles.to_dem(pulls, code="lamps")
    few = particles.to_dem(pulls.isel(subregion=slice(3)), code="lammps")  # as many classes as there are places
    assert "group class3 " in few and "group class4 " not in few
