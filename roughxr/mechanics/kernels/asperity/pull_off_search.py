"""The exact pull-off force of a sphere from superposed asperities, at one place or at very many.

The force is the sum over asperities of ``contact_sums``,

    F(δ) = Σᵢ Pᵢ(δ − oᵢ),     Pᵢ = 0 before the branch of asperity i begins at δ = tᵢ.

Each branch is convex from tᵢ on (that of ``maugis``, as tabulated, to 10⁻⁶ P_c), and begins with a jump down,
since an asperity at the end of its branch is in tension. Therefore
- between two onsets F is convex: it has at most one minimum, where its slope vanishes, and a root search of the rising
  slope finds it;
- an interval at whose right end F still falls needs no search: F continues there by a jump down, or falling;
- beyond any displacement L, F lies above a line with a step down at each later onset,

      F(δ) ≥ A + S (δ − L) − Σ(L < tᵢ ≤ δ) Cᵢ,     Cᵢ = −min Pᵢ,

  where A and S are sums over branches: of their loads and slopes at L if they rise there, else of −Cᵢ and 0.

The search goes from one onset to the next. It searches the intervals whose minimum can be below the least one so far,
skips those that the line proves to be above it, and ends when the line proves this for all larger displacements. For
distant asperities that are not yet considered, the line subtracts all adhesion within the square that the sphere can
reach, a sum known beforehand (``AsperityCells.adhesion``); if that is not enough, more asperities are considered.

oᵢ      ``offset``, displacement at which the sphere reaches vertex i, nm;  tᵢ  ``onset``, nm
L, δ    displacements from the datum, nm
F, C    nN;  S  nN/nm
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.separation import distance_at_height, sphere_height
from ..jit import kernel
from .asperity_laws import subset
from .branches import LENGTH, P, closed_force, collapse, line_force
from .contact_sums import Field
from .elliptic_table import LEAST, mark_at_row

#: Results per centre: the least force nN (0 without adhesion), its displacement nm (NaN then), the number of asperities
#: in contact at the least force, and the number of these at the scan's edge.
FORCE, DELTA, CONTACTS, AT_EDGE = range(4)

#: Largest error of the tables: an asperity's least load may be lower than tabulated by this part.
_TABLE_ERROR = 3e-6

#: A search ends when the force is accurate to this part.
_VALUE_TOLERANCE = 1e-14

#: Largest number of steps of a search.
_MOST_STEPS = 100

#: q so near the onset of a branch that the slope at a fold is 1/q there; and the least dP*/dq of a fold (JKR: 1.1).
_SMALL_Q = 1e-5
_FOLD = 0.01


class AsperityCells(NamedTuple):
    """Square cells over a scan, by which its asperities are sorted: those of a row are contiguous."""

    x: float  # lower corner, nm
    y: float
    side: float  # nm
    first: np.ndarray  # (nx, ny + 1): index of each cell's first asperity, and the end of the row
    adhesion: np.ndarray  # (nx + 1, ny + 1): ΣC over all cells before, along both axes, nN


class AsperityGrid(NamedTuple):
    """The asperities of a scan sorted into cells, each with its largest tension."""

    field: Field
    adhesion: np.ndarray  # (asperity,): Cᵢ, nN
    highest: float  # least depth + end of branch, nm: asperities where S₀ > δ − highest are out of contact
    cells: AsperityCells
    first_reach: float  # displacement up to which asperities are considered first, nm


class Near(NamedTuple):
    """The asperities that can be in contact up to some displacement, in the order of their onsets."""

    onset: np.ndarray
    offset: np.ndarray
    index: np.ndarray
    adhesion: np.ndarray  # running sum of C, from 0: (near + 1,)
    lines: np.ndarray  # (near, LENGTH): their branches, where the law is tabulated
    touch: float  # displacement at which the first vertex is touched; inf where there is none


class Total(NamedTuple):
    """The force of some asperities, its slope, and A and S of its lower bound."""

    F: float
    slope: float
    A: float
    S: float


class Least(NamedTuple):
    """The least force so far and its displacement; 0 without adhesion."""

    F: float
    delta: float


def build_grid(field, law, radius):
    """Return the asperities of ``field`` as an ``AsperityGrid``, for a law and a sphere."""
    field = _subset(field, field.scales.end < 0)  # only adhesive asperities
    least = np.full(field.x.size, -1.0) if law.spline.size == 0 else _marks(law.marks, field.scales.row)
    adhesion = -least * field.scales.P * (1 + _TABLE_ERROR)
    cells, order = _cells(field, adhesion)
    field = _subset(field, order)
    if field.x.size == 0:
        return AsperityGrid(field, adhesion, 0.0, cells, 1.0)
    highest = (field.depth + field.scales.end * field.scales.delta).min()
    area = cells.first.shape[0] * (cells.first.shape[1] - 1) * cells.side**2
    # the disc that is considered first has 200 asperities
    r2 = min(area * 200 / (np.pi * field.x.size), 0.25 * radius * radius)
    reach = max(sphere_height(r2, radius), np.median(field.scales.delta))
    return AsperityGrid(field, adhesion[order], float(highest), cells, float(highest + reach))


def _subset(field, which):
    """Return the asperities ``which`` of a field, in that order."""
    return Field(*(a[which] for a in field[:-1]), subset(field.scales, which))


@kernel
def _marks(marks, rows):
    out = np.empty(rows.size)
    for i in range(rows.size):
        out[i] = mark_at_row(marks, rows[i], LEAST)
    return out


def _cells(field, adhesion, per_cell=4.0):
    """Return the cells, about ``per_cell`` asperities in each, and the asperities' order by cells."""
    if field.x.size == 0:
        return AsperityCells(0.0, 0.0, 1.0, np.zeros((1, 2), dtype=np.int64), np.zeros((2, 2))), np.arange(0)
    x = field.x.min()
    y = field.y.min()
    width = np.ptp(field.x)
    depth = np.ptp(field.y)
    side = max(np.sqrt(width * depth * per_cell / field.x.size), max(width, depth) / 4096, 1e-9)
    i, j = ((a - low) // side for a, low in ((field.x, x), (field.y, y)))
    shape = int(i.max()) + 1, int(j.max()) + 1
    number = (i * shape[1] + j).astype(np.int64)
    order = np.argsort(number, kind="stable")
    ends = np.cumsum(np.bincount(number, minlength=shape[0] * shape[1])).reshape(shape)
    before = np.concatenate([[0], ends[:-1, -1]])[:, None]
    table = np.bincount(number, adhesion, shape[0] * shape[1]).reshape(shape)
    sums = np.pad(table.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    return AsperityCells(float(x), float(y), float(side), np.hstack([before, ends]), sums), order


@kernel
def pull_offs(x, y, grid, table, radius):
    """Return (centre, 4), ``FORCE`` … ``AT_EDGE``, for the axis of the sphere at each (x, y)."""
    out = np.zeros((x.size, 4))
    for c in range(x.size):
        reach = grid.first_reach
        least = Least(0.0, np.nan)
        row = out[c]
        near = nearby(x[c], y[c], reach, grid, table, radius)
        for _ in range(60):
            least = least_up_to(near, reach, least, grid)
            total = total_force(reach, near.onset.size, near, grid)
            if _is_bounded_beyond(x[c], y[c], reach, total, near, least, grid, radius):
                break
            reach = grid.highest + 1.5 * (reach - grid.highest)
            near = nearby(x[c], y[c], reach, grid, table, radius)
        row[FORCE] = least.F
        row[DELTA] = least.delta
        for k in range(near.onset.size):
            if near.onset[k] <= least.delta:
                row[CONTACTS] += 1.0
                row[AT_EDGE] += grid.field.at_edge[near.index[k]]
    return out


@kernel
def nearby(x, y, reach, grid, table, radius):
    """Return the asperities whose branch begins at or below the displacement ``reach``, in the order of onsets."""
    onset, offset, index = _begun_branches(x, y, reach, grid, radius)
    n = onset.size
    touch = np.inf
    for k in range(n):
        touch = min(touch, offset[k])
    order = _stable_order(onset)
    lines = np.empty((n if table.size else 0, LENGTH))
    near = Near(np.empty(n), np.empty(n), np.empty(n, np.int64), np.zeros(n + 1), lines, touch)
    for k in range(n):
        near.onset[k] = onset[order[k]]
        near.offset[k] = offset[order[k]]
        near.index[k] = index[order[k]]
        near.adhesion[k + 1] = near.adhesion[k] + grid.adhesion[near.index[k]]
        if table.size:
            collapse(table, grid.field.scales.row[near.index[k]], P, near.lines[k])
    return near


@kernel
def _begun_branches(x, y, reach, grid, radius):
    """Return onsets, offsets and indices of the asperities whose branch begins at or below ``reach``."""
    field = grid.field
    cells = grid.cells
    i0, i1, j0, j1 = _square(x, y, distance_at_height(reach - grid.highest, radius), cells)
    count_in_square = 0
    for i in range(i0, i1):
        count_in_square += cells.first[i, j1] - cells.first[i, j0]
    onset = np.empty(count_in_square)
    offset = np.empty(count_in_square)
    index = np.empty(count_in_square, np.int64)
    n = 0
    for i in range(i0, i1):
        for k in range(cells.first[i, j0], cells.first[i, j1]):
            u = field.x[k] - x
            v = field.y[k] - y
            o = field.depth[k] + sphere_height(u * u + v * v, radius)
            t = o + field.scales.end[k] * field.scales.delta[k]
            if t <= reach:
                onset[n] = t
                offset[n] = o
                index[n] = k
                n += 1
    return onset[:n], offset[:n], index[:n]


@kernel
def _stable_order(values):
    """Return the indices that sort values, by merging; NumPy's `argsort` takes a second to compile."""
    n = values.size
    order = np.empty((2, n), np.int64)
    for k in range(n):
        order[0, k] = k
    width = 1
    now = 0
    while width < n:
        for start in range(0, n, 2 * width):
            left = start
            middle = min(start + width, n)
            right = middle
            end = min(start + 2 * width, n)
            for k in range(start, end):
                from_left = right >= end or (left < middle and values[order[now, left]] <= values[order[now, right]])
                order[1 - now, k] = order[now, left if from_left else right]
                left += from_left
                right += not from_left
        now = 1 - now
        width = 2 * width
    return order[now]


@kernel
def _square(x, y, r, cells):
    """Return the ranges of cells that contain the square of half-width r around (x, y)."""
    nx = cells.first.shape[0]
    ny = cells.first.shape[1] - 1
    return (
        _cell(x - r - cells.x, cells.side, nx),
        _cell(x + r - cells.x + cells.side, cells.side, nx),
        _cell(y - r - cells.y, cells.side, ny),
        _cell(y + r - cells.y + cells.side, cells.side, ny),
    )


@kernel
def _cell(distance, side, count):
    """Return the number of the cell at a distance from the corner, between 0 and their count."""
    return int(min(max(np.floor(distance / side), 0.0), count))


@kernel
def least_up_to(near, reach, least, grid):
    """Return the least of ``least`` and the force up to the displacement ``reach``."""
    n = near.onset.size
    k = np.int64(0)  # not the literal
    while k < n:
        end = near.onset[k + 1] if k + 1 < n else reach
        total = total_force(end, k + 1, near, grid)
        width = end - near.onset[k]
        if total.slope > 0.0 and total.F - total.slope * width < least.F:
            least = search(k, width, total, least, near, grid)
        k, before = k + 1, near.adhesion[k + 1]
        while k < n:  # skip what the line proves to lie above the least
            line = total.A + total.S * (near.onset[k] - end) - (near.adhesion[k + 1] - before)
            if line < least.F:
                break
            k += 1
    return least


@kernel
def search(k, width, end, least, near, grid):
    """Return the least of ``least`` and F on the ``width`` after the k-th onset, at whose ``end`` F rises.

    In q = √(δ − t) the slope times q is regular at the onset, and nearly linear: regula falsi (Illinois) takes some
    five steps. A convex function lies above its tangents, which decide when the search ends.
    """
    start = near.onset[k]
    low, g_low = _slope_at_onset(k, near, grid)
    high = np.sqrt(width)
    g_high = end.slope * np.sqrt(width)
    if g_low == 0.0:  # F need not fall at first: the onset itself may be the minimum
        total = total_force(start + low * low, k + 1, near, grid)
        g_low = -g_high
        if total.F < least.F:
            least = Least(total.F, start + low * low)
    for _ in range(_MOST_STEPS):
        q = (low * g_high - high * g_low) / (g_high - g_low)
        total = total_force(start + q * q, k + 1, near, grid)
        if total.F < least.F:
            least = Least(total.F, start + q * q)
        g = total.slope * q
        rest = q * q - low * low if g > 0.0 else high * high - q * q
        if total.F - abs(total.slope) * rest >= least.F * (1.0 + _VALUE_TOLERANCE) or not low < q < high:
            break
        if g > 0.0:
            high = q
            g_high = g
            g_low = 0.5 * g_low
        else:
            low = q
            g_low = g
            g_high = 0.5 * g_high
    return least


@kernel
def _slope_at_onset(k, near, grid):
    """Return a small q after the k-th onset and the slope times q there: 0 if that branch begins as a point."""
    i = near.index[k]
    delta = grid.field.scales.delta[i]
    load = grid.field.scales.P[i]
    _, slope = asperity_force(_SMALL_Q * _SMALL_Q, k, near, grid.field.scales.end[i])
    g = slope * _SMALL_Q if slope * _SMALL_Q < -_FOLD else 0.0
    return _SMALL_Q * np.sqrt(delta), g * load / np.sqrt(delta)


@kernel
def asperity_force(above_end, k, near, end):
    """Return P* of the k-th nearby asperity and its slope."""
    if near.lines.size:
        return line_force(near.lines[k], above_end)
    return closed_force(end + above_end)


@kernel
def total_force(delta, n, near, grid):
    """Return the ``Total`` at δ of the first n asperities, whose onsets are below δ."""
    scales = grid.field.scales
    F = slope = A = S = 0.0
    for k in range(n):
        i = near.index[k]
        above_end = (delta - near.offset[k]) / scales.delta[i] - scales.end[i]
        p, dp = asperity_force(max(above_end, 0.0), k, near, scales.end[i])
        p *= scales.P[i]
        dp *= scales.P[i] / scales.delta[i]
        F += p
        slope += dp
        A += p if dp > 0.0 else -grid.adhesion[i]
        S += max(dp, 0.0)
    return Total(F, slope, A, S)


@kernel
def _is_bounded_beyond(x, y, reach, total, near, least, grid, radius):
    """Return whether F provably stays above ``least`` beyond ``reach``, with all distant asperities."""
    if near.touch > reach:
        return grid.adhesion.size == 0  # the first touch is not known yet
    cells = grid.cells
    known_adhesion = near.adhesion[-1]
    nx = cells.first.shape[0]
    ny = cells.first.shape[1] - 1
    delta = reach
    step = 0.05 * (reach - grid.highest)
    while True:
        r = distance_at_height(delta + step - grid.highest, radius)
        i0, i1, j0, j1 = _square(x, y, r, cells)
        a = cells.adhesion
        unknown = a[i1, j1] - a[i0, j1] - a[i1, j0] + a[i0, j0] - known_adhesion
        if total.A + total.S * (delta - reach) - max(unknown, 0.0) < least.F:
            return False
        if (i0 == 0 and j0 == 0 and i1 == nx and j1 == ny) or r >= radius:
            return True
        delta = delta + step
        step = 1.5 * step
