"""Soft bodies: attraction that acts across gaps on loading, and lengths that follow the body's own."""

import time

import numpy as np
import pytest
from scipy import special

import roughxr
from roughxr.contact import adhesive_options
from roughxr.contact.adhesive_options import snap_in_gap
from tests import surfaces


def rough(**pair):
    """Return a soft rough surface on which first contact is one low summit at its last place."""
    made = roughxr.scans.synthetic.self_affine((64, 64), 20.0, rms=12, hurst=0.8, rolloff=640, cutoff=80, seed=1)
    return made.contact.assign_pair(**({"sphere_radius": 2000, "contact_modulus": 0.3, "work_of_adhesion": 0.1} | pair))


def test_a_soft_body_settles_beyond_its_first_summit():
    """Without a preload it pulls off as after one; with contacts alone it pulled 7 times less."""
    place = {"subregions": ([840.0], [840.0]), "law": "griffith"}
    found = rough().contact.adhesive(mesh=roughxr.Mesh(2, step=0.5), **place)
    pressed = rough().contact.adhesive(mesh=roughxr.Mesh(2, None, 0.5), preload=20.0, **place)
    assert found.pull_off_force.values == pytest.approx(pressed.pull_off_force.values, rel=0.02)


def test_the_stated_error_includes_what_a_preload_changes(monkeypatch):
    """Without attraction across gaps the sphere is left on its first summit, and the error states it."""
    monkeypatch.setattr(adhesive_options, "snap_in_gap", lambda length, parameter: 0.0)
    ds = rough()
    place = {"subregions": ([840.0], [840.0]), "law": "griffith"}
    found = ds.contact.adhesive(mesh=roughxr.Mesh(2, step=0.5), **place)
    pressed = ds.contact.adhesive(mesh=roughxr.Mesh(2, None, 0.5), preload=20.0, **place)
    off = abs(float(pressed.pull_off_force[0] / found.pull_off_force[0]) - 1)
    assert off > 1.0
    assert float(found.settling_error[0]) == pytest.approx(off, rel=0.05)
    assert float(found.pull_off_error[0]) >= float(found.settling_error[0])


def test_the_gap_of_snapping_in_grows_with_the_range_and_vanishes_with_it():
    """As ρ^{4/7} at a fixed pair, where µ ~ 1/ρ; bodies that do not jump have no such gap."""
    lengths = np.array([1e-9, 1e-8, 1e-7, 1e-6])
    gaps = [snap_in_gap(length, 3.0 / length) for length in lengths]
    np.testing.assert_allclose(np.diff(np.log10(gaps)), 4 / 7, rtol=1e-3)
    assert snap_in_gap(0.3, float("nan")) == snap_in_gap(0.3, 0.6) == 0.0


@pytest.mark.parametrize("tabor", [1.0, 2.0, 5.0, 20.0])
def test_a_sphere_snaps_in_where_its_equations_turn_back(tabor):
    """Rings of a half space under van der Waals attraction, by Newton's method: the least gap on the way to contact.

    Lengths in z₀, radii in √(R z₀): z = 1 + D + r²/2 − µ^{3/2} G t(z), where z is z₀ more than the gap.
    """
    edges = np.linspace(0.0, 14.0, 161)
    r = 0.5 * (edges[1:] + edges[:-1])
    response = tabor**1.5 * np.diff(np.array([_sunk_under_disc(r, a) for a in edges]).T, axis=1)
    z, gap, least, size = 20 + 0.5 * r**2, 19.0, np.inf, r.size
    for middle in np.geomspace(20, 1.1, 300):
        for _ in range(30):
            residual = np.append(z - 1 - gap - 0.5 * r**2 + response @ (8 / 3 * (z**-3 - z**-9)), z[0] - middle)
            slopes = np.zeros((size + 1, size + 1))
            slopes[:size, :size] = np.eye(size) + response * (8 / 3 * (9 * z**-10 - 3 * z**-4))
            slopes[:size, size], slopes[size, 0] = -1.0, 1.0
            change = np.linalg.solve(slopes, -residual)
            z, gap = z + change[:size], gap + change[size]
            if np.abs(change).max() < 1e-9:
                break
        if gap > least:
            break
        least = gap
    assert snap_in_gap(0.3, tabor) == pytest.approx(0.3 * least, rel=0.01)


def _sunk_under_disc(r, a):
    """Return the displacement at radii r under unit pressure on a disc of radius a, at unit E*."""
    inside = np.clip(r / max(a, 1e-300), 0.0, 1.0) ** 2
    outside = np.clip(a / r, 0.0, 1.0) ** 2
    beyond = r * (special.ellipe(outside) - (1 - outside) * special.ellipk(outside * (1 - 1e-15)))
    return 4 / np.pi * np.where(r <= a, a * special.ellipe(inside), beyond)


def smooth(pixels=61, pixel=20.0):
    """Return a plane under a small soft sphere, on which JKR's contact is larger than the sphere's usual steps."""
    scan = surfaces.scan(np.zeros((pixels, pixels)), pixel)
    return scan.contact.assign_pair(sphere_radius=500, contact_modulus=2e-3, work_of_adhesion=0.05)


def test_a_mesh_of_too_many_cells_names_the_finest_that_is_not():
    """It is refused before anything is solved; the named one is not."""
    ds = smooth(401, 5.0)
    with pytest.raises(ValueError, match=r"found .* with mesh=16; take mesh=\d+"):
        ds.contact.adhesive(mesh=16)


def test_a_soft_sphere_on_a_smooth_scan_is_solved_within_a_minute():
    """Law, steps and cells follow the sphere alone, JKR's displacement of 109 nm and radius of 280 nm."""
    with surfaces.paraboloids():
        began = time.process_time()
        solution = smooth().contact.adhesive(mesh=roughxr.Mesh(accuracy=None))
    assert time.process_time() - began < 120  # half of it to compile
    assert solution.attrs["law"] == "griffith"
    assert float(solution.pull_off_force[0]) == pytest.approx(1.5 * np.pi * 0.05 * 500, rel=0.01)


def test_a_range_far_below_the_cells_is_refused_at_once():
    """w dx/(E* ρ²) = 350 on the finest cells, where Newton's method does not end."""
    with pytest.raises(ValueError, match=r"cells of at most .* nm .*; take law='griffith'"):
        smooth().contact.adhesive(law="exponential")
