"""Resisting moments of the simulation's own contacts, or of those of rigid bodies."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

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

    def states(place: xr.Dataset) -> xr.Dataset:
        low, high = (float(np.ravel(place[f"{name}_delta"].values)[0]) for name in ("detachment", "preload"))
        refine, law = int(place["refinement"].max()), solved.attrs["law"]
        mesh = Mesh(refine=refine if law == "lennard_jones" else min(refine, _MOST_CELLS), step=0.4)
        deltas = np.linspace(*((low, high) if low < high else _NOT_PULLED), _STATES)
        return adhesive(
            specimen, delta=deltas, datum="first_contact", subregions=place, law=law, mesh=mesh, fields=True
        )

    return _moments(states, specimen, solved, "simulated_moments", directions)


def rigid_moments(specimen: Specimen, positions: xr.Dataset, *, directions: int = 24) -> xr.Dataset:
    """Return the resisting moments of the contacts of rigid bodies at their closest approach, in the form of `rolling`.

    For pairs whose liquid, or stiffness, makes the adhesive simulation slow.
    """
    closest = floor(options_of(specimen, "hamaker").law)
    options: dict[str, Any] = {"delta": [-closest], "datum": "first_contact", "refine": _RIGID_CELLS, "fields": True}
    return _moments(
        lambda place: rigid(specimen, subregions=place, **options), specimen, positions, "rigid_moments", directions
    )


def _moments(
    states: Callable[[xr.Dataset], xr.Dataset], specimen: Specimen, positions: xr.Dataset, verb: str, directions: int
) -> xr.Dataset:
    """Return the moments of the states at each place, with the places' own coordinates."""
    places = []
    with warnings.catch_warnings():  # the run has given the warnings of these solves
        warnings.simplefilter("ignore", UserWarning)
        for k in range(positions.sizes["subregion"]):
            places.append(rolling(states(positions.isel(subregion=[k])), directions=directions))
    out = xr.concat(places, "subregion", combine_attrs="override")
    shared = {name: positions[name] for name in ("subregion", "landing_share") if name in positions.coords}
    return schema.record(schema.label(out.assign_coords(shared)), verb, specimen.bodies, directions=directions)
