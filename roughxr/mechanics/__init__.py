"""Mechanics: from a scan and a pair of bodies to datasets of numbers; no file, no figure, no sentence.

vocabulary     names and units, validation, history, refusals
kernels        plain arrays: elastic half space, adhesion, asperities, topography
scans, bodies  levelling, regions, tip, spectra, made surfaces; pair, liquid, layer, indenter
jobs           a task for each subregion, and labelled results; progress
specimen       a scan and its pair as plain values
asperity       catalogue, superposition, maps, moments
contact        `direct`, `adhesive`, `rigid`; formulas and their range; certificate
statistics     pull-off, densities, fits, bootstrap, means with their errors
particles      resting positions, loads, detachment, resuspension
studies        error budget, best estimate, grids; measured forces beside predictions, fits of the pair
"""
