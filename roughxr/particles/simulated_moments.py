"""Resisting moments of the simulation's contacts, or of superposed asperities that touch at the same depth."""

from __future__ import annotations

import warnings

import numpy as np
import xarray as xr

from ..asperity.moments import rolling
from ..bodies.liquid import menisci_of
from ..bodies.pair import range_of
from ..contact.adhesion import adhesive
from ..contact.mesh import Mesh
from ..specimen import Specimen
from ..vocabulary import schema

#: States of the retraction from rest to detachment whose moments are compared, and the most cells to a pixel.
_STATES, _MOST_CELLS = 12, 2

#: Displacements (nm) of places that the simulation did not pull off.
_NOT_PULLED = -1.0, 0.1

#: Ranges of adhesion within which two models touch at the same depth.
_EQUAL_TOUCH = 3.0


def simulated_moments(specimen: Specimen, solved: xr.Dataset, *, directions: int = 24) -> xr.Dataset:
    """Return the resisting moments of the simulation's contacts, in the form of `rolling`.

    Each place of ``solved``, a result of `adhesive` by preload, is retracted again with its fields, from the depth of
    its preload: the levers are those of the patches in contact there.
    """
    places = []
    for k in range(solved.sizes["subregion"]):
        place = solved.isel(subregion=[k])
        low, high = (float(np.ravel(place[f"{name}_delta"].values)[0]) for name in ("detachment", "preload"))
        if not low < high:
            low, high = _NOT_PULLED
        refine, law = int(solved.attrs["refine"]), solved.attrs["law"]
        with warnings.catch_warnings():  # the run has given the warnings of this simulation
            warnings.simplefilter("ignore", UserWarning)
            states = adhesive(
                specimen,
                delta=np.linspace(low, high, _STATES),
                datum="first_contact",
                subregions=place,
                law=law,
                mesh=Mesh(refine=refine if law == "lennard_jones" else min(refine, _MOST_CELLS), step=0.4),
                fields=True,
            )
            places.append(rolling(states, directions=directions))
    out = xr.concat(places, "subregion", combine_attrs="override")
    kept = {name: solved[name] for name in ("subregion", "landing_share") if name in solved.coords}
    out = out.assign_coords(kept)
    return schema.record(schema.label(out), "simulated_moments", specimen.bodies, directions=directions)


def with_equal_touch(superposed: xr.Dataset, touch_delta: xr.DataArray) -> xr.Dataset:
    """Return moments of superposed asperities where these rest within three ranges of the surface's first touch.

    ``touch_delta`` (nm) is that of `rigid` from the highest peak. Elsewhere the contacts of these asperities do not
    exist: their moments and levers are NaN.
    """
    menisci = menisci_of(superposed)
    length = range_of(superposed, "exponential") if menisci is None else menisci.height
    equal = np.abs(superposed["rest_delta"].values - touch_delta.values) <= _EQUAL_TOUCH * length
    lengths = [name for name in superposed.data_vars if "direction" in superposed[name].dims]
    out = superposed.assign({name: superposed[name].where(xr.DataArray(equal, dims="subregion")) for name in lengths})
    out.attrs["places_without_lever"] = int((~equal).sum())
    return out
