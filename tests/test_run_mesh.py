"""The mesh that a run takes: fine enough by itself where pixels are wider than contacts."""

import io
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.application.runs import analysis, parts, run_mesh
from roughxr.application.runs.stages import Stages
from roughxr.mechanics.contact import adhesive_options
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.specimen import specimen_of

from . import surfaces


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with surfaces.unpressed():
        yield


@pytest.mark.parametrize(("cutoff", "refined"), [(40.0, True), (600.0, False)])
def test_a_run_refines_until_the_pull_off_settles(cutoff, refined):
    """On waves of two pixels the coarsest mesh is off by a factor, on long ones it will do."""
    scan = self_affine((64, 64), 20.0, rms=8, hurst=0.9, rolloff=800, cutoff=cutoff, seed=3)
    scan = scan.contact.assign_pair(sphere_radius=4000, contact_modulus=40, work_of_adhesion=0.1)
    plan = analysis.plan(specimen_of(scan), subregions=(2, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        groups = parts._adhesive_simulation(analysis.Task(specimen_of(scan), plan))
        rough = replace(plan.mesh, accuracy=None)
        fine = roughxr.Mesh(16 if refined else 4, step=0.5 * plan.mesh.step)
        coarse, finest = (scan.contact.adhesive(subregions=plan.subregions, mesh=mesh) for mesh in (rough, fine))
    solved = groups["solutions/adhesive"]
    finer = groups["solutions/finer"]
    assert (solved.mesh > coarse.mesh).all() == refined
    assert (finer.mesh == 2 * solved.mesh).all()
    change = float(abs(solved.pull_off_force / finest.pull_off_force - 1).median())
    first = float(abs(coarse.pull_off_force / finest.pull_off_force - 1).median())
    assert change < 0.1
    assert (first > 0.5) == refined
    assert np.isfinite(solved.pull_off_force).all()


def test_a_run_tells_its_answer_from_the_first_places_on(tmp_path):
    scan = self_affine((64, 64), 20.0, rms=8, hurst=0.9, rolloff=800, cutoff=600, seed=3)
    scan = scan.contact.assign_pair(sphere_radius=4000, contact_modulus=40, work_of_adhesion=0.1)
    plan = analysis.plan(specimen_of(scan), subregions=(4, 3))
    stream = io.StringIO()
    options = {"subregions": plan.subregions}
    with warnings.catch_warnings(), roughxr.progress(stream), Stages({"adhesive": 1}, {}) as stage:
        warnings.simplefilter("ignore", UserWarning)
        groups = roughxr.checkpointed(
            lambda: parts._adhesive_simulation(analysis.Task(specimen_of(scan), plan, stage)),
            tmp_path / "run.nc",
            scan=scan,
            arguments={"places": (4, 3)},
        )
        alone = scan.contact.adhesive(mesh=replace(plan.mesh, accuracy=None), **options)
    answers = [line for line in stream.getvalue().splitlines() if "Mean pull-off" in line]
    assert [re.search(r"(\d+) places", line)[1] for line in answers] == ["4", "12"]  # none before the mesh was checked
    assert all("numerical error" in line for line in answers)
    mean = float(groups["solutions/adhesive"].pull_off_force.mean())
    assert ["interval" in line for line in answers] == [False, True]  # four places are too few for an interval
    low, high, unit = re.search(r"interval ([\d.]+) … ([\d.]+) (.)N", answers[-1]).groups()
    assert float(low) <= mean / {"n": 1, "µ": 1e3, "m": 1e6}[unit] <= float(high)
    # the first places are solved again, with their moments
    kept = [line for line in groups["log"].message.values.tolist() if line.endswith("kept")]
    assert kept == [f"adhesive: {share} subregions kept" for share in ("0 of 4", "0 of 4", "0 of 12")]
    np.testing.assert_array_equal(groups["solutions/adhesive"].pull_off_force, alone.pull_off_force)


def test_a_run_ends_where_its_first_places_have_no_pull_off(tmp_path, monkeypatch):
    """Too soft for its scan, it says so before it begins, and ends after four places, not after all of them."""
    solved = []

    def never(ds, *, subregions, **options):
        solved.append(subregions.sizes["subregion"])
        none = np.full(subregions.sizes["subregion"], np.nan)
        events = {"pull_off_force": none, "complete": none == 0, "truncated": none != none, "mesh": none == 0}
        return xr.Dataset({name: ("subregion", values) for name, values in events.items()})

    monkeypatch.setattr(parts, "adhesive", never)
    monkeypatch.setattr(run_mesh, "adhesive", never)
    soft = roughxr.assign_pair(
        surfaces.scan(surfaces.rough(32, seed=3)), sphere_radius=800, contact_modulus=2e-2, work_of_adhesion=0.2
    )
    for refine in ("auto", 2):
        with pytest.raises(ValueError, match=r"found none \(4 not completed, 4 in contact at.*use a larger scan"):
            roughxr.run(soft, tmp_path / f"{refine}.nc", delta=[1.0], mesh=refine, budget=0)
    assert solved == [4, 4]
    with pytest.raises(ValueError, match=r"contact that fits on a scan of 313 nm, found one 2.44e\+03 nm wide"):
        roughxr.run(soft.assign_coords(contact_modulus=1e-3), tmp_path / "run.nc", delta=[1.0], budget=0)


def test_a_run_takes_the_finest_mesh_that_can_be_solved(monkeypatch):
    scan = self_affine((64, 64), 20.0, rms=8, hurst=0.9, rolloff=800, cutoff=40, seed=3)
    scan = scan.contact.assign_pair(sphere_radius=4000, contact_modulus=40, work_of_adhesion=0.1)
    plan = analysis.plan(specimen_of(scan), subregions=(2, 1))
    options = {"subregions": (2, 1)}
    with warnings.catch_warnings(), Stages({"adhesive": 1}, {}) as stage:
        warnings.simplefilter("ignore", UserWarning)
        free = run_mesh.converged_mesh(specimen_of(scan), plan, options, stage)
        monkeypatch.setattr(adhesive_options, "MOST_CELLS", 6000)
        mesh, finer, _ = run_mesh.converged_mesh(specimen_of(scan), plan, options, stage)
    solved = scan.contact.adhesive(mesh=mesh, **options)
    assert (finer.mesh == 2 * solved.mesh).all()
    assert (finer.mesh < free.mesh.cells).all()
