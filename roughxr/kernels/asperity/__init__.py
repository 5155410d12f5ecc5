"""One asperity, an elliptic paraboloid, in closed form or from a table, and sums over many of them.

ellipse                      elliptic integrals, Hertz's contact
jkr                          the JKR sphere, and ellipses that keep Hertz's shape
elliptic_jkr, elliptic_table adhesive ellipses of free shape, computed and tabulated
maugis                       between JKR and DMT
laws                         all of them under one name each
force_curves                 one asperity at many displacements
superposition                the sum over asperities under one sphere
largest_pull                 the largest pull of such a sum, found exactly
"""
