"""How results depend on assumptions, changed one at a time, and the uncertainty that all of them leave together.

changes        the assumptions that can be changed, by name, and the changed scan and pair
superposed     the pull-off of superposed asperities under each change
simulated      the pull-off of the adhesive simulation under each change, beside the base at the same places
verb           `sensitivity`, by either method
budget         `error_budget`: the known uncertainties of the simulated pull-off
"""

from .budget import budget_of, changes_of, cut_off_waves, error_budget
from .changes import SETTINGS, SIMULATED
from .verb import sensitivity

__all__ = ["SETTINGS", "SIMULATED", "budget_of", "changes_of", "cut_off_waves", "error_budget", "sensitivity"]
