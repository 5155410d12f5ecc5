"""Runs, reports, figures and the command line of bodies that yield, or are told to."""

import dask
import numpy as np
import pytest
from matplotlib.figure import Figure

import roughxr
from roughxr import archive, report, statistics
from roughxr.application import cli
from roughxr.application.runs import analysis
from roughxr.mechanics.studies.uncertainty_budget import budget_of

from .surfaces import bare_runs, rough, scan


def surface():
    return scan(rough(64, smooth=1.5, seed=4), pixel=10.0, source_file="surface.nc")


@pytest.fixture(scope="module")
def groups(tmp_path_factory):
    """The groups of a run that was kept as it came, and read again."""
    pair = roughxr.assign_pair(
        surface(), sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05, hardness="3 GPa"
    )
    path = tmp_path_factory.mktemp("run") / "run.nc"
    options = {"subregions": (2, 1), "delta": [4, 8, 12], "preload": 3000.0, "mesh": 1, "budget": 0}
    with dask.config.set(scheduler="synchronous"), bare_runs("extrapolated", "curves", "rolling"):
        analysis.run(pair, path, **options)
    return archive.load(path)


def test_a_run_keeps_both_ways(groups):
    there = groups["solutions/direct"]
    back = groups["solutions/retraction"]
    assert there.force.dims == back.force.dims == ("subregion", "delta")
    assert (back.force <= there.force * (1 + 1e-6)).all()
    assert (back.force.isel(delta=1) < 0.9 * there.force.isel(delta=1)).any()
    assert (there.plastic_work.isel(delta=-1) > 0).all() and float(there.hardness) == 3.0
    contact = groups["solutions/contact"]
    assert float(contact.pressure.max()) == 3.0 and float(contact.residual_height.min()) < 0
    assert float(groups["solutions/adhesive"].plastic_work.min()) > 0
    assert bool(groups["statistics/regime"].yields.notnull().all())


def test_its_report_says_what_yields(groups):
    cautions = " ".join(report.cautions(groups))
    share = 100 * float(groups["solutions/direct"].isel(delta=-1).yielded_fraction.mean())
    assert cautions.count("yields at its hardness, 3 GPa: in the direct simulation") == 1
    assert f"with {share:.2g} % of the force" in cautions
    assert "in the simulation with adhesion at its preload" in cautions
    assert "do not include yield" in cautions


@pytest.mark.parametrize("options", [["--hardness", "1"], ["--hardness", "1", "--law", "dugdale"]])
def test_the_command_line_advises_what_can_be_typed_there(options, tmp_path, capsys):
    path = roughxr.scans.to_netcdf(surface(), tmp_path / "scan.nc")
    pair = ["--sphere-radius", "500", "--contact-modulus", "40", "--work-of-adhesion", "0.5", "--subregions", "1", "1"]
    assert cli.main(["run", str(path), "-o", str(tmp_path / "out"), "-q", *pair, *options]) == 1
    printed = capsys.readouterr().err
    assert "assign no hardness" in printed and "yielding=" not in printed


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_elastic_runs_warn_of_what_lies_above_an_estimate():
    pair = roughxr.assign_pair(surface(), sphere_radius=500, materials="gold", work_of_adhesion=0.05)
    solved = {"solutions/direct": roughxr.direct(pair, delta=[4, 12])}
    (caution,) = [sentence for sentence in report.cautions(solved) if "Summits may yield" in sentence]
    assert "above the estimated hardness of 1 GPa" in caution and "State a hardness" in caution
    hard = roughxr.assign_pair(surface(), sphere_radius=500, materials="alumina")
    assert not any(
        "Summits may yield" in sentence_of_run
        for sentence_of_run in report.cautions({"solutions/direct": roughxr.direct(hard, delta=[0.5])})
    )


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_superposition_is_compared_with_the_way_in():
    pair = roughxr.assign_pair(surface(), sphere_radius=500, contact_modulus=40, hardness=3.0)
    deltas = [4.0, 8.0, 12.0]
    places = (2, 2)
    summed = roughxr.superpose(pair, delta=deltas, law="hertz", subregions=places)
    solved = roughxr.direct(pair, delta=deltas, subregions=places)
    ratio = statistics.force_ratio(summed, solved)
    np.testing.assert_array_equal(ratio.force_direct, solved.force.sel(branch="loading"))


def test_figures_of_what_yields():
    pair = roughxr.assign_pair(surface(), sphere_radius=500, contact_modulus=40, hardness=3.0)
    solved = roughxr.direct(pair, delta=[4.0, 8.0, 12.0], subregions=(2, 2))
    ax = solved.contact.plot(ax=Figure().subplots())
    lines = {line.get_label(): line.get_ydata() for line in ax.lines}
    np.testing.assert_allclose(lines["loading"], solved.force.mean("subregion").sel(branch="loading"))
    np.testing.assert_allclose(lines["retraction"], solved.force.mean("subregion").sel(branch="retraction"))


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_hardness_is_an_entry_of_the_budget():
    pair = roughxr.assign_pair(surface(), sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05, hardness=3.0)
    mesh = roughxr.Mesh(1, step=0.8)
    options = {"places": 1, "preload": 3000.0, "mesh": mesh}
    solved = pair.contact.adhesive(preload=3000.0, mesh=mesh)
    softer, harder, combined = (
        budget_of(pair, solved, settings={"hardness": factors}, **options).sel(entry="hardness")
        for factors in ([0.5], [2.0], [0.5, 2.0])
    )
    up = float(softer.pull_off_change)
    down = float(harder.pull_off_change)
    assert up > 0.1 and down < -0.1  # what is softer flattens more, and sticks harder
    assert float(combined.relative_std) == pytest.approx(np.log1p(max(up, -down))) and float(combined.slope) < 0
    bare = roughxr.assign_pair(surface(), sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05)
    solved = bare.contact.adhesive(preload=3000.0, mesh=mesh)
    missing = budget_of(bare, solved, settings={"hardness": [0.5]}, **options).sel(entry="hardness")
    assert missing.reason.item().startswith("hardness: expected one that is assigned")
