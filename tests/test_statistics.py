"""Pull-off, densities and summaries against NumPy and exact cases."""

import warnings

import numpy as np
import pytest
import xarray as xr

from roughxr.figures import plot
from roughxr.mechanics.statistics.sampling import standard_deviation
from roughxr.mechanics.vocabulary.refusal import Refusal
from roughxr.statistics import bootstrap, cdf, pdf, pull_off, summary


@pytest.fixture(scope="module")
def sample():
    draws = np.random.default_rng(0).normal(15.0, 2.0, 4000)
    return xr.Dataset({"height": ("asperity", draws, {"units": "nm", "long_name": "height"})})


def sweep(force):
    force = np.asarray(force, float)
    return xr.Dataset(
        {"force": (("subregion", "delta"), force, {"units": "nN"})},
        coords={"subregion": np.arange(len(force)), "delta": np.arange(force.shape[1], dtype=float)},
    )


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_pull_off_is_the_largest_pull():
    pulls = pull_off(sweep([[0, -3, -5, 2], [0, 1, 2, 3], [-4, -1, 0, 1]]))
    np.testing.assert_array_equal(pulls.pull_off_force, [5, np.nan, 4])
    np.testing.assert_array_equal(pulls.pull_off_delta, [2, np.nan, 0])
    np.testing.assert_array_equal(pulls.bracketed, [True, False, False])
    assert pulls.pull_off_force.units == "nN" and pulls.pull_off_delta.units == "nm"


def test_a_sweep_too_short_says_where_and_to_whom_it_was_asked():
    asked = sweep([[0, -3, -5, 2], [0, 1, 2, 3], [-4, -1, 0, 1], [3, 1, -1, -2], [1, 2, 3, 4]])
    with pytest.warns(UserWarning, match="too short for 4 of 5 places: at 2 .* at 2 there is none") as warned:
        pull_off(asked)
    assert [warning.filename for warning in warned] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pull_off(asked.isel(subregion=[0]))
        pull_off(asked.chunk(subregion=1))  # it would take a computation to know


def test_samples_that_are_missing_are_told_to_whom_asks():
    force = np.ones((4, 3))
    force[1, [0, 2]] = force[2, 1] = np.nan
    ds = xr.Dataset({"force": (("subregion", "delta"), force, {"units": "nN"})}, attrs={"missing": "not touched"})
    for ask in (summary, lambda ds: pdf(ds.isel(delta=0), "force", bins=[0.0, 2.0])):
        with pytest.warns(UserWarning, match=r"force: computed from [23] of 4 samples.*\(not touched\)") as warned:
            ask(ds)
        assert [warning.filename for warning in warned] == [__file__]
    with pytest.warns(UserWarning, match="computed from 2 of 4"):
        table = summary(ds)
    np.testing.assert_array_equal(table.force.sel(statistic="count"), [3, 3, 3])
    errors = {name: ("subregion", np.full(4, np.nan), {"missing": "one mesh"}) for name in ("mesh_error", "step_error")}
    with pytest.warns(UserWarning) as warned:
        summary(ds.isel(delta=0).assign(errors))
    assert [str(warning.message).partition(" from ")[0] for warning in warned] == [
        "force: computed",
        "mesh_error, step_error: computed",
    ]
    assert ["(one mesh)" in str(warning.message) for warning in warned] == [False, True]


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_pull_off_is_the_same_on_dask_and_keeps_other_dimensions():
    ds = sweep([[0, -3, -5, 2], [0, 1, 2, 3]])
    xr.testing.assert_equal(pull_off(ds.chunk(subregion=1)).compute(), pull_off(ds))
    methods = xr.concat([ds, 2 * ds], dim=xr.DataArray(["once", "twice"], dims="method", name="method"))
    np.testing.assert_array_equal(pull_off(methods).pull_off_force.sel({"method": "twice"}), [10, np.nan])


def test_a_sweep_that_is_elastic_has_no_pull_off_however_lightly_it_presses():
    with pytest.raises(ValueError, match="found one without; solve with adhesion"):
        pull_off(sweep([[0.0, 0.2, 0.5]]).assign_attrs(method="direct"))


def test_one_displacement_is_no_sweep():
    with pytest.raises(ValueError, match="at least two displacements"):
        pull_off(sweep([[1.0]]))


def test_density_is_that_of_the_law_and_has_units(sample):
    density = pdf(sample, "height", bins=20)
    width = np.diff(density.attrs["bin_edges"])
    gauss = np.exp(-((density["height"] - 15) ** 2) / 8) / np.sqrt(8 * np.pi)
    assert float(np.abs(density - gauss).max()) < 4 * np.sqrt(gauss.max() / (4000 * width[0])) + 0.01
    assert float((density.values * width).sum()) == pytest.approx(1.0, abs=1e-6)
    assert density.units == "1/nm"
    assert density["cdf"].values[-1] == pytest.approx(1.0, abs=1e-6)
    assert (np.diff(density["cdf"].values) >= 0).all()


def test_density_of_a_sweep_is_that_of_each_displacement_on_the_same_bins():
    rng = np.random.default_rng(3)
    force = rng.gamma(2.0, 5.0, (2, 50, 3)) * np.array([0.1, 1.0, 3.0])
    force[1, 7, 2] = np.nan
    places = {"delta": [1.0, 5.08, 15.4], "branch": ["loading", "retraction"]}
    ds = xr.Dataset({"force": (("branch", "subregion", "delta"), force, {"units": "nN"})}, places)
    with pytest.warns(UserWarning, match="force: computed from 49 of 50 samples"):
        density = pdf(ds, "force", bins=12)
    assert density.dims == ("branch", "delta", "force") and density.units == "1/nN"
    edges = density.attrs["bin_edges"]
    assert edges[[0, -1]] == pytest.approx([np.nanmin(force), np.nanmax(force)])
    for branch in (0, 1):
        for delta in range(3):
            values = force[branch, :, delta]
            expected = np.histogram(values[np.isfinite(values)], bins=edges, density=True)[0]
            np.testing.assert_allclose(density[branch, delta], expected, rtol=1e-13)
    np.testing.assert_allclose(density.cdf.isel(force=-1), 1)
    assert density.attrs["samples"] == 299 and density.attrs["missing"] == 1


def test_density_of_a_sweep_takes_shares_quantities_and_dask(sample):
    sweep = xr.Dataset({"force": (("subregion", "delta"), [[0.0, 0], [0, 2], [1, 3]], {"units": "nN"})})
    shared = sweep.assign_coords(landing_share=("subregion", [1.0, 2.0, 1.0]))
    repeated = sweep.isel(subregion=[0, 1, 1, 2])
    np.testing.assert_allclose(pdf(shared, "force", bins=3), pdf(repeated, "force", bins=3))
    xr.testing.assert_identical(pdf(sweep.chunk(subregion=1), "force"), pdf(sweep, "force"))
    edges = xr.DataArray([0.0, 0.0015, 0.003], attrs={"units": "uN"})
    np.testing.assert_allclose(pdf(sweep, "force", bins=edges), pdf(sweep, "force", bins=[0.0, 1.5, 3.0]))


def test_summary_equals_numpy(sample):
    table = summary(sample).height
    values = sample.height.values
    assert float(table.sel(statistic="mean")) == pytest.approx(values.mean())
    assert float(table.sel(statistic="std")) == pytest.approx(values.std(ddof=1))
    assert float(table.sel(statistic="q5")) == pytest.approx(np.quantile(values, 0.05))
    assert float(table.sel(statistic="count")) == 4000
    assert table.units == "nm"
    xr.testing.assert_allclose(summary(sample.chunk(asperity=1000)).compute(), summary(sample))


def test_weights_count_as_repetition():
    values = [1.0, 2.0, 4.0, 7.0]
    counts = [3, 1, 2, 5]
    weighted = xr.Dataset({"height": ("asperity", values, {"units": "nm"})}).assign_coords(
        landing_share=("asperity", counts)
    )
    repeated = xr.Dataset({"height": ("asperity", np.repeat(values, counts), {"units": "nm"})})
    edges = np.array([0.0, 3, 6, 9])
    np.testing.assert_allclose(pdf(weighted, "height", bins=edges), pdf(repeated, "height", bins=edges))
    xr.testing.assert_allclose(cdf(weighted, "height"), cdf(repeated, "height"))
    table = summary(weighted).height
    assert float(table.sel(statistic="mean")) == pytest.approx(repeated.height.mean().item())
    effective = sum(counts) ** 2 / sum(count**2 for count in counts)
    unbiased = repeated.height.std().item() * np.sqrt(effective / (effective - 1))
    assert float(table.sel(statistic="std")) == pytest.approx(unbiased)


def test_equal_shares_change_no_statistic():
    values = np.random.default_rng(2).lognormal(3.0, 0.7, (9, 4))
    plain = xr.Dataset({"pull_off_force": (("subregion", "preload"), values, {"units": "nN"})})
    shared = plain.assign_coords(landing_share=("subregion", np.full(9, 1 / 9)))
    xr.testing.assert_allclose(summary(shared).drop_vars("landing_share", errors="ignore"), summary(plain), rtol=1e-12)
    for statistic in (bootstrap, pdf, cdf):
        equal, none = (statistic(ds.isel(preload=0), "pull_off_force") for ds in (shared, plain))
        xr.testing.assert_allclose(equal, none, rtol=1e-12)
    four = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0, 3.0, 4.0])})
    four = four.assign_coords(landing_share=("subregion", np.full(4, 0.25)))
    estimates = bootstrap(four, statistics=["std", "q5"]).estimate.values
    table = summary(four).pull_off_force
    np.testing.assert_allclose(estimates, [np.sqrt(5 / 3), 1.15])
    np.testing.assert_allclose(table.sel(statistic=["std", "q5"]), estimates)


def test_unequal_shares_give_the_same_statistics_in_every_table():
    values = np.random.default_rng(4).lognormal(3.0, 0.7, 12)
    share = np.random.default_rng(5).dirichlet(np.ones(12))
    ds = xr.Dataset({"pull_off_force": ("subregion", values)}, {"landing_share": ("subregion", share)})
    labels = ["mean", "std", "q5", "q50", "q95"]
    table = summary(ds).pull_off_force.sel(statistic=labels)
    np.testing.assert_allclose(table, bootstrap(ds, statistics=labels).estimate, rtol=1e-12)
    assert float(standard_deviation(ds.pull_off_force)) == pytest.approx(float(table[1]), rel=1e-12)


def test_the_weighted_variance_is_unbiased():
    """Of 20,000 samples of ten weighted normal numbers the mean variance is known to 0.6 %."""
    share = np.random.default_rng(6).dirichlet(np.ones(10))
    draws = xr.DataArray(np.random.default_rng(7).normal(5.0, 2.0, (20_000, 10)), dims=("sample", "subregion"))
    deviation = standard_deviation(draws.assign_coords(landing_share=("subregion", share)), "subregion")
    assert float((deviation**2).mean()) == pytest.approx(4.0, rel=0.02)


def test_empirical_cdf_steps_at_the_samples(sample):
    steps = cdf(sample, "height")
    values = np.sort(sample.height.values)
    np.testing.assert_array_equal(steps.height, values)
    np.testing.assert_allclose(steps, np.arange(1, 4001) / 4000)
    assert steps.units == "1" and steps.attrs["samples"] == 4000


def test_densities_are_the_same_on_dask(sample):
    xr.testing.assert_identical(pdf(sample.chunk(asperity=700), "height"), pdf(sample, "height"))
    xr.testing.assert_identical(cdf(sample.chunk(asperity=700), "height"), cdf(sample, "height"))


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda ds: pdf(ds, "depth"), "expected one of height.*found 'depth'"),
        (lambda ds: pdf(ds.isel(asperity=[0]), "height"), "at least two"),
        (lambda ds: cdf(ds.expand_dims(delta=[1.0]), "height"), "select first"),
        (lambda ds: pdf(ds, "height", bins="5 nm"), "bins: expected a number of bins.*edges in nm, found '5 nm'"),
        (lambda ds: pdf(ds, "height", bins="fine"), "bins: expected a number of bins.*found 'fine'"),
        (lambda ds: summary(ds.rename(asperity="n")), "subregion or asperity"),
        (lambda ds: pull_off(ds), "along 'delta'"),
    ],
)
def test_bad_input_is_refused_in_words(sample, call, says):
    with pytest.raises(ValueError, match=says):
        call(sample)


def test_a_map_is_a_sample_at_every_pixel():
    rng = np.random.default_rng(2)
    force = xr.DataArray(rng.gamma(3.0, 10.0, (12, 9)), dims=("x", "y"), attrs={"units": "nN"})
    whole = xr.Dataset({"pull_off_force": force}, {"x": np.arange(12.0), "y": np.arange(9.0) * 2})
    x, y = (grid.ravel() for grid in np.meshgrid(whole.x, whole.y, indexing="ij"))
    places = {"subregion_x": ("subregion", x), "subregion_y": ("subregion", y)}
    listed = xr.Dataset({"pull_off_force": ("subregion", force.values.ravel(), force.attrs)}, places)
    for verb, options in (("pdf", {}), ("bootstrap", {}), ("fit", {"simulations": 19})):
        of_map, expected = (getattr(ds.contact, verb)("pull_off_force", **options) for ds in (whole, listed))
        xr.testing.assert_equal(of_map, expected)
    xr.testing.assert_equal(whole.contact.summary(), listed.contact.summary())


@pytest.mark.parametrize("use", [pdf, plot])
def test_a_misspelt_variable_is_answered_with_the_nearest(use):
    forces = xr.Dataset({"pull_off_force": ("subregion", np.arange(1.0, 9.0), {"units": "nN"})})
    with pytest.raises(Refusal, match=r"found 'pulloff_force' \(did you mean pull_off_force\?\)"):
        use(forces, "pulloff_force")
