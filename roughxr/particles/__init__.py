"""How particles come to rest and detach: loads at a wall, the strength at which one moves, and how many remain.

resting_places       `resting`: where particles lie still, their share at each place, and the lowest pass
loads                drag, torque and lift in wall shear, weight and tilt, centrifuge, vibration; the table `LOADS`
force_balance        `critical_load`: strength of a load at which the sphere rolls, slides or lifts
kinetics             Rock'n'Roll: rates of resuspension in turbulence, and adhesion by Biasi's fit
adhesion_parameters  `parameters`: the parameters of adhesion that other codes need
dem                  `to_dem`: adhesion as input for LAMMPS, or the distribution of the pull-off as a table
remaining_fraction   `resuspension`: the fraction of particles left, from computed moments and pull-off forces
"""

from .adhesion_parameters import parameters
from .dem import to_dem
from .force_balance import critical_load
from .kinetics import biasi_adhesion, rock_n_roll
from .loads import Flow
from .remaining_fraction import resuspension
from .resting_places import resting

__all__ = [
    "Flow",
    "biasi_adhesion",
    "critical_load",
    "parameters",
    "resting",
    "resuspension",
    "rock_n_roll",
    "to_dem",
]
