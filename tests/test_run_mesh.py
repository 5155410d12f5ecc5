"""The mesh that a run takes: fine enough by itself where pixels are wider than contacts."""

import warnings

import numpy as np
import pytest

from roughxr.runs import analysis
from roughxr.scans.synthetic import self_affine


@pytest.mark.parametrize(("cutoff", "refined"), [(40.0, True), (600.0, False)])
def test_a_run_refines_until_the_pull_off_settles(cutoff, refined):
    """On waves of two pixels the coarsest mesh is off by a factor, on long ones it will do."""
    scan = self_affine((64, 64), 20.0, rms=8, hurst=0.9, rolloff=800, cutoff=cutoff, seed=3)
    scan = scan.contact.assign_pair(sphere_radius=4000, contact_modulus=40, work_of_adhesion=0.1)
    plan = analysis.plan(scan, subregions=(2, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        groups = analysis._with_adhesion(scan, plan, {"subregions": plan.subregions}, lambda words: None)
        coarse = scan.contact.adhesive(subregions=plan.subregions, accuracy=None, step=plan.step)
        finest = scan.contact.adhesive(subregions=plan.subregions, refine=16 if refined else 4, step=0.5 * plan.step)
    solved, finer = groups["solutions/adhesive"], groups["solutions/finer"]
    assert (solved.refinement > coarse.refinement).all() == refined
    assert (finer.refinement == 2 * solved.refinement).all()
    change = float(abs(solved.pull_off_force / finest.pull_off_force - 1).median())
    first = float(abs(coarse.pull_off_force / finest.pull_off_force - 1).median())
    assert change < 0.1
    assert (first > 0.5) == refined
    assert np.isfinite(solved.pull_off_force).all()
