"""Particles on a surface: resting positions, loads, detachment, and the fraction that remains.

resting_places       `resting`: resting positions, the share of particles at each, and the lowest pass
loads                drag, torque and lift in wall shear, weight and tilt, centrifuge, vibration; the table `LOADS`
force_balance        `critical_load`: strength of a load at which the sphere rolls, slides or lifts
removal              `removing_load`: strength of a load that removes a share of the particles
kinetics             Rock'n'Roll: rates of resuspension in turbulence, and adhesion by Biasi's fit
adhesion_parameters  `parameters`: the parameters of adhesion for other codes
remaining_fraction   `resuspension`: the fraction of particles that remain, from computed moments and pull-off forces
"""

from .adhesion_parameters import parameters
from .force_balance import critical_load
from .kinetics import biasi_adhesion, rock_n_roll
from .loads import Flow
from .remaining_fraction import resuspension
from .removal import removing_load
from .resting_places import resting

__all__ = [
    "Flow",
    "biasi_adhesion",
    "critical_load",
    "parameters",
    "removing_load",
    "resting",
    "resuspension",
    "rock_n_roll",
]
