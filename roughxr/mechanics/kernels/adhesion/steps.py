"""The states of a path, and the steps between them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

#: Values of a state. Yielding: the shares of compressive force and touching cells at the hardness or above, and area
#: and volume of the dents, in cells.
STATE = np.dtype(
    [
        *((name, float) for name in ("delta", "force", "contact_area", "energy", "dissipated", "contact_patches")),
        *((name, float) for name in ("resolution", "residual", "yielded_fraction", "yielded_area_fraction")),
        *((name, float) for name in ("yielded_area", "plastic_work")),
        ("iterations", int),
        ("converged", bool),
        ("prescribed", bool),
    ]
)

#: A step has jumped if it dissipates more than this part of |ΔF Δδ|. A smooth branch stays well below.
_JUMP_DISSIPATION = 0.15

#: A step has passed a sharp edge if it gains more than this part. A smooth branch stays well below.
_EDGE_GAIN = 0.05

#: Avoids 0/0 in ratios.
_TINY = 1e-300

#: Shortest step over the longest.
SHORTEST_STEP = 1.0 / 64

#: Displacements closer than this part of a step count as equal.
EQUAL_DELTA = 1e-9

#: Contacts and their resolution at states that nobody reads: counting takes a tenth of a solve.
_NOT_COUNTED = -1, np.nan


@dataclass(slots=True)
class Visit:
    """A state of the path: its row and, while a larger tension may lie beyond, the state itself."""

    row: np.void
    solved: Any
    stiffness: float
    pressure: np.ndarray | None = None
    residual_height: np.ndarray | None = None
    observed: Any = None
    most: float = -np.inf  # the largest tension that may lie between this state and the next


class Stepper:
    """The present state of a path, and the states visited so far."""

    def __init__(self, solver, step, deltas, fields):
        self.solver = solver
        self.step = step
        self.deltas = deltas
        self.fields = fields
        self.visited = []
        self.largest = 0.0
        self.stiffness = np.inf
        self.last = None

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present state."""
        freed = self._freed_energy(solved)
        moved = self.last.delta - solved.delta
        if moved != 0.0 and self._is_smooth(solved):  # across a jump two states do not give the stiffness
            self.stiffness = (self.last.force - solved.force) / moved
        self.last = solved
        self.largest = max(self.largest, -solved.force)
        pressure = residual_height = None
        if prescribed and self.fields:
            pressure = np.zeros(self.solver.separation.shape)
            pressure[solved.rows, solved.columns] = solved.state.pressure
            residual_height = solved.residual_height
        row = self._row(solved, prescribed, freed)
        self.visited.append(Visit(row, solved, self.stiffness, pressure, residual_height))

    def _row(self, solved, prescribed, freed):
        """Return the values of a state, with the energy freed by the last step in place of the whole dissipation."""
        row = np.zeros(1, STATE)[0]
        state = solved.state
        row["delta"] = solved.delta
        row["force"] = solved.force
        row["energy"] = solved.energy
        row["dissipated"] = freed
        row["contact_patches"], row["resolution"] = self.solver.contacts(state) if prescribed else _NOT_COUNTED
        row["contact_area"] = state.touching.sum()
        row["residual"] = solved.residual
        row["iterations"] = solved.rounds
        row["converged"] = solved.converged
        row["prescribed"] = prescribed
        for name, value in self.solver.yielded(solved).items():
            row[name] = value
        return row

    def _is_smooth(self, solved):
        """Return whether a step follows a branch, judged by its dissipation."""
        work = abs((self.last.force - solved.force) * (self.last.delta - solved.delta)) + _TINY
        return -_EDGE_GAIN <= self._freed_energy(solved) / work <= _JUMP_DISSIPATION

    def has_dissipated(self, solved, part=1.0):
        """Return whether a step has jumped to another branch, if the jump lies in a part of the step."""
        work = abs((self.last.force - solved.force) * (self.last.delta - solved.delta)) + _TINY
        return self._freed_energy(solved) / work > part * _JUMP_DISSIPATION

    def _freed_energy(self, solved):
        """Return the energy dissipated by the step to a state, nm²."""
        last = self.last
        return 0.5 * (solved.force + last.force) * (solved.delta - last.delta) - (solved.energy - last.energy)
