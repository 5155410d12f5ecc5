"""Asperities: the catalogue of a scan, the sum of their contacts, and the largest pull of that sum.

catalogue       `asperities`: peaks with fitted paraboloids
reconstruction  `reconstruct`: the surface that the catalogue stands for
asperity_sum    a catalogue, pair and options -> plain numbers of all asperities under a sphere
superposition   `superpose`: the sum of single asperities at displacements
maps            `pull_off_map`: the exact pull-off of that sum, up to every pixel
moments         `rolling`: the moment that resists as the sphere begins to roll
expectation     how far superposed pull-offs may be from those of the simulation
"""
