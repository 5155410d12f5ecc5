"""The archive of a run holds the stages that ended before an interrupt, and says what is missing."""

import io
import re
import warnings

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import archive
from roughxr.application import cli, report
from roughxr.application.runs import analysis, several
from roughxr.application.runs import parts as run_parts
from roughxr.application.runs.stages import Stages
from roughxr.mechanics.jobs.progress import progress
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.specimen import specimen_of

from .surfaces import bare_runs, unpressed

PARTS = analysis.PARTS  # the fixture below leaves some out

OPTIONS = {"subregions": (2, 1), "mesh": 1, "budget": 0}

#: Stages of such a run that are interrupted, each with a group that the archive has by then.
MOMENTS = {"asperities": None, "rigid": "solutions/adhesive", "rolling": "statistics/energy"}


@pytest.fixture(scope="module", autouse=True)
def _quick():
    with unpressed(), bare_runs("extrapolated", "curves"):
        yield


@pytest.fixture(scope="module")
def surface():
    scan = self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    return roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05)


@pytest.fixture(scope="module")
def whole(surface, tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "run.nc"
    return path, roughxr.run(surface, path, **OPTIONS)


def test_an_interrupted_run_reads_says_what_is_missing_and_resumes(surface, whole, tmp_path, monkeypatch, capsys):
    """It is interrupted at three stages, and resumed from each."""
    path = tmp_path / "run.nc"

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    for moment, stored in MOMENTS.items():
        with monkeypatch.context() as at_moment:
            parts = [part._replace(make=interrupted) if part.name == moment else part for part in analysis.PARTS]
            at_moment.setattr(analysis, "PARTS", parts)
            with pytest.raises(KeyboardInterrupt):
                roughxr.run(surface, path, **OPTIONS)
        assert path.exists() == (stored is not None)
        if stored is None:
            continue
        with pytest.warns(UserWarning, match=r"not finished, missing: .*detachment|not finished, missing: its"):
            groups = archive.load(path)
        assert stored in groups and "log" not in groups
    assert cli.main(["report", str(path)]) == 0
    assert cli.main(["info", str(path)]) == 0
    printed = capsys.readouterr()
    assert "is not finished" in printed.err and "run: not finished, missing: " in printed.out
    assert "The run is not finished" in (tmp_path / "report.html").read_text(encoding="utf-8")
    with warnings.catch_warnings():
        warnings.filterwarnings("error", ".*not finished")
        groups = roughxr.run(surface, path, **OPTIONS)
    assert list(groups) == list(whole[1])
    for name in set(groups) - {"log"}:
        xr.testing.assert_allclose(groups[name], whole[1][name], rtol=1e-6)
    assert "not finished" not in report.page(groups)


def test_one_preload_is_what_a_run_takes(surface, tmp_path):
    for preload in ([0.0, 50.0], -1.0):
        with pytest.raises(ValueError, match=r"preload: expected one force of at least 0 nN"):
            roughxr.run(surface, tmp_path / "run.nc", preload=preload, **OPTIONS)
    assert not list(tmp_path.iterdir())


#: Durations of the stages of runs of 64 places, s, of the simulation at all places without levers, and whether its
#: mesh was refined: the glass twin on two busy cores, by an earlier version; README's scan, the grains and the chip of
#: `shared/scans` on two idle ones, by the processor time of the main thread and that of places on two threads.
MEASURED = {
    "glass": ([5.4, 142.8 + 57.7, 32.0, 210.5, 0.2, 11.1, 17.9, 15.5, 1.0, 14.4], 104.0, False),
    "rough": ([0.1, 2.7, 0.3, 0.6, 0.3, 0.6, 0.2, 0.1, 1.3, 3.4], 1.4, True),
    "grains": ([0.2, 4.5, 0.5, 1.8, 0.8, 0.3, 0.2, 0.1, 1.5, 3.0], 2.4, True),
    "chip": ([0.1, 1.2, 0.1, 0.5, 0.2, 0.2, 0.1, 0.1, 1.2, 3.3], 0.6, True),
}


def test_only_a_refusal_is_the_reason_of_a_missing_estimate(surface, monkeypatch):
    solved = {"solutions/adhesive": xr.Dataset()}
    task = run_parts.Task(specimen_of(surface), run_parts.Plan(None, np.zeros(1), 0.0), groups=solved)

    def refused(*_, **__):
        raise roughxr.Refusal("scan", "a self-affine surface", "noise")

    monkeypatch.setattr(run_parts, "real_pull_off", refused)
    (missing,) = run_parts._extrapolated_pull_off(task).values()
    assert "expected a self-affine surface, found noise" in str(missing.attrs)
    monkeypatch.setattr(run_parts, "real_pull_off", lambda *_, **__: np.ones(2) + np.ones(3))
    with pytest.raises(ValueError, match="could not be broadcast"):
        run_parts._extrapolated_pull_off(task)


def minutes_left(line):
    """Return the least and the most minutes that a line of progress may mean."""
    if "less than a minute left" in line:
        return 0.0, 1.0
    minutes = float(re.search(r"about (\d+) min left", line)[1])
    return minutes - 0.5, minutes + 0.5


@pytest.mark.parametrize("surface", MEASURED)
def test_the_time_left_of_measured_runs_is_right_within_a_factor_of_two(surface, monkeypatch):
    """Once all places are solved; before, and on other machines, it is that of most scans."""
    (durations, solved, is_refined) = MEASURED[surface]
    now = [0.0]
    monkeypatch.setattr("roughxr.mechanics.jobs.progress.time.monotonic", lambda: now[0])
    expected = analysis._durations(PARTS, 64)[0]
    with progress(stream := io.StringIO()), Stages(expected, {}) as stage:
        for name, duration in zip(expected, durations):
            stage(name)
            if name == "adhesive":
                stage.expect("each place takes as long as at the first places", adhesive=duration)
            now[0] += duration
            if name == "adhesive":
                why, seconds = run_parts._durations_after(solved, 64, 8, is_refined)
                stage.expect(why, **seconds)
    lines = [line for line in stream.getvalue().splitlines() if line.startswith("stage")]
    of_beginnings = [minutes_left(line) for line in lines if "each place takes" not in line]  # others: within a stage
    for k in range(2, len(of_beginnings)):
        true_minutes = sum(durations[k:]) / 60
        assert of_beginnings[k][0] <= 2 * true_minutes and of_beginnings[k][1] >= true_minutes / 2
    shown = [minutes_left(line) for line in lines]
    for before, after, line in zip(shown, shown[1:], lines[1:]):
        assert after <= before or "(more than before: each place t" in line


@pytest.mark.parametrize(("share", "compiling"), [(1.0, True), (0.9, True), (0.4, False), (0.0, False)])
def test_a_run_states_the_time_of_compiling_where_no_kernel_is_stored(share, compiling, monkeypatch):
    """Of kernels that other runs need, such as those of humid air, some always remain; checks compile a few before."""
    monkeypatch.setattr(run_parts, "share_to_compile", lambda folder: share)
    assert [part.compiling > 0 for part in PARTS if part.kernels] == [compiling] * 3


def test_a_batch_states_a_time_left_that_shrinks_or_why_it_grew(tmp_path, monkeypatch):
    """Scans that an earlier call has finished are no measure of the others."""
    now = [0.0]
    durations = {"a": 3.0, "b": 120.0, "c": 60.0, "d": 600.0, "e": 90.0}
    monkeypatch.setattr("roughxr.application.runs.several.time.monotonic", lambda: now[0])
    (tmp_path / "a").mkdir()

    monkeypatch.setattr(
        several, "_scan_result", lambda groups: several.ScanResult("", [], None, xr.Dataset(), None, [])
    )
    scans = several.scan_folders([f"{name}.nc" for name in durations], tmp_path)

    def timed(scan, folder):
        now[0] += durations[scan.stem]
        return {}

    with progress(stream := io.StringIO()), pytest.raises(ValueError, match="at least one scan with a pull-off"):
        several.run_each(scans, timed)
    assert stream.getvalue().splitlines() == [
        "scan 1 of 5: a.nc",
        "scan 2 of 5: b.nc",
        "scan 3 of 5: c.nc, about 6 min left for all of them",
        "scan 4 of 5: d.nc, about 3 min left for all of them",
        "scan 5 of 5: e.nc, about 4 min left (more than before: d.nc took about 10 min) for all of them",
    ]


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_force_over_displacement_of_soft_bodies_is_computed_at_one_place(surface, monkeypatch):
    monkeypatch.setattr(
        run_parts, "adhesive", lambda ds, *, subregions, **options: subregions.expand_dims(branch=["retraction"])
    )
    for modulus, places in ((40, 2), (1, 1)):
        pair = {"sphere_radius": 500, "contact_modulus": modulus, "work_of_adhesion": 0.05}
        specimen = specimen_of(roughxr.assign_pair(surface, **pair))
        plan = analysis.plan(specimen, subregions=(2, 1))
        solved = roughxr.adhesive(specimen.scan, subregions=(2, 1), mesh=1)
        groups = run_parts._curves_around_pull_off(analysis.Task(specimen, plan, groups={"solutions/adhesive": solved}))
        assert groups["solutions/curves"].sizes["subregion"] == places


def test_a_run_takes_a_file_and_its_pair(tmp_path, capsys):
    roughxr.scans.to_netcdf(
        self_affine((32, 32), 20.0, rms=1.0, hurst=0.8, rolloff=300, cutoff=150, seed=1), tmp_path / "scan.nc"
    )
    pair = {"sphere_radius": 500, "contact_modulus": 40, "work_of_adhesion": 0}
    places = {"subregions": (2, 1), "delta": [1.0, 2.0]}
    groups = roughxr.run(tmp_path / "scan.nc", tmp_path / "run.nc", **places, **pair)
    assert float(groups["scan"].sphere_radius) == 500 and "asperities" in capsys.readouterr().out
    with pytest.raises(roughxr.Refusal, match=r"meshs: .* no such option \(did you mean mesh\?\)"):
        roughxr.run(tmp_path / "scan.nc", tmp_path / "run.nc", meshs=2)
