"""Adhesion between a rigid profile and the half space, followed through loading and retraction.

cohesive_laws       traction across a gap, and the work left to separate the surfaces from it
constrained_cells   cells held at a prescribed gap, and the pressures that hold them
capped_cells        the same for a body that yields: the depth by which each cell gives way
contact_patches     connected contacts, and the curvature of their outlines
equilibrium         a local minimum of the energy at a fixed displacement
path                loading and retraction, state by state
smooth_laws, …      the same for laws of finite range, all cells at once: smooth_equilibrium, smooth_path,
                    smooth_prediction (a guess of the next state), smooth_patches, newton_system
potentials          attraction across a gap between bodies too stiff to deform
rigid               the pull of a rigid body on a rough half space, at one place or at all
tuning              the chosen constants of the cell-by-cell solver
"""
