"""How particles come to rest and come off: loads at a wall, the strength at which one moves, and how many remain.

coming_to_rest  `resting`: where particles lie still, the share of them that does so, and the pass they leave by
loads       drag, torque and lift in wall shear, weight and tilt, centrifuge, vibration; the table `LOADS`
leaving_rest  `leaving`: the strength at which they leave over the lowest pass
balance     `critical_load`: the strength of a load at which a place gives way, and whether it rolls, slides or lifts
kinetics    Rock'n'Roll: rates of resuspension in turbulence, and adhesion by Biasi's fit
for_codes   `parameters`: the parameters of adhesion that other codes need
particle_codes  `to_dem`: adhesion as lines for the input of other codes
remaining   `resuspension`: the fraction of particles left, from computed moments and pull-off forces

A new load is one function ``(strength, body) -> Push`` and its row in `LOADS`, or a `Load` of one's own.
"""

from .adhesion_parameters import parameters
from .dem import to_dem
from .force_balance import critical_load, with_pull_off
from .kinetics import LogNormal, biasi_adhesion, resuspension_rate, rock_n_roll
from .leaving_rest import leaving
from .loads import LOADS, Body, Flow, Load, Push, drag, friction_reynolds, lift, torque, weight
from .remaining_fraction import resuspension
from .resting_places import resting

__all__ = [
    "LOADS",
    "Body",
    "Flow",
    "Load",
    "LogNormal",
    "Push",
    "biasi_adhesion",
    "critical_load",
    "drag",
    "friction_reynolds",
    "leaving",
    "lift",
    "parameters",
    "resting",
    "resuspension",
    "resuspension_rate",
    "rock_n_roll",
    "to_dem",
    "torque",
    "weight",
    "with_pull_off",
]
