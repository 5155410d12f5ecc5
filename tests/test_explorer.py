"""The interactive page of a run: it contains the archive's numbers, and a click changes what it shows."""

import base64
import io
import json
import re
import warnings

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread

import roughxr
from roughxr import archive
from roughxr.application import report
from roughxr.application.cli import main
from roughxr.application.report.explorer import explorer_page, page_data

from .browser import BROWSER, NO_BROWSER, Browser
from .surfaces import rough, scan

DELTAS = np.arange(5.0, 14.5, 0.5).tolist()


@pytest.fixture(scope="module")
def run():
    """Return the groups of a run at four places, its adhesion without a range."""
    pressed = roughxr.assign_pair(scan(rough(64, seed=3), pixel=10.0), sphere_radius=300, contact_modulus=40)
    pressed = pressed.assign_coords(work_of_adhesion=0.2)
    places = roughxr.scans.regions.centres(pressed, (2, 2))
    how = {"preload": 0.0, "law": "jkr", "mesh": roughxr.Mesh(1, step=0.5), "subregions": places}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of contacts of a pixel: their maps are looked at, not their numbers
        sticking = roughxr.adhesive(pressed, **how)
        rigid = roughxr.rigid(pressed, delta=[0.0], subregions=places)
    return {
        "scan": pressed,
        "solutions/direct": roughxr.direct(pressed, delta=DELTAS, subregions=places),
        "solutions/energy": roughxr.superpose(pressed, delta=np.linspace(-2, 14, 81), subregions=places),
        "solutions/adhesive": sticking,
        "solutions/rigid": rigid,
        "statistics/adhesive": roughxr.pull_off(sticking),
        "statistics/rigid": roughxr.pull_off(rigid),
    }


@pytest.fixture(scope="module")
def written(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("explorer")
    return report.write_explorer(archive.save(run, folder / "run.nc"))


def content(text):
    """Return the data that the page's script reads."""
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL).group(1))


@pytest.fixture(scope="module")
def data(written):
    return content(written.read_text(encoding="utf-8"))


def named(rows, name):
    return next(row for row in rows if row["name"] == name)


def pixels(uri):
    return imread(io.BytesIO(base64.b64decode(uri.partition(",")[2])))


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_places_are_those_of_the_archive(data, run):
    centres = [[place["x"], place["y"]] for place in data["places"]]
    direct = run["solutions/direct"]
    assert centres == np.stack([direct.subregion_x, direct.subregion_y], axis=1).tolist()


def test_curves_and_pull_offs_are_the_archives(data, run):
    for name in ("direct", "energy"):
        lines = named(data["curves"], name)["lines"]
        solved = run[f"solutions/{name}"]
        for k, (line,) in enumerate(lines):
            forces = dict(zip(line["delta"], line["force"]))
            shown = [forces[delta] for delta in solved.delta.values.round(4)]
            np.testing.assert_allclose(shown, solved.force.isel(subregion=k), rtol=1e-4)
    pulls = named(data["pulls"], "adhesive")
    events = named(data["curves"], "adhesive")
    touch = run["solutions/rigid"].touch_delta.values
    solved = run["solutions/adhesive"]
    np.testing.assert_allclose(np.array(pulls["values"], float), solved.pull_off_force, rtol=1e-4)
    for k, (points,) in enumerate(events["lines"]):
        assert points["delta"] == pytest.approx([float(solved.pull_off_delta[k]) + touch[k]], rel=1e-4)
        assert points["force"] == pytest.approx([-float(solved.pull_off_force[k])], rel=1e-4)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_a_superposed_curve_attains_the_pull_off_of_its_table_at_every_place(run):
    for deltas in (None, [-2.0, 5.0, 14.0]):  # displacements that step over the tension, too
        swept = roughxr.superpose(run["scan"], delta=deltas, subregions=(4, 4))
        groups = {"solutions/energy": swept, "statistics/energy": roughxr.pull_off(swept)}
        (curve,) = page_data({"scan": run["scan"]} | groups)["curves"]
        least = [min(line["force"]) for (line,) in curve["lines"]]
        np.testing.assert_allclose(least, -swept.pull_off_force, rtol=1e-4)
        assert all((np.diff(line["delta"]) >= 0).all() for (line,) in curve["lines"])


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_missing_groups_are_left_out_and_missing_numbers_are_null(run):
    bare = content(explorer_page({"scan": run["scan"], "solutions/direct": run["solutions/direct"]}))
    assert bare["pulls"] == [] and [curve["name"] for curve in bare["curves"]] == ["direct"]
    spoiled = run["statistics/adhesive"].copy(deep=True)
    spoiled["pull_off_force"][dict(subregion=0)] = np.nan
    text = explorer_page(run | {"statistics/adhesive": spoiled})
    assert named(content(text)["pulls"], "adhesive")["values"][0] is None


def test_an_archive_that_is_no_run_is_refused(run, tmp_path, capsys):
    for keep in ("solutions/direct", "scan"):
        path = archive.save({keep: run[keep]}, tmp_path / "some.nc")
        assert main(["explore", str(path), "-q"]) == 1
        assert (
            f"some.nc: expected the archive of a run, with its scan and results at places, found groups: {keep};"
            in (capsys.readouterr().err)
        )
        assert [file.name for file in tmp_path.iterdir()] == ["some.nc"]


def test_text_of_a_file_cannot_break_the_page(run):
    nasty = run["scan"].assign_attrs(title="</script><script>alert(1)</script>")
    text = explorer_page({"scan": nasty, "solutions/direct": run["solutions/direct"]})
    assert "alert(1)</script>" not in text and text.count("<script") == 2


@pytest.fixture(scope="module")
def browser():
    if BROWSER is None:
        pytest.skip(NO_BROWSER)
    with Browser() as browser:
        yield browser


#: What the page shows of the chosen place.
SHOWN = """({
  curves: [...document.querySelectorAll("#force .curve")].map(curve => curve.dataset.method + curve.getAttribute("d")),
  methods: [...document.querySelectorAll("#force [data-method]")].map(curve => curve.dataset.method),
  mark: Number(document.querySelector("#mark")?.dataset.value),
  chosen: Number(document.querySelector("#chosen").dataset.place),
  current: document.querySelector("#current").textContent,
  hash: location.hash,
})"""


@pytest.mark.parametrize("width", [400, 1280])
def test_a_click_changes_curves_and_mark(browser, written, run, width):
    browser.open(written, width)
    before = browser.value(SHOWN)
    browser.click('#scan .place[data-place="3"]')
    after = browser.value(SHOWN)
    assert before["chosen"] == 0 and after["chosen"] == 3 and after["hash"] == "#place=3"
    assert "Place 3" in after["current"] and set(after["methods"]) == {"adhesive", "direct", "energy"}
    assert not set(after["curves"]) & set(before["curves"])
    stored = run["solutions/adhesive"].pull_off_force
    assert [before["mark"], after["mark"]] == pytest.approx(stored.values[[0, 3]], rel=1e-4)
    assert browser.complaints() == []
    assert browser.value("document.documentElement.scrollWidth") <= width


def test_keys_alone_choose_places(browser, written):
    browser.open(written, 1280)
    browser.value("document.querySelector('#scan').focus()")
    visited = []
    for key in ("UP", "RIGHT", "RIGHT", "DOWN", "HOME", "END"):
        browser.press(f"ARROW_{key}" if key not in ("HOME", "END") else key)
        visited.append(browser.value(SHOWN)["chosen"])
    assert visited == [1, 3, 3, 2, 0, 3]
    assert browser.complaints() == []


def test_an_address_names_a_place_and_axes_name_their_units(browser, written, run):
    browser.open(written, 400, address="#place=2")
    shown = browser.value(SHOWN)
    stored = run["solutions/adhesive"].pull_off_force
    assert shown["chosen"] == 2 and shown["mark"] == pytest.approx(float(stored[2]), rel=1e-4)
    labels = browser.value("[...document.querySelectorAll('svg text')].map(text => text.textContent)")
    for axis in ("x", "y", "displacement δ", "force", "pull-off force"):
        assert any(re.fullmatch(rf"{axis} \[.*\]", label) for label in labels), axis


def test_a_bare_archive_is_shown_without_complaint(browser, run, tmp_path):
    page = tmp_path / "bare.html"
    page.write_text(explorer_page({name: run[name] for name in ("scan", "solutions/direct")}), encoding="utf-8")
    browser.open(page, 400)
    browser.click('#scan .place[data-place="1"]')
    assert browser.complaints() == [] and "no pull-off" in browser.value("document.body.innerText")
    nothing = xr.full_like(run["solutions/direct"][["force"]], np.nan)
    bare = {"scan": run["scan"].drop_vars("contact_modulus"), "solutions/direct": nothing.drop_vars("contact_modulus")}
    page.write_text(explorer_page(bare), encoding="utf-8")
    browser.open(page, 400)
    assert browser.complaints() == []
    assert "querySelector" not in browser.value("document.body.innerText")
