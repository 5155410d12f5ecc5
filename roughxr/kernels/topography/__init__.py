"""Peaks of a height map, the paraboloids fitted to them, and the surface that these alone would make.

peaks, paraboloid   local maxima, and a least-squares paraboloid at each
tile_stitching      the same for a scan that is seen tile by tile
envelope            the upper envelope of many paraboloids
"""
