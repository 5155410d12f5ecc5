"""Figures: units on every axis, minimal data, nothing left behind."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

matplotlib.use("Agg")

from matplotlib import pyplot

from roughxr import figures
from roughxr.asperity.catalogue import asperities
from roughxr.asperity.reconstruction import reconstruct
from roughxr.asperity.superposition import superpose
from roughxr.bodies.pair import assign_pair
from roughxr.contact.elastic import direct
from roughxr.figures.distributions import bin_edges
from roughxr.figures.forces import hertz_error, jkr_sphere, mean_ratio
from roughxr.figures.style import display_unit, styled, superscripts
from roughxr.reproduction import paper_figures
from roughxr.scans import regions
from roughxr.statistics import bootstrap, debris, force_ratio, pull_off
from roughxr.vocabulary import schema

PAPER = [f"figure-{number:02d}" for number in range(2, 17)]

#: Labels of numbers without a unit, as documented.
UNIT_ONE = (
    "samples",
    "superposed / direct",
    "ratio",
    "ln(B/A)",
    "/P_c",
    "/a_c",
    "delta_c",
    "probability density",
    "rough / smooth",
)


@pytest.fixture(scope="module")
def run():
    """A run on a small seeded surface with one debris particle among nine tiles."""
    scan = assign_pair(_surface(), sphere_radius=500, contact_modulus=40, work_of_adhesion=1.35)
    grid, sweep = (3, 3), np.arange(-5, 20, 0.5)
    catalogue = asperities(scan, vertex="pixel")
    middle = regions.centres(scan, (1, 1))
    groups = {
        "scan": scan,
        "asperities": catalogue,
        "reconstruction": reconstruct(scan, catalogue),
        "solutions/direct": direct(scan, delta=[1, 5.08, 10, 12, 15.4, 18], subregions=grid),
        "solutions/contact": direct(scan, delta=[17.0], subregions=middle, fields=True),
        "solutions/smooth": direct(scan.assign(height=0 * scan.height), delta=[1, 5, 10, 15, 20]),
        "solutions/hertz": superpose(catalogue, delta=sweep, subregions=grid, law="hertz"),
    }
    for name in ("published", "self_similar", "energy"):
        groups[f"solutions/{name}"] = superpose(catalogue, delta=sweep, subregions=grid, formulation=name)
        groups[f"statistics/{name}"] = pull_off(groups[f"solutions/{name}"])
    return groups


def _surface(pixels=90, size=900.0):
    """Smoothed noise of 1.5 nm with a 12 nm particle, quantised to 0.1 nm."""
    rng = np.random.default_rng(5)
    noise = rng.normal(size=(pixels, pixels))
    for axis in (0, 1):
        noise = sum(np.roll(noise, shift, axis) for shift in (-2, -1, 0, 1, 2))
    x = (np.arange(pixels) + 0.5) * size / pixels
    particle = 12 * np.exp(-((x[:, None] - 450) ** 2 + (x[None, :] - 450) ** 2) / (2 * 40**2))
    height = np.round(12 + 1.5 * noise / noise.std() + particle, 1)
    return schema.label(xr.Dataset({"height": (("x", "y"), height)}, coords={"x": x, "y": x}))


@pytest.fixture(autouse=True)
def nothing_left():
    """No rcParams may change; figures that a test lets pyplot open are closed."""
    before = dict(matplotlib.rcParams)
    yield
    assert dict(matplotlib.rcParams) == before
    pyplot.close("all")


DRAWN = {
    "scan_map": lambda run: figures.scan_map(run["scan"], robust=True),
    "contact_grid": lambda run: figures.contact_grid(run["scan"], (3, 3), highlight=[True] + [False] * 8),
    "contact_grid of scattered centres": lambda run: figures.contact_grid(run["scan"], ([100.0, 300], [200.0, 250])),
    "ellipses": lambda run: figures.asperity_map(run["scan"], run["asperities"]),
    "vertices": lambda run: figures.asperity_map(run["scan"], run["asperities"], shape="vertices"),
    "subregion_map": lambda run: figures.subregion_map(run["statistics/energy"]),
    "subregion_map of scattered centres": lambda run: figures.subregion_map(
        run["statistics/energy"].isel(subregion=[0, 4, 5]), "pull_off_delta"
    ),
    "pressure": lambda run: figures.field_map(run["solutions/contact"]),
    "displacement": lambda run: figures.field_map(run["solutions/contact"], "displacement", location="top"),
    "gap": lambda run: figures.field_map(run["solutions/contact"], "gap"),
    "heights": lambda run: figures.field_map(run["solutions/contact"], "height", scan=run["scan"]),
    "contact_section": lambda run: figures.contact_section(run["solutions/contact"], run["scan"]),
    "contact_maps": lambda run: figures.contact_maps(run["solutions/contact"], run["scan"]),
    "distribution": lambda run: figures.distribution(run["statistics/energy"], "pull_off_force", label="energy"),
    "fitted_distribution": lambda run: figures.fitted_distribution(run["statistics/energy"]),
    "orientation_rose": lambda run: figures.orientation_rose(run["asperities"]),
    "pressure over heights": lambda run: figures.field_map(run["solutions/contact"], scan=run["scan"]),
    "method_comparison": lambda run: figures.method_comparison(
        force_ratio(run["solutions/hertz"], run["solutions/direct"]), mark=12.0
    ),
    "asperity_statistics": lambda run: figures.asperity_statistics(run["asperities"]),
    "force_fan": lambda run: figures.force_fan(run["solutions/energy"]),
    "mean_force": lambda run: figures.mean_force({"direct": run["solutions/direct"], "hertz": run["solutions/hertz"]}),
    "mean_force of one": lambda run: figures.mean_force(run["solutions/direct"]),
    "force_ratio": lambda run: figures.force_ratio(run["solutions/direct"], run["solutions/smooth"]),
    "sweep": lambda run: figures.sweep({"JKR": run["solutions/energy"]}, subregion=4),
    "against_hertz": lambda run: figures.against_hertz(run["solutions/smooth"]),
    "asperity_curve": lambda run: figures.asperity_curve("P", "a", laws=("hertz", "energy"), ratio=4.0),
}


@pytest.mark.parametrize("name", DRAWN)
def test_axes_with_units(run, name):
    drawn = np.atleast_1d(DRAWN[name](run)).tolist()
    assert all(isinstance(ax, Axes) for ax in drawn)
    drawn[0].figure.draw_without_rendering()
    for ax in drawn:
        if ax.name == "polar":
            assert ax.get_xlabel().startswith("orientation")
            continue
        shared = name == "against_hertz" and ax is drawn[0]
        labels = [ax.get_ylabel()] if shared else [ax.get_xlabel(), ax.get_ylabel()]
        for label in labels:
            assert label.endswith("]") or any(word in label for word in UNIT_ONE), label


@pytest.mark.parametrize("name", DRAWN)
def test_one_column_wide(run, name):
    drawn = np.atleast_1d(DRAWN[name](run))
    assert drawn[0].figure.get_figwidth() == pytest.approx(85 / 25.4)


@pytest.fixture(scope="module")
def paper(run):
    drawn = dict(paper_figures(run))
    assert not pyplot.get_fignums()
    return drawn


def test_paper_figures(paper):
    assert list(paper) == PAPER
    for name, figure in paper.items():
        figure.draw_without_rendering()
        assert figure.get_suptitle().startswith(f"Figure {int(name[-2:])}. ")


def test_printed_numbers_stand_beside_ours(paper):
    printed = {"figure-12": "21 ± 11 µN", "figure-15": "19.1 µN", "figure-16": "2.0 ± 1.37 µN"}
    for name, words in printed.items():
        texts = [text.get_text() for text in paper[name].findobj(matplotlib.text.Text)]
        assert {"here", "paper", words} <= set(texts)


def test_a_missing_group_is_named():
    found = []
    with pytest.raises(ValueError, match="'solutions/smooth'"):
        found.extend(name for name, _ in paper_figures({}))


def test_given_axes_are_drawn_on(run):
    ax = Figure().subplots()
    assert figures.scan_map(run["scan"], ax=ax) is ax
    assert not pyplot.get_fignums()
    with pytest.raises(ValueError, match="expected 4 Axes, found 2"):
        figures.asperity_statistics(run["asperities"], ax=Figure().subplots(2))


def test_data_stay_in_the_schemas_units():
    ax = figures.distribution(
        xr.Dataset({"force": ("subregion", [2e3, 4e3, 4e3, 8e3], {"units": "nN"})}), "force", kde=False
    )
    ax.figure.draw_without_rendering()
    assert ax.get_xlabel() == "contact force [µN]"
    assert ax.get_xlim()[1] > 7e3
    assert "4" in [tick.get_text() for tick in ax.get_xticklabels()]


def test_minimal_data():
    small = xr.Dataset({"height": (("x", "y"), np.eye(2))}, coords={"x": [0.0, 1.0], "y": [0.0, 1.0]})
    assert figures.scan_map(schema.label(small)).get_xlabel() == "x [nm]"
    force = xr.Dataset({"force": (("subregion", "delta"), [[0.0, 2.0]])}, coords={"delta": [0.0, 1.0]})
    for draw in (figures.force_fan, figures.mean_force):
        assert draw(force).get_ylabel() == "contact force [nN]"
    alike = xr.Dataset({"force": ("subregion", [1.0, 1.0])})
    assert figures.distribution(alike, "force").get_ylabel() == "2 samples"
    asperity = xr.Dataset(
        {
            "height": ("asperity", [1.0, 2.0]),
            "curvature_min": ("asperity", [0.1, 0.1]),
            "curvature_max": ("asperity", [0.2, 0.3]),
            "orientation": ("asperity", [0.0, 1.0]),
            "axis_ratio": ("asperity", [0.6, 0.5]),
        }
    )
    assert figures.asperity_statistics(asperity).size == 4


def test_fields_are_asked_for_by_name(run):
    with pytest.raises(ValueError, match="fields=True"):
        figures.field_map(run["solutions/direct"])
    for name, scan in (("height", None), ("gap", run["scan"])):
        with pytest.raises(ValueError, match="scan: expected with name='height'"):
            figures.field_map(run["solutions/contact"], name, scan=scan)


def test_debris_is_the_tile_with_the_particle(run):
    flags = debris(run["asperities"], run["solutions/direct"])
    assert flags.values.tolist() == [False] * 4 + [True] + [False] * 4


def test_intervals_are_drawn_where_they_were_found(run):
    pull = run["statistics/energy"]
    ax = figures.distribution(pull, "pull_off_force")
    found = bootstrap(pull, "pull_off_force", statistics=["mean"]).sel(resampling="block")
    bars = [line.get_xdata() for line in ax.lines if len(line.get_xdata()) == 2]
    np.testing.assert_allclose(bars[-1], [float(found.low[0]), float(found.high[0])])
    with_bars, without = (figures.mean_force(run["solutions/direct"], interval=level) for level in (0.95, None))
    assert len(with_bars.collections) == len(without.collections) + 1
    low, high = np.array([path.vertices[:, 1] for path in with_bars.collections[-1].get_paths()]).T
    mean = run["solutions/direct"].force.mean("subregion").values
    assert ((low <= mean) & (mean <= high)).all()


def test_the_best_law_stands_first(run):
    ds = xr.Dataset({"pull_off_force": ("subregion", np.random.default_rng(0).lognormal(1, 0.8, 400), {"units": "nN"})})
    words = [text.get_text() for text in figures.fitted_distribution(ds).get_legend().get_texts()]
    assert words[0] == "log-normal" and all("ΔAIC" in word for word in words[1:]) and len(words) == 4


def test_a_law_without_an_end_at_zero_is_drawn_beside_it():
    """Many places that hardly pull: a Weibull of shape < 1."""
    ds = xr.Dataset({"pull_off_force": ("subregion", np.random.default_rng(0).weibull(0.5, 60), {"units": "nN"})})
    ax = figures.fitted_distribution(ds, laws=["weibull"])
    assert ax.lines and all(np.nanmax(line.get_ydata()) < 1.5 * ax.get_ylim()[1] for line in ax.lines[:1])


def test_petals_tell_shares_by_area_at_both_ends():
    names = ("height", "curvature_min", "curvature_max")
    values = {name: ("asperity", np.ones(4)) for name in names}
    ds = xr.Dataset(values | {"orientation": ("asperity", [0.1, 0.1, 0.1, -1.0])})
    heights = [bar.get_height() for bar in figures.orientation_rose(ds, bins=2).patches]
    np.testing.assert_allclose(np.square(heights), [0.5, 1.5, 0.5, 1.5])


def test_flat_axes_cannot_hold_a_rose(run):
    with pytest.raises(ValueError, match="polar"):
        figures.orientation_rose(run["asperities"], ax=Figure().subplots())


def test_smooth_sphere_follows_hertz(run):
    assert np.nanmax(np.abs(hertz_error(run["solutions/smooth"])[1:])) < 0.03


def test_jkr_sphere_pulls_with_its_known_force(run):
    pair = run["scan"]
    force = jkr_sphere(pair, np.linspace(-20, 5, 5001))
    assert force.min() == pytest.approx(-1.5 * np.pi * 1.35 * 500, rel=1e-5)
    assert force[0] == 0


def test_ratio_is_exact_for_hertz_between_displacements():
    coarse, fine = np.array([1.0, 4.0, 9.0]), np.array([2.0, 3.0, 7.0, 12.0])
    one, other = (
        xr.Dataset({"force": (("subregion", "delta"), [scale * d**1.5])}, coords={"delta": d})
        for scale, d in ((3.0, fine), (1.0, coarse))
    )
    np.testing.assert_allclose(mean_ratio(one, other), [3, 3, 3, np.nan])


def test_units_on_labels():
    assert display_unit("GPa", 1e9).text == "GPa"
    assert superscripts("density [1/µN]") == "density [1/µN]"
    assert superscripts("contact area [nm^2]") == "contact area [nm²]"


def test_importing_figures_leaves_matplotlib_alone():
    code = "import sys, roughxr; roughxr.figures; sys.exit(any(m in sys.modules for m in ('matplotlib', 'seaborn')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_save_writes_the_figure_of_axes(run, tmp_path):
    ax = figures.force_fan(run["solutions/energy"])
    for what, name in ((ax, "axes.png"), (ax.figure, "figure.pdf")):
        assert figures.save(what, tmp_path / name, dpi=60).stat().st_size > 1000


def test_a_saved_figure_is_matplotlibs_own_and_keeps_its_layout(paper, tmp_path):
    from PIL import Image

    for name in ("figure-13", "figure-16"):
        figure = paper[name]
        figures.save(figure, tmp_path / "ours.png", dpi=90)
        engine = figure.get_layout_engine()
        figure.savefig(tmp_path / "own.png", dpi=90)
        ours, own = (np.asarray(Image.open(tmp_path / f"{one}.png")).astype(int) for one in ("ours", "own"))
        assert engine is figure.get_layout_engine() is not None and np.abs(ours - own).mean() < 0.2


def test_titles_tell_what_this_run_shows(paper):
    titles = {name: figure.get_suptitle() for name, figure in paper.items()}
    assert "one place" not in titles["figure-07"] and "9 contact centres" in titles["figure-07"]
    assert "1 of 9" in titles["figure-11"].replace("\n", " ")
    assert "8 of 9" in titles["figure-14"].replace("\n", " ")


def test_only_the_settings_of_the_figure_itself_are_taken_back():
    """What choosing a backend sets while a figure is drawn has to stay."""

    @styled
    def drawn(ax=None):
        matplotlib.rcParams["savefig.dpi"] = 123.0
        matplotlib.rcParams["font.size"] = 99.0
        return figures.scan_map(_surface(), ax=ax)

    with matplotlib.rc_context():
        size = matplotlib.rcParams["font.size"]
        drawn()
        assert (matplotlib.rcParams["savefig.dpi"], matplotlib.rcParams["font.size"]) == (123.0, size)


def test_any_result_draws_itself(run):
    solution, pulls = run["solutions/energy"], run["statistics/energy"]
    drawn = run["scan"].contact.plot()
    assert (drawn.get_xlabel()[0], drawn.get_ylabel()[0]) == ("x", "y")
    assert solution.contact.plot().get_ylabel().startswith("contact force")
    assert pulls.contact.plot().get_xlabel().startswith("pull-off force")
    assert pulls.contact.plot("pull_off_delta", on="map").get_ylabel().startswith("y of the contact centre")
    assert len(run["asperities"].contact.plot()) == 4
    assert run["solutions/contact"].contact.plot().get_aspect() == 1
    with pytest.raises(ValueError, match=r"expected one of the variables .* found 'forse'"):
        solution.contact.plot("forse")


def test_a_map_alone_has_x_to_the_right(run):
    """xarray's own plot sets the first dimension upright."""
    ax = run["scan"].height.contact.plot(ax=Figure().subplots())
    (mesh,) = ax.collections
    np.testing.assert_array_equal(mesh.get_array(), run["scan"].height.values.T)
    assert ax.get_xlabel().startswith("x")


def test_a_density_is_drawn_between_its_edges(run):
    density = run["statistics/energy"].contact.pdf("pull_off_force", bins=3)
    (steps,) = density.contact.plot(ax=Figure().subplots()).patches
    np.testing.assert_array_equal(steps.get_data().edges, density.attrs["bin_edges"])
    np.testing.assert_array_equal(steps.get_data().values, density.values)
    kde = run["statistics/energy"].contact.pdf("pull_off_force", method="kde")
    assert len(kde.contact.plot(ax=Figure().subplots()).lines) == 1


def test_bins_of_quantised_values_hold_equally_many_levels():
    """A rule's edges put now two and now three levels into a bin, which shows as a comb."""
    values = np.round(np.random.default_rng(2).normal(15.0, 1.5, 5000), 1)
    edges = bin_edges(values, "auto")
    assert np.allclose(np.diff(edges) / 0.1, np.round(np.diff(edges) / 0.1)) and np.ptp(np.diff(edges)) < 1e-9
    assert np.histogram(values, edges)[0].sum() == values.size
    assert len(bin_edges(np.random.default_rng(2).normal(size=100), "auto")) < 30


def test_an_asperitys_curves_leave_at_one_edge_and_no_radius_is_negative():
    ax = figures.asperity_curve("delta", "a", ax=Figure().subplots())
    assert ax.get_ylim()[0] == 0
    right = ax.get_xlim()[1]
    assert all(
        line.get_xdata().max() >= right - 1e-9 for line in ax.lines if line.get_label() in ("Hertz", "JKR, stable")
    )
    assert any("(−0.333, 1)" in text.get_text() for text in ax.texts)


def test_a_cycle_is_refused_with_what_to_select(run):
    both = run["solutions/energy"].expand_dims(branch=["loading", "retraction"])
    with pytest.raises(ValueError, match=r"also branch; select one first, for example ds.sel\(branch='retraction'\)"):
        figures.force_fan(both)
    events = run["statistics/energy"]
    with pytest.raises(ValueError, match=r"found only pull-offs; solve with adhesive\(…, delta="):
        figures.force_fan(events)


def adhering(push):
    """Return three places' sweeps that pull with 1 to 3 nN and end at a push."""
    delta = np.linspace(-1.0, 4.0, 11)
    force = [np.where(delta < 1, -pull * np.exp(-((delta * 3) ** 2)), push * (delta - 1)) for pull in (1.0, 2.0, 3.0)]
    return xr.Dataset({"force": (("subregion", "delta"), force)}, coords={"delta": delta, "subregion": [4, 5, 6]})


def test_a_pull_is_seen_beside_a_push_a_thousand_times_as_large():
    deep, shallow = figures.plot(adhering(1000.0)), figures.plot(adhering(3.0))
    assert (deep.get_yscale(), shallow.get_yscale()) == ("symlog", "linear")
    low, zero = (deep.transData.transform((0, force))[1] for force in (-2.0, 0.0))
    assert zero - low > 0.05 * deep.get_window_extent().height


def test_a_single_place_of_a_sweep_draws_itself():
    one = adhering(1000.0).isel(subregion=1).assign(pull_off_force=2.0)
    ax = figures.plot(one)
    assert [line.get_text() for line in ax.get_legend().get_texts()] == ["place 5"]
    with pytest.raises(ValueError, match="pull_off_force: a single number"):
        figures.plot(one, "pull_off_force")


def test_a_contact_where_nothing_touches_has_no_colour_bar_of_nothing(run):
    ds = run["solutions/contact"]
    ds = ds.assign({name: xr.zeros_like(ds[name]) for name in ("pressure", "displacement")}).assign(gap=ds["gap"] + 9)
    for name in ("pressure", "displacement"):
        ax = figures.field_map(ds, name, subregion=int(ds["subregion"][0]))
        assert [text.get_text() for text in ax.texts] == ["nothing touches"] and len(ax.figure.axes) == 1


def test_lines_that_are_drawn_are_named(run):
    ax = figures.mean_force(run["solutions/direct"])
    assert "bars: 95 % interval of the mean" in [text.get_text() for text in ax.get_legend().get_texts()]
    ratio = figures.asperity_statistics(run["asperities"])[2]
    assert ratio.get_ylabel() == "probability density"  # of a number: no empty brackets
    assert [text.get_text()[:4] for text in ratio.texts] == ["mean"]


def test_few_samples_are_drawn_as_points_and_no_density():
    few = xr.Dataset({"force": ("subregion", [1.0, 2.0, 4.0, 5.0], {"units": "nN"})})
    ax = figures.distribution(few, "force", interval=None)
    assert sorted(ax.lines[0].get_xdata()) == [1.0, 2.0, 4.0, 5.0] and ax.get_ylabel() == "4 samples"
    many = few.isel(subregion=np.arange(12) % 4)
    assert "density" in figures.distribution(many, "force", interval=None).get_ylabel()
