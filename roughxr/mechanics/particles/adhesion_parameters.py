"""`parameters`: adhesion and moments reduced to the parameters of other codes.

Rock'n'Roll    log-normal pull-off over the smooth sphere's, and a lever over the radius (Reeks & Hall 2001)
LAMMPS         pair_style granular, normal jkr: E_eff and γ, pull-off 3πγR; rolling sds: μ_roll, whose largest
               moment is μ_roll R (N + 2 · 3πγR) (its manual, "pair_style granular")
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..statistics import cdf, reduction
from ..statistics.sampling import deviation_of_places, mean_of_places, quantile_of_places, refuse_several
from ..vocabulary import schema

#: Reported quantiles over the places, and the suffixes of their names.
_QUANTILES = {"low": 0.05, "median": 0.5, "high": 0.95}


@schema.verb("result")
def parameters(ds: xr.Dataset) -> xr.Dataset:
    """Return the parameters of adhesion of resuspension and discrete-element codes, from the places of a result.

    Parameters
    ----------
    ds : Dataset
        Result of `rolling`, or a pull-off with its pair (without levers).

    Returns
    -------
    Dataset
        Scalars, which `to_table` lists with units and meaning. ``adhesion_mean``, ``adhesion_spread`` and
        ``adhesion_law_distance`` (Kolmogorov's) of the log-normal law of the pull-off over the smooth sphere's.
        ``work_of_adhesion_median``, at which a smooth JKR sphere has the same pull-off force, with ``_low`` and
        ``_high``, 5 and 95 % of the places, and ``surface_energy_median``, half of it, LAMMPS' γ. From `rolling`
        ``moment_mean`` (nN nm) and ``moment_spread`` (geometric), ``lever_median`` over the radius, with ``_low`` and
        ``_high``, and ``rolling_friction_median``, LAMMPS' μ_roll; from the simulation also ``lever_error_median``.

    Notes
    -----
    A smooth JKR sphere with ``work_of_adhesion_median`` has the pull-off force of the rough contact, but not its area
    or its stiffness, and no scatter.

    References
    ----------
    Reeks & Hall, J. Aerosol Sci. 32 (2001) 1, doi:10.1016/S0021-8502(00)00063-X; LAMMPS manual, pair_style granular.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> found = roughxr.particles.parameters(roughxr.rolling(scan, directions=8, subregions=(3, 3)))
    >>> bool(0 < found.adhesion_mean < 1), found.work_of_adhesion_median.units
    (True, 'J/m^2')
    """
    from scipy.stats import norm

    refuse_several(ds)
    ds = reduction(ds)
    ln_ratio = np.log(ds["pull_off_ratio"])
    mean = mean_of_places(ln_ratio)
    spread = deviation_of_places(ln_ratio)
    steps = cdf(ds, "pull_off_ratio")
    law = norm.cdf(np.log(steps["pull_off_ratio"]), mean, spread)
    below = np.append(0.0, steps.values[:-1])
    rows = {
        "adhesion_mean": np.exp(mean),
        "adhesion_spread": np.exp(spread),
        "adhesion_law_distance": float(np.maximum(abs(law - steps), abs(law - below)).max()),
        **_quantiles("work_of_adhesion", ds["pull_off_force"] / (1.5 * np.pi * ds["sphere_radius"])),
    }
    rows["surface_energy_median"] = 0.5 * rows["work_of_adhesion_median"]
    if "lever" in ds:
        ln_moment = np.log(ds["resisting_moment"].where(ds["resisting_moment"] > 0))
        rows["moment_mean"] = float(np.exp(mean_of_places(ln_moment)))
        rows["moment_spread"] = float(np.exp(deviation_of_places(ln_moment)))
        rows |= _quantiles("lever", ds["lever"] / ds["sphere_radius"])
        rows["rolling_friction_median"] = 0.5 * rows["lever_median"]
    if "lever_error" in ds:
        rows["lever_error_median"] = float(quantile_of_places(ds["lever_error"], 0.5))
    return schema.label(xr.Dataset(rows, coords=schema.pair_coordinates(ds)))


@schema.verb("moments")
def adhesion_by_place(ds: xr.Dataset) -> xr.Dataset:
    """Return adhesion, lever and moment of each place, over all directions."""
    reduced = reduction(ds)[["pull_off_force", "pull_off_ratio", "contact_area"]]
    moment = ds["resisting_moment"]
    columns = {
        **{name: ds[name] for name in ("lever_error",) if name in ds},
        "lever": ds["lever"].mean("direction"),
        "moment_over_directions": moment.mean("direction"),
        "moment_least": moment.min("direction"),
        "moment_largest": moment.max("direction"),
    }
    out = reduced.assign(columns).assign_attrs(missing=ds.attrs.get("missing", ""))
    return schema.label(out)


def _quantiles(name: str, values: xr.DataArray) -> dict[str, float]:
    return {f"{name}_{end}": float(quantile_of_places(values, share)) for end, share in _QUANTILES.items()}
