"""Asperities: the catalogue of a scan, the sum of their contacts, and the pull-off of that sum.

catalogue       `asperities`: peaks with fitted paraboloids
reconstruction  `reconstruct`: the surface made of these paraboloids
asperity_sum    a catalogue, pair and options as plain numbers of all asperities under a sphere
superposition   `superpose`: the sum of single asperities at displacements
pull_off_maps   `pull_off_map`: the exact pull-off of that sum, up to every pixel
moments         `rolling`: the moment that resists as the sphere begins to roll
expectation     the expected ratio of superposed pull-offs to those of the simulation
"""
