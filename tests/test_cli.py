"""The command line, as a user meets it: its products, its words, its exit status."""

import contextlib
import functools
import gc
import html
import io
import json
import os
import pickle
import re
import subprocess
import sys
import tomllib
from argparse import Namespace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import roughxr
from roughxr import archive, superpose
from roughxr.application import report
from roughxr.application.cli import file_commands, main
from roughxr.application.cli.checks import both_counts
from roughxr.application.cli.options import command_line
from roughxr.application.cli.words import error_in_shell, in_shell
from roughxr.application.reproduction import conclusion, printed, printed_tables
from roughxr.application.reproduction import run as reproduction
from roughxr.application.reproduction.numbered_figures import FIGURES, SIMULATED_FIGURES
from roughxr.application.runs import analysis
from roughxr.mechanics.bodies.pair import elastic
from roughxr.mechanics.contact.mesh import Mesh
from roughxr.mechanics.vocabulary.refusal import Refusal
from roughxr.mechanics.vocabulary.text import Argument, Phrase, RoughxrWarning, warn
from roughxr.scans import to_file

from .surfaces import bare_runs, rough, scan

#: Adhesion as it is solved fastest, for what is no question of adhesion.
QUICK = ["--law", "jkr", "--mesh", "1"]

#: The stages of a run but that which takes long.
WITHOUT_EXTRAPOLATION = [part for part in analysis.PARTS if part.name != "extrapolated"]


@pytest.mark.parametrize(
    ("arguments", "nearest"),
    [(["run", "a.nc", "--sphere-raduis", "3 um"], "--sphere-radius"), (["detach", "run", "--fliud"], "--fluid")],
)
def test_a_misspelt_option_is_answered_with_the_nearest(arguments, nearest, capsys):
    with pytest.raises(SystemExit):
        main(arguments)
    assert f"did you mean {nearest}" in capsys.readouterr().err


def test_a_file_of_options_holds_every_option_but_scheduler_and_output(tmp_path, capsys):
    written = tmp_path / "run.toml"
    with pytest.raises(SystemExit):
        main(["run", "--write-config", str(written)])
    text = written.read_text(encoding="utf-8")
    options = re.findall(r"^# (\w+) = ", text, re.MULTILINE)
    assert {"sphere_radius", "materials", "humidity", "mesh", "particle"} <= set(options)
    assert not {"scheduler", "output", "config"} & set(options)
    written.write_text(re.sub(r"^# (\w+ = )", r"\1", text, flags=re.MULTILINE), encoding="utf-8")
    tomllib.loads(written.read_text(encoding="utf-8"))
    for line, reason in (
        ("scheduler = 'x'", "no option of a file"),
        ("sphere_radus = 3", "did you mean sphere_radius"),
    ):
        written.write_text(line)
        with pytest.raises(SystemExit):
            main(["run", "a.nc", "--config", str(written)])
        assert reason in capsys.readouterr().err


one_parser = functools.cache(command_line)


def options_of(text, tmp_path, *before):
    """Return the parsed options of `run` with a file of options, and those that the file may set."""
    file = tmp_path / "options.toml"
    file.write_text(text, encoding="utf-8")
    options = one_parser().parse_args(["run", "--config", str(file), *before, "--", "scan.nc"])
    return options, {option.dest: option for option in options.file_options}


def test_no_value_of_a_file_of_options_becomes_another_option(tmp_path, capsys):
    """Whatever option a stranger fills with words of a command line: they stay its value, or are refused."""
    stranger = ["2", "--scheduler", "threads", "-o", "elsewhere", "--particle", "--", "other.nc"]
    usual, names = options_of("sphere_radius = 1", tmp_path, "-o", "mine")
    assert usual.scan == ["scan.nc"] and usual.sphere_radius == "1" and len(names) > 20
    untouched = {"scan", "output", "scheduler", "config"}
    for name, option in names.items():
        for value in (
            stranger,
            [stranger],
            " ".join(stranger),
            "--output=elsewhere",
            "-o",
            "--scheduler=x",
            ["-oelse"],
        ):
            text = f"{name} = {json.dumps(value)}"
            radius = "" if name in ("sphere_radius", "indenter") else "sphere_radius = 1\n"
            try:
                options, _ = options_of(radius + text, tmp_path, "-o", "mine")
            except SystemExit as stop:
                assert stop.code == 2 and f"options.toml: {name}: " in capsys.readouterr().err
                continue
            assert option.nargs == "+" or isinstance(value, str)
            changed = {key for key in untouched | set(names) if getattr(options, key) != getattr(usual, key)}
            assert changed <= {name, "sphere_radius"} and not changed & untouched


def test_a_file_of_options_sets_what_a_command_line_does(tmp_path):
    """Every option by its own type, flags and lists among them; the command line replaces what a file sets."""
    text = (
        "sphere-radius = '3 um'\nyoung_modulus = [70, '169 GPa']\npoisson_ratio = 0.2\nsubregions = ['4x2']\n"
        "delta = ['-1 nm', 2]\nmesh = 2\nbudget = 4\nparticle = true\nlevel = 'none'\npreload = 5\n"
        "size = ['1 um', 1000]\n"
    )
    in_file, _ = options_of(text, tmp_path)
    command = "run scan.nc --sphere-radius 3um --young-modulus 70 169GPa --poisson-ratio 0.2 --subregions 4x2"
    command += " --mesh 2 --budget 4 --particle --level none --preload 5 --size 1um 1000"
    assert in_file.young_modulus == ["70", "169 GPa"] and in_file.delta == [-1.0, 2.0] and in_file.particle is True
    parsed = vars(command_line().parse_args(command.split()))
    for name in ("subregions", "mesh", "budget", "particle", "level", "preload", "poisson_ratio"):
        assert parsed[name] == getattr(in_file, name)
    replaced, _ = options_of(text, tmp_path, "--mesh", "3", "--level=plane", "--sphere-r", "1")
    assert (replaced.mesh, replaced.level, replaced.sphere_radius, replaced.budget) == (3, "plane", "1", 4)
    assert options_of("particle = false\nsphere_radius = 1", tmp_path)[0].particle is False


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("sphere_radius = 2020-01-01", "expected text or a number, found datetime.date"),
        ("sphere_radius = [1, 2]", "expected text or a number, found several values"),
        ("sphere_radius = true", "found True"),
        ("sphere_radius = {a = 1}", "found {'a': 1}"),
        ("particle = 'yes'", "expected true or false"),
        ("level = 'cubic'", "expected one of plane, quadratic, none"),
        ("young_modulus = []", "expected at least one value"),
        ("delta = ['3 kg']", "expected units that convert to 'nm'"),
        ("budget = 1.5", "1.5"),
        ("a = " + "[" * 100_000, "found: "),
        ("#" * 2**21, "at most 1024 KiB"),
    ],
)
def test_a_file_of_options_is_refused_by_the_name_of_the_option(line, reason, tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        options_of(line, tmp_path)
    error = capsys.readouterr().err
    assert reason in error and "options.toml: " in error


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_no_file_of_options(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(SystemExit, match="2"):
        main(["run", "a.nc", "--config", str(tmp_path / "pipe")])
    assert "found a folder, pipe or device" in capsys.readouterr().err


def test_a_file_named_like_an_option_is_no_option(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "--scheduler=x").write_text("")
    assert main(["run", "--scheduler=x", "a.nc"]) == 1
    assert "name the file ./--scheduler=x" in capsys.readouterr().err


def test_errors_name_options_in_a_shell(tmp_path, capsys):
    (tmp_path / "heights.txt").write_text("1 2 3\n2 3 4\n3 4 5\n", encoding="utf-8")
    assert main(["info", str(tmp_path / "heights.txt")]) == 1
    assert "state their units, --height-units" in capsys.readouterr().err
    sample = str(Path(__file__).parents[1] / "datasets" / "rough.nc")
    pair = ["--sphere-radius", "3 um", "--materials", "glass/silicon"]
    assert main(["run", sample, *pair, "--preload", "5 nm", "-o", str(tmp_path / "run")]) == 1
    assert "--preload: expected units that convert to 'nN'" in capsys.readouterr().err
    (tmp_path / "matrix.txt").write_text("1 2\n2 3\n", encoding="utf-8")
    assert main(["info", str(tmp_path / "matrix.txt"), "--height-units", "nm"]) == 1
    assert "give it, for example --size '5 um' '5 um'" in capsys.readouterr().err
    assert main(["run", sample, "--sphere-radius", "10 nm", *pair[2:], "-o", str(tmp_path / "run")]) == 1
    assert "--sphere-radius: expected more than one pixel" in capsys.readouterr().err
    assert main(["run", sample, *pair, "--contact-modulus", "40", "-o", str(tmp_path / "run")]) == 1
    assert "expected one of --materials, --contact-modulus, --young-modulus, found" in capsys.readouterr().err


def test_a_phrase_names_arguments_as_python_does_and_keeps_them_between_processes():
    options = Namespace(mesh="auto", work_of_adhesion=None)
    advice = Phrase("take ", Argument("mesh", 4), ", ", Argument("law", "jkr"), " or ", Argument("work_of_adhesion"))
    sent = pickle.loads(pickle.dumps(Refusal("mesh", "cells of mesh=2", "mesh=1", Phrase(advice, "."))))
    assert str(sent) == "mesh: expected cells of mesh=2, found mesh=1; take mesh=4, law='jkr' or work_of_adhesion."
    shell = "--mesh: expected cells of mesh=2, found mesh=1; take --mesh 4, law='jkr' or --work-of-adhesion."
    assert error_in_shell(sent, options) == shell
    with pytest.warns(RoughxrWarning, match="mesh: coarse; take mesh=4, law='jkr'") as caught:
        warn(Phrase("coarse; ", advice), what="mesh")
    assert in_shell(caught[0].message.args[0], options).startswith("--mesh: coarse; take --mesh 4, law='jkr' or")


@pytest.fixture(scope="module")
def paper_run(tmp_path_factory):
    """Return the folder of the paper's run, its adhesion in the limit without range: a seventh of the time.

    With the range that the twin's Tabor parameters ask for it is a notebook's, which is executed too.
    """
    folder = tmp_path_factory.mktemp("paper")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reproduction, "PLAN", reproduction.PLAN._replace(law="jkr", mesh=Mesh(1, step=0.4)))
        assert main(["paper", "-o", str(folder), "-q"]) == 0
    return folder


@pytest.mark.soak
def test_the_papers_table_stands_beside_ours(paper_run):
    table = pd.read_csv(paper_run / "table-contact.csv", index_col="quantity")
    methods = ["published", "self_similar", "energy", "adhesive"]
    assert list(table.columns) == ["paper", "paper's is", *methods]
    assert 0.05 < table.loc["pull-off, rough / smooth", "adhesive"] < 0.2
    smooth = table.loc["pull-off, smooth sphere [µN]"]
    assert smooth["published"] == pytest.approx(19.1, rel=2e-3)
    pull = table.loc["pull-off, mean [µN]"]
    assert pull["paper's is"] == "target"  # which is why the next line confirms nothing but the fit
    assert pull["published"] == pytest.approx(pull["paper"], rel=0.2)
    assert pull["self_similar"] == pytest.approx(pull["energy"], rel=0.1)
    rows = table.loc[table["paper"].notna() & (table["paper's is"].fillna("") == "")]
    assert {"pull-off, smooth sphere [µN]", "figure 15, pull-off [µN]"} <= set(rows.index)


@pytest.mark.soak
def test_every_published_value_stands_in_a_table(paper_run):
    parts = {"scan": printed.SCAN, "contact": printed.PULL_OFF, "force": printed.FORCE}
    for part, published in (parts | {"superposition": printed.CONCLUSION}).items():
        table = pd.read_csv(paper_run / f"table-{part}.csv", index_col="quantity")
        assert set(published) <= set(table.index)
        assert set(table.index[table["paper's is"].notna()]) <= {row for row, (_, note) in published.items() if note}
    assert "confirms nothing" in " ".join((paper_run / "table.txt").read_text(encoding="utf-8").split())


@pytest.mark.soak
def test_the_papers_conclusion_is_tested_at_each_place(paper_run):
    """Contacts overlap at pull-off, the means agree by cancellation, and single places do not."""
    table = pd.read_csv(paper_run / "table-superposition.csv", index_col="quantity")
    published = table["published"]
    assert 10 < published["overlapping contacts [%]"] < 30
    assert 30 < published["places with overlapping contacts [%]"] < 60
    net = published["added by sums too large [% of mean]"] - published["taken by sums too small [% of mean]"]
    assert published["sum / simulation, of the means"] == pytest.approx(1 + net / 100, rel=1e-4)
    low, high = (published[f"sum / simulation, {share} % of places below"] for share in (5, 95))
    assert low < 0.8 and high > 1.5
    assert (paper_run / "superposition-by-place.png").stat().st_size > 10_000
    text = " ".join((paper_run / "table.txt").read_text(encoding="utf-8").split())
    assert "Its method gives the mean of many places" in text and "It does not give the pull-off of one place" in text


@pytest.mark.soak
def test_the_simulations_pull_off_is_counted_from_the_highest_point(paper_run):
    """The printed 9.7 ± 2.52 nm were a target of the published sum alone."""
    table = pd.read_csv(paper_run / "table-contact.csv", index_col="quantity")
    mean, std = (table.loc[f"displacement at pull-off, {name} [nm]", "adhesive"] for name in ("mean", "std"))
    assert mean == pytest.approx(9.7, abs=0.7) and std == pytest.approx(2.52, abs=0.4)


def test_the_papers_tables_are_at_most_100_characters_wide(paper_alone):
    lines = (paper_alone[0] / "table.txt").read_text(encoding="utf-8").splitlines()
    assert max(map(len, lines)) <= 100


@pytest.mark.soak
def test_the_papers_tables_with_the_simulation_are_at_most_100_characters_wide(paper_run):
    lines = (paper_run / "table.txt").read_text(encoding="utf-8").splitlines()
    assert max(map(len, lines)) <= 100


def test_both_means_of_the_pull_off_are_named(paper_alone):
    """All places equally, as in the paper, and debris by its area, as in the other results."""
    folder, groups, _ = paper_alone
    table = pd.read_csv(folder / "table-contact.csv", index_col="quantity")
    for method in ("published", "energy"):
        pull_off = groups[f"statistics/{method}"]
        assert table.loc["pull-off, mean [µN]", method] == pytest.approx(
            1e-3 * float(pull_off.pull_off_force.mean()), rel=1e-5
        )
        by_area = 1e-3 * float(pull_off.contact.summary().pull_off_force.sel(statistic="mean"))
        assert table.loc["pull-off, mean, debris by area [µN]", method] == pytest.approx(by_area, rel=1e-5)
    assert "debris count as their area, 5.7 % of the scan" in " ".join(
        (folder / "table.txt").read_text("utf-8").split()
    )


def test_the_overlap_at_pull_off_is_that_of_a_sum_at_this_displacement(paper_alone):
    groups = paper_alone[1]
    solution = groups["solutions/published"]
    states = conclusion.states_at_pull_off(solution)
    catalogue = groups["asperities"]
    for place in (0, 20, 45):
        chosen = solution.isel(subregion=[place])
        delta = np.round(chosen["pull_off_delta"].values, 1)
        summed = superpose(elastic(catalogue), delta=delta, subregions=chosen, formulation="published")
        for name in ("contacts", "contacts_overlapping", "contacts_beyond_patch"):
            assert states[name][place].item() == summed[name].item()


def _paper_names(folder):
    """Return the names of the paper's figures in a folder."""
    return sorted(path.stem for path in folder.glob("*.png"))


def test_the_paper_is_answered_before_the_simulation_with_adhesion(tmp_path, monkeypatch, capsys):
    def interrupted(task):
        raise KeyboardInterrupt

    parts = [part._replace(make=interrupted) if part.name == "adhesive" else part for part in analysis.PARTS]
    monkeypatch.setattr(analysis, "PARTS", parts)
    glass = roughxr.open_sample("glass")[{"x": slice(0, 128), "y": slice(0, 128)}]
    monkeypatch.setattr(reproduction, "open_sample", lambda name: glass)
    monkeypatch.setattr(reproduction, "PLAN", reproduction.PLAN._replace(subregions=(2, 2)))
    monkeypatch.setattr(reproduction, "paper_figures", lambda run, names: [(name, Figure()) for name in names])
    assert main(["paper", "-o", str(tmp_path), "-q"]) == 130
    printed = capsys.readouterr().out
    for table in (printed, (tmp_path / "table.txt").read_text(encoding="utf-8")):
        assert "Pull-off force by method" in table and "figure 15, above smooth" in table and "19.1" in table
    assert _paper_names(tmp_path) == sorted(set(FIGURES) - set(SIMULATED_FIGURES))
    assert {"table-contact.csv", "table-scan.csv"} <= {path.name for path in tmp_path.iterdir()}


@pytest.fixture(scope="module")
def paper_alone(tmp_path_factory):
    """Return the folder of the paper without the simulation with adhesion, its groups, and the names of its figures."""
    folder = tmp_path_factory.mktemp("paper-alone")
    drawn = []

    def empty_figures(run, names):
        drawn.extend(names)
        return [(name, Figure()) for name in names]

    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()):
        patch.setattr(reproduction, "_COMPARISON", "none")
        patch.setattr(reproduction, "paper_figures", empty_figures)
        patch.setattr("roughxr.application.report.report_page._pictures", lambda run, figures: [])
        groups = reproduction.paper(folder)
    return folder, groups, drawn


def test_each_figure_of_the_paper_is_drawn_once(paper_alone):
    folder, _, drawn = paper_alone
    assert sorted(drawn) == sorted(FIGURES) == _paper_names(folder)


def test_the_paper_ends_with_the_paper(paper_alone):
    """Nothing that the paper does not have but the simulation with adhesion, which its sums are compared with."""
    assert [part.name for part in reproduction._parts(dict)][-2:] == ["paper", "adhesive"]
    folder, groups, _ = paper_alone
    beyond = ("rigid", "rolling", "detachment", "error_budget", "extrapolated", "curves")
    assert not [name for name in groups if name.rpartition("/")[2] in beyond]
    assert "best estimate" not in (folder / "table.txt").read_text(encoding="utf-8").lower()
    names = {path.name for path in folder.iterdir()}
    assert {"paper.nc", "report.html", "table.txt", "places.csv"} <= names and "overview.png" not in names


def test_printed_results_that_were_no_target_are_met(paper_alone):
    """The direct simulation of a smooth flat, where the rough force surpasses the smooth one, and where both agree."""
    pull_off = pd.read_csv(paper_alone[0] / "table-contact.csv", index_col="quantity")
    surpassing = pull_off.loc["figure 15, above smooth from [nm]"]
    assert surpassing["published"] == pytest.approx(surpassing["paper"], abs=0.2)
    table = pd.read_csv(paper_alone[0] / "table-force.csv", index_col="quantity")
    smooth = table.loc["smooth flat, difference from Hertz [%]"]
    assert smooth["direct"] < smooth["paper"]
    places = {d: table.loc[f"places within 2 % at {d} nm"] for d in (11, 12, 13)}
    assert places[11]["published"] == places[11]["corrected"] == 58
    assert 10 < places[12]["published"] < 50 and places[13]["published"] < 5
    ratio = {d: table.loc[f"sum / direct at {d} nm"] for d in (9, 10, 11, 12)}
    for delta in (9, 10, 11):
        assert 0.6 < ratio[delta]["published"] < 1.2 and 0.9 < ratio[delta]["corrected"] < 1.1
    assert ratio[12]["published"] > ratio[12]["corrected"] > 1.3
    scan = pd.read_csv(paper_alone[0] / "table-scan.csv", index_col="quantity")
    assert scan.loc["asperities with a < 10 b [%]", "scan"] > 99


def test_the_corrections_of_formulas_and_patch_cancel(paper_alone):
    """Each entry of the table of corrections is a superposition of its own; the diagonal is that of the methods."""
    groups = paper_alone[1]
    corrections = groups["statistics/corrections"]
    for axis in ("subregion_x", "subregion_y"):
        np.testing.assert_array_equal(corrections[axis], groups["statistics/energy"][axis])
    mean = corrections["pull_off_force"].mean("subregion")
    paper, auto = (mean.sel(patch=patch) for patch in ("paper", "auto"))
    assert float(paper.sel(formulation="self_similar") / paper.sel(formulation="published")) > 3
    assert float(auto.sel(formulation="self_similar") / paper.sel(formulation="self_similar")) < 0.33
    for name, patch in (("published", "paper"), ("self_similar", "auto")):
        method = groups[f"statistics/{name}"]["pull_off_force"].mean()
        assert float(mean.sel(formulation=name, patch=patch)) == pytest.approx(float(method))
    page = (Path(__file__).parents[1] / "notebooks" / "site" / "citing.md").read_text(encoding="utf-8")
    for row in printed_tables.correction_table(groups).to_numpy():
        assert f"| {' | '.join(row)} |".replace("  ", " ") in page


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return the words of a small run, its archive, which is all that it leaves, and what it printed."""
    folder = tmp_path_factory.mktemp("finished")
    scan(rough(64, seed=3), pixel=10.0).to_netcdf(folder / "scan.nc")
    command = ["run", str(folder / "scan.nc"), "--sphere-radius", "0.3 um", "--subregions", "2", "1", "-q"]
    command += ["--young-modulus", "75", "130", "--poisson-ratio", "0.22", "0.28", "--work-of-adhesion", "0.13"]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main([*command, *QUICK, "--budget", "0", "-o", str(folder / "run.nc")]) == 0
    return command, folder / "run.nc", printed.getvalue()


def test_run_does_the_same_for_any_scan(finished, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "roughxr.application.report.report_page._pictures", lambda run, figures: []
    )  # they are of `test_report`
    command, archived, printed = finished
    assert "pull-off, mean" in printed
    with xr.open_datatree(archived) as tree:
        assert float(tree["scan/sphere_radius"]) == 300
        assert float(tree["scan/work_of_adhesion"]) == 0.13
        assert np.isfinite(tree["statistics/energy/pull_off_force"]).any()
        assert "error_budget" not in tree["statistics"]
        means = tree.map_over_datasets(lambda ds: ds.mean())
        assert float(means["solutions/direct/contact_area"]) > 0
        assert not [text for node in tree.subtree for text in node.attrs.values() if str(text)[:1] in ("{", "[")]
        assert tree["solutions/direct/delta"].attrs["datum"] == "first_contact"
    monkeypatch.setattr(analysis, "PARTS", WITHOUT_EXTRAPOLATION)
    assert main([*command, "-o", str(tmp_path / "out"), "--budget", "1", "--delta", "1", "2", "4", "--mesh", "1"]) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"run.nc", "overview.png", "table.txt", "report.html"} <= names
    assert not any(name.startswith("figure-") for name in names)
    table = (tmp_path / "out" / "table.txt").read_text(encoding="utf-8")
    assert "Error budget of the mean pull-off" in table
    assert "Mean pull-off " in " ".join(table.split())
    assert "Force without adhesion" in (tmp_path / "out" / "table.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "no-such-file.spm", "--sphere-radius", "3000", "--materials", "glass"], "no-such-file.spm"),
        (["run", __file__, "--sphere-radius", "3000", "--materials", "glass"], "test_cli.py"),
    ],
)
def test_bad_input_is_one_line_and_status_1(arguments, says, capsys, tmp_path):
    assert main([*arguments, *(["-o", str(tmp_path / "out")] if arguments[0] == "run" else [])]) == 1
    error = capsys.readouterr().err.removeprefix("loading the package\n")
    assert error.startswith("roughxr: ") and says in error
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


def test_the_hardness_of_the_paper_is_an_estimate_that_changes_no_force(tmp_path, monkeypatch):
    executed = []
    monkeypatch.setattr(reproduction, "execute", lambda *arguments, **how: executed.append(arguments) or {})
    monkeypatch.setattr(reproduction, "_as_text", lambda run, tables: "")
    reproduction.paper(tmp_path)
    bodies = executed[0][0].bodies
    assert float(bodies.hardness_estimate) == 6.0 and "hardness" not in bodies.coords


def test_interruption_is_told_and_leaves_nothing(tmp_path, monkeypatch, capsys):
    from roughxr.application.runs import analysis

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(analysis, "analyse", interrupted)
    assert main(["paper", "-o", str(tmp_path / "out"), "-q"]) == 130
    assert "the same command continues" in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.nc")) and not list(tmp_path.rglob("*.part"))


def test_an_interrupted_process_ends_without_the_tasks_that_still_compute():
    program = (
        "import time; from concurrent.futures import ThreadPoolExecutor; from roughxr.application import cli;"
        "ThreadPoolExecutor(1).submit(time.sleep, 60); cli.main = lambda: 130; cli.main_of_process()"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=59).returncode == 130


def test_a_command_collects_garbage_that_its_process_did_not_while_it_imported(tmp_path, capsys):
    scan(rough(32), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    gc.disable()
    try:
        assert main(["info", str(tmp_path / "scan.nc")]) == 0
        assert gc.isenabled() and gc.get_freeze_count() > 0
    finally:
        gc.enable()
        gc.unfreeze()


def test_an_interrupt_elsewhere_promises_nothing(tmp_path, monkeypatch, capsys):
    """Numba turns an interrupt within a kernel into a SystemError."""

    def interrupted(*arguments, **options):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("returned a result with an exception set") from error

    scan(rough(32), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    monkeypatch.setattr(file_commands, "open_scan", interrupted)
    assert main(["convert", str(tmp_path / "scan.nc"), "-o", str(tmp_path / "out.gsf")]) == 130
    assert capsys.readouterr().err == "roughxr: interrupted\n"


def test_info_tells_channels_sizes_and_roughness_and_draws(tmp_path, capsys):
    scan(rough(32), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    assert main(["info", str(tmp_path / "scan.nc"), "--picture", str(tmp_path / "scan.png")]) == 0
    printed = capsys.readouterr().out
    for word in ("scan.nc", "320", "s_q", "nm"):
        assert word in printed
    assert (tmp_path / "scan.png").stat().st_size > 1000
    assert main(["info", str(tmp_path / "scan.nc"), "--picture", "scan.doc"]) == 1
    assert "scan.doc's ending: expected one of" in capsys.readouterr().err


def test_info_prints_each_doubt_once(tmp_path, capsys):
    heights = rough(128)
    heights[:, 40] += 50 * heights.std()  # a line out of place
    path = to_file(scan(heights, pixel=10.0), tmp_path / "scan.gsf")
    assert main(["info", str(path), "--picture", str(tmp_path / "scan.png")]) == 0
    printed = capsys.readouterr()
    assert printed.out.count("line 40") == 1 and printed.err == ""


@pytest.mark.door
def test_images_are_chosen_by_number_or_direction_and_lengths_stated(tmp_path, capsys):
    images = xr.Dataset({"forward": scan(rough(32)).height, "backward": scan(rough(32) * 3).height})
    images.to_netcdf(tmp_path / "both.nc")
    np.savetxt(tmp_path / "bare.txt", rough(32))
    stated = ["--height-units", "um", "--size", "1 um", "2 um"]
    rms = {}
    for name, options in {
        "both.nc": ["--channel", "1"],
        "bare.txt": stated,
    }.items():
        assert main(["info", str(tmp_path / name), *options]) == 0
        (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("  r_q_datum"))
        rms[name] = float(line.split()[1])
    expected = np.sqrt((rough(32) ** 2).mean())
    assert rms == {"both.nc": pytest.approx(3 * expected), "bare.txt": pytest.approx(1000 * expected, rel=1e-5)}
    assert main(["convert", str(tmp_path / "bare.txt"), *stated, "-o", str(tmp_path / "bare.nc")]) == 0
    with xr.open_dataset(tmp_path / "bare.nc") as ds:
        assert float(ds.y[-1] + ds.y[0]) == pytest.approx(2000)
    assert main(["info", str(tmp_path / "both.nc"), "--channel", "2"]) == 1
    assert "forward [nm], backward [nm]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["-o", "scan.xyz"], "--output: expected one of '.nc', '.gsf', found '.xyz'"),
        (["-o", "in.nc/scan.nc"], "in.nc/scan.nc: expected a name in a folder, found a file, in.nc"),
        (["-o", "in.nc"], "--output: expected another file than those that are read, found in.nc"),
    ],
)
def test_what_cannot_be_written_is_refused(options, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scan(rough(32)).to_netcdf("in.nc")
    assert main(["convert", "in.nc", *options]) == 1
    assert says in capsys.readouterr().err and [path.name for path in tmp_path.iterdir()] == ["in.nc"]


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["report", "{run}", "-o", "page.pdf"], "page.pdf: expected the name of a page, ending in .html"),
        (["explore", "{run}", "-o", "page.png"], "page.png: expected the name of a page, ending in .html"),
        (["paper", "-o", ""], "--output: expected the name of a file or folder, found an empty one"),
        (["detach", "{run}", "--dem", "edem", "out.csv"], "--dem: expected one of 'lammps', 'liggghts'"),
        (["detach", "{run}", "--remove", "90"], "--remove: expected a number between 0 and 1, such as 0.9 or '90 %'"),
    ],
)
def test_an_output_of_another_kind_and_a_wrong_value_are_named_by_the_option(
    finished, command, says, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    _, archived, _ = finished
    assert main([word.format(run=archived) for word in command]) == 1
    assert says in capsys.readouterr().err
    assert not [*tmp_path.glob("*")]


def test_a_finished_run_is_recognised_and_another_refused(finished, capsys):
    command, archived, _ = finished
    again = [*command, *QUICK, "--budget", "0", "-o", str(archived)]
    first = archived.read_bytes()
    assert main(again) == 0
    assert archived.read_bytes() == first
    assert main([*again, "--sphere-radius", "0.6 um"]) == 1
    assert "300" in capsys.readouterr().err
    assert archived.read_bytes() == first


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ([], "expected the bodies' elastic constants, found none; give --materials A/B"),
        (
            ["--young-modulus", "75", "--poisson-ratio", "0.22"],
            "expected the adhesion of the bodies, found none",
        ),
        (["--materials", "glass/cheese"], "expected one or two of glass"),
    ],
)
def test_what_nobody_can_guess_is_asked_for(options, says, tmp_path, capsys):
    scan(rough(32), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    assert (
        main(["run", str(tmp_path / "scan.nc"), "--sphere-radius", "500", *options, "-o", str(tmp_path / "o.nc")]) == 1
    )
    assert says in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["scan.nc"]


EMPTY = {
    "one place": ["--subregions", "1", "1"],
    "nothing touches": ["--subregions", "2", "1", "--delta", "1e-6"],
    "far too deep": ["--subregions", "2", "1", "--delta", "1e4"],
    "no adhesion": ["--subregions", "2", "1", "--work-of-adhesion", "0"],
}


@pytest.mark.door
@pytest.mark.parametrize(
    ("options", "output"),
    [pytest.param(EMPTY["no adhesion"], "run.nc", id="no adhesion, run.nc alone")]
    + [pytest.param(options, "", id=name, marks=pytest.mark.soak) for name, options in EMPTY.items()],
)
def test_a_run_that_finds_nothing_ends_well_and_is_reported_as_what_it_is(options, output, tmp_path, monkeypatch):
    monkeypatch.setattr("roughxr.application.report.report_page._DPI", 50)  # whether they are drawn, and not how well
    if "--delta" in options:
        monkeypatch.setattr(analysis, "PARTS", WITHOUT_EXTRAPOLATION)  # as in the other cases
    scan(rough(64, rms=1.0, seed=3), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    pair = ["--sphere-radius", "500", "--materials", "glass", *QUICK, "--budget", "1"]
    written = tmp_path / "out" / output
    assert main(["run", str(tmp_path / "scan.nc"), *pair, *options, "-q", "-o", str(written)]) == 0
    assert main(["report", str(written)]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "What was analysed" in page and "Force without adhesion" in page
    if "1e-6" in options:
        assert "Nothing touches at any displacement" in page
    if options[-2:] == ["1", "1"]:
        assert "Only one place was computed" in page


def test_a_flat_scan_is_told_before_anything_is_solved(tmp_path, capsys):
    scan(np.zeros((64, 64)), pixel=10.0).to_netcdf(tmp_path / "scan.nc")
    pair = ["--sphere-radius", "500", "--materials", "glass"]
    assert main(["run", str(tmp_path / "scan.nc"), *pair, "-o", str(tmp_path / "o.nc")]) == 1
    printed = capsys.readouterr().err
    assert "is it flat?" in printed and "direct simulation" not in printed


@pytest.mark.door
def test_a_folder_of_scans_is_one_command_with_its_options_in_a_file(tmp_path, capsys, monkeypatch):
    """Three surfaces, one of them no scan: a run of each, one table, one page, each scan's answer on the last lines."""
    monkeypatch.chdir(tmp_path)
    for seed in (3, 4):
        scan(rough(48, seed=seed), pixel=10.0).to_netcdf(f"wafer-{seed}.nc")
    (tmp_path / "torn.nc").write_bytes(b"no scan at all")
    with pytest.raises(SystemExit, match="0"):
        main(["run", "--write-config", "wafer.toml"])
    capsys.readouterr()
    options = ["sphere_radius = '0.3 um'  # the bodies", "materials = 'glass/silicon'", "law = 'Griffith'", "mesh = 1"]
    options += ["fluid = 'water'"]
    with (tmp_path / "wafer.toml").open("a", encoding="utf-8") as file:
        file.write("\n".join([*options, "budget = 8", "subregions = [2, 1]"]))
    files = ["wafer-3.nc", "wafer-4.nc", "torn.nc"]
    with bare_runs("extrapolated", "curves", "rigid", "superposition"):
        assert main(["run", *files, "--config", "wafer.toml", "--budget", "0", "-o", "wafer", "-q"]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith("roughxr: torn.nc: cannot be read and is left out: ")
    assert printed.err.count("left out") == 1
    lines = printed.out.splitlines()
    assert lines[-3].startswith("Mean pull-off over 2 scans, as scanned: ")
    assert lines[-3].endswith(" 1 of 3 files were left out.")
    assert [line.partition(":")[0] for line in lines[-2:]] == ["wafer-3.nc", "wafer-4.nc"]
    table = pd.read_csv("wafer/places.csv")
    assert table.columns[0] == "scan" and sorted(table["scan"]) == ["wafer-3.nc"] * 2 + ["wafer-4.nc"] * 2
    assert table.notna().any().all()
    rows = pd.read_csv("wafer/wafer.csv", index_col="scan")
    assert list(rows.index) == ["wafer-3.nc", "wafer-4.nc"] and (rows["places"] == 2).all()
    columns = rows.columns.tolist()
    order = ["pull_off_force [nN]", "critical_friction_velocity [m/s]", "wall_shear_stress [Pa]", "places", "supports"]
    assert sorted(order, key=columns.index) == order and columns[-2:] == ["warnings", "path"]
    assert rows["warnings"].str.endswith(".").all() and rows.notna().any().all()
    assert (rows[["materials", "fluid"]] == ["glass/silicon", "water"]).all(axis=None)
    assert (rows["sphere_radius [nm]"] == 300).all() and pd.to_datetime(rows["date"]).notna().all()
    for name, row in rows.iterrows():
        groups = archive.load(tmp_path / "wafer" / Path(name).stem / "run.nc")
        summary = groups["statistics/summary"]
        assert groups["solutions/adhesive"].attrs["law"] == "jkr"
        assert row["pull_off_force [nN]"] == pytest.approx(
            float(groups["statistics/adhesive"].pull_off_force.mean()), rel=1e-3
        )
        assert row["wall_shear_stress [Pa]"] == pytest.approx(float(summary.wall_shear_stress), rel=1e-3)
        assert float(summary.wall_shear_stress / summary.critical_friction_velocity**2) == pytest.approx(998.2)
        sentence = report.headline(groups)
        assert f"{name}: {sentence}" in lines
        assert " ".join(summary.contact.answer().sentence.split()) == sentence
        assert main(["explore", f"wafer/{Path(name).stem}"]) == 0
        capsys.readouterr()
        for page in ("report.html", "explore.html", "table.txt", "../index.html"):
            text = (tmp_path / "wafer" / Path(name).stem / page).read_text(encoding="utf-8")
            assert sentence in " ".join(html.unescape(text).split())
            assert "flow of water" in text or page == "explore.html"
            assert "flow of air" not in text
        assert pd.read_csv(f"wafer/{Path(name).stem}/places.csv").columns[0] == "scan"
        repeated = f"roughxr run {name} --sphere-radius '0.3 um' --materials glass/silicon --subregions 2 1 "
        repeated += f"--fluid water --law Griffith --mesh 1 --budget 0 -o wafer/{Path(name).stem}"
        assert summary.attrs["command"] == repeated
    assert main(["detach", "wafer", "--remove", "90%", "--picture", "moved.png", "-o", "moved.csv"]) == 0
    heading, columns, *rows = capsys.readouterr().out.splitlines()
    assert heading.startswith("critical friction velocity (flow of water; ") and "removes 90 %" in columns
    assert [row.split()[0] for row in rows] == ["wafer-3", "wafer-4", "drawn", "written"]
    assert pd.read_csv("moved.csv")["scan"].tolist() == ["wafer-3.nc"] * 2 + ["wafer-4.nc"] * 2
    assert main(["detach", "wafer", "--parameters", "moved.csv"]) == 1
    page = (tmp_path / "wafer" / "index.html").read_text(encoding="utf-8")
    assert "wafer-4/report.html" in page and (tmp_path / "wafer" / "wafer-4" / "report.html").exists()
    assert "torn.nc" in page
    assert "<dt>materials</dt><dd>glass/silicon</dd>" in page and "its 95 % interval" in page
    assert "all errors as scanned (half width of the 95 % interval)" in page


def test_a_file_is_no_place_for_a_run(tmp_path, capsys):
    path = tmp_path / "notes.md"
    path.write_text("kept", encoding="utf-8")
    file = str(tmp_path / "scan.nc")
    scan(rough(32), pixel=10.0).to_netcdf(file)
    arguments = ["--radius", "300", "--materials", "glass", "-o", str(path)]
    wanted = {1: "a folder or a file ending in .nc", 2: "a folder for several scans"}
    for count, expected in wanted.items():
        assert main(["run", *[file] * count, *arguments]) == 1
        assert f"--output: expected {expected}, found " in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == "kept"


def test_a_reader_that_has_had_enough_is_no_error(tmp_path):
    program = f"import sys; from roughxr.application.cli import main; sys.exit(main({['--help']!r}))"
    buffered = os.environ | {"PYTHONUNBUFFERED": ""}  # the output is written at the end
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", program], **pipes, env=buffered) as process:
        process.stdout.close()
        assert process.stderr.read() == b"" and process.wait() == 0


def _bug():
    return None + 1


def _library():
    return np.zeros(3).reshape(2, 2)


@pytest.mark.parametrize("fault", [_bug, _library])
def test_an_error_that_is_no_refusal_shows_where_it_is(fault, tmp_path, monkeypatch):
    scan(rough(32)).to_netcdf(tmp_path / "scan.nc")
    monkeypatch.setattr(file_commands, "open_scan", lambda *_, **__: fault())
    with pytest.raises((TypeError, ValueError)):
        main(["convert", str(tmp_path / "scan.nc"), "-o", str(tmp_path / "out.nc")])


def test_output_never_fails_on_a_sign(tmp_path, monkeypatch):
    scan(rough(32), title="− Δ 表面").to_netcdf(tmp_path / "scan.nc")
    printed = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(printed, encoding="ascii", errors="strict"))
    assert main(["info", str(tmp_path / "scan.nc")]) == 0
    sys.stdout.flush()
    assert b"s_q" in printed.getvalue() and b"?" in printed.getvalue()


def test_a_method_that_a_run_does_not_have_is_refused(finished, capsys):
    groups = archive.load(finished[1])
    needed = {"scan", "asperities", "solutions/adhesive", *report.DETACHMENT} & set(groups)
    archive.save({name: groups[name] for name in needed}, finished[1].with_name("other.nc"))
    assert main(["detach", str(finished[1].with_name("other.nc")), "--method", "extrapolated"]) == 1
    assert "found none of extrapolated; take --method adhesive" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "a.nc", "--radius", "3", "um"], "unexpected um after --radius 3: quote values that contain spaces"),
        (["detach", "run", "--dem", "lammps"], "--dem: expected 2 arguments, CODE FILE; see"),
        (["detach", "run", "--load", "tilt"], "what detaches the sphere is --cause: wall_shear, tilt"),
        (["compare", "run", "forces.csv", "-o", "table.csv"], "roughxr compare: unknown option -o"),
        (["rnu", "a.nc"], r"unknown command rnu \(did you mean run\?\)"),
        (["run", "@wafer.toml"], r"read by --config wafer.toml; a file of this name is \./@wafer.toml"),
        (["run", "a.nc", "--budget", "1.5"], "expected a whole number, found '1.5'"),
        (["detach", "run", "--friction-coefficient", "0.3 N"], "expected a number without a unit, .*found '0.3 N'"),
        (["run", "a.nc", "--diameter", "5 um"], "give --sphere-radius half of this value"),
        (["run", "a.nc", "--budget", "-2"], "--budget: expected a whole number, found .-2."),
        (["run", "a.nc", "--sphere-diameter", "5 um"], "the radius is half of the diameter"),
        (["run", "a.nc", "--radius", "3um", "--subregions", "many"], "such as 8 8 or 8x8, found 'many'"),
        (["run", "a.nc", "--radius", "3um", "--delta", "5 nN"], "argument --delta: "),
        (["paper", "glass"], "unexpected glass: expected options alone; see"),
        (["convert", "a.nc", "b.nc", "-o", "c.gsf"], "unexpected b.nc: expected FILE alone; see"),
    ],
)
def test_a_wrong_word_is_answered_with_the_right_one(arguments, says, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert re.search(says, capsys.readouterr().err)


@pytest.mark.parametrize(
    ("arguments", "name", "expected"),
    [
        (["--subregions", "4x2"], "subregions", (4, 2)),
        (["--subregions", "4,2"], "subregions", (4, 2)),
        (["--subregions", "4", "2"], "subregions", (4, 2)),
        (["--delta", "5nm", "0.01 um"], "delta", [5.0, 10.0]),
        (["--delta", "-5nm"], "delta", [-5.0]),
        (["--preload", "-3nN"], "preload", "-3nN"),
    ],
)
def test_numbers_are_read_as_people_write_them(arguments, name, expected):
    options = command_line().parse_args(["run", "a.nc", "--radius", "3um", *arguments])
    read = getattr(options, name)
    assert (both_counts(read) if name == "subregions" else read) == expected


@pytest.mark.parametrize("shortened", [["--humid", "20 %"], ["--humid=20 %"]])
def test_a_shortened_option_replaces_that_of_a_file(shortened, tmp_path):
    file = tmp_path / "wafer.toml"
    file.write_text("sphere_radius = 3\nhumidity = '60 %'\n")
    options = command_line().parse_args(["run", "a.nc", "--conf", str(file), *shortened])
    assert (options.sphere_radius, options.humidity) == ("3", "20 %")


def test_another_file_is_no_damaged_archive(tmp_path, capsys):
    (tmp_path / "m.csv").write_text("pull_off_force [nN]\n1\n")
    assert main(["report", str(tmp_path / "m.csv")]) == 1
    assert (
        "m.csv: expected the archive of a run, found another kind of file, such as a scan, or damage"
        in capsys.readouterr().err
    )


def test_options_that_need_humidity_are_named_as_typed(tmp_path, capsys):
    scan(rough(32), pixel=10.0).to_netcdf(tmp_path / "a.nc")
    arguments = ["run", str(tmp_path / "a.nc"), "--radius", "300", "--materials", "glass"]
    assert main([*arguments, "--film", "5nm", "-o", str(tmp_path / "o")]) == 1
    printed = capsys.readouterr().err
    assert "--humidity: expected one with --film, found none" in printed and "a solid film is a --layer" in printed
    assert main([*arguments, "--humidity", "160%", "-o", str(tmp_path / "o")]) == 1
    assert capsys.readouterr().err.rstrip().endswith("found '160%'")


def test_quoted_wildcards_name_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("force [nN]\n1\n2\n3\n")
    assert main(["measured", "*.csv"]) == 0
    assert "median" in capsys.readouterr().out
    assert main(["info", "*.csv"]) == 1
    assert "expected one file, found 2 by *.csv: a.csv, b.csv" in capsys.readouterr().err
    assert main(["info", "*.spm"]) == 1
    assert "expected files that fit the wildcards, found none by *.spm" in capsys.readouterr().err


def test_the_archive_of_a_folder_is_that_with_statistics(tmp_path):
    scan = roughxr.open_sample("rough").isel(x=slice(0, 8), y=slice(0, 8))
    roughxr.scans.to_netcdf(scan, tmp_path / "a-scan.nc")
    roughxr.archive.save({"scan": scan, "statistics/roughness": scan.contact.roughness()}, tmp_path / "wafer.nc")
    assert roughxr.application.archive.run_archive(tmp_path).name == "wafer.nc"


@pytest.mark.parametrize("name", ["preload=5.spm", "sphere_radius scan.spm", "law=jkr.spm", "size", "law"])
def test_a_file_is_printed_by_its_name_even_if_this_looks_like_an_argument(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = ["run", name, "--sphere-radius", "500", "--materials", "glass"]
    assert main(command) == 1
    assert capsys.readouterr().err.splitlines()[-1] == f"roughxr: {name}: no such file or directory"
    Path(name).write_text("no scan")
    assert main(command) == 1
    assert f"roughxr: {name}: expected an AFM image, found" in capsys.readouterr().err
