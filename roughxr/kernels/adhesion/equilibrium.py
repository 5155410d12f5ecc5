"""Equilibrium at one displacement: p + t(g) = 0 where surfaces attract, g = 0 and p + t(0) ≥ 0 where they touch.

The gap of every cell follows from the pressures, g = S − δ + A p. Either of two steps improves a guess, each by one
linear system (``newton_system``):

Newton's       linearises t as well. It converges quadratically near the solution, and is taken where it lowers the
               potential, which follows without another product.
tangent        holds t fixed (τ = 0). As the energy of adhesion −W(u) is concave, the energy with the tangent in place
               of −W is an upper bound, so that its minimum is a descent from any state ("convex-concave procedure",
               Yuille & Rangarajan 2003). This step leads from the end of a branch to the next branch.

After either step, the attracting cells get the traction at their new gap. Cells so far apart that their traction hardly
changes with the gap (``_SMALLEST_SLOPE``) are left out of the systems, and their tractions updated with their gaps.

Gaps are computed by transforms in single precision, until the residual is so small that their rounding would matter.
Unit cells and unit modulus.
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.active_set import PATIENCE
from ..halfspace.active_set import solve as solve_contact
from ..halfspace.products import displaced
from ..halfspace.transforms import Convolution, convolve
from ..jit import kernel
from .newton_system import near_cells, solve, workspace
from .traction_laws import SmoothLaw, remaining_work, traction

#: Cells are left out of the linear systems if their traction falls by at most this part of the cell's own stiffness.
_SMALLEST_SLOPE = 1e-3

#: Residual, over the largest traction, above which only tangent steps are taken, and below which gaps are exact.
_TANGENT_RESIDUAL, _EXACT_RESIDUAL = 1.0, 1e-3

#: A Newton step is too long if it opens a gap by more than this many lengths of the law.
_LARGEST_OPENING = 3.0

#: Largest number of products for a linear system, and the part to which its residual is reduced.
_MOST_PRODUCTS, _SYSTEM_TOLERANCE = 12, 0.2

#: Where a step is no descent direction, the linearised slope of the tractions is multiplied by this factor, again and
#: again, until less than ``_LEAST_SLOPE`` of it is left, and then dropped. These systems start from the directions of
#: the one before, which saves a fifth of all work, until no more than ``_LARGEST_UNSOLVED`` of the right side is left.
_SLOPE_PART, _LEAST_SLOPE, _LARGEST_UNSOLVED = 0.85, 0.3, 0.3

#: When Newton's method is given up: number of rounds without progress, and residual. Progress is a residual that falls
#: to the first part of the least, or a potential that falls by the second part of w of one cell. While the front of a
#: contact runs, residuals rise and fall, and only the potential tells that it gets on: counting it saves a fifth of the
#: work of whole cycles, and half of that where contacts jump.
_STAGNANT_ROUNDS, _DIVERGED_RESIDUAL = 6, 6.0
_RESIDUAL_FALL, _POTENTIAL_FALL = 0.7, 0.004

#: Number of rounds after which a state is given up, and one near the guess.
_MOST_ROUNDS, _MOST_ROUNDS_NEAR = 1000, 30

#: The residual is relative to this part of the largest pressure, if that is more than the largest attraction.
_PRESSURE_SCALE = 0.1

#: Number of tangent steps at the start where that is the case.
_FIRST_TANGENT_STEPS = 2

#: With attraction fixed fixed, gaps are closed to this part of the largest traction, with at most so many products.
_OVERLAP_TOLERANCE, _OVERLAP_PRODUCTS = 0.01, 200

#: Weight of a gap (nm) relative to a pressure (nm) in deciding whether a cell touches.
_GAP_WEIGHT = 0.5


class BoxProblem(NamedTuple):
    """The input of a solve on a box, and its work space."""

    separation: np.ndarray  # (nx, ny) S, nm, inf where there is nothing to touch
    law: SmoothLaw
    tolerance: float
    quick: Convolution  # with A, in single precision
    inverse: Convolution  # with the periodic inverse of A
    sinks: np.ndarray  # the last displacement in double precision, nm


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
    fine: bool


def settle(body, delta, state, near=False):
    """Bring ``state`` to equilibrium at a displacement (nm), starting from its own values.

    With ``near`` only Newton's method is used: a state that is not close to the start is not searched.
    """
    anchor = ContactState(*(values.copy() for values in state))
    out = _newton(body, delta, state, near)
    products, rounds, steps = out.products, out.rounds, _FIRST_TANGENT_STEPS
    if out.fine or near:
        return out
    while rounds < _MOST_ROUNDS:
        products += _relax(body, delta, anchor, steps)
        bound = energy(body.separation, body.law, delta, anchor)
        for old, new in zip(anchor, state):
            new[:] = old
        out = _newton(body, delta, state, near)
        products, rounds, steps = products + out.products, rounds + out.rounds + steps, 2 * steps
        if out.fine and energy(body.separation, body.law, delta, state) <= bound + 1e-3 * abs(bound):
            break
    return Convergence(rounds, products, out.residual, out.fine)


def _newton(body, delta, state, near):
    """Iterate until the residual is small, or has not fallen for long; unless ``near``, nor has the potential."""
    products, best, lowest, since, exact, worst = 0, np.inf, np.inf, 0, False, np.inf
    most = _MOST_ROUNDS_NEAR if near else _MOST_ROUNDS
    for turn in range(most):
        exact = exact or worst < _EXACT_RESIDUAL
        worst, potential = (_exact_residual if exact else _quick_residual)(body, delta, state)
        if not exact and worst <= body.tolerance:
            exact = True
            worst, potential = _exact_residual(body, delta, state)
        if exact and worst <= body.tolerance:
            return Convergence(turn, products, worst, True)
        falls = worst < _RESIDUAL_FALL * best or (not near and potential < lowest - _POTENTIAL_FALL * body.law.work)
        since = 0 if falls else since + 1
        best, lowest = worst if worst < _RESIDUAL_FALL * best else best, min(potential, lowest)
        if since > _STAGNANT_ROUNDS or not worst < _DIVERGED_RESIDUAL:
            return Convergence(turn, products, worst, False)
        products += 1 + _improve(body, state, worst)
    return Convergence(most, products, worst, False)


def _relax(body, delta, state, steps):
    """Take some tangent steps; return the number of products."""
    fixed = np.zeros(state.gap.shape)
    _fix_attraction(body.law, state, fixed)
    _quick_gaps(body.quick, body.separation, delta, state)
    return sum(_press(body, delta, state, fixed) for _ in range(steps))


def _exact_residual(body, delta, state):
    """Compute gaps in double precision, and which cells touch; return the largest residual, and the potential."""
    body.sinks[:] = displaced(state.pressure)
    np.add(body.sinks, body.separation - delta, out=state.gap)
    return _classify(body.separation, body.law, delta, state)


def _quick_residual(body, delta, state):
    """Do the same in single precision."""
    _quick_gaps(body.quick, body.separation, delta, state)
    return _classify(body.separation, body.law, delta, state)


@kernel
def _fix_attraction(law, state, fixed):
    """Set the pressure of each cell to the attraction at its gap, minus what presses where it touches."""
    for i in range(fixed.shape[0]):
        for j in range(fixed.shape[1]):
            t = traction(max(state.gap[i, j], 0.0), law)[0]
            before = fixed[i, j] if fixed[i, j] > 0.0 else t
            presses = max(state.pressure[i, j] + before, 0.0) if state.touching[i, j] else 0.0
            fixed[i, j], state.pressure[i, j] = t, presses - t


def _press(body, delta, state, fixed):
    """Find which cells touch, and their pressures, with the attraction fixed; return the number of products."""
    _fix_attraction(body.law, state, fixed)
    _quick_gaps(body.quick, body.separation, delta, state)
    at = rows, columns = _places(body.law, state)
    if rows.size == 0:
        return 1
    near = near_cells(rows, columns, body.quick, body.inverse)
    pressure, gap, contact = (np.append(values[at], values.dtype.type(0)) for values in state)
    pressure[:-1] += fixed[at]
    contact &= pressure > 0.0
    goal = _OVERLAP_TOLERANCE * max(body.law.strength, -0.1 * gap.min())
    limits = goal, _OVERLAP_PRODUCTS, 0.0, np.inf, PATIENCE
    out = solve_contact(near, np.zeros(rows.size), pressure, gap, contact, *limits)
    state.pressure[at], state.gap[at], state.touching[at] = pressure[:-1] - fixed[at], gap[:-1], contact[:-1]
    return 1 + out[1]


@kernel
def _quick_gaps(convolution, separation, delta, state):
    """Compute the gaps from the pressures, in single precision."""
    pressure, box = state.pressure, convolution.box
    for i in range(box.shape[0]):
        for j in range(box.shape[1]):
            box[i, j] = pressure[i, j] if j < pressure.shape[1] else 0.0
    convolve(convolution)
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            state.gap[i, j] = box[i, j] + (separation[i, j] - delta)


@kernel
def _classify(separation, law, delta, state):
    """Decide which cells touch, update the tractions of distant cells; return the largest residual, and the potential.

    The residual is relative to the largest attraction, or to ``_PRESSURE_SCALE`` of the largest pressure if more. The
    potential (nm²) is the energy less Σ (p + t) g over touching cells: to first order, gaps that are not closed yet do
    not count.
    """
    worst, most, potential = 0.0, 0.0, 0.0
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            gap, pressure = state.gap[i, j], state.pressure[i, j]
            most = max(most, pressure)
            t, tau = traction(max(gap, 0.0), law)
            touching = gap < law.range and pressure + t > _GAP_WEIGHT * gap
            state.touching[i, j] = touching
            potential += _stored(pressure, gap, separation[i, j], delta, law)
            if touching:
                potential -= (pressure + t) * gap
                worst = max(worst, abs(gap))
                continue
            worst = max(worst, abs(pressure + t))
            if tau < _SMALLEST_SLOPE:
                state.pressure[i, j] = -t
    return worst / max(law.strength, _PRESSURE_SCALE * most), potential


def _improve(body, state, worst):
    """Take one step; return the number of products."""
    rows, columns = _places(body.law, state)
    if rows.size == 0:
        return 0
    near = near_cells(rows, columns, body.quick, body.inverse)
    touching, fall, right = _system(body.law, state, rows, columns)
    room, x, image = workspace(_MOST_PRODUCTS, rows.size), np.empty(rows.size), np.empty(rows.size)
    part = 1.0 if worst < _TANGENT_RESIDUAL else 0.0
    size = solve(near, touching, part * fall, right, _SYSTEM_TOLERANCE, 0, room, x, image)
    while part > 0.0 and not _is_downhill(body.law, state, rows, columns, touching, x, image):
        part = _SLOPE_PART * part if part > _LEAST_SLOPE else 0.0
        size = solve(near, touching, part * fall, right, _LARGEST_UNSOLVED, size, room, x, image)
    _go(body.law, state, rows, columns, touching, x, image)
    return size


@kernel
def _go(law, state, rows, columns, touching, x, image):
    """Apply a step: solved pressures where cells touch, tractions at the new gaps where they attract."""
    most = traction(0.0, law)[0]
    for k in range(rows.size):
        i, j = rows[k], columns[k]
        if touching[k]:
            state.pressure[i, j] = max(state.pressure[i, j] + x[k], -most)
        else:
            state.pressure[i, j] = -traction(max(state.gap[i, j] + image[k], 0.0), law)[0]


@kernel
def _places(law, state):
    """Return rows and columns of the cells that touch, or whose traction changes with the gap."""
    rows, columns, count = np.empty(state.gap.size, np.int64), np.empty(state.gap.size, np.int64), 0
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            gap = state.gap[i, j]
            if state.touching[i, j] or gap < 0.0 or traction(gap, law)[1] >= _SMALLEST_SLOPE:
                rows[count], columns[count], count = i, j, count + 1
    return rows[:count], columns[:count]


@kernel
def _system(law, state, rows, columns):
    """Return which cells touch, the slopes of the others' tractions, and the right side."""
    count = rows.size
    touching, tau, right = np.empty(count, np.bool_), np.zeros(count), np.empty(count)
    for k in range(count):
        i, j = rows[k], columns[k]
        touching[k] = state.touching[i, j]
        if touching[k]:
            right[k] = -state.gap[i, j]
        else:
            t, tau[k] = traction(max(state.gap[i, j], 0.0), law)
            right[k] = -t - state.pressure[i, j]
    return touching, tau, right


@kernel
def _is_downhill(law, state, rows, columns, touching, x, image):
    """Return whether a step x of the pressures, A x of the gaps, lowers the potential and is not too long."""
    rise, longest = 0.0, _LARGEST_OPENING * law.length
    for k in range(rows.size):
        rise += 0.5 * x[k] * image[k]
        if touching[k]:
            continue
        if abs(image[k]) > longest:
            return False
        gap, pressure = state.gap[rows[k], columns[k]], state.pressure[rows[k], columns[k]]
        rise += pressure * image[k] - _work_from(gap + image[k], law) + _work_from(gap, law)
    return rise <= 0.0


@kernel
def _work_from(gap, law):
    """Return the work left at a gap; below zero as if the traction in contact went on."""
    return remaining_work(max(gap, 0.0), law) - min(gap, 0.0) * traction(0.0, law)[0]


@kernel
def energy(separation, law, delta, state):
    """Return ½ Σ p (δ − S + g) − Σ W(g), nm²."""
    total = 0.0
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            total += _stored(state.pressure[i, j], state.gap[i, j], separation[i, j], delta, law)
    return total


@kernel
def _stored(pressure, gap, separation, delta, law):
    """Return the energy of one cell, nm²."""
    if not gap < law.range:
        return 0.0
    return 0.5 * pressure * (delta - separation + gap) - remaining_work(max(gap, 0.0), law)


@kernel
def closed_parts(state, law):
    """Return the closed fraction of each cell: the work of separation that is left there, over the whole."""
    closed = np.empty(state.gap.shape)
    for i in range(closed.shape[0]):
        for j in range(closed.shape[1]):
            closed[i, j] = remaining_work(max(state.gap[i, j], 0.0), law) / (law.work - law.cut)
    return closed
