"""The pair of bodies: elastic moduli, surface energy, and the indenter, put on a scan as coordinates.

They travel as scalar coordinates through every result into every archive.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from . import schema
from .units import converted, magnitude, positive


def contact_modulus(young_modulus: Any, poisson_ratio: Any) -> float:
    """Return the contact modulus E* of two elastic bodies, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂.

    Parameters
    ----------
    young_modulus : number, quantity or pair of them
        GPa; one value for two equal bodies, ``inf`` for a rigid one.
    poisson_ratio : number or pair of them

    Returns
    -------
    float
        GPa.

    Raises
    ------
    ValueError
        If a modulus is not positive, a ratio outside (−1, 0.5], or both bodies are rigid.

    References
    ----------
    Johnson, Contact Mechanics, eq. 4.22; Cheng, Dunn & Brach below eq. 5.

    Examples
    --------
    >>> round(contact_modulus(75, 0.22), 3)
    39.407
    """
    moduli = [_modulus(value) for value in _two(young_modulus, "young_modulus")]
    ratios = [_ratio(value) for value in _two(poisson_ratio, "poisson_ratio")]
    compliance = sum((1 - ratio**2) / modulus for modulus, ratio in zip(moduli, ratios))
    if compliance == 0:
        raise ValueError("young_modulus: expected at least one elastic body, found two rigid ones")
    return 1 / compliance


def gilman_surface_energy(
    young_modulus: Any,
    *,
    poisson_ratio: float | None = None,
    plane_spacing: Any = 0.2,
    atomic_radius: Any = 0.13,
) -> float:
    """Return Gilman's estimate of the surface energy from the stiffness, γ = (E/y₀)(a₀/π)².

    Parameters
    ----------
    young_modulus : number or quantity
        E, GPa.
    poisson_ratio : float, optional
        Where given, E/(1 − ν²) stands for E. The published pull-off of the smooth sphere, 19.1 µN, takes this
        reading; the equation as printed takes E.
    plane_spacing : number or quantity
        y₀ between cleavage planes, nm.
    atomic_radius : number or quantity
        a₀ of the atoms in these planes, nm.

    Returns
    -------
    float
        γ, J/m².

    References
    ----------
    Gilman (1960); Cheng, Dunn & Brach eq. 43.

    Examples
    --------
    >>> round(gilman_surface_energy(75), 4), round(gilman_surface_energy(75, poisson_ratio=0.22), 4)
    (0.6421, 0.6748)
    """
    modulus = positive(young_modulus, "GPa", "young_modulus")
    if poisson_ratio is not None:
        modulus /= 1 - _ratio(poisson_ratio) ** 2
    spacing = positive(plane_spacing, "nm", "plane_spacing")
    return modulus / spacing * (positive(atomic_radius, "nm", "atomic_radius") / np.pi) ** 2


def assign_pair(
    ds: xr.Dataset,
    *,
    sphere_radius: Any = None,
    indenter: xr.DataArray | None = None,
    young_modulus: Any = None,
    poisson_ratio: Any = None,
    contact_modulus: Any = None,
    surface_energy: Any = None,
    work_of_adhesion: Any = None,
) -> xr.Dataset:
    """Return the scan or catalogue with the pair of bodies on it.

    Parameters
    ----------
    ds : Dataset
        A scan or an asperity catalogue.
    sphere_radius : number or quantity
        nm. Either this or ``indenter``.
    indenter : DataArray
        Heights (x, y) of the indenter, pointing out of it, nm or with ``units``; x, y (nm) are counted from
        the contact centre along the scan's axes.
    young_modulus, poisson_ratio : number or pair
        Of both bodies alike, or of each; GPa. Either these or ``contact_modulus``.
    contact_modulus : number or quantity
        E*, GPa.
    surface_energy : number or quantity, optional
        γ of two equal bodies, J/m²; the work of adhesion is 2γ.
    work_of_adhesion : number or quantity, optional
        w, J/m².

    Returns
    -------
    Dataset
        With scalar coordinates ``sphere_radius``, ``contact_modulus``, ``work_of_adhesion``, as far as given,
        and the indenter's map where there is one.

    Raises
    ------
    ValueError
        If a quantity is given twice or not at all, or is not a positive number (w may be zero).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> pair = assign_pair(scan, sphere_radius="3 um", young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> float(pair.sphere_radius), round(float(pair.contact_modulus), 3), float(pair.work_of_adhesion)
    (3000.0, 39.407, 1.35)
    """
    _one_of("sphere_radius", sphere_radius, "indenter", indenter)
    _one_of("contact_modulus", contact_modulus, "young_modulus and poisson_ratio", young_modulus)
    values = {"contact_modulus": _contact_modulus(contact_modulus, young_modulus, poisson_ratio)}
    if sphere_radius is not None:
        values["sphere_radius"] = positive(sphere_radius, "nm", "sphere_radius")
    adhesion = _work_of_adhesion(surface_energy, work_of_adhesion)
    if adhesion is not None:
        values["work_of_adhesion"] = adhesion
    out = ds.drop_vars([*schema.PAIR, "indenter_height", "indenter_x", "indenter_y"], errors="ignore")
    out = out.assign_coords(values)
    if indenter is not None:
        out = out.assign(indenter_height=_indenter(indenter))
    return schema.record(schema.label(out), "assign_pair", **values)


def indenter_map(ds: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return x, y and height (nm) of the assigned indenter's map, or None where a sphere is assigned."""
    if "indenter_height" not in ds:
        return None
    return tuple(ds[name].values.astype(float) for name in ("indenter_x", "indenter_y", "indenter_height"))


def _contact_modulus(given: Any, young_modulus: Any, poisson_ratio: Any) -> float:
    if given is not None:
        return positive(given, "GPa", "contact_modulus")
    if poisson_ratio is None:
        raise ValueError("poisson_ratio: expected one beside young_modulus, found none")
    return contact_modulus(young_modulus, poisson_ratio)


def _work_of_adhesion(surface_energy: Any, work_of_adhesion: Any) -> float | None:
    if surface_energy is not None and work_of_adhesion is not None:
        raise ValueError("expected surface_energy or work_of_adhesion (= 2 surface_energy), found both")
    if surface_energy is None and work_of_adhesion is None:
        return None
    given, times = (work_of_adhesion, 1.0) if surface_energy is None else (surface_energy, 2.0)
    value = magnitude(given, "J m-2", "surface_energy" if times == 2.0 else "work_of_adhesion")
    if not isinstance(value, float) or value < 0:
        raise ValueError(f"surface energy: expected one number >= 0 in J m-2, found {given!r}")
    return times * value


def _indenter(indenter: xr.DataArray) -> xr.DataArray:
    """Return the indenter's map on its own dimensions, in nm."""
    if not isinstance(indenter, xr.DataArray) or set(indenter.dims) != {"x", "y"}:
        raise ValueError("indenter: expected a DataArray of heights with dimensions ('x', 'y')")
    if "units" in indenter.attrs:
        indenter = converted(indenter, "nm", "indenter")
    for axis in ("x", "y"):
        schema.spacing(indenter[axis])
    schema.finite(indenter.values)
    return indenter.transpose("x", "y").rename(x="indenter_x", y="indenter_y").reset_coords(drop=True)


def _one_of(name: str, value: Any, other: str, other_value: Any) -> None:
    if (value is None) == (other_value is None):
        found = "neither" if value is None else "both"
        raise ValueError(f"expected either {name} or {other}, found {found}")


def _two(value: Any, name: str) -> tuple[Any, Any]:
    if isinstance(value, (tuple, list)):
        if len(value) != 2:
            raise ValueError(f"{name}: expected one value or a pair, found {len(value)}")
        return tuple(value)
    return value, value


def _modulus(value: Any) -> float:
    return np.inf if value == np.inf else positive(value, "GPa", "young_modulus")


def _ratio(value: Any) -> float:
    ratio = magnitude(value, "1", "poisson_ratio")
    if not isinstance(ratio, float) or not -1 < ratio <= 0.5:
        raise ValueError(f"poisson_ratio: expected a number in (-1, 0.5], found {value!r}")
    return ratio
