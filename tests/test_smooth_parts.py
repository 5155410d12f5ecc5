"""Parts of the solver for smooth laws, each against what defines it: linear systems, extrapolation, contacts."""

import numpy as np
import pytest

from roughxr.kernels.adhesion import newton_system
from roughxr.kernels.adhesion import traction_laws as smooth_laws
from roughxr.kernels.adhesion.equilibrium import ContactState, closed_parts
from roughxr.kernels.adhesion.patches import contacts_and_resolution
from roughxr.kernels.adhesion.path import follow_smooth
from roughxr.kernels.halfspace.love import love_coefficients
from roughxr.kernels.halfspace.products import DENSE_LIMIT
from roughxr.kernels.halfspace.transforms import convolution, even_length, transfer_of
from roughxr.kernels.jit import kernel

LOVE = love_coefficients(257, 257)
LAW = smooth_laws.law_of(exponential=(0.03, 0.4))


@kernel
def solve(rows, columns, coefficients, product, inverse, touching, tau, right, part, known, room, x, image):
    near = newton_system.near_cells(rows, columns, coefficients, product, inverse)
    return newton_system.solve(near, touching, tau, right, part, known, room, x, image)


class System:
    """A disc of cells that touch within a ring of cells that attract, and what solves it."""

    def __init__(self, radius, seed=0):
        n, rng = int(2 * radius) + 5, np.random.default_rng(seed)
        distance = np.hypot(*(np.indices((n, n)) - 0.5 * (n - 1)))
        self.rows, self.columns = np.nonzero(distance < radius + 1.5)
        self.touching = distance[self.rows, self.columns] < radius
        count = self.rows.size
        self.tau = np.where(self.touching, 0.0, rng.uniform(0.0, 0.25, count))
        self.right = rng.uniform(0.5, 1.0, count)
        self.love = LOVE[abs(self.rows[:, None] - self.rows), abs(self.columns[:, None] - self.columns)]
        size = even_length(n)
        wide, single = transfer_of(2 * size, 2 * size, LOVE), np.complex64(0)
        periodic = (1.0 / (size**4 * transfer_of(size, size, LOVE).double)).astype(np.float32)
        self.boxes = convolution(n, 2 * size, wide.single, single), convolution(n, size, periodic, single)
        self.room, self.x, self.image = newton_system.workspace(30, count), np.empty(count), np.empty(count)

    def solve(self, part, tau=None, known=0):
        tau = self.tau if tau is None else tau
        given = self.touching, tau, self.right, part, known, self.room, self.x, self.image
        return solve(self.rows, self.columns, LOVE, *self.boxes, *given)

    def left(self, tau):
        """Return the part of the right side that is not solved."""
        sides = np.where(self.touching, self.image, self.x - tau * self.image)
        return np.linalg.norm(sides - self.right) / np.linalg.norm(self.right)


SIZES = pytest.mark.parametrize("radius", [3.0, 9.5], ids=["by a matrix", "by transforms"])


@SIZES
def test_a_linear_system_is_solved_to_its_part(radius):
    system = System(radius)
    assert (system.rows.size > DENSE_LIMIT) == (radius > 5)
    for part in (0.2, 1e-4):
        products = system.solve(part)
        np.testing.assert_allclose(system.image, system.love @ system.x, atol=1e-5 * abs(system.image).max())
        assert system.left(system.tau) < 1.01 * part
        assert products < 30
    tau = system.tau[:, None]
    matrix = np.where(system.touching[:, None], system.love, np.eye(system.x.size) - tau * system.love)
    assert system.x == pytest.approx(np.linalg.solve(matrix, system.right), abs=2e-2 * abs(system.x).max())


@SIZES
def test_another_slope_is_solved_best_by_the_directions_at_hand(radius):
    """By no other combination of them is less left; what they leave takes fewer products than all of it."""
    system = System(radius)
    size = system.solve(1e-2)
    tau = 0.7 * system.tau
    assert system.solve(1.0, tau, known=size) == size
    directions, images = system.room.preconditioned[:size].T, system.room.images[:size].T
    sides = np.where(system.touching[:, None], images, directions - tau[:, None] * images)
    best = np.linalg.lstsq(sides, system.right)[0]
    np.testing.assert_allclose(system.x, directions @ best, atol=1e-6 * abs(system.x).max())
    np.testing.assert_allclose(system.image, images @ best, atol=1e-6 * abs(system.image).max())
    known, goal = system.left(tau), 1e-3
    assert goal < known < 0.5
    more = system.solve(goal, tau, known=size) - size
    assert system.left(tau) < 1.01 * goal
    assert 0 < more < system.solve(goal, tau)


def test_nothing_is_solved_by_nothing():
    system = System(3.0)
    system.right[:] = 0.0
    with np.errstate(invalid="ignore"):
        assert system.solve(0.2) == 0
    assert not system.x.any() and not system.image.any()


@pytest.mark.parametrize("name", ["exponential", "waals", "step"])
def test_slopes_are_those_of_the_tractions_and_tractions_those_of_the_work(name):
    """From contact on, where the van der Waals law repels more the closer it is."""
    law = smooth_laws.law_of(**{name: (0.03, 0.4)})
    u, part = np.linspace(1e-4, 3.0, 61), 1e-5
    every = [
        [(*smooth_laws.traction(x, law), smooth_laws.remaining_work(x, law)) for x in u + d] for d in (-part, 0, part)
    ]
    (low, _, more), (t, fall, _), (high, _, less) = np.transpose(every, (0, 2, 1))
    np.testing.assert_allclose(fall, (low - high) / (2 * part), atol=1e-6 * law.strength / law.length)
    np.testing.assert_allclose(t, (more - less) / (2 * part), atol=1e-6 * law.strength)


def test_contacts_are_counted_where_cells_touch_and_sized_by_what_is_closed():
    """Nine and four cells with a ring between them that attracts, and a single cell that bears next to nothing."""
    gap, touching = np.full((12, 20), 10.0), np.zeros((12, 20), bool)
    for block in ((slice(2, 5), slice(2, 5)), (slice(6, 8), slice(9, 11)), (slice(10, 11), slice(18, 19))):
        gap[block], touching[block] = 0.0, True
    gap[5, 2:5] = 0.3  # nearest to the nine
    gap[6:8, 11] = 0.5  # to the four
    pressure = np.where(touching, 0.2, -LAW.strength * np.exp(-gap / LAW.length))
    pressure[2, 2:5], pressure[6, 9], pressure[10, 18] = -0.05, -0.07, -0.001
    state = ContactState(pressure, gap, touching)
    closed = closed_parts(state, LAW)
    np.testing.assert_allclose(closed, np.exp(-gap / LAW.length), atol=1e-4)
    found, radius = contacts_and_resolution(state, closed, LAW)
    assert found == 3
    assert radius == pytest.approx(np.sqrt((4 + 2 * np.exp(-0.5 / LAW.length)) / np.pi), rel=1e-4)
    pressure[6:8, 9:12], pressure[10, 18] = 0.2, 0.2  # neither the four nor the one pull
    found, radius = contacts_and_resolution(state, closed, LAW)
    assert radius == pytest.approx(np.sqrt((9 + 3 * np.exp(-0.3 / LAW.length)) / np.pi), rel=1e-4)
    alone = ContactState(np.where(touching, 0.0, pressure), gap, np.zeros_like(touching))  # two rims without a core
    found, radius = contacts_and_resolution(alone, closed, LAW)
    assert found == 0
    assert radius == pytest.approx(np.sqrt(3 * np.exp(-0.3 / LAW.length) / np.pi), rel=1e-4)
    nothing = ContactState(np.zeros_like(gap), gap, np.zeros_like(touching))
    assert contacts_and_resolution(nothing, closed, LAW)[0] == 0
    assert np.isnan(contacts_and_resolution(nothing, closed, LAW)[1])


def test_a_long_contact_may_lie_along_either_axis():
    """Where its linear systems need a part of the box that begins elsewhere along its length than across it."""
    x, y = np.arange(40) - 19.6, np.arange(132) - 65.7
    separation = x[:, None] ** 2 / 50 + y**2 / 800
    paths = []
    for turned in (separation, np.ascontiguousarray(separation.T)):
        (found,) = follow_smooth(turned, [0.5], 0.25, LOVE, LAW, fields=True)
        assert found.states["converged"].all()
        assert np.count_nonzero(found.pressures[0]) > DENSE_LIMIT
        paths.append(found)
    one, other = paths
    assert one.states["force"].min() == pytest.approx(other.states["force"].min(), rel=1e-3)
    np.testing.assert_allclose(one.pressures[0], other.pressures[0].T, atol=1e-4 * LAW.strength)
    rounds = sorted(found.states["iterations"].sum() for found in paths)
    assert rounds[1] <= 1.2 * rounds[0]
