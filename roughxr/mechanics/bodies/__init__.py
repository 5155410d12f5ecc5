"""The pair of bodies: elastic constants, adhesion, condensed liquid, and rough indenters.

pair         `assign_pair`: moduli, adhesion and its range, hardness
pair_record  the assigned pair as plain numbers, as every solver takes it
liquid       menisci that condense between the bodies in humid air
substances   the table of named materials
indenter     rough indenters from scans
"""
