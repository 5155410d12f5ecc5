"""Studies: many solves for one question.

parameter_grid  `vary`: a verb over a grid of properties of the pair
short_waves     `scale_dependence`: what waves shorter than the scan shows do
uncertainty_budget  `error_budget`: known uncertainties of the simulated pull-off and their sources
assumptions, budget_changes   the assumptions that it changes, and the pull-off under each change
"""
