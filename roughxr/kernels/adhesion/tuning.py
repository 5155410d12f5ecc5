"""Every number of the adhesive solver that was chosen, and what each gains.

The first group enters the results, the second decides how closely a path is followed, the third only how long that
takes. ``python tests/benchmarks/line_tension.py`` shows of the first, but for CORE, what each number is found from and
what the error of the pull-off is with more or less of it. Its fit of LINE and NARROW is of first order: with --quick it
gives 0.49 and 2.1, more than stands here, with which spheres of 2.5 to 6 cells pull 1 to 1.6 % too hard.
"""

# --- The traction between cells in the Griffith limit (``cohesive_laws``, ``contact_patches``) -----------------------

#: How fast a traction falls with the gap on a mesh, in E*/dx. An edge row along the grid resists with 0.58: faster
#: than that and cells let go one by one, so that the pull-off hangs on where a contact stands on the grid; much slower
#: and the zone in which they let go is too wide for narrow contacts.
SOFTENING = 0.3

#: What that zone costs per length of the outline, in w times a cell: at a radius of ten cells 3 % of w is taken back.
LINE = 0.37

#: Radius in cells that is added to a contact's, since the zone cannot be wider than the contact: at 2.5 cells 9 % of w
#: is taken back, which would be 15 % without.
NARROW = 1.6

#: Power of the lengthening with which an adhesive ellipse's dL/dA grows (``contact_patches``).
LENGTHENING_POWER = 5.0 / 3.0

#: Part of a cell that must be closed for it to belong to the core of a contact patch: two patches that are about to
#: merge count as two until there is a bridge.
CORE = 0.2

# --- How closely a path is followed (``path``) -----------------------------------------------------------------------

#: A step past the end of a branch that frees more than this many cells' w is halved, so that jumps begin where due.
JUMP = 0.02

#: How much of the largest pull may be missed between two states: the largest pull is then right to this part.
MISSED = 0.003

#: By how much of the largest pull the pull may at most grow in the shortest step: no halving for less.
LEAST_GROWTH = 0.002

#: No step is halved that is shorter than this part of the longest: an end to halving.
LEAST_STEP = 1e-4

#: A state is found again while the root of a cell's factor on w changes by more than this: the toughness of the
#: outline and the outline agree to it.
SAME_ROOT = 1e-3

#: At most so often, and from the second on by less and less of the change: two patches that are about to merge may go
#: to and fro between the toughness of one and of two for ever.
MOST_UPDATES, UNDAMPED_UPDATES = 60, 20

# --- What it costs (``equilibrium``, ``path``) -----------------------------------------------------------------------

#: A cell leaves the set once its gap is this many times the law's range: less, and cells come and go.
RELEASE = 1.2

#: Times that a state takes in others before it is given up as not converged.
MOST_JOININGS = 60

#: Sweeps of single cells past the end of a branch, where Newton's method is of no use, until it is tried again.
SWEEPS_PAST_END = 10

#: Cells that Newton's method balances together at most: their matrix takes 46 MB. More are balanced one by one.
NEWTON_CELLS = 2400

#: Contacts with a smaller part of the whole tension than this do not count for the resolution that is reported.
BEARING_SHARE = 0.1
