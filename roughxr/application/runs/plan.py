"""The plan of a run: places, displacements, mesh and what else was chosen."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.contact.adhesive_options import LONG_STEP, usual_step
from ...mechanics.contact.mesh import Mesh
from ...mechanics.contact.problem import default_datum, default_deltas
from ...mechanics.particles.loads import Flow
from ...mechanics.specimen import Specimen
from ...mechanics.vocabulary import schema


class Plan(NamedTuple):
    """The options of a run."""

    subregions: Any
    direct_deltas: np.ndarray  # nm, of the simulation without adhesion
    contact_delta: float  # nm, for the one contact with fields, on the datum of the simulation without adhesion
    sweep: np.ndarray | None = None  # nm, for superpositions; None: those of `superpose`
    datum: str = "highest_peak"  # of the simulation without adhesion
    superposed: tuple[str, ...] = ("energy",)  # formulations; the first one chooses the catalogue of the run
    preload: float = 0.0  # nN, of the adhesive simulation; 0: the sphere settles under its own adhesion
    law: str = "auto"
    mesh: Mesh = Mesh()
    checked: int = 4  # places also solved on a mesh twice as fine with half the steps
    budget: int = 8  # places solved again under each change of the error budget; 0: no budget
    directions: int = 24  # of rolling, in which resisting moments are computed; 0: no detachment
    finer: xr.Dataset | None = None  # a second scan of the surface on finer pixels
    shortest: float | None = None  # nm, shortest wavelength of the surface, where it is known
    flow: str | Flow = "air"  # the fluid that detaches the sphere


def plan(specimen: Specimen, *, subregions: Any = (8, 8), delta: Any = None, **adhesion: Any) -> Plan:
    """Return a plan whose displacements suit the heights of a scan."""
    centres = specimen.centres(subregions)
    datum = "highest_peak" if delta is not None else default_datum(specimen)
    deltas = default_deltas(specimen, centres, datum) if delta is None else schema.ascending(delta, "nm", "delta")
    options: dict[str, Any] = {"mesh": usual_mesh(specimen), "datum": datum} | adhesion
    return Plan(subregions, deltas, float(deltas[-1]), **options)


def usual_mesh(specimen: Specimen) -> Mesh:
    """Return the mesh of a run for which none is stated: with long steps, where anything attracts."""
    return Mesh(step=LONG_STEP * usual_step(specimen)) if specimen.pair.work > 0 else Mesh()
