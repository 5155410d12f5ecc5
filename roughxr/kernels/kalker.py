"""Adhesionless contact of a rigid profile with a half space, at a displacement or a load.

On cells with undeformed separation S (nm), at a displacement δ (nm), find pressures p (GPa) with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0                       (Kalker 1990; Cheng, Dunn & Brach, eqs. 36–39)

The active set (``kernels.active_set``) finds which cells touch. Here it is given as few cells as possible, and a good
start, none of which changes the solution:

- Only cells with S < δ can carry load, since A p ≥ 0; everything else is cut away.
- Of these, the cells that a prediction puts well apart are left out too. One product over the whole overlap at the end
  tells whether any of them penetrates; then they are taken in and the solve goes on.
- The prediction comes from the two solutions before, in a sweep, or from the same problem on cells twice as large.
- Pressures scale with E*/dx, so cells of unit side on a half space of unit modulus are solved.
"""

from typing import NamedTuple

import numpy as np

from . import active_set
from .active_set import CONVERGED, ITERATION_LIMIT, gather_cells
from .halfspace import DENSE_LIMIT, convolve
from .jit import kernel

#: Reasons, by status.
REASONS = {CONVERGED: "converged", ITERATION_LIMIT: "iteration limit reached before the tolerance"}

#: In a sweep, cells that penetrate by this part of the step when extrapolated are taken to touch.
_JOINING = 0.1

#: After a coarse solve, cells whose predicted gap exceeds this part of the deepest overlap are left out.
_MARGIN = 0.05

#: Tolerance of the solve on cells twice as large, which only makes a start.
_COARSE_TOLERANCE = 1e-3

#: Under a load, cells are chosen up to this many times the guessed depth.
_SLACK = 1.1

#: d ln F / d ln depth of a sphere.
_SPHERE_EXPONENT = 1.5

#: Windows narrower than this are not halved to find a displacement.
_SMALLEST_HALVED = 24

#: Choices of cells at most under one load.
_MOST_CHOICES = 30


class Solution(NamedTuple):
    """One contact on a window of dx × dx cells, and how the solve ended."""

    pressure: np.ndarray  #: GPa, >= 0
    displacement: np.ndarray  #: nm, on the overlap's bounding box; NaN elsewhere
    force: float  #: nN
    area: float  #: nm²
    status: int
    iterations: int  #: products A p
    residual: float  #: largest |g| in contact or penetration outside, over the deepest overlap

    @property
    def converged(self):
        """Whether the tolerance was met."""
        return self.status == CONVERGED


class Prediction(NamedTuple):
    """What a contact may look like on the window."""

    pressure: np.ndarray  #: GPa
    touching: np.ndarray  #: cells to start from
    possible: np.ndarray  #: cells that may touch, the others are left out until they prove to penetrate


def solve(separation, delta, dx, contact_modulus, *, tolerance=1e-6, start=None, max_iterations=5000):
    """Solve the contact at one displacement.

    Parameters
    ----------
    separation : (nx, ny) array
        Undeformed separation S, nm; NaN or inf where there is nothing to touch.
    delta : float
        Displacement, nm.
    dx : float
        Side of the cells, nm.
    contact_modulus : float
        E*, GPa.
    tolerance : float
        Relative error of the force: the gap left in contact, and the penetration outside, stay below half of it times
        the deepest overlap (force grows about like depth^1.5, or as depth at first touch).
    start : Prediction, optional
        What the contact may look like.
    max_iterations : int
        Products A p at most.

    Returns
    -------
    Solution
    """
    overlap = _overlap(separation, delta)
    if overlap.count == 0:
        return _untouched(separation.shape)
    box, scale = _box(overlap), contact_modulus / dx
    depth = delta - separation[box]
    if start is None:
        start = _coarse_prediction(depth, overlap.count, dx, contact_modulus)
    else:
        start = Prediction(*(part[box] for part in start))
    goal = 0.5 * tolerance * overlap.largest
    found = _solve_box(depth, overlap.count, start, scale, goal, max_iterations)
    return _on_window(separation.shape, box, found, dx, scale, overlap.largest)


def _on_window(shape, box, found, dx, scale, largest):
    """Return what was found in a box as a `Solution` on the window, in units."""
    pressure, displacement, outcome = found
    out = _untouched(shape)
    out.pressure[box], out.displacement[box] = pressure * scale, displacement
    return out._replace(
        force=float(pressure.sum()) * scale * dx * dx,
        area=np.count_nonzero(pressure) * dx * dx,
        status=outcome.status,
        iterations=outcome.iterations,
        residual=outcome.violation / largest,
    )


def sweep(separation, deltas, dx, contact_modulus, *, tolerance=1e-6, max_iterations=5000):
    """Yield the contact at each of ascending displacements, each started from those before."""
    before, last = None, None
    for delta in deltas:
        start = None if last is None else _extrapolated(separation, before, last, delta)
        limits = {"tolerance": tolerance, "max_iterations": max_iterations}
        solution = solve(separation, delta, dx, contact_modulus, start=start, **limits)
        if solution.force > 0:
            before, last = last, (delta, solution)
        yield solution


def _extrapolated(separation, before, last, delta):
    """Predict the contact at δ on the straight line through two solutions, or from one.

    As δ grows the contact only grows, and the displacement of a cell outside grows ever faster (the inverse of A has
    positive entries on its diagonal only): on the line a cell that will touch penetrates already, and one that
    penetrates by little seldom touches. A displacement known once only is taken to stay, for what is possible, and to
    grow by half the step, for what touches; a cell whose displacement is not known at all is possible.
    """
    (delta_last, known), ahead = last, np.nan
    older = known
    if before is not None:
        older, ahead = before[1], (delta - delta_last) / (delta_last - before[0])
    out = Prediction(np.empty(separation.shape), *(np.empty(separation.shape, np.bool_) for _ in range(2)))
    _extrapolate(separation, delta, delta - delta_last, known[:2], older[:2], ahead, out)
    return out


@kernel
def _extrapolate(separation, delta, step, known, older, ahead, out):
    """Fill in ``out``; ``known`` and ``older`` are pressure and displacement, ``ahead`` is NaN without an older one."""
    for i in range(separation.shape[0]):
        for j in range(separation.shape[1]):
            pressure, displacement = known[0][i, j], known[1][i, j]
            growth = ahead * (displacement - older[1][i, j])
            if not np.isnan(ahead):
                out.pressure[i, j] = max(pressure + ahead * (pressure - older[0][i, j]), 0.0)
            else:
                out.pressure[i, j] = pressure
            doubt = 0.0
            if np.isnan(growth):
                growth, doubt = 0.0, 0.5 * step
            gap = displacement + growth + separation[i, j] - delta
            out.touching[i, j] = pressure > 0.0 or gap + doubt < -_JOINING * step
            out.possible[i, j] = out.touching[i, j] or not gap >= 0.0


def loaded(separation, loads, dx, contact_modulus, *, tolerance=1e-6, max_iterations=5000):
    """Yield (delta, contact) for each of ascending loads (nN > 0), each started from the one before."""
    found = None
    for load in loads:
        found = _solve_load(separation, load, dx, contact_modulus, tolerance, max_iterations, found)
        yield found


def _solve_load(separation, load, dx, contact_modulus, tolerance, max_iterations, known):
    """Return (δ, contact) at a load; the active set finds δ along with the contact.

    Only the cells to work on are chosen by a guess of δ, from the load before or from cells twice as large; where δ
    turns out to lie deeper, or far less deep, they are chosen again.
    """
    touch, scale = float(np.nanmin(separation, initial=np.inf)), contact_modulus / dx
    if not np.isfinite(touch):  # nothing to press on carries no load
        return np.nan, _untouched(separation.shape)._replace(status=ITERATION_LIMIT)
    delta, start = _first_guess(separation, load, dx, contact_modulus, touch, known)
    products = 0
    for _ in range(_MOST_CHOICES):
        reach = touch + _SLACK * (delta - touch)
        overlap = _overlap(separation, reach)
        box, slack = _box(overlap), reach - delta
        depth = delta - separation[box]
        begin = _half_deep(depth, slack) if start is None else Prediction(*(part[box] for part in start))
        goal, left, scaled = 0.5 * tolerance * (delta - touch), max_iterations - products, load / (scale * dx * dx)
        found = _solve_box(depth, overlap.count, begin, scale, goal, left, load=scaled, slack=slack)
        guess, delta, products = delta, delta + found[2].shift, products + found[2].iterations
        solution = _on_window(separation.shape, box, found, dx, scale, delta - touch)
        shallow = delta - touch < 0.5 * (guess - touch)  # then the goal, a part of the guessed depth, was too loose
        if not solution.converged or (delta <= reach and not shallow):
            break
        start = _extrapolated(separation, None, (delta, solution), delta)
    return delta, solution._replace(iterations=products)


def _first_guess(separation, load, dx, contact_modulus, touch, known):
    """Return a displacement near that of the load, and what the contact there may look like (None if not known)."""
    if known is not None and known[1].force > 0:
        delta = touch + (known[0] - touch) * (load / known[1].force) ** (1 / _SPHERE_EXPONENT)
        return delta, _extrapolated(separation, None, known, delta)
    if min(separation.shape) < _SMALLEST_HALVED:
        return touch + _depth_estimate(separation - touch, load, dx, contact_modulus), None
    coarse = _halved(separation)
    delta, solution = _solve_load(coarse, load, 2 * dx, contact_modulus, _COARSE_TOLERANCE, 1000, None)
    delta = max(delta, touch + 0.1 * (delta - np.nanmin(coarse)))
    return delta, _refined(solution, delta - separation, dx, contact_modulus, delta - touch)


def _half_deep(depth, slack=0.0):
    """Return a start for few cells: those that overlap by more than half the deepest.

    So many of a paraboloid's overlapping cells touch.
    """
    return Prediction(np.zeros(depth.shape), depth > 0.5 * np.nanmax(depth), depth > -slack)


def _depth_estimate(depths, load, dx, contact_modulus):
    """Return the depth at which F = (4/3) E* depth √(overlap area/2π), as for a paraboloid, reaches the load."""
    depths = np.sort(depths[np.isfinite(depths)])
    deeper = np.append(depths[1:], np.inf)
    area = np.arange(1, depths.size + 1) * dx * dx
    stiffness = 4 / 3 * contact_modulus * np.sqrt(area / (2 * np.pi))
    within = load / stiffness <= deeper  # reached before the next cell overlaps
    return float((load / stiffness)[np.argmax(within)])


class _Overlap(NamedTuple):
    """The cells with S < δ: their bounding box, how many they are, and how deep the deepest (nm)."""

    first_row: int
    last_row: int
    first_column: int
    last_column: int
    count: int
    largest: float


def _box(overlap):
    """Return the overlap's bounding box as slices."""
    return slice(overlap.first_row, overlap.last_row + 1), slice(overlap.first_column, overlap.last_column + 1)


@kernel
def _overlap(separation, delta):
    rows, columns = separation.shape
    first_row, last_row, first_column, last_column, count, least = rows, -1, columns, -1, 0, np.inf
    for i in range(rows):
        for j in range(columns):
            if separation[i, j] < delta:
                first_row, last_row = min(first_row, i), i
                first_column, last_column = min(first_column, j), max(last_column, j)
                least = min(least, separation[i, j])
                count += 1
    return _Overlap(first_row, last_row, first_column, last_column, count, delta - least)


def _untouched(shape):
    return Solution(np.zeros(shape), np.full(shape, np.nan), 0.0, 0.0, CONVERGED, 0, 0.0)


def _solve_box(depth, count, start, scale, goal, max_iterations, *, load=0.0, slack=0.0):
    """Return scaled pressures, displacements and outcome on the overlap's bounding box.

    The active set works on the chosen cells, its search directions in single precision; the product over the whole
    box, in double, is what decides. Whatever violates a condition there goes back to the active set. With a ``load``
    (scaled) the depths shift, and cells within ``slack`` of overlapping are taken along.
    """
    inside = depth > -slack
    pressure, touching = start.pressure / scale, start.touching & inside
    chosen = inside if count <= DENSE_LIMIT else start.possible & inside
    iterations, shift = 0, 0.0
    while True:
        outcome = _solve_chosen(depth + shift, chosen, pressure, touching, goal, max_iterations - iterations, load)
        displacement = convolve(pressure)
        iterations, shift = iterations + outcome.iterations + 1, shift + outcome.shift
        worst = _violation(pressure, displacement, depth + shift, goal, touching)
        outcome = outcome._replace(iterations=iterations, violation=worst, shift=shift)
        if outcome.status != CONVERGED or worst <= goal:
            return pressure, displacement, outcome
        chosen = chosen | touching


@kernel
def _violation(pressure, displacement, depth, goal, touching):
    """Mark the cells that touch or penetrate; return the largest |g| in contact or penetration outside."""
    worst = 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            gap = displacement[i, j] - depth[i, j]
            loaded = pressure[i, j] > 0.0
            touching[i, j] = loaded or (depth[i, j] > 0.0 and gap < -goal)
            if loaded or depth[i, j] > 0.0:
                worst = max(worst, abs(gap) if loaded else -gap)
    return worst


def _solve_chosen(depth, chosen, pressure, touching, goal, max_iterations, load):
    """Solve on the chosen cells; their pressures (scaled) in the box become the solution."""
    indices = np.flatnonzero(chosen)
    cells = gather_cells(chosen, indices, depth.ravel()[indices])
    contact = np.append(touching.ravel()[indices], False)
    compact = np.append(np.where(contact[:-1], pressure.ravel()[indices], 0.0), 0.0)
    if load > 0 and not compact.any():
        contact[np.argmax(cells.depth)] = True  # something must carry
        compact[contact] = load / np.count_nonzero(contact)
    outcome = active_set.Outcome(*active_set.solve(cells, compact, contact, goal, max_iterations, load))
    pressure[...] = 0.0
    pressure.ravel()[indices] = compact[:-1]
    return outcome


def _coarse_prediction(depth, count, dx, contact_modulus):
    """Return the contact on cells twice as large, or a start for few cells."""
    if count <= DENSE_LIMIT or min(depth.shape) < 4:
        return _half_deep(depth)
    solution = solve(-_halved(depth), 0.0, 2 * dx, contact_modulus, tolerance=_COARSE_TOLERANCE)
    return _refined(solution, depth, dx, contact_modulus, float(np.nanmax(depth)))


def _refined(solution, depth, dx, contact_modulus, largest):
    """Return what a solution on cells twice as large says of a box of depths (nm), the largest of them given."""
    rows, columns = depth.shape
    pressure = np.repeat(np.repeat(solution.pressure, 2, axis=0), 2, axis=1)[:rows, :columns]
    gap = _doubled(solution.displacement)[:rows, :columns] - depth
    touching = (pressure * dx / contact_modulus > gap) & (pressure > 0) | (gap < 0)
    return Prediction(pressure, touching, touching | ~(gap >= _MARGIN * largest))


def _halved(depth):
    """Return the means of 2 × 2 cells; odd rims are continued."""
    odd = [(0, n % 2) for n in depth.shape]
    padded = np.pad(depth, odd, mode="edge")
    return padded.reshape(padded.shape[0] // 2, 2, -1, 2).mean(axis=(1, 3))


def _doubled(field):
    """Return a field at the centres of cells half as large, linear between the centres."""
    for axis in (0, 1):
        field = np.moveaxis(field, axis, 0)
        padded = np.pad(field, [(1, 1), (0, 0)], mode="edge")
        fine = np.empty((2 * field.shape[0], field.shape[1]))
        fine[0::2] = 0.75 * field + 0.25 * padded[:-2]
        fine[1::2] = 0.75 * field + 0.25 * padded[2:]
        field = np.moveaxis(fine, 0, axis)
    return field
