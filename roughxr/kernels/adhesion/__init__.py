"""Adhesion between a rigid profile and the half space, followed through loading and retraction.

cohesive_laws       traction across a gap, and the work it still takes to open it
constrained_cells   cells held at a prescribed gap, and the pressures that do it
contact_patches     which cells form which contact, and how curved its outline is
equilibrium         a local minimum of the energy at a fixed displacement
path                loading and retraction, state by state
potentials          attraction across a gap that bodies too stiff to bend keep
rigid               the pull of a rigid body on a rough half space, at one place or at all
"""
