"""A layer bonded to the scan's body, and the base below it, as every verb reads them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.calls import checked_class
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantity
from .substances import materials

if TYPE_CHECKING:
    from ..kernels.halfspace.layered import Film

#: Coordinates of a layer and of its base, and those of a pair that are moduli.
_COORDINATES = ("layer_thickness", "layer_modulus", "layer_poisson_ratio", "base_modulus", "base_poisson_ratio")
MODULI = ("contact_modulus", "layer_modulus", "base_modulus")


@checked_class
@dataclass(frozen=True)
class Layer:
    """A homogeneous layer bonded to the scan's body, for `assign_pair`.

    Parameters
    ----------
    thickness : number or quantity
        nm.
    material : str, optional
        Name of its material; or its moduli:
    young_modulus : number or quantity, optional
        GPa.
    poisson_ratio : number, optional

    Examples
    --------
    >>> import roughxr
    >>> oxide = roughxr.Layer("50 nm", "silica")
    >>> gel = roughxr.Layer(200, young_modulus="2 MPa", poisson_ratio=0.5)
    >>> oxide.material, gel.thickness
    ('silica', 200)
    """

    thickness: Quantity
    material: str | None = None
    young_modulus: Quantity | None = None
    poisson_ratio: Quantity | None = None


def read_layer(layer: Layer | str) -> Layer:
    """Return a layer, also of text such as "5 nm silica", its thickness and material; raise if it is neither."""
    if isinstance(layer, Layer):
        return layer
    thickness, _, material = str(layer).strip().rpartition(" ")
    material = material.lower()
    if not isinstance(layer, str) or not thickness or material not in materials():
        raise Refusal(
            "layer",
            f"thickness and one of {', '.join(materials())}, such as '5 nm silica'",
            f"{layer!r}",
            "in Python, make a layer of another material with roughxr.Layer",
        )
    return Layer(thickness, material)


def film_of(ds: xr.Dataset) -> Film | None:
    """Return the layer of a pair as kernels take it, its thickness in nm; None on a half space."""
    if not schema.is_coated(ds):
        return None
    from ..kernels.halfspace.layered import Film  # not at the top: words of a pair are checked without SciPy

    thickness, modulus, ratio, base, base_ratio = (float(ds[name]) for name in _COORDINATES)
    share = float(ds["contact_modulus"]) * (1 - ratio**2) / modulus
    if not 0 < share <= 1 + 1e-9:
        raise Refusal(
            "contact_modulus",
            f"at most the layer's {modulus / (1 - ratio**2):.4g} GPa",
            f"{float(ds['contact_modulus']):.4g} GPa",
            "assign the pair with its layer anew",
        )
    return Film(thickness, share, modulus * (1 + base_ratio) / (base * (1 + ratio)), ratio, base_ratio)


def stiffened(ds: xr.Dataset, factor: float) -> dict[str, float]:
    """Return all moduli of a pair, multiplied by a factor."""
    return {name: float(ds[name]) * factor for name in MODULI if name in ds.coords}


def need_computable(film: Film, width: float, *, yields: bool) -> None:
    """Raise where a layer (nm) is too thin for its rigid base on a scan of this width (nm), or bulges and yields."""
    if yields and film.bulges:
        raise Refusal(
            "hardness",
            "none with a nearly incompressible layer, which bulges beside the contact",
            advice="leave it out",
        )
    # least F at the scan's width that is computed well enough: below, the layer is too thin for its rigid base
    if film.compliance(2 * np.pi * film.thickness / width) < 1e-8:
        raise Refusal(
            "layer",
            f"an elastic base below a layer of {film.thickness:.3g} nm on a scan of {width:.3g} nm",
            "a rigid one",
            "give its moduli, or crop the scan",
        )


def largest_contact(ds: xr.Dataset) -> float:
    """Return the largest contact radius (nm) for which the layer of a coated pair counts as a half space."""
    return 0.1 * float(ds["layer_thickness"])


def need_small_contacts(ds: xr.Dataset, radius: float) -> None:
    """Raise unless contacts of a radius (nm) are far smaller than the layer, which then counts as a half space."""
    limit = largest_contact(ds)
    if not radius <= limit:
        raise Refusal(
            "layer",
            f"contacts up to {limit:.3g} nm, for which it counts as a half space",
            f"{radius:.3g} nm (JKR's at pull-off, of the median asperity)",
            "take direct or adhesive",
        )
