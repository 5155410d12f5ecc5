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
from roughxr import archive, report
from roughxr.cli import main

from .browser import BROWSER, NO_BROWSER, Browser
from .surfaces import rough, scan

DELTAS = np.arange(5.0, 14.5, 0.5).tolist()


@pytest.fixture(scope="module")
def run():
    """Return the groups of a run at four places, its adhesion without a range."""
    pressed = roughxr.assign_pair(scan(rough(64, seed=3), pixel=10.0), sphere_radius=300, contact_modulus=40)
    pressed = pressed.assign_coords(work_of_adhesion=0.2)
    places = roughxr.scans.regions.centres(pressed, (2, 2))
    how = {"preload": 0.0, "law": "griffith", "mesh": roughxr.Mesh(1, step=0.5), "subregions": places}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of contacts of a pixel: their maps are looked at, not their numbers
        sticking = roughxr.adhesive(pressed, **how)
    return {
        "scan": pressed,
        "solutions/direct": roughxr.direct(pressed, delta=DELTAS, subregions=places),
        "solutions/energy": roughxr.superpose(pressed, delta=np.linspace(-2, 14, 81), subregions=places),
        "solutions/adhesive": sticking,
        "solutions/rigid": roughxr.rigid(pressed, delta=[0.0], subregions=places),
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


def test_places_are_those_of_the_archive(data, run):
    centres = [[place["x"], place["y"]] for place in data["places"]]
    direct = run["solutions/direct"]
    assert centres == np.stack([direct.subregion_x, direct.subregion_y], axis=1).tolist()


def test_curves_and_pull_offs_are_the_archives(data, run):
    for name in ("direct", "energy"):
        lines = named(data["curves"], name)["lines"]
        solved = run[f"solutions/{name}"]
        for k, (line,) in enumerate(lines):
            np.testing.assert_allclose(line["delta"], solved.delta, rtol=1e-4, atol=1e-9)
            np.testing.assert_allclose(line["force"], solved.force.isel(subregion=k), rtol=1e-4)
    pulls, events = named(data["pulls"], "adhesive"), named(data["curves"], "adhesive")
    touch = run["solutions/rigid"].touch_delta.values
    solved = run["solutions/adhesive"]
    np.testing.assert_allclose(np.array(pulls["values"], float), solved.pull_off_force, rtol=1e-4)
    for k, (points,) in enumerate(events["lines"]):
        assert points["delta"][0] == pytest.approx(float(solved.pull_off_delta[k]) + touch[k], rel=1e-4)


def test_several_conditions_are_refused(run):
    several = run | {"solutions/adhesive": xr.concat([run["solutions/adhesive"]] * 2, "preload")}
    with pytest.raises(ValueError, match="expected one condition, found several along preload"):
        report.explorer_page(several)


def test_maps_show_the_fields_of_the_archive_as_they_lie_on_the_surface():
    """A bump to the right of the centre and above it presses in the picture's right upper quarter."""
    flat = scan(np.zeros((32, 32)), pixel=10.0)
    bumpy = flat.assign(height=flat.height + 5 * np.exp(-((flat.x - 55) ** 2 + (flat.y - 35) ** 2) / 200))
    bumpy["height"].attrs = flat.height.attrs
    bumpy = roughxr.assign_pair(bumpy, sphere_radius=1000, contact_modulus=40)
    solved = roughxr.direct(bumpy, delta=[3.0, 4.0], subregions=([0.0], [0.0]), fields=True)
    states = content(report.explorer_page({"scan": bumpy, "solutions/direct": solved}))["maps"]["0"]
    np.testing.assert_allclose([state["force"] for state in states], solved.force[0], rtol=1e-4)
    shown = pixels(states[-1]["picture"])[..., 3] > 0
    x0, x1, y0, y1 = states[-1]["box"]
    cell = (x1 - x0) * (y1 - y0) / shown.size
    assert shown.sum() * cell == pytest.approx(float(solved.contact_area[0, -1]), rel=1e-4)
    rows, columns = np.nonzero(shown)
    assert x0 + (columns.mean() + 0.5) / shown.shape[1] * (x1 - x0) == pytest.approx(55, abs=10)
    assert y1 - (rows.mean() + 0.5) / shown.shape[0] * (y1 - y0) == pytest.approx(35, abs=10)


def test_missing_groups_are_left_out_and_missing_numbers_are_null(run):
    bare = content(report.explorer_page({"scan": run["scan"], "solutions/direct": run["solutions/direct"]}))
    assert bare["pulls"] == [] and bare["maps"] == {} and [curve["name"] for curve in bare["curves"]] == ["direct"]
    spoiled = run["solutions/adhesive"].copy(deep=True)
    spoiled["pull_off_force"][dict(subregion=0)] = np.nan
    text = report.explorer_page(run | {"solutions/adhesive": spoiled})
    assert named(content(text)["pulls"], "adhesive")["values"][0] is None


@pytest.mark.parametrize(
    ("keep", "says"),
    [
        (["solutions/direct"], "with its scan, found groups: solutions/direct; make one with roughxr run"),
        (["scan"], "expected results at places of the scan .*, found groups: scan"),
    ],
)
def test_an_archive_that_is_no_run_is_refused(run, tmp_path, keep, says, capsys):
    path = archive.save({name: run[name] for name in keep}, tmp_path / "some.nc")
    with pytest.raises(ValueError, match=f"some.nc: .*{says}"):
        report.write_explorer(path)
    assert main(["explore", str(path), "-q"]) == 1
    told = capsys.readouterr().err
    assert told.startswith("roughxr: ") and told.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["some.nc"]


def test_text_of_a_file_cannot_break_the_page(run):
    nasty = run["scan"].assign_attrs(title="</script><script>alert(1)</script>")
    text = report.explorer_page({"scan": nasty, "solutions/direct": run["solutions/direct"]})
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
  map: document.querySelector("#map image")?.getAttribute("href"),
  words: document.querySelector("#map-words").textContent,
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
    words = browser.value("[...document.querySelectorAll('svg text')].map(text => text.textContent)")
    for axis in ("x", "y", "displacement δ", "force", "pull-off force"):
        assert any(re.fullmatch(rf"{axis} \[.*\]", word) for word in words), axis


def test_a_bare_archive_is_shown_without_complaint(browser, run, tmp_path):
    page = tmp_path / "bare.html"
    page.write_text(report.explorer_page({name: run[name] for name in ("scan", "solutions/direct")}), encoding="utf-8")
    browser.open(page, 400)
    browser.click('#scan .place[data-place="1"]')
    assert browser.complaints() == [] and "no pull-off" in browser.value("document.body.innerText")
    nothing = xr.full_like(run["solutions/direct"][["force"]], np.nan)
    bare = {"scan": run["scan"].drop_vars("contact_modulus"), "solutions/direct": nothing.drop_vars("contact_modulus")}
    page.write_text(report.explorer_page(bare), encoding="utf-8")
    browser.open(page, 400)
    assert browser.complaints() == [] and "holds no fields" in browser.value("document.body.innerText")
    assert "querySelector" not in browser.value("document.body.innerText")


def test_the_map_follows_the_place_and_the_displacement(browser, run, tmp_path):
    page = tmp_path / "fields.html"
    fields = roughxr.direct(run["scan"], delta=DELTAS[-3:], subregions=run["solutions/direct"], fields=True)
    page.write_text(report.explorer_page({"scan": run["scan"], "solutions/direct": fields}), encoding="utf-8")
    browser.open(page, 1280)
    deepest = browser.value(SHOWN)
    browser.value("document.querySelector('#state').focus()")
    browser.press("HOME")
    shallow = browser.value(SHOWN)
    browser.click('#scan .place[data-place="3"]')
    assert len({deepest["map"], shallow["map"], browser.value(SHOWN)["map"]}) == 3
    assert f"δ = {DELTAS[-3]:g} nm" in shallow["words"] and browser.complaints() == []
