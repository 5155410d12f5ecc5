"""Particles on a surface: resting positions, loads, detachment, and the fraction that remains."""

from .mechanics.particles.adhesion_parameters import parameters
from .mechanics.particles.dem import to_dem
from .mechanics.particles.force_balance import critical_load
from .mechanics.particles.kinetics import biasi_adhesion, rock_n_roll
from .mechanics.particles.loads import Flow
from .mechanics.particles.remaining_fraction import resuspension
from .mechanics.particles.removal import removing_load
from .mechanics.particles.resting_places import resting

__all__ = [
    "Flow",
    "biasi_adhesion",
    "critical_load",
    "parameters",
    "removing_load",
    "resting",
    "resuspension",
    "rock_n_roll",
    "to_dem",
]
