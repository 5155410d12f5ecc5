"""The two bodies: what they are made of, and what is pressed on.

materials   `assign_pair`: moduli, adhesion and its range, hardness
liquid      what condenses between them in humid air
substances  the table of named materials
probes      an indenter from its own scan
"""
