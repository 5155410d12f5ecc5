"""Peaks of a height map, the paraboloids fitted to them, and the surface that these paraboloids make up.

peaks, paraboloid   local maxima, and a least-squares paraboloid at each
envelope            the upper envelope of many paraboloids
random_surface      Gaussian surfaces of a given spectrum
"""
