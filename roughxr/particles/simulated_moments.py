"""Resisting moments of the simulation's own contacts, or of those of rigid bodies."""

from __future__ import annotations

import warnings

import numpy as np
import xarray as xr

from ..asperity.moments import rolling
from ..contact.adhesion import adhesive
from ..contact.mesh import Mesh
from ..contact.rigid.attraction import options_of
from ..contact.rigid.bodies import rigid
from ..kernels.adhesion.rigid import floor
from ..specimen import Specimen
from ..vocabulary import schema

#: States of the retraction from rest to detachment whose moments are compared, and the most cells to a pixel.
_STATES, _MOST_CELLS = 12, 2

#: Displacements (nm) of places that the simulation did not pull off.
_NOT_PULLED = -1.0, 0.1

#: Cells to a pixel between rigid bodies: their supports are told apart by fractions of a nanometre.
_RIGID_CELLS = 4


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
        refine, law = int(place["refinement"].max()), solved.attrs["law"]
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
    return _of_places(specimen, solved, places, "simulated_moments", directions)


def rigid_moments(specimen: Specimen, positions: xr.Dataset, *, directions: int = 24) -> xr.Dataset:
    """Return the resisting moments of the contacts of rigid bodies at their closest approach, in the form of `rolling`.

    For pairs whose liquid, or stiffness, makes the adhesive simulation slow.
    """
    closest = floor(options_of(specimen, "hamaker").law)
    places = []
    for k in range(positions.sizes["subregion"]):
        with warnings.catch_warnings():  # the run has given the warnings of these sums
            warnings.simplefilter("ignore", UserWarning)
            states = rigid(
                specimen,
                delta=[-closest],
                datum="first_contact",
                subregions=positions.isel(subregion=[k]),
                refine=_RIGID_CELLS,
                fields=True,
            )
            places.append(rolling(states, directions=directions))
    return _of_places(specimen, positions, places, "rigid_moments", directions)


def _of_places(
    specimen: Specimen, positions: xr.Dataset, places: list[xr.Dataset], verb: str, directions: int
) -> xr.Dataset:
    """Return the moments of single places, one after the other, with the places' own coordinates."""
    out = xr.concat(places, "subregion", combine_attrs="override")
    shared = {name: positions[name] for name in ("subregion", "landing_share") if name in positions.coords}
    return schema.record(schema.label(out.assign_coords(shared)), verb, specimen.bodies, directions=directions)
