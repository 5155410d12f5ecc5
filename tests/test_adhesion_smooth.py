"""Adhesion of finite range: equilibria against an independent minimisation, limits, balances and invariances."""

import numpy as np
import pytest
import scipy.fft
from scipy.optimize import minimize

from roughxr.mechanics.kernels.adhesion import traction_laws as laws
from roughxr.mechanics.kernels.adhesion.path import follow_path
from roughxr.mechanics.kernels.halfspace.love import love_coefficients
from roughxr.mechanics.kernels.halfspace.products import DENSE_LIMIT, surface_displacement

from . import half_space as kalker

RADIUS = 2000.0  # cells
W = 0.03
LENGTH = 0.4


def sphere(n=96, radius=RADIUS, shift=(0.0, 0.0)):
    x, y = (np.arange(n) - 0.5 * (n - 1) + part for part in shift)
    return (x[:, None] ** 2 + y[None, :] ** 2) / (2 * radius)


def rough(seed, n=96):
    """A sphere with bumps of some cells; its lowest point at zero."""
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((n, n)))
    q = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None, :])
    bumps = np.fft.irfft2(noise * np.where(q > 0, 1.0, 0.0) * np.exp(-((12 * q) ** 2)), (n, n))
    out = sphere(n) + 0.8 * bumps / bumps.std()
    return out - out.min()


def follow(separation, deltas, law, step=0.25, **options):
    return follow_path(separation, deltas, step, law, **options)


def pull_off(path):
    return -path.states["force"][path.first_retraction :].min()


@pytest.fixture(scope="module")
def law():
    return laws.smooth_law(exponential=(W, LENGTH))


@pytest.mark.parametrize("name, cut", [("exponential", 40.0), ("waals", 1e4)])
def test_laws_do_the_work_of_separation(name, cut):
    law = laws.smooth_law(**{name: (W, LENGTH)}, cut=cut * LENGTH)
    u = np.r_[0.0, np.geomspace(1e-4, law.range, 40001)[:-1]]
    t, fall = np.array([laws.traction(x, law) for x in u]).T
    assert np.trapezoid(t, u) == pytest.approx(W, rel=1e-4)
    assert t.max() == pytest.approx(law.strength, rel=1e-3)
    k = 20000
    work = laws.remaining_work(u[k], law)
    assert work == pytest.approx(np.trapezoid(t[k:], u[k:]), rel=1e-3)
    assert fall[k] == pytest.approx(-(t[k + 1] - t[k - 1]) / (u[k + 1] - u[k - 1]), rel=1e-2)


class Oracle:
    """Least energy over the gaps of a box that is padded for free boundaries: nothing of the engine's own.

    In the displacement u of the padded, periodic box the energy is a quadratic form, the inverse of Love's
    coefficients; what pads it is free of traction at the minimum.
    """

    def __init__(self, separation, w, length):
        self.separation = separation
        self.w = w
        self.length = length
        self.n = separation.shape[0]
        size = 2 * separation.shape[0]
        at = np.minimum(np.arange(size), size - np.arange(size))
        self.stiffness = 1 / scipy.fft.rfft2(love_coefficients(size, size)[at][:, at])

    def pressure(self, u):
        return scipy.fft.irfft2(scipy.fft.rfft2(u) * self.stiffness, u.shape)

    def energy(self, v, delta):
        u = v.reshape(2 * self.n, 2 * self.n)
        p = self.pressure(u)
        gap = (self.separation - delta + u[: self.n, : self.n]) / self.length
        pull = self.w * np.exp(-gap)
        gradient = p.copy()
        gradient[: self.n, : self.n] += pull / self.length
        return 0.5 * np.sum(u * p) - pull.sum(), gradient.ravel()

    def force(self, delta, u):
        """Return the force, nm, and the displacement that has it, from a first one."""
        low = np.full(u.shape, -np.inf)
        low[: self.n, : self.n] = delta - self.separation
        bounds = np.stack([low.ravel(), np.full(low.size, np.inf)], axis=1)
        start = np.maximum(u, low).ravel()
        limits = {"maxiter": 3000, "maxfun": 6000, "ftol": 0.0, "gtol": 3e-5 * self.w / self.length, "maxcor": 8}
        minimum = minimize(self.energy, start, (delta,), "L-BFGS-B", jac=True, bounds=bounds, options=limits)
        u = minimum.x.reshape(u.shape)
        return self.pressure(u)[: self.n, : self.n].sum(), u


@pytest.mark.parametrize("seed", [1, 2])
def test_force_is_that_of_an_independent_minimisation(seed, law):
    separation = rough(seed, 48)
    deltas = np.array([0.5, 1.0, 1.5])
    (path,) = follow(separation, deltas, law)
    ours = path.states[(path.states["prescribed"] > 0)][: deltas.size]
    oracle = Oracle(separation, W, LENGTH)
    u = np.zeros((96, 96))
    theirs = []
    for delta in deltas:
        force, u = oracle.force(delta, u)
        theirs.append(force)
    np.testing.assert_allclose(ours["force"], theirs, rtol=0.01, atol=0.01 * pull_off(path))


def test_short_range_pulls_off_as_jkr():
    radius = 400.0
    w = 0.02
    errors = []
    for tabor in (1.5, 3.0):
        length = (radius * w**2) ** (1 / 3) / tabor
        (path,) = follow(sphere(100, radius), [0.5], laws.smooth_law(exponential=(w, length)), step=0.1)
        errors.append(pull_off(path) / (1.5 * np.pi * w * radius) - 1)
        assert path.states["converged"].all()
    assert 0 < errors[1] < errors[0] < 0.12
    assert errors[1] < 0.06


def test_a_stiff_sphere_pulls_off_as_a_rigid_one():
    radius = 250.0
    w = 5e-6
    (path,) = follow(sphere(130, radius), [0.2], laws.smooth_law(exponential=(w, 0.8), cut=10.0 * 0.8), step=0.2)
    assert pull_off(path) == pytest.approx(2 * np.pi * w * radius, rel=0.02)


def test_without_adhesion_it_presses_as_the_elastic_contact():
    separation = rough(3)
    elastic = kalker.solve(separation, 1.0, 1.0, 1.0, tolerance=1e-7).force
    errors = []
    for w in (1e-2 * W, 1e-3 * W, 1e-4 * W):
        (path,) = follow(separation, [1.0], laws.smooth_law(exponential=(w, LENGTH)))
        errors.append(1 - path.states["force"][path.first_retraction - 1] / elastic)
    np.testing.assert_allclose(errors[1:], np.array(errors[:-1]) / 10, rtol=0.1)  # in proportion to w, to nothing
    assert 0 < errors[-1] < 5e-4


def test_every_state_is_an_equilibrium(law):
    separation = rough(4)
    deltas = np.array([0.5, 1.0])
    (path,) = follow(separation, deltas, law, fields=True)
    asked = path.states[path.states["prescribed"] > 0]
    assert len(asked) == len(path.pressures) == 4
    assert path.states["converged"].all()
    for state, pressure in zip(asked, path.pressures):
        gap = separation - state["delta"] + surface_displacement(pressure, 1.0, 1.0)
        pull = np.array([laws.traction(max(g, 0.0), law)[0] for g in gap.ravel()]).reshape(gap.shape)
        touching = pressure + pull > 1e-4 * law.strength
        assert gap.min() > -1e-4 * law.strength
        assert np.abs(gap[touching]).max(initial=0) < 1e-4 * law.strength
        assert np.abs(pressure + pull)[~touching].max() < 2e-4 * law.strength
        assert state["force"] == pytest.approx(pressure.sum())


@pytest.mark.parametrize(("n", "length", "jumps"), [(64, LENGTH, False), (48, LENGTH / 4, True)])
def test_work_of_the_force_is_energy_and_what_is_lost(n, length, jumps):
    """Contacts jump under a law of short range, and lose more than they hold; under the other one they lose nothing."""
    (path,) = follow(rough(5, n), [1.0], laws.smooth_law(exponential=(W, length)), step=0.1)
    s = path.states
    work = np.sum(0.5 * (s["force"][1:] + s["force"][:-1]) * np.diff(s["delta"]))
    largest_energy = np.abs(s["energy"]).max()
    assert s["dissipated"][-1] == pytest.approx(work, abs=1e-2 * largest_energy)
    assert abs(s["energy"][-1]) < 1e-2 * largest_energy
    assert s["dissipated"][-1] > (1 if jumps else -1e-2) * largest_energy


def test_step_shift_and_window_do_not_matter(law):
    separation = rough(6, 48)
    reference = pull_off(follow(separation, [1.0], law)[0])
    assert pull_off(follow(separation, [1.0], law, step=0.1)[0]) == pytest.approx(reference, rel=0.01)
    assert pull_off(follow(separation + 3.0, [4.0], law)[0]) == pytest.approx(reference, rel=1e-4)
    wider = np.pad(separation, ((9, 4), (2, 7)), constant_values=np.nan)
    assert pull_off(follow(wider, [1.0], law)[0]) == pytest.approx(reference, rel=1e-4)
    turned = np.ascontiguousarray(np.rot90(separation))
    assert pull_off(follow(turned, [1.0], law)[0]) == pytest.approx(reference, rel=1e-3)


def test_preloads_share_one_loading_and_are_met(law):
    separation = rough(7, 48)
    (deep,) = follow(separation, [2.0], law)
    largest_force = deep.states["force"].max()
    preloads = np.array([0.0, 0.3, 0.6]) * largest_force
    paths = follow(separation, [2.0], law, preloads=preloads)
    assert len(paths) == 3
    for preload, path in zip(preloads, paths):
        assert path.states["force"][path.first_retraction - 1] == pytest.approx(preload, abs=5e-3 * largest_force)
        assert path.states["contact_area"][path.first_retraction - 1] > 0
        assert path.states["contact_area"][-1] == 0
    turns = [path.first_retraction for path in paths]
    for path, turn in zip(paths[1:], turns):
        for name in path.states.dtype.names:
            np.testing.assert_array_equal(path.states[name][:turn], paths[-1].states[name][:turn])


def test_more_cells_than_allowed_are_refused_as_data(law):
    (path,) = follow(sphere(), [1.0], law, max_cells=10)
    assert path.status == 2
    assert len(path.states) == 0


def test_what_is_never_touched_has_no_force(law):
    (path,) = follow(sphere() + 50.0, [1.0, 2.0], law)
    assert not path.states["force"].any() and not path.states["contact_area"].any()
    assert path.states["prescribed"].sum() == 4


@pytest.mark.parametrize("name", ["exponential", "waals", "step"])
def test_slopes_are_those_of_the_tractions_and_tractions_those_of_the_work(name):
    """From contact on, where the van der Waals law repels more the closer it is."""
    law = laws.smooth_law(**{name: (0.03, 0.4)})
    length = 1.6 if name == "step" else 0.4
    u = np.linspace(1e-4, 3.0, 61)
    part = 1e-5
    tractions_and_work = [
        [(*laws.traction(x, law), laws.remaining_work(x, law)) for x in u + d] for d in (-part, 0, part)
    ]
    (low, _, more), (t, fall, _), (high, _, less) = np.transpose(tractions_and_work, (0, 2, 1))
    np.testing.assert_allclose(fall, (low - high) / (2 * part), atol=1e-6 * law.strength / length)
    np.testing.assert_allclose(t, (more - less) / (2 * part), atol=1e-6 * law.strength)


def test_a_long_contact_may_lie_along_either_axis(law):
    """Where its linear systems need a part of the box that begins elsewhere along its length than across it."""
    x = np.arange(40) - 19.6
    y = np.arange(132) - 65.7
    separation = x[:, None] ** 2 / 50 + y**2 / 800
    orientations = separation, separation.T.copy()
    (along_x,), (along_y,) = (follow(turned, [0.5], law, fields=True) for turned in orientations)
    assert along_x.states["converged"].all() and along_y.states["converged"].all()
    assert np.count_nonzero(along_x.pressures[0]) > DENSE_LIMIT
    assert along_x.states["force"].min() == pytest.approx(along_y.states["force"].min(), rel=1e-3)
    np.testing.assert_allclose(along_x.pressures[0], along_y.pressures[0].T, atol=1e-4 * law.strength)
