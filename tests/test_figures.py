"""Figures: units on every axis, plotted numbers, nothing left behind."""

import matplotlib
import numpy as np
import pytest
import seaborn
import xarray as xr
from matplotlib.figure import Figure

matplotlib.use("Agg")

from matplotlib import pyplot

from roughxr import figures
from roughxr.asperity.catalogue import asperities
from roughxr.asperity.reconstruction import reconstruct
from roughxr.asperity.superposition import superpose
from roughxr.bodies.pair import assign_pair
from roughxr.contact.elastic import direct
from roughxr.figures import style
from roughxr.reproduction import paper_figures
from roughxr.scans import regions
from roughxr.statistics import LAWS, bootstrap, debris, pull_off
from roughxr.vocabulary import schema

#: Labels of numbers without a unit.
UNIT_ONE = ("samples", "ln(B/A)", "axis ratio", "probability density", "/P_c", "/a_c", "delta_c")


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
    "centres": lambda run: figures.scan_map(run["scan"], subregions=(3, 3), highlight=[True] + [False] * 8),
    "asperities": lambda run: figures.scan_map(run["scan"], catalogue=run["asperities"]),
    "subregion_map": lambda run: figures.subregion_map(run["statistics/energy"]),
    "subregion_map of scattered centres": lambda run: figures.subregion_map(
        run["statistics/energy"].isel(subregion=[0, 4, 5]), "pull_off_delta"
    ),
    "pressure": lambda run: figures.field_map(run["solutions/contact"], scan=run["scan"]),
    "displacement": lambda run: figures.field_map(run["solutions/contact"], "displacement"),
    "distribution": lambda run: figures.distribution(run["statistics/energy"], label="energy"),
    "laws": lambda run: figures.distribution(run["asperities"], "height", laws=tuple(LAWS)),
    "asperity_statistics": lambda run: figures.asperity_statistics(run["asperities"]),
    "sweep": lambda run: figures.sweep(run["solutions/energy"]),
    "mean_force": lambda run: figures.mean_force({"direct": run["solutions/direct"], "hertz": run["solutions/hertz"]}),
}


def _has_units(text: str) -> bool:
    return text.replace("\n", " ").endswith("]") or any(word in text.replace("\n", " ") for word in UNIT_ONE)


@pytest.mark.parametrize("name", DRAWN)
def test_axes_of_one_column_have_units(run, name):
    drawn = np.atleast_1d(DRAWN[name](run)).tolist()
    figure = drawn[0].figure
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(85 / 25.4)
    assert all(_has_units(text) for ax in drawn for text in (ax.get_xlabel(), ax.get_ylabel()))


@pytest.fixture(scope="module")
def papers(run):
    """The paper's figures by name."""
    return dict(paper_figures(run))


def test_the_papers_figures_have_units_and_belong_to_no_window(papers):
    assert not pyplot.get_fignums()
    assert list(papers) == [f"figure-{number:02d}" for number in range(2, 17)]
    for figure in papers.values():
        figure.draw_without_rendering()
        labels = [text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel()) if text]
        assert labels and all(map(_has_units, labels))


def test_a_smooth_sphere_lies_on_hertzs_law_in_figure_5(papers):
    (ax,) = papers["figure-05"].axes
    solved, hertz = (line.get_ydata() for line in ax.lines[:2])
    np.testing.assert_allclose(solved[1:], hertz[1:], rtol=0.03)


def test_the_smooth_sphere_of_figure_15_pulls_with_its_known_force(papers):
    (ax,) = papers["figure-15"].axes
    smooth = next(line for line in ax.lines if line.get_label() == "smooth sphere, JKR")
    assert smooth.get_ydata().min() == pytest.approx(-1.5 * np.pi * 1.35 * 500, rel=1e-2)  # steps of 0.5 nm


def test_debris_is_the_tile_with_the_particle(run):
    flags = debris(run["asperities"], run["solutions/direct"])
    assert flags.values.tolist() == [False] * 4 + [True] + [False] * 4
    ax = figures.scan_map(run["scan"], subregions=run["solutions/direct"], highlight=flags, ax=Figure().subplots())
    ringed = np.c_[ax.lines[1].get_data()]
    np.testing.assert_allclose(ringed, [[450.0, 450.0]])


def test_given_axes_are_drawn_on(run):
    ax = Figure().subplots()
    assert figures.scan_map(run["scan"], ax=ax) is ax
    assert not pyplot.get_fignums()
    with pytest.raises(ValueError, match="expected 4 Axes, found 2"):
        figures.asperity_statistics(run["asperities"], ax=Figure().subplots(2))


def test_colours_are_seaborns_for_colour_blind_readers():
    palette = seaborn.color_palette("colorblind").as_hex()
    assert {style.BLUE, style.ORANGE, style.GREEN, style.VERMILION, style.PURPLE} == set(palette[:5])


def histogram(ax):
    """Return the bins' edges and the densities of an Axes' first histogram, from the outline that is drawn."""
    x, y = ax.collections[0].get_paths()[0].vertices.T
    edges = np.unique(x)
    middles = (edges[:-1] + edges[1:]) / 2
    upper = [y[:-1][(x[:-1] - middle) * (x[1:] - middle) < 0].max() for middle in middles]
    return edges, np.array(upper)


def test_a_drawn_distribution_is_the_density_weighted_by_shares():
    rng = np.random.default_rng(4)
    shares = {"landing_share": ("subregion", rng.uniform(0, 1, 60))}
    ds = xr.Dataset({"pull_off_force": ("subregion", rng.gamma(2, 5, 60), {"units": "nN"})}, shares)
    expected = ds.contact.pdf("pull_off_force", bins=7)
    edges, density = histogram(figures.distribution(ds, bins=7, interval=None))
    np.testing.assert_allclose(edges, expected.attrs["bin_edges"])
    np.testing.assert_allclose(density, expected, rtol=1e-12)
    few = figures.distribution(ds.isel(subregion=slice(5)).drop_vars("landing_share"), interval=None)
    np.testing.assert_allclose(few.lines[0].get_ydata(), np.arange(6) / 5)


def test_data_stay_in_the_schemas_units_and_enter_in_any():
    force = xr.Dataset({"force": ("subregion", np.tile([2.0, 4.0, 4.0, 8.0], 3), {"units": "uN"})})
    ax = figures.distribution(force, "force", interval=None)
    ax.figure.draw_without_rendering()
    assert ax.get_xlabel() == "contact force [µN]"
    assert ax.get_xlim()[1] > 7e3
    assert "4" in [tick.get_text() for tick in ax.get_xticklabels()]
    edges, density = histogram(ax)
    assert float((density * np.diff(edges)).sum()) == pytest.approx(1.0)  # per nN


def test_fields_that_are_missing_are_refused(run):
    with pytest.raises(ValueError, match="fields=True"):
        figures.field_map(run["solutions/direct"])
    with pytest.raises(ValueError, match="scan: expected with name='pressure'"):
        figures.field_map(run["solutions/contact"], "gap", scan=run["scan"])


def test_intervals_are_those_of_the_bootstrap(run):
    pull = run["asperities"][["height"]]
    ax = figures.distribution(pull, "height")
    interval = bootstrap(pull, "height", statistics=["mean"])
    ends = next(line.get_xdata() for line in ax.lines if len(line.get_xdata()) == 2)
    np.testing.assert_allclose(ends, [float(interval.low[0]), float(interval.high[0])])
    bars = figures.mean_force({"direct": run["solutions/direct"]}).collections[-1]
    low, high = np.array([path.vertices[:, 1] for path in bars.get_paths()]).T
    mean = run["solutions/direct"].force.mean("subregion").values
    assert ((low <= mean) & (mean <= high)).all()


def test_the_best_law_stands_first():
    ds = xr.Dataset({"pull_off_force": ("subregion", np.random.default_rng(0).lognormal(1, 0.8, 400), {"units": "nN"})})
    words = [text.get_text() for text in figures.distribution(ds, laws=tuple(LAWS)).get_legend().get_texts()]
    assert words[1] == "log-normal" and all("ΔAIC" in word for word in words[2:]) and len(words) == 5


def test_a_law_that_diverges_at_zero_is_drawn_from_where_it_fits():
    """Many places that hardly pull: a Weibull of shape < 1."""
    ds = xr.Dataset({"pull_off_force": ("subregion", np.random.default_rng(0).weibull(0.5, 60), {"units": "nN"})})
    ax = figures.distribution(ds, laws=["weibull"], interval=None)
    assert all(np.nanmax(line.get_ydata()) < ax.get_ylim()[1] for line in ax.lines)


def test_the_band_of_chance_contains_directions_without_preference():
    values = {name: ("asperity", np.ones(900)) for name in ("height", "curvature_min", "axis_ratio")}
    values |= {"curvature_max": ("asperity", 2 + np.arange(900.0) / 900)}
    angles = np.random.default_rng(1).uniform(-np.pi / 2, np.pi / 2, 900)
    ax = figures.asperity_statistics(xr.Dataset(values | {"orientation": ("asperity", angles)}))[3]
    band = next(patch for patch in ax.patches if hasattr(patch, "get_height"))
    density = histogram(ax)[1]
    assert np.mean((density >= band.get_y()) & (density <= band.get_y() + band.get_height())) >= 0.85


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
    """xarray's own plot draws the first dimension upright."""
    ax = run["scan"].height.contact.plot(ax=Figure().subplots())
    (mesh,) = ax.collections
    np.testing.assert_array_equal(mesh.get_array(), run["scan"].height.values.T)
    assert ax.get_xlabel().startswith("x")


def test_a_density_is_drawn_between_its_edges(run):
    density = run["statistics/energy"].contact.pdf("pull_off_force", bins=3)
    (steps,) = density.contact.plot(ax=Figure().subplots()).patches
    np.testing.assert_array_equal(steps.get_data().edges, density.attrs["bin_edges"])
    np.testing.assert_array_equal(steps.get_data().values, density.values)


def test_densities_of_a_few_displacements_share_an_axes_and_many_are_a_map(run):
    densities = run["solutions/direct"].contact.pdf("force", bins=4)
    few = densities.isel(delta=[0, -1])
    ax = few.contact.plot(ax=Figure().subplots())
    for steps, values in zip(ax.patches, few.values, strict=True):
        np.testing.assert_array_equal(steps.get_data().values, values)
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == [f"{delta:g} nm" for delta in few.delta.values] and ax.get_xlabel().startswith("contact force")
    many = densities.interp(delta=np.linspace(*densities.delta.values[[0, -1]], 7))
    assert many.contact.plot(ax=Figure().subplots()).collections


def test_a_cycle_is_refused_with_what_to_select(run):
    both = run["solutions/energy"].expand_dims(branch=["loading", "retraction"])
    with pytest.raises(ValueError, match=r"also branch; select one first, for example ds.sel\(branch='retraction'\)"):
        figures.mean_force({"both": both})
    with pytest.raises(ValueError, match=r"found only pull-offs; solve with adhesive\(…, delta="):
        figures.sweep(run["statistics/energy"])


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
    place = adhering(1000.0).isel(subregion=1).assign(pull_off_force=2.0)
    ax = figures.plot(place)
    assert [line.get_text() for line in ax.get_legend().get_texts()] == ["place 5"]
    with pytest.raises(ValueError, match="pull_off_force: a single number"):
        figures.plot(place, "pull_off_force")


def test_a_contact_where_nothing_touches_has_no_colour_bar(run):
    ds = run["solutions/contact"]
    ds = ds.assign({name: xr.zeros_like(ds[name]) for name in ("pressure", "displacement")}).assign(gap=ds["gap"] + 9)
    for name in ("pressure", "displacement"):
        ax = figures.field_map(ds, name, subregion=int(ds["subregion"][0]))
        assert [text.get_text() for text in ax.texts] == ["nothing touches"] and len(ax.figure.axes) == 1


def test_figures_show_the_numbers_that_they_are_given(run):
    force = (("subregion", "delta"), [[0.0, 1.0, 4.0], [0.0, 2.0, 5.0]])
    ds = xr.Dataset({"force": force}, {"delta": [0.0, 1.0, 2.0]})
    ax = figures.mean_force({"all": ds, "first": ds.isel(subregion=[0])})
    assert [line.get_ydata().tolist() for line in ax.lines] == [[0.0, 1.5, 4.5], [0.0, 1.0, 4.0]]
    centres = {"subregion_x": ("subregion", [0.0, 0, 1, 1]), "subregion_y": ("subregion", [0.0, 1, 0, 1])}
    modes = xr.Dataset({"mode": ("subregion", ["roll", "slide", "roll", "roll"])}, centres)
    legend = figures.subregion_map(modes, "mode").get_legend().get_texts()
    assert [text.get_text() for text in legend] == ["roll (3)", "slide (1)"]
    assert len(figures.field_map(run["solutions/contact"], scan=run["scan"]).images) == 2  # heights below the pressure
    values = {"relative_error": [0.03, np.nan], "standard_error": [0.01, np.nan], "known_bias": [False, False]}
    entries = {name: ("entry", value) for name, value in (values | {"pull_off_change": [-0.03, np.nan]}).items()}
    budget = xr.Dataset(entries | {"total_error": 0.03, "total_standard_error": 0.01}, {"entry": ["modulus", "tip"]})
    ax = figures.error_budget(budget)
    assert [bar.get_width() for bar in ax.patches] == pytest.approx([3.0, 3.0])
    assert [text.get_text() for text in ax.texts] == ["−3.0 ± 1.0", "not computed", "3.0 ± 1.0"]
    moment = (("subregion", "direction"), [[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]])
    rose = figures.moment_rose(xr.Dataset({"resisting_moment": moment}, {"direction": [0.0, 2.0, 4.0]}))
    assert rose.get_xlabel() == "resisting moment [nN nm]\nmedian and middle half of 2 places"
    left, _ = figures.predicted_and_measured(*(force_of(np.arange(1.0, 9.0) * factor) for factor in (1, 2)))
    words = [text.get_text() for text in left.get_legend().get_texts()]
    assert words == ["mean, 95 % interval", "predicted", "measured"]


def force_of(values):
    return xr.Dataset({"pull_off_force": ("subregion", values, {"units": "nN"})})
