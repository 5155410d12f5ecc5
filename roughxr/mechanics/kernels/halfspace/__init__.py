"""The elastic half space: its displacement under pressures, and its contact with a rigid profile, without adhesion.

love                   displacement of a uniformly loaded square
transforms, products   u = A p, by fast transforms or by a matrix
separation             the undeformed gap between indenter and surface
active_set             the touching cells of a list, and their pressures
working_set            the cells of a box that the active set must include, and a first guess by coarser cells
displacement_control   contact at a displacement, or through a sweep
load_control           contact under a load
yielding               the residual heights of a contact that yields
"""
