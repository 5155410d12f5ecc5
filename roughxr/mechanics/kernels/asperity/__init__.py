"""One asperity, an elliptic paraboloid, in closed form or from a table, and sums over many of them.

ellipse                      elliptic integrals, Hertz's contact
jkr                          the JKR sphere, and ellipses that keep Hertz's shape
elliptic_jkr, elliptic_table adhesive ellipses of free shape, computed and tabulated
maugis                       Maugis's transition between JKR and DMT
asperity_laws                all of these under one name each
branches                     an asperity at many displacements
contact_sums                 the sum over asperities under a sphere
pull_off_search              the exact pull-off force of such a sum
rotation                     the moment that resists rolling off the asperities
"""
