"""Cheap estimates: the pull-off implied by an elastic sweep, and Tabor's parameter."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.catalogue import asperities
from ..bodies.layer import film_of
from ..bodies.liquid import pair_menisci
from ..bodies.pair import attraction_range
from ..jobs.records import converged
from ..kernels.asperity import maugis
from ..kernels.halfspace.layered import contact_at_pull_off
from ..specimen import Specimen
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import EXPONENTIAL, HERTZ, JKR, SHORT_RANGE
from ..vocabulary.units import Quantity, positive

#: Least P″ over P′/depth for an estimate: half of a paraboloid's. A flat top or mesh noise would divide by nearly zero.
_LEAST_CURVATURE = 0.25


def elastic_pull_off(ds: xr.Dataset, *, smoothing: Quantity = 2.0) -> xr.Dataset:
    """Estimate the pull-off from a sweep without adhesion by Ciavarella's rule.

    Adhesion moves each state of force P, area A and displacement δ₁ to δ = δ₁ − √(2wA′/P″) and P − P′(δ₁ − δ). The rule
    is exact for a sphere.

    Parameters
    ----------
    ds : Dataset
        A sweep of `direct` or of `superpose` with law="hertz", at eight displacements or more, with a pair.
    smoothing : number or quantity
        Half-width, nm, of the fits (in the root of the depth) for the derivatives, at least three displacements to
        either side.

    Returns
    -------
    Dataset
        As `pull_off`.

    References
    ----------
    Ciavarella, arXiv 1712.05844.

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> pressed = roughxr.direct(scan, delta=np.linspace(1, 12, 12), datum="first_contact", subregions=(1, 2))
    >>> bool((roughxr.reference.elastic_pull_off(pressed).pull_off_force > 0).all())
    True
    """
    ds = schema.entered(ds)
    if not all(name in ds and "delta" in ds[name].dims for name in ("force", "contact_area")):
        names = ", ".join(map(str, ds.variables))
        raise ValueError(f"expected a sweep with 'force' and 'contact_area' along 'delta', found variables: {names}")
    (w,) = schema.pair(ds, "work_of_adhesion")
    if ds.attrs.get("method") == "adhesive" or ds.attrs.get("law", HERTZ) != HERTZ:
        raise ValueError("expected a sweep without adhesion (of direct, or law='hertz'), found one with; take pull_off")
    if ds.sizes["delta"] < 8:
        raise ValueError(f"delta: expected a sweep of at least eight displacements, found {ds.sizes['delta']}")
    moved = xr.apply_ufunc(
        _largest_adhesion,
        ds["force"],
        ds["contact_area"],
        input_core_dims=[["delta"], ["delta"]],
        output_core_dims=[["event"]],
        kwargs={"delta": ds["delta"].values, "w": w, "half": positive(smoothing, "nm", "smoothing")},
        vectorize=True,
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"output_sizes": {"event": 3}, "allow_rechunk": True},
    )
    out = xr.Dataset({name: moved[..., k] for k, name in enumerate(("pull_off_force", "pull_off_delta", "bracketed"))})
    known = (converged(ds) | ~(ds["force"] > 0)).all("delta")
    out = out.where(known).assign(bracketed=known & (out["bracketed"] == 1))
    out.attrs = {"datum": ds.attrs.get("datum", ""), "method": "elastic_pull_off"}
    return schema.record(schema.label(out), "elastic_pull_off", ds, smoothing=smoothing)


def _largest_adhesion(force, area, *, delta, w, half):
    """Return pull-off force, its displacement, and whether it lies inside the sweep."""
    touched = force > 0
    if touched.sum() < 8:
        return np.full(3, np.nan)
    delta = delta[touched]
    force = force[touched]
    area = area[touched]
    root = _roots(delta, force)
    derivatives = np.array([_derivatives(root, force, area, k, half) for k in range(delta.size)])
    growth, first, second = derivatives.T
    possible = (growth > 0) & (second > _LEAST_CURVATURE * first / root**2)
    if not possible.any():
        return np.full(3, np.nan)
    drop = np.sqrt(2 * w * growth[possible] / second[possible])
    pull = first[possible] * drop - force[possible]
    k = int(np.argmax(pull))
    inside = 0 < k < pull.size - 1
    return np.array([pull[k], delta[possible][k] - drop[k], inside]) if pull[k] > 0 else np.full(3, np.nan)


def _derivatives(root, force, area, k, half):
    """Return A′, P′ and P″ at the k-th displacement, by fits in the root s of the depth (a sphere has P ~ s³)."""
    depth = root**2
    s = root[k]
    offset = np.abs(depth - depth[k])
    near = offset <= max(half, np.sort(offset)[min(6, root.size - 1)])
    cubic = np.polynomial.polynomial.polyfit(root[near] - s, force[near], 3)
    parabola = np.polynomial.polynomial.polyfit(root[near] - s, area[near], 2)
    return parabola[1] / (2 * s), cubic[1] / (2 * s), (2 * cubic[2] - cubic[1] / s) / (4 * s * s)


def _roots(delta, force):
    """Return √(δ − first touch), the touch extrapolated from force^{2/3} (linear for a sphere) at two states."""
    first, second = force[:2] ** (2 / 3)
    before = np.clip(first / (second - first), 1e-3, 1.0) if second > first else 1e-3
    return np.sqrt(delta - delta[0] + before * (delta[1] - delta[0]))


def pair_attractions(ds: xr.Dataset) -> list[tuple[float, float]]:
    """Return work (J/m²) and range (nm) of a pair's attraction; for a humid pair, of the solids and of the liquid."""
    (work,) = schema.pair(ds, "work_of_adhesion", humid=True)
    menisci = pair_menisci(ds)
    if menisci is None:
        return [(work, attraction_range(ds))]
    return [(work * menisci.share, attraction_range(ds)), (menisci.work, menisci.range)]


def tabor(ds: xr.Dataset) -> xr.Dataset:
    """Return the catalogue with Tabor's parameter of each asperity under the assigned sphere.

    Above about 5 JKR's limit holds, below about 0.1 the limit of long range (DMT). A humid pair has the
    larger parameter of the solids under the liquid and of the liquid.

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
    Tabor, J. Colloid Interface Sci. 58, 2 (1977).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> roughxr.reference.tabor(scan.contact.asperities()).tabor_parameter.dims
    ('asperity',)
    """
    ds = schema.validate(ds, "asperities") if "asperity" in ds.dims else asperities(ds)
    radius, modulus = schema.pair(ds, "sphere_radius", "contact_modulus", coated=True)
    A, B = (0.5 * (ds[name].values + 1 / radius) for name in ("curvature_min", "curvature_max"))
    with np.errstate(invalid="ignore", divide="ignore"):
        composite = 0.5 / np.sqrt(A * B)
        each = [
            maugis.tabor(A, B, contact_at_pull_off(composite, work, modulus, film_of(ds))[1], work, length)
            for work, length in pair_attractions(ds)
        ]
    parameter = np.where(A > 0, np.max(each, axis=0), np.nan)
    out = ds.assign(tabor_parameter=("asperity", parameter))
    return schema.record(schema.label(out), "tabor", ds)


def median_tabor(specimen: Specimen, length: float) -> float:
    """Return the median Tabor parameter of the asperities at a range (nm); NaN without a sphere."""
    if specimen.indenter.map:
        return np.nan
    parameter = tabor(specimen.derived(asperities).assign_coords(adhesion_range=length))["tabor_parameter"].values
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
