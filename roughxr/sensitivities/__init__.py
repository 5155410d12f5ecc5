"""What a result hangs on: one assumption changed at a time, and what all of them together leave open.

changes        what can be changed, by name, and how a scan and its pair look then
superposed     the pull-off of superposed asperities under each change
simulated      that of the simulation with adhesion, at a sample of places
verb           `sensitivity`, by either method
budget         `error_budget`: all that is known of how far the simulated pull-off can be trusted
"""

from .budget import cut_off_waves, error_budget
from .changes import SETTINGS, SIMULATED
from .verb import sensitivity

__all__ = ["SETTINGS", "SIMULATED", "cut_off_waves", "error_budget", "sensitivity"]
