"""The chosen constants of the cell-by-cell solver, and the reason for each value.

The first group affects the results, the second how closely a path is followed, the third only the time. For the first
group except CORE, ``python tests/benchmarks/line_tension.py`` shows what each constant is found from, and the error of
the pull-off for larger and smaller values. Its fit of LINE and NARROW is of first order: with --quick it gives 0.49 and
2.1, more than the values here; with those, spheres of 2.5 to 6 cells pull 1 to 1.6 % too hard.
"""

# --- The traction between cells in the Griffith limit (``cohesive_laws``, ``contact_patches``) -----------------------

#: Slope at which a traction falls with the gap on a mesh, in E*/dx. An edge row along the grid resists with 0.58: with
#: a steeper slope cells let go one by one, so that the pull-off depends on the position of a contact on the grid; with
#: a much smaller one the zone that lets go is too wide for narrow contacts.
SOFTENING = 0.3

#: Cost of that zone per length of the outline, in w times a cell: at a radius of ten cells 3 % of w is subtracted.
LINE = 0.37

#: Radius in cells that is added to a contact's, since the zone cannot be wider than the contact: at 2.5 cells 9 % of w
#: is subtracted, which would be 15 % without it.
NARROW = 1.6

#: Power of the lengthening of an ellipse's outline with which its dL/dA grows (``contact_patches``).
LENGTHENING_POWER = 5.0 / 3.0

#: Closed fraction above which a cell belongs to the core of a contact patch: two patches that are about to merge count
#: as two until there is a bridge.
CORE = 0.2

# --- How closely a path is followed (``path``) -----------------------------------------------------------------------

#: A step past the end of a branch that releases more than w of this many cells is halved: jumps begin where due.
JUMP = 0.02

#: Largest part of the largest pull that may be missed between two states, and so its relative error.
MISSED = 0.003

#: Largest growth of the pull, in parts of the largest, in the shortest step: steps are not halved for less.
LEAST_GROWTH = 0.002

#: Steps shorter than this part of the longest are not halved any more.
LEAST_STEP = 1e-4

#: A state is solved again while the root of a cell's factor on w changes by more than this, until the toughness agrees
#: with the outline.
SAME_ROOT = 1e-3

#: Largest number of such updates, and the number after which only a decreasing part of the change is applied: two
#: patches that are about to merge may otherwise alternate between the toughness of one and of two for ever.
MOST_UPDATES, UNDAMPED_UPDATES = 60, 20

# --- What it costs (``equilibrium``, ``path``) -----------------------------------------------------------------------

#: A cell leaves the set once its gap is this many times the law's range: with less, cells come and go.
RELEASE = 1.2

#: Number of times that cells may join a state before it is given up as not converged.
MOST_JOININGS = 60

#: Sweeps of single cells past the end of a branch, where Newton's method does not work, before it is tried again.
SWEEPS_PAST_END = 10

#: Largest number of cells that Newton's method balances together: their matrix takes 46 MB. More are balanced singly.
NEWTON_CELLS = 2400

#: Newton's step is solved exactly for fewer open cells than this, for more to this part of the right side: with a third
#: more steps a place of 250 open cells takes half the time, one of 700 a third.
FEW_OPEN, OPEN_PART = 100, 1e-3

#: Contacts with a smaller part of the whole tension than this do not count for the reported resolution.
BEARING_SHARE = 0.1
