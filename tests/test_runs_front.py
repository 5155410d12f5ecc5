"""Runs whose contacts are followed by their front: archive, resumption, report, and what they leave out."""

import html
import re

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import archive
from roughxr.application import cli, report
from roughxr.application.runs import analysis
from roughxr.mechanics.statistics.means import mean_pull_off

from .surfaces import bare_runs

OPTIONS = {"subregions": (2, 1), "mesh": "front", "budget": 1}


def lens(amplitude=3.0):
    """Return a lens of PDMS over ripples that fit it, on which it holds more than on a flat."""
    x = 25.0 * (np.arange(64) + 0.5)
    ripples = np.cos(2 * np.pi * x / 200)
    scan = xr.Dataset({"height": (("x", "y"), amplitude * np.multiply.outer(ripples, ripples))}, {"x": x, "y": x})
    pair = {"sphere_radius": 1000, "contact_modulus": 0.03, "work_of_adhesion": 0.05}
    return roughxr.schema.label(scan).contact.assign_pair(**pair)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An interrupted and resumed run, the groups that it had by then, and what `adhesive` gives."""
    path = tmp_path_factory.mktemp("front") / "lens"
    with bare_runs():
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(analysis, "PARTS", [part._replace(make=_stop(part)) for part in analysis.PARTS])
            with pytest.raises(KeyboardInterrupt):
                roughxr.run(lens(), path, **OPTIONS)
        with pytest.warns(UserWarning, match="the run is not finished, missing: .*; the same command continues it"):
            before = archive.load(path / "run.nc")
        whole = lens().contact.adhesive(subregions=(2, 1), mesh="front")
        return path, before, roughxr.run(lens(), path, **OPTIONS), whole


def _stop(part, name="rigid"):
    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    return interrupted if part.name == name else part.make


def test_a_run_by_the_front_resumes_with_the_same_values(made):
    _, before, resumed, whole = made
    assert "statistics/rigid" not in before
    for groups in (before, resumed):
        xr.testing.assert_equal(groups["solutions/adhesive"].load(), whole)
    solved = resumed["solutions/adhesive"]
    assert solved.attrs["mesh"] == "front" and not solved["mesh"].any() and solved["complete"].all()
    assert float(resumed["statistics/error_budget"]["relative_std"].sel(entry="mesh")) < 0.15


def test_its_report_states_what_is_left_out(made):
    path, _, groups, _ = made
    assert {"solutions/curves", "solutions/pull_off_contact", "solutions/rolling"}.isdisjoint(groups)
    page = html.unescape(re.sub("<[^>]+>", " ", (path / "report.html").read_text()))
    assert "followed by its edge" in page
    assert "Left out: fields, force over displacement, and moments that resist rolling" in page
    (path / "report.html").unlink()
    with bare_runs():
        assert cli.main(["report", str(path)]) == 0
    assert (path / "report.html").exists()


def test_a_run_warns_of_soft_places_that_take_long_before_it_starts(tmp_path, monkeypatch):
    """They are requested on cells, not by their front."""
    monkeypatch.setattr(analysis, "PARTS", [analysis.PARTS[0]._replace(make=_stop(analysis.PARTS[0], "asperities"))])
    pair = {"sphere_radius": 5000, "contact_modulus": 0.003, "work_of_adhesion": 0.05}
    with pytest.raises(KeyboardInterrupt), pytest.warns(UserWarning, match="a place takes about 50 s of processor"):
        roughxr.run(roughxr.open_sample("rough"), tmp_path / "run.nc", law="jkr", **pair)


def test_no_result_by_the_front_advises_a_finer_mesh(made):
    path, _, groups, _ = made
    solved = groups["solutions/adhesive"]
    summary = mean_pull_off(solved)
    assert float(summary["smooth_share"]) > 1
    sentence = solved.contact.answer().attrs["sentence"]
    assert "fits the sphere" in sentence
    sentences = [sentence, (path / "report.html").read_text(), *report.cautions(groups)]
    assert not any("finer mesh" in " ".join(text.split()) for text in sentences)
    on_cells = solved.assign_attrs(mesh=2).contact.answer().attrs["sentence"]
    assert "compare with a finer mesh" in " ".join(on_cells.split())


def test_a_caution_counts_the_places_without_a_valid_front(made):
    _, _, groups, _ = made
    solved = groups["solutions/adhesive"].load()
    lost = solved.assign(complete=solved["complete"] & (solved["subregion"] > 0))
    cautions = report.cautions(dict(groups) | {"solutions/adhesive": lost})
    assert any("1 of 2 places have no valid front" in caution for caution in cautions)
    assert not any("no valid front" in caution for caution in report.cautions(groups))
