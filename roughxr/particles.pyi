# Public names of `roughxr.particles`, which `lazy_loader` imports on first use.

from .mechanics.particles.adhesion_parameters import parameters as parameters
from .mechanics.particles.dem import to_dem as to_dem
from .mechanics.particles.force_balance import critical_load as critical_load
from .mechanics.particles.kinetics import biasi_adhesion as biasi_adhesion
from .mechanics.particles.kinetics import rock_n_roll as rock_n_roll
from .mechanics.particles.loads import Flow as Flow
from .mechanics.particles.remaining_fraction import resuspension as resuspension
from .mechanics.particles.resting_places import resting as resting
