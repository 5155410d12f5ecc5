"""The elastic half space: what pressures do to it, and its contact with a rigid profile, without adhesion.

love                   displacement of a uniformly loaded square
transforms, products   u = A p, by fast transforms or by a matrix
separation             the undeformed gap between indenter and surface
active_set             which of a list of cells touch, and how hard
working_set            which cells of a window the active set must know
warm_start             what a contact will look like, before it is solved
displacement_control   contact at a displacement, or through a sweep
load_control           contact under a load
yielding               what a contact that yields leaves behind
"""
