"""The physics, on plain float64 arrays without labels.

Every kernel file opens with its equation and source, then goes from primitives to one item to a loop
over items. Units are coherent nano-units throughout (nm, nN, GPa = nN/nm², J/m² = nN/nm), so no
conversion factor occurs. Kernels never raise: a solver returns a NamedTuple that carries its status.
"""
