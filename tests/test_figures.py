"""Figures: units on every axis, plotted numbers, nothing left behind."""

import functools
import io
import re

import matplotlib
import numpy as np
import pytest
import seaborn
import xarray as xr
from matplotlib.figure import Figure

from . import verb_calls

matplotlib.use("Agg")

from matplotlib import pyplot

from roughxr import figures, scans
from roughxr.accessor import ContactAccessor
from roughxr.application.figures import style
from roughxr.application.reproduction import paper_figures
from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.reconstruction import reconstruct
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.bodies.pair import assign_pair
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.scans import regions
from roughxr.mechanics.statistics.sampling import weighted_by_landing_share
from roughxr.mechanics.vocabulary import schema
from roughxr.mechanics.vocabulary.units import converts, factor
from roughxr.statistics import LAWS, bootstrap, fit, pull_off

#: Labels of numbers without a unit.
UNIT_ONE = ("samples", "ln(B/A)", "axis ratio", "probability density", "/P_c", "/a_c", "delta_c", "rough / smooth")
UNIT_ONE += ("superposed / direct",)


@pytest.fixture(scope="module")
def run():
    """A run on a small seeded surface with one debris particle among nine tiles."""
    scan = assign_pair(_surface(), sphere_radius=500, contact_modulus=40, work_of_adhesion=1.35)
    grid = (3, 3)
    sweep = np.arange(-5, 20, 0.5)
    catalogue = asperities(scan)
    middle = regions.centres(scan, (1, 1))
    groups = {
        "scan": scan,
        "asperities": catalogue,
        "reconstruction": reconstruct(scan, catalogue),
        "solutions/direct": direct(scan, delta=[1, 5.08, 10, 12, 15.4, 18], subregions=grid),
        "solutions/contact": direct(scan, delta=[17.0], subregions=middle, fields=True),
        "solutions/smooth": direct(scan.assign(height=0 * scan.height), delta=[1, 5, 10, 15, 20]),
        "solutions/hertz": superpose(catalogue, delta=sweep, subregions=grid, law="hertz", formulation="published"),
        "solutions/hertz_corrected": superpose(catalogue, delta=sweep, subregions=grid, law="hertz"),
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
    "scan_map": lambda run: figures.scan_map(run["scan"], limits=(10.0, 20.0)),
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
    assert figure.get_figwidth() == pytest.approx(85 / 25.4)
    assert all(_has_units(text) for ax in drawn for text in (ax.get_xlabel(), ax.get_ylabel()))


@pytest.mark.parametrize("name", ["scan_map", "pressure", "distribution"])
def test_a_png_that_is_drawn_once_is_that_of_matplotlib(run, name):
    of_once, of_twice = (np.atleast_1d(DRAWN[name](run))[0].figure for _ in range(2))
    once, twice = io.BytesIO(), io.BytesIO()
    style.write_png(of_once, once, 110)
    of_twice.savefig(twice, dpi=110, format="png")
    assert once.getvalue() == twice.getvalue()


@pytest.fixture(scope="module")
def papers(run):
    """The paper's figures by name."""
    return dict(paper_figures(run))


def test_the_papers_figures_have_units_and_belong_to_no_window(papers):
    assert not pyplot.get_fignums()
    assert list(papers) == [f"figure-{number:02d}" for number in range(2, 17)]
    for figure in papers.values():
        labels = [text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel()) if text]
        assert labels and all(map(_has_units, labels))


def line_of(ax, label):
    """Return the line with a label."""
    return next(line for line in ax.lines if line.get_label() == label)


@pytest.mark.parametrize("number", [2, 3, 4])
def test_critical_points_of_an_asperity_are_the_ends_of_its_curve(papers, number):
    """The least displacement, and the least force, of the drawn curve of JKR."""
    (ax,) = papers[f"figure-{number:02d}"].axes
    curve = np.hstack([line_of(ax, f"JKR, {branch}").get_data() for branch in ("unstable", "stable")])
    at = {name: 0 if f"/{name}_c" in ax.get_xlabel() else 1 for name in ("P", "a")}
    points = {line.get_marker(): np.ravel(line.get_data()) for line in ax.lines if line.get_marker() in "os"}
    ends = {"o": curve[:, curve[0].argmin()]} if number != 3 else {}
    ends |= {"s": curve[:, curve[at["P"]].argmin()]} if number != 2 else {}
    for marker, end in ends.items():
        np.testing.assert_allclose(points[marker], end, atol=5e-3)
    if number == 2:
        assert points["s"][at["a"]] == pytest.approx(1, abs=0.02)


def test_a_smooth_sphere_lies_on_hertzs_law_in_figure_5(papers):
    (ax,) = papers["figure-05"].axes
    solved, hertz = (line_of(ax, label).get_data() for label in ("direct simulation", "Hertz"))
    np.testing.assert_allclose(solved[1][1:], np.interp(solved[0], *hertz)[1:], rtol=0.03)


def test_figure_7_divides_the_scan_into_areas_of_one_centre_each(papers, run):
    ax = papers["figure-07"].axes[0]
    x, y = (np.array([path.vertices for path in lines.get_paths()]) for lines in ax.collections[:2])
    edges = [np.r_[0, np.unique(lines[:, :, axis]), 900] for axis, lines in enumerate((x, y))]
    counts = np.histogram2d(run["solutions/direct"].subregion_x, run["solutions/direct"].subregion_y, bins=edges)[0]
    np.testing.assert_array_equal(counts, np.ones((3, 3)))


def test_figure_8_has_the_colours_of_figure_6(papers):
    original, reconstructed = (papers[f"figure-{number:02d}"].axes[0].images[0] for number in (6, 8))
    assert original.get_clim() == reconstructed.get_clim()


def test_figure_10_shows_pressure_and_displacement(papers, run):
    contact = run["solutions/contact"].isel(subregion=0, delta=0)
    pressure, displacement = (ax.images[-1].get_array().T for ax in papers["figure-10"].axes[:2])
    np.testing.assert_allclose(displacement, contact["displacement"])
    np.testing.assert_allclose(np.ma.filled(pressure, 0.0), contact["pressure"])


def test_figure_13_shows_the_ratio_of_the_forces_above_it(papers):
    upper, lower = papers["figure-13"].axes
    rough, smooth = (line_of(upper, label).get_data() for label in ("rough", "smooth"))
    delta, ratio = (values[:-1] for values in lower.lines[0].get_data())  # the last is beyond the rough surface's
    np.testing.assert_allclose(ratio, np.interp(delta, *rough) / np.interp(delta, *smooth))


def test_figures_14_and_15_show_the_papers_own_sum(papers, run):
    upper, lower = papers["figure-14"].axes
    drawn = line_of(upper, "the paper's sum").get_data()
    clean = np.flatnonzero(~run["solutions/direct"].on_debris)
    options = {"delta": drawn[0], "subregions": (3, 3), "law": "hertz", "formulation": "published"}
    paper_sum = superpose(run["asperities"], **options).force.isel(subregion=clean)
    np.testing.assert_allclose(drawn[1], paper_sum.mean("subregion"))
    direct = dict(zip(*line_of(upper, "direct simulation").get_data()))
    for delta, ratio in zip(*lower.lines[0].get_data()):
        assert np.isnan(ratio) or ratio == pytest.approx(np.interp(delta, *drawn) / direct[delta], rel=1e-6)
    hertz = line_of(papers["figure-15"].axes[0], "paper's sum, Hertz").get_data()
    assert any(np.allclose(np.interp(drawn[0], *hertz), place) for place in paper_sum)


def test_figure_15_shows_the_smooth_spheres_pull_off_and_where_the_rough_force_surpasses_it(papers):
    upper, lower = papers["figure-15"].axes
    rough, smooth = (line_of(upper, label).get_data() for label in ("paper's sum, JKR", "smooth sphere, JKR"))
    pull_off = -1.5 * np.pi * 1.35 * 500
    assert smooth[1].min() == pytest.approx(pull_off, rel=1e-2)  # steps of 0.5 nm
    assert min(lower.get_ylim()) < pull_off < max(lower.get_ylim())
    below = np.flatnonzero(rough[1] <= smooth[1])[-1]
    ends = [line.get_xdata() for line in upper.lines if len(line.get_xdata()) == 2]
    marked = next(first for first, last in ends if first == last)
    assert rough[0][below] < marked <= rough[0][below + 1]
    assert min(upper.get_xlim()) < marked < max(upper.get_xlim()) and smooth[1][below] < max(upper.get_ylim())


def test_figure_16_has_a_panel_for_each_method(papers, run):
    panels = papers["figure-16"].axes
    methods = {"published": "published", "corrected": "self_similar", "least energy": "energy"}
    for ax, (label, key) in zip(panels, methods.items(), strict=True):
        forces = run[f"statistics/{key}"].pull_off_force
        drawn = line_of(ax, f"{label} ({forces.size})").get_xdata()[1:]  # the first step begins at −∞
        np.testing.assert_array_equal(drawn, np.sort(forces))


def test_the_ratio_by_place_is_drawn_with_the_places_where_contacts_overlap(run):
    """Each place once, as a ring if any of its contacts overlaps at pull-off; only after a simulation."""
    overlapping = run["solutions/energy"]["contacts_overlapping"].copy()
    overlapping[:] = 0
    overlapping[{"subregion": slice(2, 5)}] = 1
    simulated = run["statistics/energy"].assign(pull_off_force=run["statistics/energy"].pull_off_force / 2)
    groups = dict(run)
    groups["solutions/energy"] = run["solutions/energy"].assign(contacts_overlapping=overlapping)
    groups["statistics/adhesive"] = simulated
    (drawn,) = dict(paper_figures(groups, ["superposition-by-place"])).values()
    _, lower = drawn.axes
    alone, rings = (line_of(lower, label) for label in ("no contacts overlap", "contacts overlap"))
    assert len(rings.get_xdata()) == 3 and len(alone.get_xdata()) == 6
    np.testing.assert_allclose(np.r_[alone.get_ydata(), rings.get_ydata()], 2)
    np.testing.assert_allclose(rings.get_xdata(), simulated.pull_off_force[2:5])
    assert lower.get_xlabel().endswith("N]")


def test_a_ratio_that_begins_late_is_explained(papers, run):
    """Figure 14 has no ratio where no place without debris is in contact."""
    clean = np.flatnonzero(~run["solutions/direct"].on_debris)
    mean = run["solutions/direct"].force.isel(subregion=clean).mean("subregion")
    annotations = " ".join(text.get_text() for text in papers["figure-14"].axes[1].texts)
    last = mean.delta.where(mean == 0).max()
    assert ("no ratio" in annotations) == bool(last.notnull())


def places_of_force(low, high, tension):
    """Return a solution at 20 places whose force at the last displacement lies between two values, nN."""
    last = np.linspace(low, high, 20)
    force = np.stack([np.full(20, -tension), 0.1 * last, last], axis=1)
    ds = xr.Dataset(
        {"force": (("subregion", "delta"), force)}, {"delta": [-1.0, 5.0, 20.0], "subregion": np.arange(20)}
    )
    pulls = {"pull_off_force": ("subregion", np.full(20, tension)), "pull_off_delta": ("subregion", np.full(20, -1.0))}
    return schema.label(ds.assign(pulls))


def test_a_sweep_has_the_unit_of_its_pull_off_where_forces_are_far_larger():
    ax = figures.sweep(places_of_force(1e6, 2e6, tension=2e3), ax=Figure().subplots())
    assert ax.get_yscale() == "symlog" and ax.get_ylabel() == "contact force [µN]"
    ax = figures.sweep(places_of_force(2e3, 4e3, tension=2e3), ax=Figure().subplots())
    assert ax.get_yscale() == "linear"


@pytest.mark.parametrize(("high", "is_visible"), [(1.001e6, False), (3e6, True)])
def test_a_legend_names_an_interval_only_if_it_is_to_be_seen(high, is_visible):
    ax = figures.mean_force({"a": places_of_force(1e6, high, tension=0.0)}, ax=Figure().subplots())
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert ("95 % interval of the mean" in labels) == is_visible


def test_laws_and_bars_count_the_same_places_equally():
    """Two of ten places are on debris that covers a hundredth of the area; the fit counts them as two of ten."""
    force = np.r_[np.linspace(1.0, 2.0, 8), 9.0, 9.5]
    coords = {"on_debris": ("subregion", force > 5), "debris_share": 0.01}
    ds = xr.Dataset({"pull_off_force": ("subregion", force, {"units": "nN"})}, coords)
    edges = np.array([0.0, 5.0, 10.0])
    ax = figures.distribution(ds, laws=["normal"], bins=edges, ax=Figure().subplots())
    heights = np.unique(ax.collections[0].get_paths()[0].vertices[:, 1])
    np.testing.assert_allclose(heights[heights > 0], [0.2 / 5, 0.8 / 5])
    weighted = figures.distribution(ds, bins=edges, ax=Figure().subplots())
    heights = np.unique(weighted.collections[0].get_paths()[0].vertices[:, 1])
    np.testing.assert_allclose(heights[heights > 0], [0.01 / 5, 0.99 / 5])


def test_debris_is_the_tile_with_the_particle(run):
    flags = run["solutions/direct"].on_debris
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


def test_stated_bins_are_drawn_whatever_the_number_of_samples():
    six = schema.label(xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0, 2.5, 3.0, 4.0, 6.0])}))
    assert figures.distribution(six, ax=Figure().subplots()).get_ylabel() == "share of samples below"
    assert figures.distribution(six, bins=3, ax=Figure().subplots()).get_ylabel().startswith("probability density")


def test_no_bar_of_several_distributions_is_cut_off():
    ax = Figure().subplots()
    for order, width in enumerate((10.0, 1.0)):
        force = force_of(20 + width * np.linspace(-1, 1, 40))
        figures.distribution(force, bins=5, interval=None, order=order, ax=ax)
    tops = [bars.get_paths()[0].vertices[:, 1].max() for bars in ax.collections]
    assert tops[0] < tops[1] < ax.get_ylim()[1]


def test_a_title_stands_above_a_legend():
    ax = figures.distribution(force_of(np.arange(1.0, 30.0)), laws=["normal"])
    ax.set_title("a title that is as long as the legend")
    ax.figure.draw_without_rendering()
    assert ax.title.get_window_extent().y0 >= ax.get_legend().get_window_extent().y1


def test_a_drawn_distribution_is_the_density_weighted_by_shares():
    rng = np.random.default_rng(4)
    shares = {"landing_share": ("subregion", rng.uniform(0, 1, 60))}
    ds = xr.Dataset({"pull_off_force": ("subregion", rng.gamma(2, 5, 60), {"units": "nN"})}, shares)
    expected = ds.contact.pdf("pull_off_force", bins=7)
    edges, density = histogram(figures.distribution(ds, bins=7, interval=None))
    np.testing.assert_allclose(edges, expected.attrs["bin_edges"])
    np.testing.assert_allclose(density, expected, rtol=1e-12)
    five_places = figures.distribution(ds.isel(subregion=slice(5)).drop_vars("landing_share"), interval=None)
    np.testing.assert_allclose(five_places.lines[0].get_ydata(), np.arange(6) / 5)


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
    (drawn,) = ax.containers[0].lines[2]
    ends = drawn.get_segments()[0][:, 0]
    np.testing.assert_allclose(ends, [float(interval.low[0]), float(interval.high[0])])
    bars = figures.mean_force({"direct": run["solutions/direct"]}).collections[-1]
    low, high = np.array([path.vertices[:, 1] for path in bars.get_paths()]).T
    mean = weighted_by_landing_share(run["solutions/direct"].force).mean("subregion").values
    assert ((low <= mean) & (mean <= high)).all()


def test_the_best_law_stands_first():
    ds = xr.Dataset({"pull_off_force": ("subregion", np.random.default_rng(0).lognormal(1, 0.8, 400), {"units": "nN"})})
    labels = [text.get_text() for text in figures.distribution(ds, laws=tuple(LAWS)).get_legend().get_texts()]
    assert labels[0] == "log-normal" and all("ΔAIC" in label for label in labels[1:4]) and len(labels) == 5


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
    solution = run["solutions/energy"]
    pulls = run["statistics/energy"]
    drawn = run["scan"].contact.plot()
    assert (drawn.get_xlabel()[0], drawn.get_ylabel()[0]) == ("x", "y")
    assert solution.contact.plot().get_ylabel().startswith("contact force")
    assert pulls.contact.plot().get_xlabel().startswith("pull-off force")
    assert pulls.contact.plot("pull_off_delta", on="map").get_ylabel().startswith("y of the contact centre")
    assert len(run["asperities"].contact.plot()) == 4
    assert run["solutions/contact"].contact.plot().get_aspect() == 1
    with pytest.raises(ValueError, match="found 'pressure'; fields=True of direct and adhesive computes it"):
        figures.plot(xr.Dataset({"force": ("subregion", [1.0])}), "pressure")
    with pytest.raises(ValueError, match=r"expected one of the variables .* found 'forse'"):
        solution.contact.plot("forse")


def test_a_map_alone_has_x_to_the_right(run):
    """xarray's own plot draws the first dimension upright."""
    ax = run["scan"].height.contact.plot(ax=Figure().subplots())
    (picture,) = ax.images
    np.testing.assert_array_equal(picture.get_array(), run["scan"].height.values.T)
    assert ax.get_xlabel().startswith("x")


def test_a_density_is_drawn_between_its_edges(run):
    density = run["statistics/energy"].contact.pdf("pull_off_force", bins=3)
    (steps,) = density.contact.plot(ax=Figure().subplots()).patches
    np.testing.assert_array_equal(steps.get_data().edges, density.attrs["bin_edges"])
    np.testing.assert_array_equal(steps.get_data().values, density.values)


def test_densities_of_a_few_displacements_share_an_axes_and_many_are_a_map(run):
    densities = run["solutions/direct"].contact.pdf("force", bins=4)
    ends = densities.isel(delta=[0, -1])
    ax = ends.contact.plot(ax=Figure().subplots())
    for steps, values in zip(ax.patches, ends.values, strict=True):
        np.testing.assert_array_equal(steps.get_data().values, values)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == [f"{delta:g} nm" for delta in ends.delta.values] and ax.get_xlabel().startswith("contact force")
    many = densities.interp(delta=np.linspace(*densities.delta.values[[0, -1]], 7))
    assert many.contact.plot(ax=Figure().subplots()).collections


def test_a_cycle_is_refused_with_what_to_select(run):
    both_branches = run["solutions/energy"].expand_dims(branch=["loading", "retraction"])
    with pytest.raises(ValueError, match=r"also branch; select one first, for example ds.sel\(branch='retraction'\)"):
        figures.mean_force({"both": both_branches})
    with pytest.raises(ValueError, match=r"found only pull-offs; solve with adhesive\(…, delta="):
        figures.sweep(run["statistics/energy"])


def adhering(push):
    """Return three places' sweeps that pull with 1 to 3 nN and end at a push."""
    delta = np.linspace(-1.0, 4.0, 11)
    force = [np.where(delta < 1, -pull * np.exp(-((delta * 3) ** 2)), push * (delta - 1)) for pull in (1.0, 2.0, 3.0)]
    return xr.Dataset({"force": (("subregion", "delta"), force)}, coords={"delta": delta, "subregion": [4, 5, 6]})


def test_a_pull_is_seen_beside_a_push_a_thousand_times_as_large():
    deep = figures.plot(adhering(1000.0))
    shallow = figures.plot(adhering(3.0))
    assert (deep.get_yscale(), shallow.get_yscale()) == ("symlog", "linear")
    low, zero = (deep.transData.transform((0, force))[1] for force in (-2.0, 0.0))
    assert zero - low > 0.05 * deep.get_window_extent().height


def test_a_single_place_of_a_sweep_draws_itself():
    place = adhering(1000.0).isel(subregion=1).assign(pull_off_force=2.0)
    ax = figures.plot(place)
    assert [line.get_text() for line in ax.get_legend().get_texts()] == ["place 5"]
    with pytest.raises(ValueError, match=r"pull_off_force: .*found a single number"):
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
    ax = figures.error_budget(error_entries())
    assert [bar.get_width() for bar in ax.patches] == pytest.approx([3.0, 0.0, 3.0])
    assert [text.get_text() for text in ax.texts] == ["−3.0 ± 1.0", "not computed", "3.0 ± 1.0"]
    rose = figures.moment_rose(moments(1))
    assert rose.get_xlabel().startswith("resisting moment [nN nm]\nmedian and middle half of 2 places\ndashed: median")
    bars, _ = figures.predicted_and_measured(*(force_of(np.arange(1.0, 9.0) * factor) for factor in (1, 2)))
    labels = [text.get_text() for text in bars.get_legend().get_texts()]
    assert labels == ["predicted (8)", "measured (8)", "mean, 95 % interval"]


def test_a_map_of_tension_alone_shows_no_pressure_of_the_same_darkness(run):
    tension = -run["solutions/contact"]["pressure"]
    bar = figures.field_map(run["solutions/contact"].assign(pressure=tension)).images[-1].colorbar
    assert bar.ax.get_ylim() == (pytest.approx(float(tension.min())), 0.0)


def test_a_contact_of_two_cells_is_outlined_along_its_cells(run):
    contact = run["solutions/contact"]
    pressure = xr.zeros_like(contact["pressure"])
    pressure[..., 4:6, 4] = 1.0
    ax = figures.field_map(contact.assign(pressure=pressure))
    (outline,) = ax.collections
    corners = np.array(outline.get_segments())
    assert len(corners) == 6 and (np.ptp(corners, axis=1) > 0).sum(axis=1).tolist() == [1] * 6  # upright or level
    assert [text.get_text() for text in ax.texts] == ["contact of 2 cells"]


def test_two_displacements_of_fields_are_two_panels(run):
    contact = run["solutions/contact"]
    two = xr.concat([contact, contact.assign_coords(delta=contact["delta"] + 1)], "delta", data_vars="minimal")
    titles = [ax.get_title("left") for ax in figures.field_map(two)]
    assert len(titles) == 2 and titles[0] != titles[1] and all("displacement" in title for title in titles)
    assert figures.field_map(two, delta=two["delta"].values[0]).get_title("left") == ""


def test_a_small_tension_is_as_dark_as_a_large_pressure(run):
    contact = run["solutions/contact"]
    pressure = xr.zeros_like(contact["pressure"])
    pressure[..., 4, 4] = 1.0
    pressure[..., 5, 4] = -0.01
    drawn = figures.field_map(contact.assign(pressure=pressure)).images[-1]
    assert drawn.norm([-0.01, 0.0, 1.0]).tolist() == [0.0, 0.5, 1.0]


def test_a_pull_off_map_is_drawn_as_a_map_and_formulas_in_words(run):
    pull_offs = pull_off_map(run["asperities"], subregions=(3, 3))
    assert pull_offs.contact.plot().get_xlabel().startswith("x of the contact centre")
    force = ("formula", [1.0, 2.0], {"units": "nN"})
    formulas = xr.Dataset({"pull_off_force": force}, {"formula": ["bradley", "rumpf_rms"]})
    labels = [tick.get_text() for tick in formulas.contact.plot().get_yticklabels()]
    assert labels == ["Bradley, smooth sphere", "Rumpf, by rms height"]


def test_fitted_laws_are_drawn_over_the_histogram_of_their_samples():
    fits = fit(force_of(np.random.default_rng(1).normal(50, 5, 200)), simulations=0)
    bars = fits.contact.plot().patches[0].get_data()
    assert float((bars.values * np.diff(bars.edges)).sum()) == pytest.approx(1.0)


def force_of(values):
    return xr.Dataset({"pull_off_force": ("subregion", values, {"units": "nN"})})


def enlarged(ds, size):
    """Return a result with lengths and forces ``size`` times as large."""
    powers = {"nm": 1, "nN": 1, "1/nm": -1}
    units = {name: variable.attrs.get("units") for name, variable in ds.variables.items()}
    parts = {name: ds[name].variable for name in units if units[name] in powers}
    return ds.assign({name: (v.dims, v.values * size ** powers[units[name]], v.attrs) for name, v in parts.items()})


def error_entries():
    values = {"relative_std": [0.03, np.nan], "standard_error": [0.01, np.nan], "known_bias": [False, False]}
    entries = {name: ("entry", value) for name, value in (values | {"pull_off_change": [-0.03, np.nan]}).items()}
    return xr.Dataset(entries | {"total_std": 0.03, "total_standard_error": 0.01}, {"entry": ["modulus", "tip"]})


def over_pixels(size):
    ends = {"pull_off_mean": 30.0 * size, "pull_off_low": 1.0 * size, "pull_off_high": 75.0 * size}
    series = {"pull_off_on_pixels": ("pixel_size", size * np.array([58.0, 90.0, 105.0]))}
    return xr.Dataset(series | ends, {"pixel_size": [19.5, 39.0, 78.0]})


def over_velocity(last):
    fraction = (("friction_velocity", "time"), np.linspace(1, 0, 5)[:, None])
    coords = {"friction_velocity": np.geomspace(0.01, last, 5), "time": [1.0]}
    return xr.Dataset({"remaining": fraction}, coords)


def moments(size):
    moment = (("subregion", "direction"), size * np.array([[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]]))
    return xr.Dataset({"resisting_moment": moment}, {"direction": [0.0, 2.0, 4.0]})


def cycle(size):
    loading = adhering(3.0).force
    both_branches = xr.concat([loading, loading - 1], "branch").assign_coords(branch=["loading", "retraction"])
    return xr.Dataset({"force": size * both_branches})


def over_parameters(size, *parameters):
    """Return pull-offs of three places over some parameters."""
    shape = [len(values) for _, values in parameters]
    force = size * (1.0 + np.arange(3 * np.prod(shape, dtype=int)).reshape(3, *shape))
    coords = {"subregion": [0, 1, 2]} | {name: (name, values, {"units": "nN"}) for name, values in parameters}
    return xr.Dataset({"pull_off_force": (tuple(coords), force, {"units": "nN"})}, coords)


def spectrum_and_fit():
    scan = _surface()
    return scans.power_spectrum(scan).merge(scans.self_affine_fit(scan), combine_attrs="override")


def named(size, dim="formula"):
    return xr.Dataset({"pull_off_force": (dim, size * np.array([1.0, 3.0, 50.0]))}, {dim: ["sum", "bradley", "rumpf"]})


#: Every figure of the package, of data in nm and nN times a size.
FIGURES = {
    "asperity_statistics": lambda run, size: figures.asperity_statistics(enlarged(run["asperities"], size)),
    "distribution": lambda run, size: figures.distribution(force_of(size * np.arange(1.0, 20.0)), laws=["normal"]),
    "few": lambda run, size: figures.distribution(force_of(size * np.arange(1.0, 5.0))),
    "error_budget": lambda run, size: figures.error_budget(error_entries()),
    "force_over_pixel": lambda run, size: figures.force_over_pixel(over_pixels(size)),
    "pressure": lambda run, size: figures.field_map(enlarged(run["solutions/contact"], size)),
    "field_map": lambda run, size: figures.field_map(enlarged(run["solutions/contact"], size), "displacement"),
    "fraction_remaining": lambda run, size: figures.fraction_remaining(over_velocity(0.02 * size)),
    "mean_force": lambda run, size: figures.mean_force({"direct": enlarged(run["solutions/direct"], size)}),
    "moment_rose": lambda run, size: figures.moment_rose(moments(size)),
    "overview": lambda run, size: figures.overview({name: enlarged(ds, size) for name, ds in run.items()}).axes,
    "plot": lambda run, size: figures.plot(enlarged(run["statistics/energy"], size).contact.pdf("pull_off_force")),
    "cdf": lambda run, size: figures.plot(enlarged(run["statistics/energy"], size).contact.pdf("pull_off_force").cdf),
    "predicted_and_measured": lambda run, size: figures.predicted_and_measured(
        force_of(size * np.arange(1.0, 9.0)), force_of(size * np.arange(2.0, 14.0))
    ),
    "scan_map": lambda run, size: figures.scan_map(enlarged(run["scan"], size)),
    "subregion_map": lambda run, size: figures.subregion_map(enlarged(run["statistics/energy"], size)),
    "sweep": lambda run, size: figures.sweep(enlarged(run["solutions/direct"], size)),
    "deep sweep": lambda run, size: figures.sweep(adhering(1000.0 * size)),
    "cycle": lambda run, size: figures.sweep(cycle(size)),
    "over a preload": lambda run, size: figures.plot(over_parameters(size, ("preload", [0.0, 10.0, 1000.0]))),
    "over two": lambda run, size: figures.plot(
        over_parameters(size, ("preload", [0.0, 1.0]), ("load", [1.0, 2.0, 90.0]))
    ),
    "spectrum": lambda run, size: figures.plot(spectrum_and_fit()),
    "named": lambda run, size: figures.plot(named(size)),
    "bootstrap": lambda run, size: figures.plot(force_of(size * np.arange(1.0, 9.0)).contact.bootstrap()),
    "summary": lambda run, size: figures.plot(force_of(size * np.arange(1.0, 9.0)).contact.summary()),
    "fit": lambda run, size: figures.plot(force_of(size * np.arange(1.0, 9.0)).contact.fit(simulations=0)),
    "map": lambda run, size: figures.plot(
        xr.Dataset({"pull_off_force": (("x", "y"), size * np.eye(3))}, {"x": [1.0, 2, 3], "y": [1.0, 2, 3]})
    ),
}


def axes_with_labels(figure):
    """Yield each axis of a figure, also those of colour bars, with its label or, where panels share one, the last."""
    last = {"x": "", "y": ""}
    for ax in [part for panel in figure.axes[::-1] for part in (*panel.child_axes, panel)]:
        for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
            if ax not in figure.axes and not axis.get_label_text():
                continue  # across a colour bar
            last[name] = axis.get_label_text() or last[name]
            label = ax.get_xlabel().partition("\n")[0] if ax.name == "polar" else last[name].replace("\n", " ")
            yield axis, "direction [°]" if ax.name == "polar" and name == "x" else label


@functools.cache
def unit_size(label):
    """Return the size of the unit in a label, in the schema's units; 1 for parts, per cent and numbers."""
    unit = (re.findall(r"\[(.*)\]$", label) or ["1"])[0].translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    tables = ("nm", "nN", "GPa", "nm^2", "nm^4", "1/nm", "1/nN", "nN nm", "rad", "1/rad", "m/s", "1")
    return 1.0 if unit == "%" else next(factor(unit, table) for table in tables if converts(unit, table))


def number_of(text):
    """Return the number that the text of a tick shows, or None for words."""
    text = text.replace("−", "-").strip("°")
    power = re.fullmatch(r"\$\\mathdefault\{(-?)10\^\{(-?\d+)\}\}\$", text)
    if power:
        return float(f"{power[1]}1e{power[2]}")
    if "× 10" in text:
        mantissa, _, exponent = text.partition(" × 10")
        return float(f"{mantissa}e{exponent.translate(str.maketrans('⁻⁰¹²³⁴⁵⁶⁷⁸⁹', '-0123456789'))}")
    if "π" in text:
        return eval(text.replace("π", "3.141592653589793"))
    return float(re.sub(r"\$\\mathdefault\{(.*)\}\$", r"\1", text)) if re.match(r"[-$.\d]", text) else None


def assert_ticks_are_true(figure):
    """Tick text × unit = position on each axis, without an offset or a factor written elsewhere."""
    figure.set_layout_engine("none")  # which draws all text twice; a tick's text does not depend on where it lies
    figure.draw_without_rendering()
    compared = 0
    for axis, label in axes_with_labels(figure):
        assert axis.get_offset_text().get_text() == ""
        for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
            number = number_of(tick.label1.get_text())
            if number is not None:
                assert number * unit_size(label) == pytest.approx(tick.get_loc(), rel=1e-5, abs=1e-12), label
                compared += 1
    assert compared > 1


def test_a_variable_over_a_parameter_is_its_mean_and_its_places():
    ds = over_parameters(1.0, ("preload", [0.0, 10.0, 1000.0]))
    *places, _, mean = figures.plot(ds).lines
    np.testing.assert_array_equal([line.get_ydata() for line in places], ds.pull_off_force)
    np.testing.assert_allclose(mean.get_ydata(), ds.pull_off_force.mean("subregion"))
    two = figures.plot(over_parameters(1.0, ("preload", [0.0, 1.0]), ("load", [1.0, 2.0, 90.0])))
    assert [text.get_text() for text in two.get_legend().get_texts()] == ["0 nN", "1 nN"]
    two_laws = over_parameters(1.0, ("preload", [0.0, 1.0, 2.0]), ("law", ["jkr", "exponential"]))
    assert [text.get_text() for text in figures.plot(two_laws).get_legend().get_texts()] == ["jkr", "exponential"]
    with pytest.raises(ValueError, match=r"select first, for example ds.isel\(load=0\)"):
        figures.plot(over_parameters(1.0, ("preload", range(9)), ("load", range(8))))


def test_an_interval_is_drawn_from_its_lower_to_its_upper_end():
    intervals = force_of(np.arange(1.0, 9.0)).contact.bootstrap()
    (ends,) = figures.plot(intervals).collections
    drawn = np.array([segment[:, 0] for segment in ends.get_segments()])
    np.testing.assert_allclose(drawn, np.c_[intervals.low, intervals.high])


#: Verbs whose results are drawn elsewhere, or are no Datasets.
NOT_DRAWN = {
    "plot": "draws",
    "to_table": "a table of pandas",
    "error_budget": "test_figures_show_the_numbers_that_they_are_given",
    "answer": "test_the_answer_is_drawn_with_its_intervals",
    "extrapolated": "an error budget",
    "resting": "samples of places",
}


@pytest.mark.parametrize("verb", sorted({name for name in vars(ContactAccessor) if name[0] != "_"} - set(NOT_DRAWN)))
def test_a_result_of_each_verb_is_drawn_or_another_figure_is_named(verb):
    datasets = verb_calls.made()
    for kinds, options in verb_calls.CALLS[verb]:
        result = verb_calls.call(verb, kinds, options, datasets)
        try:
            drawn = result.contact.plot()
        except ValueError as refusal:
            assert re.search(r"draw|select first", str(refusal))
        else:
            labels = [ax.get_xlabel() + ax.get_ylabel() for ax in np.ravel(drawn)]
            assert all(labels) and "subregion [1]" not in "".join(labels)
        pyplot.close("all")


def test_the_answer_is_drawn_with_its_intervals():
    summary = force_of(np.arange(1.0, 9.0)).contact.answer()
    (ends,) = figures.plot(summary).collections
    np.testing.assert_allclose(ends.get_segments()[0][:, 0], [summary.low, summary.high])


def test_every_figure_of_the_package_is_among_those_whose_ticks_are_compared():
    assert set(figures.__all__) <= set(FIGURES)


@pytest.mark.parametrize("size", [pytest.param(1, marks=pytest.mark.soak), 3000])
@pytest.mark.parametrize("name", FIGURES)
def test_tick_text_times_unit_is_the_position(run, name, size):
    assert_ticks_are_true(np.ravel(FIGURES[name](run, size))[0].figure)


@pytest.mark.parametrize("number", range(2, 17))
def test_tick_text_times_unit_is_the_position_in_the_papers_figures(papers, number):
    assert_ticks_are_true(papers[f"figure-{number:02d}"])


def test_statistics_over_a_radius_are_drawn_with_their_intervals():
    radii = xr.concat([force_of(scale * np.arange(1.0, 41.0)) for scale in (1.0, 2.0)], "sphere_radius")
    radii = radii.assign_coords(sphere_radius=("sphere_radius", [250.0, 500.0], {"units": "nm"}))
    statistics = radii.contact.bootstrap("pull_off_force", statistics=["mean", "q50"])
    ax = figures.plot(statistics)
    for order, bars in enumerate(ax.collections):
        drawn = np.array(bars.get_segments())[:, :, 1]
        np.testing.assert_allclose(drawn, statistics[["low", "high"]].isel(statistic=order).to_array().T)
    assert ax.get_ylabel() == "pull-off force [nN]" and ax.get_xlabel() == "sphere radius [nm]"
    with pytest.raises(ValueError, match=r"draw result\.contact\.bootstrap"):  # a line from a count to a mean
        figures.plot(radii.contact.summary())


def test_a_spectrum_is_drawn_to_the_nyquist_wavevector():
    drawn = figures.plot(scans.power_spectrum(_surface())).lines[0].get_xdata()
    nyquist = np.pi / schema.pixel(_surface())[0]
    assert 0.95 * nyquist < drawn.max() <= nyquist


def test_the_work_lost_is_in_the_legend_only_where_work_is_lost():
    legends = []
    for solution in (cycle(1.0), cycle(1.0).where(cycle(1.0).branch == "loading", cycle(1.0).sel(branch="loading"))):
        legends.append([text.get_text() for text in figures.sweep(solution).get_legend().get_texts()])
    assert legends[0] == ["work lost", *legends[1]]
