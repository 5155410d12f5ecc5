"""The pair of bodies: elastic constants, adhesion, condensed liquid, and rough indenters.

pair        `assign_pair`: moduli, adhesion and its range, hardness
liquid      menisci that condense between the bodies in humid air
substances  the table of named materials
indenter    rough indenters from scans
"""
