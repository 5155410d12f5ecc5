"""A fit counts the roughness finer than the scan, and its uncertainty, where an extrapolation gives it."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.vocabulary.error_sources import UNSEEN

from .surfaces import as_measured

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

TRUE = 0.3
QUICK = {"mesh": roughxr.Mesh(1, step=0.5), "law": "exponential", "subregions": (2, 2)}
SUMMED = {"subregions": (6, 6)}


def surface(seed, work=TRUE, n=12, scale=1.0):
    """Return a scan, and pull-offs simulated at random places of it with the instrument's noise."""
    ds = self_affine((64, 64), 8.0, rms=1.2 * scale, hurst=0.8, rolloff=120, cutoff=40, seed=seed)
    pair = {"sphere_radius": 1000, "contact_modulus": 40, "work_of_adhesion": 0.1, "adhesion_range": 0.3}
    ds = ds.contact.assign_pair(**pair)
    rng = np.random.default_rng(seed)
    places = tuple(rng.uniform(-180, 180, (2, n)) + [[float(ds[axis].mean())] for axis in "xy"])
    solution = ds.assign_coords(work_of_adhesion=work).contact.adhesive(**QUICK | {"subregions": places})
    return ds, solution.assign(pull_off_force=solution.pull_off_force * np.exp(0.05 * rng.standard_normal(n)))


def extrapolation(factor, spread):
    """Return what `fit_pair` reads of a result of `extrapolated`: a factor, whose 95 % interval spans a factor."""
    errors = {"entry": ["places", UNSEEN], "relative_std": ("entry", [9.0, np.log(spread) / 1.96])}
    return xr.Dataset(errors | {"roughness_factor": factor})


def change_of_force(scan, fitted, end):
    """Return by how much ln(mean pull-off) changes from the fitted work of adhesion to an end of its interval."""
    works = fitted.fitted_work_of_adhesion, fitted[f"fitted_work_{end}"]
    means = [
        scan.assign_coords(work_of_adhesion=float(w)).contact.pull_off_map(**SUMMED).pull_off_force.mean()
        for w in works
    ]
    return abs(float(np.log(means[1] / means[0])))


def test_a_fit_with_what_the_scan_does_not_show():
    """Forces that unseen waves halve need more adhesion than the picture tells; the interval grows by their error.

    Sums over asperities are smooth in the work of adhesion, to better than the fit's tolerance.
    """
    how = {"method": "superposed", **SUMMED}
    scan, pulls = surface(0)
    unseen = extrapolation(0.5, 3.0)
    bare, more = (scan.contact.fit_pair(pulls, extrapolation=below, **how) for below in (None, unseen))
    halved = scan.contact.fit_pair(pulls.assign(pull_off_force=2 * pulls.pull_off_force), **how)
    np.testing.assert_allclose(more.fitted_work_of_adhesion, halved.fitted_work_of_adhesion, rtol=0.01)
    for end in ("low", "high"):  # as forces, which the exponent gives near the fitted work only
        unsure, sure = (change_of_force(scan, fitted, end) for fitted in (more, halved))
        assert unsure == pytest.approx(np.hypot(sure, np.log(3.0)), rel=0.15)
    assert "scan is not included" in roughxr.answer(bare).sentence
    assert "scan is included" in roughxr.answer(more).sentence
    for wrong in (unseen.assign(roughness_factor=np.nan), xr.Dataset()):
        with pytest.raises(ValueError, match="extrapolation: expected a result of `extrapolated`"):
            scan.contact.fit_pair(pulls, extrapolation=wrong, **how)


def test_what_extrapolated_finds_is_taken_as_it_is():
    glass = as_measured(roughxr.open_sample("glass"))
    scan = glass.contact.assign_pair(sphere_radius=300, materials="glass")
    options = {"subregions": (2, 2), "law": "exponential", "mesh": 1}
    pulls = scan.contact.adhesive(**options)
    below = scan.contact.extrapolated(subregions=(3, 3), mesh=1, places=1)
    with_unseen, bare = (scan.contact.fit_pair(pulls, extrapolation=estimate, **options) for estimate in (below, None))
    assert float(with_unseen.fitted_work_of_adhesion) > float(bare.fitted_work_of_adhesion)
    assert float(with_unseen.fitted_work_low) < float(with_unseen.fitted_work_of_adhesion)
