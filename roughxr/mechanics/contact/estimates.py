"""Tabor's parameter, and the law of adhesion that follows from it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.catalogue import asperities, catalogue_of
from ..bodies.pair_record import Pair, read_pair
from ..specimen import Specimen
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import EXPONENTIAL, JKR, SHORT_RANGE


@schema.recorded
def tabor(ds: xr.Dataset) -> xr.Dataset:
    """Return the catalogue with Tabor's parameter of each asperity under the assigned sphere.

    Above about 5 JKR's limit holds, below about 0.1 the limit of long range (DMT). A humid pair has the larger
    parameter of the solids under the liquid and of the liquid.

    Parameters
    ----------
    ds : Dataset
        An asperity catalogue, or a scan (its asperities are then detected with the default patch), with an assigned
        pair and its work of adhesion; z₀ is the pair's range of adhesion.

    Returns
    -------
    Dataset
        With ``tabor_parameter`` along asperity, (R w²/(E*² z₀³))^{1/3} with the composite radius R of asperity and
        sphere; NaN for a saddle. On a layer, E* is that at the size of the contact.

    References
    ----------
    Tabor, J. Colloid Interface Sci. 58, 2 (1977), doi:10.1016/0021-9797(77)90366-6.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius="3 um", materials="glass")
    >>> roughxr.reference.tabor(scan.contact.asperities()).tabor_parameter.dims
    ('asperity',)
    """
    schema.need_dataset(ds)
    ds = schema.validate(ds, "asperities") if "asperity" in ds.dims else asperities(ds)
    parameter = _tabor_parameters(ds, read_pair(ds, "sphere_radius", "contact_modulus", "work_of_adhesion"))
    out = ds.assign(tabor_parameter=("asperity", parameter))
    return schema.label(out)


def _tabor_parameters(catalogue: xr.Dataset, pair: Pair) -> np.ndarray:
    """Return Tabor's parameter of each asperity, NaN for a saddle."""
    A, B = (0.5 * (catalogue[name].values + 1 / pair.sphere_radius) for name in ("curvature_min", "curvature_max"))
    with np.errstate(invalid="ignore", divide="ignore"):
        parameters = np.max(pair.tabor_parameters(0.5 / np.sqrt(A * B)), axis=0)
    return np.where(A > 0, parameters, np.nan)


def median_tabor(specimen: Specimen) -> float:
    """Return the median Tabor parameter of the asperities at the pair's range; NaN without a sphere."""
    if specimen.indenter.map:
        return np.nan
    parameter = _tabor_parameters(catalogue_of(specimen.scan), specimen.pair)
    parameter = parameter[np.isfinite(parameter)]
    return float(np.median(parameter)) if parameter.size else np.nan


def automatic_law(parameter: float, *, yields: bool = False, humid: bool = False) -> str:
    """Return the law of `adhesive` for "auto", which `regime` recommends, at the asperities' Tabor parameter.

    Examples
    --------
    >>> automatic_law(132.0), automatic_law(0.8), automatic_law(132.0, yields=True), automatic_law(float("nan"))
    ('jkr', 'exponential', 'exponential', 'exponential')
    """
    return JKR if parameter >= SHORT_RANGE and not (yields or humid) else EXPONENTIAL
