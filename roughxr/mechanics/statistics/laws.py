"""Fit distributions with two parameters by maximum likelihood, and compare them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import warn
from .densities import binned_density
from .sampling import samples, without_weights


class Law(NamedTuple):
    """One law, and its name in SciPy."""

    words: str
    distribution: str  # in scipy.stats
    positive: bool  # begins at zero, with a shape and a scale; else a location and a scale

    @property
    def scipy(self):
        """The distribution in SciPy."""
        from scipy import stats

        return getattr(stats, self.distribution)


LAWS = {
    "normal": Law("normal", "norm", positive=False),
    "log_normal": Law("log-normal", "lognorm", positive=True),
    "weibull": Law("Weibull", "weibull_min", positive=True),
    "gumbel": Law("Gumbel, of largest values", "gumbel_r", positive=False),
}

_RESULTS = ("shape", "location", "scale", "log_likelihood", "aic", "ks_distance", "ks_p_value")


@schema.verb("result")
def fit(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    laws: str | Sequence[str] = tuple(LAWS),
    simulations: int = 199,
) -> xr.Dataset:
    """Fit laws to a variable's samples by maximum likelihood and compare them.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` and no other dimension.
    laws : sequence of {"normal", "log_normal", "weibull", "gumbel"}
        "gumbel" is the law of largest values.
    simulations : int
        Number of samples drawn from each fitted law and fitted again, since Kolmogorov's tables are not valid for
        fitted parameters. For more than 2000 samples ``ks_p_value`` is computed from 2000 of them, with a warning.

    Returns
    -------
    Dataset
        Along ``law``: ``location`` and ``scale`` (the variable's unit; for the log-normal, ``scale`` is the median and
        ``shape`` the standard deviation of the logarithm), ``shape`` (1; NaN for a law without), ``log_likelihood``,
        ``aic``, ``aic_difference`` to the best, ``akaike_weight``, ``ks_distance`` (largest distance between empirical
        and fitted cumulative probability), and ``ks_p_value``; NaN if a law is not defined for the samples. Places are
        taken as independent; if they are not, ``ks_p_value`` is too small and differences in AIC are too large. Pull-
        off forces that are known by their limits are censored; then ``ks_distance`` and ``ks_p_value`` are NaN. The
        attributes ``bin_edges`` and ``density`` are the histogram of the samples.

    Raises
    ------
    ValueError
        If there are fewer than three different samples, or a law is not among those listed.

    References
    ----------
    Akaike (1974); Burnham & Anderson (2002), section 2.9, for the weights; Stute et al., Metrika 40 (1993) 243,
    doi:10.1007/BF02613687, for the simulated goodness of fit.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> values = np.random.default_rng(0).lognormal(1.0, 0.5, 500)
    >>> ds = xr.Dataset({"pull_off_force": ("subregion", values, {"units": "nN"})})
    >>> fits = ds.contact.fit("pull_off_force", simulations=0)
    >>> str(fits.law[int(fits.aic.argmin('law'))].values), fits.scale.units
    ('log_normal', 'nN')
    """
    laws = [laws] if isinstance(laws, str) else laws
    for law in laws:
        schema.one_of(law, LAWS, "laws")
    sample = without_weights(samples(ds, name), "fit")
    values = sample.values
    if values.size < 3 or np.ptp(values) == 0:
        raise Refusal(name, "at least three samples, not all equal", values.size)
    simulations = 0 if sample.bounds is not None else simulations
    tested = _tested_samples(values, name) if simulations else values
    bounds = np.array([values, values]) if sample.censored is None else sample.censored
    rows = np.array([_fit_law(LAWS[law], bounds, tested, simulations) for law in laws])
    out = xr.Dataset({result: ("law", rows[:, k]) for k, result in enumerate(_RESULTS)}, coords={"law": list(laws)})
    out["aic_difference"] = out["aic"] - out["aic"].min()
    weight = xr.DataArray(np.exp(-0.5 * out["aic_difference"])).fillna(0.0)
    out["akaike_weight"] = weight / weight.sum()
    for parameter in ("location", "scale"):
        out[parameter].attrs["units"] = ds[name].attrs.get("units", "1")
    # most bins of a histogram: rules for their width fail where most samples are similar and a few are far off
    edges = np.histogram_bin_edges(values, bins=min(48, np.histogram_bin_edges(values, bins="auto").size - 1))
    attrs = {"variable": name, "samples": values.size, "missing": "NaN where a law is not defined for the samples"}
    return schema.label(out).assign_attrs(attrs, bin_edges=edges, density=binned_density(sample, edges))


def _tested_samples(values: np.ndarray, name: str) -> np.ndarray:
    """Return the samples for the simulated goodness of fit, with a warning if these are not all."""
    # largest number of samples. All 262,144 pixels of a map would take ten minutes, and such close neighbours are not
    # independent.
    most_simulated = 2000
    if values.size <= most_simulated:
        return values
    warn(
        f"{name}: {values.size} samples; ks_p_value is computed from {most_simulated} of them drawn at random, all "
        "other results from all"
    )
    return np.random.default_rng(0).choice(values, most_simulated, replace=False)


def fitted_law(fits: xr.Dataset, law: str):
    """Return a fitted law as a distribution of SciPy."""
    fitted = fits.sel(law=law)
    names = ("shape", "location", "scale") if LAWS[law].positive else ("location", "scale")
    return LAWS[law].scipy(*(float(fitted[name]) for name in names))


def log_likelihood(law: Law, parameters: tuple, bounds: np.ndarray) -> np.ndarray:
    """Return the logarithm of the likelihood of samples, each known or within its bounds.

    Parameters may be arrays of one shape, which the result has then.
    """
    low, high = bounds
    is_known = low == high
    columns = [np.asarray(parameter, dtype=float)[..., None] for parameter in parameters]
    total = law.scipy.logpdf(low[is_known], *columns).sum(axis=-1)
    limits, counts = np.unique(bounds[:, ~is_known], axis=1, return_counts=True)
    with np.errstate(divide="ignore"):
        between = np.log(law.scipy.cdf(limits[1], *columns) - law.scipy.cdf(limits[0], *columns))
    return total + (between * counts).sum(axis=-1)


def fitted_parameters(law: Law, bounds: np.ndarray) -> tuple[float, ...]:
    """Return the parameters of the law of highest likelihood."""
    from scipy.stats import CensoredData

    low, high = bounds
    is_known = low == high
    options = {"floc": 0.0} if law.positive else {}
    if is_known.all():
        return tuple(map(float, law.scipy.fit(low, **options)))
    is_open = np.isinf(high)
    interval = np.c_[low, high][~is_known & ~is_open]
    data = CensoredData(uncensored=low[is_known], right=low[is_open], interval=interval)
    return tuple(map(float, law.scipy.fit(data, **options)))


def _fit_law(law: Law, bounds: np.ndarray, tested: np.ndarray, simulations: int) -> list[float]:
    """Return the `_RESULTS` of one law; without tests of its fit if some samples are limits."""
    from scipy import stats

    low, high = bounds
    is_exact = (low == high).all()
    exact_values = low[low == high]
    if np.unique(exact_values).size < 2 or (law.positive and exact_values.min() <= 0):
        return [np.nan] * len(_RESULTS)
    parameters = fitted_parameters(law, bounds)
    likelihood = float(log_likelihood(law, parameters, bounds))
    distance = stats.ks_1samp(low, law.scipy(*parameters).cdf).statistic if is_exact else np.nan
    shape = parameters[0] if law.positive else np.nan
    chance = np.nan
    if simulations:
        how: dict[str, Any] = {"known_params": {"loc": 0.0}} if law.positive else {}
        how |= {"statistic": "ks", "n_mc_samples": simulations, "random_state": np.random.default_rng(0)}
        chance = stats.goodness_of_fit(law.scipy, tested, **how).pvalue
    return [shape, *parameters[-2:], likelihood, 2 * 2 - 2 * likelihood, distance, chance]
