"""A run of particles from the shell: places are rests, and archive, report, explorer and `detach` lead with them."""

import json
import re

import numpy as np
import pandas as pd
import pytest

import roughxr
from roughxr import archive
from roughxr.application import report
from roughxr.application.cli import main
from roughxr.mechanics.studies import extrapolation

from .surfaces import bare_runs, rough, scan, unpressed

PAIR = ["--sphere-radius", "1 um", "--contact-modulus", "40", "--work-of-adhesion", "0.05"]
QUICK = ["--law", "jkr", "--mesh", "1", "--budget", "0", "--delta", "1", "2", "--quiet"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of a run at the rests that are reached from 3 × 2 landings."""
    folder = tmp_path_factory.mktemp("particles")
    roughxr.scans.to_netcdf(scan(rough(64, rms=2.0, smooth=2.0), 10.0), folder / "scan.nc")
    command = ["run", str(folder / "scan.nc"), "--particle", "--subregions", "3", "2", *PAIR, *QUICK]
    with unpressed(), bare_runs("extrapolated", "curves", "rigid"):
        assert main([*command, "-o", str(folder / "run")]) == 0
    return folder / "run"


@pytest.fixture(scope="module")
def groups(folder):
    return archive.load(folder / "run.nc")


def test_a_run_of_a_probe_is_no_continuation_of_one_of_particles(folder, groups, capsys):
    command = ["run", str(folder.with_name("scan.nc")), "--subregions", "3", "2", *PAIR, *QUICK, "-o", str(folder)]
    assert main(command) == 1
    assert (
        "run.nc: expected no file or the same run, found a run with other subregions; choose" in capsys.readouterr().err
    )


def median(values, share):
    """Return the median of numbers repeated by whole numbers of particles."""
    return np.median(np.repeat(values, np.round(6 * share).astype(int)))


def test_the_archive_holds_rests_with_their_shares(groups):
    rests = groups["statistics/rests"]
    assert float(rests.landing_share.sum()) == pytest.approx(1.0)
    assert (rests.supports >= 3).all()
    for name in ("solutions/adhesive", "solutions/energy", "solutions/rolling"):
        for axis in ("subregion_x", "subregion_y", "landing_share"):
            assert groups[name][axis].values == pytest.approx(rests[axis].values)
    mean = (groups["statistics/adhesive"].pull_off_force * rests.landing_share.values).sum()
    summary = roughxr.statistics.summary(groups["statistics/adhesive"][["pull_off_force"]])
    assert float(summary.pull_off_force.sel(statistic="mean")) == pytest.approx(float(mean))


def test_the_report_shows_particles_at_rest(folder):
    text = re.sub(r"\s+", " ", (folder / "report.html").read_text(encoding="utf-8"))
    assert "at its resting position" in text
    table = pd.read_csv(folder / "places.csv")
    assert table["landing_share"].sum() == pytest.approx(1.0, abs=5e-4)  # four digits each


def test_the_explorer_shows_the_rests_each_with_its_share(folder, groups):
    page = folder / "explore.html"
    assert main(["explore", str(folder), "--quiet"]) == 0
    text = page.read_text(encoding="utf-8")
    contents = json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL).group(1)
    )
    rests = groups["statistics/rests"]
    assert [place["share"] for place in contents["places"]] == pytest.approx(rests.landing_share.values, rel=1e-4)
    assert [place["x"] for place in contents["places"]] == pytest.approx(rests.subregion_x.values)
    facts = {row["name"]: row["values"] for row in contents["facts"]}
    assert facts["supports"] == pytest.approx(rests.supports.values)


def test_detach_counts_particles_not_places(folder, groups, capsys):
    assert main(["detach", str(folder), "--method", "adhesive"]) == 0
    printed_text = capsys.readouterr().out
    assert "5 % of particles below" in printed_text
    rests = report.run_moments(groups, "adhesive")
    share = groups["statistics/rests"].landing_share.values
    at_rest = roughxr.particles.critical_load(rests).critical_friction_velocity.values
    printed = re.search(r"median ([\d.]+)", printed_text).group(1)
    decimals = len(printed.partition(".")[2])
    assert abs(float(printed) - median(at_rest, share)) <= 0.5 * 10**-decimals


def test_resuspension_of_a_run_counts_particles_not_places(groups):
    held = groups["solutions/rolling"]
    resuspended = roughxr.particles.resuspension(held, friction_velocity=[5.0, 10.0, 20.0])
    expected = (resuspended.remaining_at_place * held.landing_share).sum("subregion")
    assert resuspended.remaining.values == pytest.approx(expected.values)


def on_cells_of_5_nm(surface, **options):
    """Solve surfaces with pixels of 5 and 10 nm on equal cells, without refinement."""
    return roughxr.adhesive(surface, mesh=round(roughxr.schema.pixel(surface)[0] / 5), **options)


def test_with_a_second_scan_a_run_of_particles_contains_the_best_estimate(folder, groups, monkeypatch):
    """The second scan is the first one on finer pixels: it shows nothing new."""
    monkeypatch.setattr(extrapolation, "adhesive", on_cells_of_5_nm)
    monkeypatch.setattr(extrapolation, "_SECOND_PLACES", (2, 2))
    scan = groups["scan"][["height"]]
    pixels = {axis: np.arange(float(scan[axis][10]), float(scan[axis][-10]), 5.0) for axis in "xy"}
    roughxr.scans.to_netcdf(scan.interp(pixels, method="cubic"), folder.with_name("finer.nc"))
    command = ["run", str(folder.with_name("scan.nc")), "--finer", str(folder.with_name("finer.nc"))]
    output = folder.with_name("finer")
    with unpressed(), bare_runs("curves", "rigid", "superposition", "rolling"):
        assert main([*command, "--particle", "--subregions", "3", "2", *PAIR, *QUICK, "-o", str(output)]) == 0
    estimate = archive.load(output / "run.nc")["statistics/extrapolated"]
    hidden = np.exp(extrapolation.one_scan_factor(extrapolation._FEWEST_OCTAVES).log)  # on any pixels
    assert 0.7 < float(estimate.roughness_factor) / hidden < 1.4
    assert estimate.pull_off_low < estimate.pull_off_mean < estimate.pull_off_high
    assert "best estimate" in (output / "report.html").read_text(encoding="utf-8")


def test_a_particle_on_a_plane_is_refused_in_words(tmp_path, capsys):
    tilted = scan(0.02 * np.add.outer(np.arange(40.0), np.arange(40.0)), 10.0)
    roughxr.scans.to_netcdf(tilted, tmp_path / "scan.nc")
    command = ["run", str(tmp_path / "scan.nc"), "--particle", "--level", "none", *PAIR, *QUICK]
    assert main([*command, "-o", str(tmp_path / "run")]) == 1
    assert "no resting position" in capsys.readouterr().err
