"""Measured pull-offs at the command line and in figures."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import roughxr
from roughxr.application import sentences
from roughxr.application.cli import main, measurements
from roughxr.application.wording import render_sentences

from .surfaces import glass_pair, rough, scan


@pytest.fixture
def run(tmp_path):
    """Return the archive of a run in short, and a table of half its forces a little off its places."""
    surface = glass_pair(scan(rough(96, smooth=2.0, seed=1)), sphere_radius=500.0)
    predicted = surface.contact.pull_off_map(subregions=(16, 16))
    roughxr.archive.save({"scan": surface, "statistics/energy": predicted}, tmp_path / "run.nc")
    measured = predicted.isel(subregion=slice(0, 128))
    measured = measured.assign(pull_off_force=measured.pull_off_force / 2).assign_coords(
        subregion_x=measured.subregion_x - 60.0
    )
    measured[["pull_off_force"]].contact.to_table(tmp_path / "own.csv")
    return tmp_path


@pytest.mark.door
def test_what_was_measured_is_told(run, capsys):
    assert main(["measured", str(run / "own.csv"), "-o", str(run / "again.csv")]) == 0
    said = capsys.readouterr().out
    assert "measured: table" in said and "places: known" in said and "95 % quantile" in said
    again = roughxr.open_pull_off(run / "again.csv")
    xr.testing.assert_allclose(again, roughxr.open_pull_off(run / "own.csv"), rtol=5e-4)
    forces = pd.read_csv(run / "again.csv")["pull_off_force [nN]"]
    assert forces.tolist() == [float(f"{force:.4g}") for force in forces]


def test_a_run_is_compared_with_what_was_measured(run, capsys):
    command = ["compare", str(run), str(run / "own.csv"), "--method", "energy", "--picture", str(run / "both.png")]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "measured / predicted" in said and "relative standard deviation" in said
    assert "Places alone scatter the forces by " in said
    assert "The distributions disagree: " in said and "agree." not in said.replace("disagree.", "")
    assert (run / "both.png").stat().st_size > 10_000


def test_what_a_command_lacks_is_said(run, capsys):
    assert main(["compare", str(run), str(run / "own.csv")]) == 1
    assert "--method: expected one of 'energy', found 'adhesive'" in capsys.readouterr().err
    (run / "bare.csv").write_text("adhesion\n1\n2\n")
    assert main(["measured", str(run / "bare.csv")]) == 1
    assert "give them, such as --units nN" in capsys.readouterr().err
    assert main(["measured", str(run / "own.csv"), "--units", "nN", "--place-units", "nm"]) == 0  # as the file states
    capsys.readouterr()
    assert main(["compare", str(run / "own.csv"), str(run)]) == 1
    assert "own.csv: expected a run first, then the measured forces" in capsys.readouterr().err
    assert main(["measured", str(run / "bare.csv"), "--units", "V", "--sensitivity", "12 nN/V"]) == 0
    assert "places: not known" in capsys.readouterr().out


def agreement(means, *best):
    """Return the sentences of a best estimate beside a predicted and a measured mean."""
    return render_sentences("comparison.toml", ["estimate", "agreement"], sentences._agreement_values(means, *best))


def test_a_prediction_as_scanned_is_set_beside_the_best_estimate():
    means = xr.Dataset({"predicted": 61.0, "measured_low": 95.0, "measured_high": 99.0})
    first, _ = agreement(means, 43.0, 11.0, 87.0)
    assert "best estimate is 43 nN (95 % interval 11 … 87 nN), 0.7 times the prediction" in first


def test_a_measured_mean_without_interval_neither_agrees_nor_disagrees():
    means = xr.Dataset({"predicted": 61.0, "measured_low": np.nan, "measured_high": np.nan})
    _, second = agreement(means, 43.0, 11.0, 87.0)
    assert "too few independent forces are measured for an interval" in second and "agree" not in second


@pytest.mark.door
def test_a_comparison_with_a_best_estimate_has_one_verdict(run, capsys):
    """By all known errors, which the test of the distributions as scanned leaves out, at whatever probability."""
    groups = roughxr.archive.load(run / "run.nc")
    forces = groups["statistics/energy"]
    mean = float(forces.pull_off_force.mean())
    estimate = xr.Dataset({"pull_off_mean": mean, "pull_off_low": mean / 4, "pull_off_high": 4 * mean})
    named = {"statistics/adhesive": forces, "statistics/extrapolated": estimate}
    roughxr.archive.save({"scan": groups["scan"], **named}, run / "run.nc")
    assert main(["compare", str(run), str(run / "own.csv")]) == 0
    said = capsys.readouterr().out
    assert said.count("agree") == 1 and "they agree" in said and "p =" not in said
    measured = roughxr.open_pull_off(run / "own.csv")
    assert forces.contact.compare(measured, extrapolation=estimate).contact.answer().sentence in said
    assert main(["compare", str(run), str(run / "own.csv"), "--force-std", "10%"]) == 0
    assert (
        "An error of 10 % (standard deviation) that all measured forces share is included." in capsys.readouterr().out
    )


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_a_runs_pair_is_fitted_to_measured_forces_by_a_command(tmp_path, capsys, monkeypatch):
    fits = []

    def fit_and_keep(*arguments, **options):
        fits.append(roughxr.measured.fit_pair(*arguments, **options))
        return fits[-1]

    monkeypatch.setattr(measurements, "fit_pair", fit_and_keep)
    surface = glass_pair(scan(rough(32, smooth=2.0, seed=1)), sphere_radius=300.0)
    solved = surface.contact.adhesive(subregions=(2, 1), mesh=1, law="jkr")
    groups = {"scan": surface, "solutions/adhesive": solved, "statistics/adhesive": solved.contact.pull_off()}
    roughxr.archive.save(groups, tmp_path / "run.nc")
    measured = solved.assign(pull_off_force=solved.pull_off_force / 2)
    measured[["pull_off_force"]].contact.to_table(tmp_path / "own.csv")
    command = ["fit", str(tmp_path), str(tmp_path / "own.csv"), "--picture", str(tmp_path / "fit.png"), "-q"]
    assert main(command) == 0
    said, warned = capsys.readouterr()
    assert "mesh" not in warned  # it is the run's, no option of this command
    (fit,) = fits
    assert fit.law == "jkr" and 0.6 < float(fit.fitted_work_of_adhesion) < 1.0  # assigned, for twice the force: 1.35
    assert said.startswith(fit.contact.answer().sentence) and (tmp_path / "fit.png").stat().st_size > 10_000
    assert said.splitlines()[-1].startswith("run again with --work-of-adhesion ")
    assert float(said.split()[-1]) == pytest.approx(float(fit.fitted_work_of_adhesion), rel=0.01)


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (11.0, 107.0, "agree, as any mean from 11 nN to 107 nN would"),
        (11.0, 87.0, "they disagree"),
        (2.0, 900.0, "it is too wide to decide"),
    ],
)
def test_means_agree_where_the_interval_of_the_best_estimate_overlaps_that_of_the_measured_mean(low, high, verdict):
    means = xr.Dataset({"predicted": 61.0, "measured_low": 95.0, "measured_high": 99.0})
    assert verdict in agreement(means, 43.0, low, high)[1]


def test_a_picture_shows_the_best_estimate_of_its_sentence():
    forces = np.random.default_rng(0).gamma(4, 5.0, 200)
    made = [xr.Dataset({"pull_off_force": ("subregion", f * forces, {"units": "nN"})}) for f in (1.0, 0.5)]
    estimate = xr.Dataset({"pull_off_mean": 8.0, "pull_off_low": 2.0, "pull_off_high": 30.0})
    compared = roughxr.compare(*made, extrapolation=estimate, resamples=20)
    distributions, quantiles = roughxr.figures.predicted_and_measured(*made, comparison=compared)
    best = next(bars for bars in distributions.containers if str(bars.get_label()).startswith("best estimate"))
    mean, _, _ = best.lines
    assert mean.get_xdata() == [8.0]
    line = next(line for line in quantiles.lines if line.get_label() == "equal to the best estimate")
    assert line.get_ydata()[1] / line.get_xdata()[1] == pytest.approx(8 / forces.mean())


def test_a_folder_of_curves_in_tables_is_a_sample(run, capsys):
    """Approach and retraction in each; the eighth does not adhere, and its reason does not hide the written forces."""
    piezo = np.concatenate([np.linspace(-300.0, 60.0, 361), np.linspace(60.0, -300.0, 361)])
    rng = np.random.default_rng(0)
    files = []
    for pull in (20.0, 30.0, 25.0, 40.0, 35.0, 28.0, 33.0, 0.0):
        adheres = np.where(np.arange(722) < 361, 0.0, pull)
        force = np.where(piezo > -adheres / 2.0, 2.0 * piezo, 0.0) + rng.normal(0, 0.1, 722)
        files.append(run / f"curve{len(files)}.csv")
        rows = "\n".join(f"{z:.3f},{f / 100:.6f}" for z, f in zip(piezo, force))
        files[-1].write_text(f"piezo (nm),deflection (V)\n{rows}\n")
    names = [str(file) for file in files]
    table = str(run / "pulls.csv")
    calibration = ["--sensitivity", "50 nm/V", "--spring-constant", "2"]
    for baseline in ([], ["--baseline", "1"]):
        assert main(["measured", *names, *calibration, *baseline, "-o", table]) == 0
        assert "curves: 7 used, 1 no pull exceeds the noise" in capsys.readouterr().out
    expected = [20.0, 30.0, 25.0, 40.0, 35.0, 28.0, 33.0, np.nan]
    np.testing.assert_allclose(roughxr.open_pull_off(table).pull_off_force, expected, atol=2.5)
    assert main(["compare", str(run), table, "--method", "energy"]) == 0
    assert "1 of 8 measured are limits, which count from 0" in capsys.readouterr().out


def test_the_doubtful_curves_are_drawn_with_their_doubts(run, capsys, monkeypatch):
    """Of a curve without a pull, the limit is drawn in place of the pull-off."""
    piezo = np.linspace(60.0, -300.0, 361)
    rng = np.random.default_rng(3)
    files = []
    for pull in (20.0, 0.0):
        force = np.where(piezo > -pull / 2.0, 2.0 * piezo, 0.0) + rng.normal(0, 0.1, piezo.size)
        files.append(str(run / f"doubtful{len(files)}.csv"))
        rows = "\n".join(f"{z:.3f},{f:.6f}" for z, f in zip(piezo, force))
        Path(files[-1]).write_text(f"piezo [nm],force [nN]\n{rows}\n")
    drawn = []
    monkeypatch.setattr(measurements, "save_picture", lambda figure, path: drawn.append(figure))
    assert main(["measured", *files, "--baseline", "0", "0.4", "--picture", "curves.png"]) == 0
    assert "1 used, 1 no pull exceeds the noise" in capsys.readouterr().out
    titles = [ax.get_title(loc="left").replace("\n", " ") for ax in drawn[0].axes]
    assert sorted(titles) == ["curve 0: no doubt", "curve 1: no pull exceeds the noise"]
    labels = [text.get_text() for ax in drawn[0].axes for text in ax.get_legend().get_texts()]
    assert sorted(label.split(" ")[0] for label in labels) == ["baseline", "baseline", "limit", "pull-off"]


def test_quantiles_are_drawn_where_they_are():
    forces = np.random.default_rng(0).gamma(4, 5.0, 200)
    made = [xr.Dataset({"pull_off_force": ("subregion", f * forces)}) for f in (1.0, 2.0)]
    compared = roughxr.compare(*made, resamples=20)
    ax = compared.contact.plot(ax=Figure().subplots())
    line = next(line for line in ax.lines if line.get_label().startswith("means"))
    assert line.get_label() == "means: × 2, then at most 0 % apart"
    (drawn,) = (line for line in ax.lines if line.get_xdata().size == 99)
    np.testing.assert_allclose(drawn.get_ydata(), 2 * drawn.get_xdata())
