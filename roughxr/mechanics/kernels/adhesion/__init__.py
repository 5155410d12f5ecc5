"""Adhesion between a rigid profile and the half space, followed through loading and retraction.

traction_laws   traction across a gap, and the work left to separate the surfaces from it
equilibrium     a local minimum of the energy at a fixed displacement, all cells at once
newton_system   the linear systems of its steps
patches         the number of contacts, and their resolution by the mesh
states          a state from the state before it, and plastic yielding
steps           the states of a path, and the steps between them
retraction      from a turning point until contact is lost, with the largest tension
path            loading and retraction, state by state
potentials      attraction across a gap between bodies too stiff to deform
rigid           the attraction between a rigid body and a rough half space
"""
