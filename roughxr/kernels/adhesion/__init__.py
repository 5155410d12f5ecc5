"""Adhesion between a rigid profile and the half space, followed through loading and retraction.

cohesive_laws       traction across a gap, and the work it still takes to open it
constrained_cells   cells held at a prescribed gap, and the pressures that do it
capped_cells        the same of a body that yields: how far each gives way
contact_patches     which cells form which contact, and how curved its outline is
equilibrium         a local minimum of the energy at a fixed displacement
path                loading and retraction, state by state
smooth_laws, …      the same for laws of finite range, all cells at once: smooth_equilibrium, smooth_path,
                    smooth_prediction (a guess of the next state), smooth_patches, newton_system
potentials          attraction across a gap that bodies too stiff to bend keep
rigid               the pull of a rigid body on a rough half space, at one place or at all
tuning              every chosen number of the cell-by-cell solver
"""
