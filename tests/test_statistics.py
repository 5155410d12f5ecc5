"""Pull-off, densities and summaries against NumPy and exact cases."""

import numpy as np
import pytest
import xarray as xr

from roughxr.statistics import pdf, pull_off, summary


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


def test_pull_off_is_the_largest_pull():
    found = pull_off(sweep([[0, -3, -5, 2], [0, 1, 2, 3], [-4, -1, 0, 1]]))
    np.testing.assert_array_equal(found.pull_off_force, [5, np.nan, 4])
    np.testing.assert_array_equal(found.pull_off_delta, [2, np.nan, 0])
    np.testing.assert_array_equal(found.bracketed, [True, False, False])
    assert found.pull_off_force.units == "nN" and found.pull_off_delta.units == "nm"


def test_pull_off_is_the_same_on_dask_and_keeps_other_dimensions():
    ds = sweep([[0, -3, -5, 2], [0, 1, 2, 3]])
    xr.testing.assert_equal(pull_off(ds.chunk(subregion=1)).compute(), pull_off(ds))
    both = xr.concat([ds, 2 * ds], dim=xr.DataArray(["once", "twice"], dims="method", name="method"))
    np.testing.assert_array_equal(pull_off(both).pull_off_force.sel({"method": "twice"}), [10, np.nan])


def test_one_displacement_is_no_sweep():
    with pytest.raises(ValueError, match="at least two displacements"):
        pull_off(sweep([[1.0]]))


@pytest.mark.parametrize("method", ["histogram", "kde"])
def test_density_integrates_to_one_and_has_units(sample, method):
    density = pdf(sample, "height", method=method)
    points = density["height"].values
    width = np.diff(density.attrs["bin_edges"]) if method == "histogram" else np.gradient(points)
    assert float((density.values * width).sum()) == pytest.approx(1.0, abs=1e-6)
    assert density.units == "nm-1"
    assert density["cdf"].values[-1] == pytest.approx(1.0, abs=1e-6)
    assert (np.diff(density["cdf"].values) >= 0).all()


def test_density_is_that_of_the_law(sample):
    density = pdf(sample, "height", method="kde")
    variance = 2.0**2 + density.attrs["bandwidth"] ** 2  # a kernel estimate is the law, widened by its kernel
    gauss = np.exp(-((density["height"] - 15) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
    noise = np.sqrt(gauss.max() / (2 * np.sqrt(np.pi)) / (4000 * density.attrs["bandwidth"]))
    assert float(np.abs(density - gauss).max()) < 4 * noise


def test_missing_samples_are_counted(sample):
    holes = sample.where(sample.height > 13)
    density = pdf(holes, "height")
    assert density.attrs["missing"] == int(holes.height.isnull().sum())
    assert density.attrs["samples"] + density.attrs["missing"] == 4000


def test_density_plots_and_becomes_a_dataset(sample):
    import matplotlib

    matplotlib.use("Agg")
    pdf(sample, "height").plot()
    matplotlib.pyplot.close("all")
    assert set(pdf(sample, "height").to_dataset().variables) == {"pdf", "cdf", "height"}


def test_summary_equals_numpy(sample):
    table = summary(sample).height
    values = sample.height.values
    assert float(table.sel(statistic="mean")) == pytest.approx(values.mean())
    assert float(table.sel(statistic="std")) == pytest.approx(values.std(ddof=1))
    assert float(table.sel(statistic="q5")) == pytest.approx(np.quantile(values, 0.05))
    assert float(table.sel(statistic="count")) == 4000
    assert table.units == "nm"
    xr.testing.assert_allclose(summary(sample.chunk(asperity=1000)).compute(), summary(sample))


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda ds: pdf(ds, "depth"), "expected one of height"),
        (lambda ds: pdf(ds, "height", method="spline"), "'histogram'"),
        (lambda ds: pdf(ds.isel(asperity=[0]), "height"), "at least two"),
        (lambda ds: pdf(ds.expand_dims(delta=[1.0]), "height"), "select first"),
        (lambda ds: summary(ds.rename(asperity="n")), "subregion or asperity"),
        (lambda ds: pull_off(ds), "along 'delta'"),
    ],
)
def test_bad_input_is_refused_in_words(sample, call, says):
    with pytest.raises(ValueError, match=says):
        call(sample)
