"""Studies: many solutions for one question.

parameter_grid      `vary`: a verb over a grid of properties of the pair
extrapolation       `extrapolated`: the pull-off with the roughness below the pixel
finer_scan          a second scan, without its noise, as it is and as the first would show it
uncertainty_budget  `error_budget`: known uncertainties of the simulated pull-off and their sources
assumptions         the assumptions that the budget changes
budget_changes      the change of the pull-off under each
comparison          `compare`: measured and predicted forces
fitting, likelihood `fit_pair`: the work of adhesion by measured forces
"""
