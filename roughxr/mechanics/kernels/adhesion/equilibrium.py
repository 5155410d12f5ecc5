"""Equilibrium at one displacement: p + t(g) = 0 where surfaces attract, g = 0 and p + t(0) ≥ 0 where they touch.

The gap of every cell follows from the pressures, g = S − δ + A p. Two kinds of steps improve a guess, each with a
linear system (``newton_system``):

Newton's       linearises t. It converges quadratically near the solution, and is taken if it lowers the potential,
               which follows without another product.
tangent        keeps t fixed (τ = 0). As the energy of adhesion −W(u) is concave, the energy with the tangent in place
               of −W is an upper bound, so that its minimum is a descent from any state ("convex-concave procedure",
               Yuille & Rangarajan 2003). This step leads from the end of a branch to the next branch.

After each step, the attracting cells get the traction at their new gap. Cells so far apart that their traction hardly
changes with the gap (``_SMALLEST_SLOPE``) are left out of the systems, and their tractions updated with their gaps.

Gaps are computed by transforms in single precision, until the residual is so small that rounding would matter.
Unit cells and unit modulus.
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.active_set import PATIENCE
from ..halfspace.active_set import solve as solve_contact
from ..halfspace.products import displaced
from ..halfspace.transforms import Convolution, convolve
from ..jit import kernel
from .newton_system import operator_on, solve, workspace
from .traction_laws import SmoothLaw, remaining_work, traction, traction_and_work

#: Cells are left out of the linear systems if |dt/du| is at most this, in units of a cell's stiffness (about 1).
_SMALLEST_SLOPE = 1e-3

#: Residual, over the largest traction, above which only tangent steps are taken.
_TANGENT_RESIDUAL = 1.0

#: Residual, over the largest traction, below which gaps are computed in double precision.
_EXACT_RESIDUAL = 1e-3

#: Largest number of products for a linear system.
_MOST_PRODUCTS = 12

#: Part to which the residual of a linear system is reduced.
_SYSTEM_TOLERANCE = 0.2

#: If a step is not a descent direction, the slopes τ are multiplied by this factor repeatedly.
_SLOPE_FACTOR = 0.85

#: Factor below which slopes are set to 0.
_LEAST_SLOPE = 0.3

#: Each such system starts from the directions of the last one, which saves a fifth of all work, and is solved to this
#: part of the right side.
_DAMPED_TOLERANCE = 0.3

#: Newton's method ends after this many rounds without progress.
_STAGNANT_ROUNDS = 6

#: Progress is a residual below this number times the least so far, …
_RESIDUAL_FALL = 0.7

#: … or a potential lower by this number times w of one cell. While the front of a contact moves, residuals rise and
#: fall and only the potential shows progress: counting it saves a fifth of the work of whole cycles, half where
#: contacts jump.
_POTENTIAL_FALL = 0.004

#: Largest number of rounds.
_MOST_ROUNDS = 1000

#: The residual is relative to this part of the largest pressure, if that exceeds the largest attraction.
_PRESSURE_SCALE = 0.1

#: Number of tangent steps after Newton's method has first failed; doubled after each further failure.
_FIRST_TANGENT_STEPS = 2

#: Tolerance of gaps at fixed attraction, over the largest traction.
_OVERLAP_TOLERANCE = 0.01

#: Largest number of products for them.
_OVERLAP_PRODUCTS = 200

#: Weight of a gap (nm) relative to a pressure (nm) in deciding whether a cell touches.
_GAP_WEIGHT = 0.5


class BoxProblem(NamedTuple):
    """The input of a solve on a box, and its work space."""

    separation: np.ndarray  # (nx, ny) S, nm, inf where there is nothing to touch
    law: SmoothLaw
    tolerance: float
    quick: Convolution  # with A, in single precision
    displacement: np.ndarray  # the last one in double precision, nm
    film: tuple | None  # on the half space, see ``halfspace.layered``
    operators: dict  # the last one, see ``operator_on``


class ContactState(NamedTuple):
    """Pressures, gaps and contact of a body."""

    pressure: np.ndarray  # (nx, ny) nm
    gap: np.ndarray  # nm
    touching: np.ndarray


class Convergence(NamedTuple):
    """Cost and accuracy of an equilibrium."""

    rounds: int
    products: int
    residual: float  # over the largest traction
    converged: bool


def settle(body, delta, state, near=False):
    """Bring ``state`` to equilibrium at a displacement (nm), in place.

    With ``near`` only Newton's method is used, which converges only to states close to the start.
    """
    anchor = ContactState(*(values.copy() for values in state))
    out = _newton(body, delta, state, near)
    products = out.products
    rounds = out.rounds
    steps = _FIRST_TANGENT_STEPS
    if out.converged or near:
        return out
    while rounds < _MOST_ROUNDS:
        products += _relax(body, delta, anchor, steps)
        bound = energy(body.separation, body.law, delta, anchor)
        for old, new in zip(anchor, state):
            new[:] = old
        out = _newton(body, delta, state, near)
        products = products + out.products
        rounds = rounds + out.rounds + steps
        steps = 2 * steps
        if out.converged and energy(body.separation, body.law, delta, state) <= bound + 1e-3 * abs(bound):
            break
    return Convergence(rounds, products, out.residual, out.converged)


def _newton(body, delta, state, near):
    """Iterate until the residual is small or progress ends; a fall of the potential counts unless ``near``."""
    products = 0
    best = np.inf
    lowest = np.inf
    since = 0
    exact = False
    worst = np.inf
    for turn in range(_MOST_ROUNDS):
        exact = exact or worst < _EXACT_RESIDUAL
        if not exact:
            worst, potential = _quick_residual(body.quick, body.separation, body.law, delta, state)
            exact = worst <= body.tolerance
            if exact and body.tolerance >= _EXACT_RESIDUAL:  # single precision is finer than such a tolerance
                body.displacement[:] = body.quick.box[:, : state.gap.shape[1]]
                return Convergence(turn, products, worst, True)
        if exact:
            worst, potential = _exact_residual(body, delta, state)
        if exact and worst <= body.tolerance:
            return Convergence(turn, products, worst, True)
        falls = worst < _RESIDUAL_FALL * best or (not near and potential < lowest - _POTENTIAL_FALL * body.law.work)
        since = 0 if falls else since + 1
        best = worst if worst < _RESIDUAL_FALL * best else best
        lowest = min(potential, lowest)
        if since > _STAGNANT_ROUNDS or not np.isfinite(worst):
            return Convergence(turn, products, worst, False)
        products += 1 + _improve(body, state, worst)
    return Convergence(_MOST_ROUNDS, products, worst, False)


def _relax(body, delta, state, steps):
    """Take some tangent steps; return the number of products."""
    fixed = np.zeros(state.gap.shape)
    _fix_attraction(body.law, state, fixed)
    _quick_gaps(body.quick, body.separation, delta, state)
    return sum(_tangent_step(body, delta, state, fixed) for _ in range(steps))


def _exact_residual(body, delta, state):
    """Compute gaps in double precision and the touching cells; return the largest residual, and the potential."""
    body.displacement[:] = displaced(state.pressure, body.film)
    np.add(body.displacement, body.separation - delta, out=state.gap)
    return _classify(body.separation, body.law, delta, state)


@kernel
def _quick_residual(convolution, separation, law, delta, state):
    """Compute gaps in single precision and the touching cells; return the largest residual, and the potential."""
    _quick_gaps(convolution, separation, delta, state)
    return _classify(separation, law, delta, state)


@kernel
def _fix_attraction(law, state, fixed):
    """Set the pressure of each cell to minus the attraction at its gap, plus the contact pressure if it touches."""
    for i in range(fixed.shape[0]):
        for j in range(fixed.shape[1]):
            t = traction(max(state.gap[i, j], 0.0), law)[0]
            before = fixed[i, j] if fixed[i, j] > 0.0 else t
            presses = max(state.pressure[i, j] + before, 0.0) if state.touching[i, j] else 0.0
            fixed[i, j] = t
            state.pressure[i, j] = presses - t


def _tangent_step(body, delta, state, fixed):
    """Solve for the touching cells and their pressures at fixed attraction; return the number of products."""
    _fix_attraction(body.law, state, fixed)
    _quick_gaps(body.quick, body.separation, delta, state)
    cells = _coupled_cells(body.law, state)
    if cells.size == 0:
        return 1
    at = tuple(cells)
    near = operator_on(cells, body.film, body.operators)
    pressure, gap, contact = (np.append(values[at], values.dtype.type(0)) for values in state)
    pressure[:-1] += fixed[at]
    contact &= pressure > 0.0
    goal = _OVERLAP_TOLERANCE * max(body.law.strength, -0.1 * gap.min())
    limits = goal, _OVERLAP_PRODUCTS, 0.0, np.inf, PATIENCE
    out = solve_contact(near, np.zeros(cells.shape[1]), pressure, gap, contact, *limits)
    state.pressure[at] = pressure[:-1] - fixed[at]
    state.gap[at] = gap[:-1]
    state.touching[at] = contact[:-1]
    return 1 + out[1]


@kernel
def _quick_gaps(convolution, separation, delta, state):
    """Compute the gaps from the pressures, in single precision."""
    box = convolution.box
    (rows, columns) = state.pressure.shape
    for i in range(rows):
        for j in range(box.shape[1]):
            box[i, j] = state.pressure[i, j] if j < columns else 0.0
    convolve(convolution)
    for i in range(rows):
        for j in range(columns):
            state.gap[i, j] = box[i, j] + (separation[i, j] - delta)


@kernel
def _classify(separation, law, delta, state):
    """Update the touching cells and the tractions of distant cells; return the largest residual, and the potential.

    The residual is relative to the largest attraction, or to ``_PRESSURE_SCALE`` of the largest pressure if more. The
    potential (nm²) is the energy less Σ (p + t) g over touching cells, which removes the first-order effect of gaps
    that are not closed yet.
    """
    worst = 0.0
    most = 0.0
    potential = 0.0
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            gap = state.gap[i, j]
            pressure = state.pressure[i, j]
            most = max(most, pressure)
            t, tau, left = traction_and_work(max(gap, 0.0), law)
            touching = gap < law.range and pressure + t > _GAP_WEIGHT * gap
            state.touching[i, j] = touching
            if gap < law.range:
                potential += 0.5 * pressure * (delta - separation[i, j] + gap) - left
            if touching:
                potential -= (pressure + t) * gap
                worst = max(worst, abs(gap))
                continue
            worst = max(worst, abs(pressure + t))
            if tau < _SMALLEST_SLOPE:
                state.pressure[i, j] = -t
    return worst / max(law.strength, _PRESSURE_SCALE * most), potential


def _improve(body, state, worst):
    """Take a Newton step, or a tangent step where none descends; return the number of products."""
    cells = _coupled_cells(body.law, state)
    if cells.size == 0:
        return 0
    return _step(operator_on(cells, body.film, body.operators), body.law, state, *cells, worst)


@kernel
def _step(near, law, state, rows, columns, worst):
    """Solve for a step on some cells, and apply it; return the number of products."""
    touching, fall, right, work = _linear_system(law, state, rows, columns)
    room = workspace(_MOST_PRODUCTS, rows.size)
    x = np.empty(rows.size)
    image = np.empty(rows.size)
    part = 1.0 if worst < _TANGENT_RESIDUAL else 0.0
    tolerance = _SYSTEM_TOLERANCE
    size = np.int64(0)  # for a literal 0 Numba compiles all calls once more
    while True:
        size = solve(near, touching, part * fall, right, tolerance, size, room, x, image)
        if part == 0.0 or _is_downhill(law, state, rows, columns, touching, x, image, work):
            break
        part = _SLOPE_FACTOR * part if part > _LEAST_SLOPE else 0.0
        tolerance = _DAMPED_TOLERANCE
    _apply_step(law, state, rows, columns, touching, x, image)
    return size


@kernel
def _apply_step(law, state, rows, columns, touching, x, image):
    """Apply a step: solved pressures where cells touch, tractions at the new gaps where they attract."""
    most = traction(0.0, law)[0]
    for k in range(rows.size):
        i = rows[k]
        j = columns[k]
        if touching[k]:
            state.pressure[i, j] = max(state.pressure[i, j] + x[k], -most)
        else:
            state.pressure[i, j] = -traction(max(state.gap[i, j] + image[k], 0.0), law)[0]


@kernel
def _coupled_cells(law, state):
    """Return rows and columns (2, count) of the cells that touch, or whose traction changes with the gap."""
    gap = state.gap
    cells = np.empty((2, gap.size), np.int64)
    count = 0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            if state.touching[i, j] or gap[i, j] < 0.0 or traction(gap[i, j], law)[1] >= _SMALLEST_SLOPE:
                cells[0, count] = i
                cells[1, count] = j
                count += 1
    return cells[:, :count].copy()


@kernel
def _linear_system(law, state, rows, columns):
    """Return which cells touch, the slopes τ of the others' tractions, the right side, and their remaining work."""
    count = rows.size
    touching = np.empty(count, np.bool_)
    tau = np.zeros(count)
    right = np.empty(count)
    work = np.zeros(count)
    for k in range(count):
        i = rows[k]
        j = columns[k]
        touching[k] = state.touching[i, j]
        if touching[k]:
            right[k] = -state.gap[i, j]
        else:
            t, tau[k] = traction(max(state.gap[i, j], 0.0), law)
            right[k] = -t - state.pressure[i, j]
            work[k] = _work_from(state.gap[i, j], law)
    return touching, tau, right, work


@kernel
def _is_downhill(law, state, rows, columns, touching, x, image, work):
    """Return whether a step x of the pressures and A x of the gaps lowers the potential."""
    rise = 0.0
    for k in range(rows.size):
        rise += 0.5 * x[k] * image[k]
        if touching[k]:
            continue
        gap = state.gap[rows[k], columns[k]]
        pressure = state.pressure[rows[k], columns[k]]
        rise += pressure * image[k] - _work_from(gap + image[k], law) + work[k]
    return rise <= 0.0


@kernel
def _work_from(gap, law):
    """Return the remaining work at a gap; below zero, extrapolated by the traction in contact."""
    return remaining_work(max(gap, 0.0), law) - min(gap, 0.0) * traction(0.0, law)[0]


@kernel
def energy(separation, law, delta, state):
    """Return ½ Σ p (δ − S + g) − Σ W(g), nm²."""
    total = 0.0
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            gap = state.gap[i, j]
            pressure = state.pressure[i, j]
            if gap < law.range:
                total += 0.5 * pressure * (delta - separation[i, j] + gap) - remaining_work(max(gap, 0.0), law)
    return total


@kernel
def closed_parts(state, law):
    """Return the closed fraction of each cell: the remaining work of separation over the whole work."""
    closed = np.empty(state.gap.shape)
    for i in range(closed.shape[0]):
        for j in range(closed.shape[1]):
            closed[i, j] = remaining_work(max(state.gap[i, j], 0.0), law) / (law.work - law.cut)
    return closed
