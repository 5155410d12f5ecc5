"""The pair of bodies, against the paper's numbers and limits."""

import numpy as np
import pytest
import xarray as xr

from roughxr.materials import assign_pair, contact_modulus, gilman_surface_energy
from roughxr.units import factor, magnitude

from .surfaces import scan


def test_the_papers_pair():
    assert contact_modulus(75, 0.22) == pytest.approx(39.407, abs=5e-4)
    assert gilman_surface_energy(75) == pytest.approx(0.6421, abs=5e-5)
    plane_strain = gilman_surface_energy(75, poisson_ratio=0.22)
    assert plane_strain == pytest.approx(0.67478, abs=5e-6)
    assert 3 * np.pi * plane_strain * 3000 == pytest.approx(19.08e3, rel=1e-3)  # the printed 19.1 µN


def test_a_rigid_body_adds_no_compliance():
    assert contact_modulus((75, np.inf), (0.22, 0.3)) == pytest.approx(2 * contact_modulus(75, 0.22))
    assert contact_modulus((75, 200), (0.22, 0.3)) == pytest.approx(1 / ((1 - 0.22**2) / 75 + (1 - 0.3**2) / 200))


def test_surface_energy_is_half_the_work_of_adhesion():
    ds = scan(np.zeros((4, 4)))
    one, other = (
        assign_pair(ds, sphere_radius=3, contact_modulus=40, **energy)
        for energy in ({"surface_energy": 0.5}, {"work_of_adhesion": 1.0})
    )
    assert float(one.work_of_adhesion) == float(other.work_of_adhesion) == 1.0


def test_any_unit_of_the_right_kind_is_taken():
    pint = pytest.importorskip("pint")
    quantity = pint.UnitRegistry().Quantity
    for radius in ("3 um", "3 µm", quantity(3e-6, "m"), xr.DataArray(3.0, attrs={"units": "um"}), 3000):
        pair = assign_pair(scan(np.zeros((4, 4))), sphere_radius=radius, young_modulus="75 GPa", poisson_ratio=0.2)
        assert float(pair.sphere_radius) == 3000.0
        assert pair.sphere_radius.units == "nm"
    assert factor("mJ m-2", "nN nm-1") == pytest.approx(1e-3)
    assert magnitude("40 kPa", "GPa", "modulus") == pytest.approx(4e-5)


def test_the_pair_survives_a_file(tmp_path):
    pair = assign_pair(scan(np.zeros((4, 4))), sphere_radius=3, contact_modulus=40)
    pair.to_netcdf(tmp_path / "pair.nc")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "pair.nc"), pair)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "sphere_radius or indenter, found neither"),
        ({"sphere_radius": 3}, "found neither"),
        ({"sphere_radius": -3, "contact_modulus": 1}, "positive"),
        ({"sphere_radius": "3 GPa", "contact_modulus": 1}, "nm"),
        ({"sphere_radius": "three", "contact_modulus": 1}, "sphere_radius"),
        ({"sphere_radius": [1, 2], "contact_modulus": 1}, "one positive number"),
        ({"sphere_radius": np.nan, "contact_modulus": 1}, "finite"),
        ({"sphere_radius": 3, "young_modulus": 75}, "poisson_ratio"),
        ({"sphere_radius": 3, "young_modulus": 75, "poisson_ratio": 0.7}, "poisson_ratio"),
        ({"sphere_radius": 3, "young_modulus": (1, 2, 3), "poisson_ratio": 0.2}, "pair"),
        ({"sphere_radius": 3, "young_modulus": np.inf, "poisson_ratio": 0.2}, "elastic"),
        ({"sphere_radius": 3, "contact_modulus": 1, "young_modulus": 2}, "found both"),
        ({"sphere_radius": 3, "contact_modulus": 1, "surface_energy": -1}, ">= 0"),
        (
            {"sphere_radius": 3, "contact_modulus": 1, "surface_energy": 1, "work_of_adhesion": 1},
            "found both",
        ),
    ],
)
def test_bad_pairs_are_refused_in_words(options, says):
    with pytest.raises(ValueError, match=says):
        assign_pair(scan(np.zeros((4, 4))), **options)
