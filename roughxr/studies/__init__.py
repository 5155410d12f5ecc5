"""Studies: many solves for one question.

parameter_grid  `vary`: a verb over a grid of properties of the pair
several_scans   `over_scans`: a verb over several scans
short_waves     `scale_dependence`: what waves shorter than the scan shows do
sensitivities   `sensitivity`, `error_budget`: what an assumption does to the pull-off
"""
