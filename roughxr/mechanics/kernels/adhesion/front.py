"""The contact of a soft sphere as one region, by the front that bounds it: a(θ), followed through pinning and jumps.

A region of radius a on a half space, with the separation s(r, θ) of the undeformed bodies about its middle, has at its
edge the stress intensity

    K(θ) = E* [g(a, θ) − Δ] / √(πa),    g_n(a) = a ∫₀ᵃ (r/a)ⁿ [s_n′(r) + n s_n(r)/r] / √(a² − r²) dr,

for each harmonic n of θ (Copson 1947; Sneddon 1965 for n = 0), exact for any s. An edge that deviates from a circle,
a(θ) = m + Σ a_n e^{inθ}, changes K to first order by S = Σ |n| a_n e^{inθ} K₀/2m (Gao & Rice 1987), with K₀ = √(2E*w)
by Griffith. The second order is known in the mean: as an edge moves on, its mean energy per area is that without S,
so that ⟨S²⟩ + 2K₀⟨K₂⟩ vanishes where K is uniform, and K₀² − ⟨K⟩² = ⟨S²⟩ at rest. On fine roughness that is the energy
that flattening it takes, U = (E*/4) Σ q |h_q|². The edge rests where

    K(θ) + S(θ) + ⟨S²⟩/2K₀ = K₀.

Where the left side is larger the region shrinks, where it is smaller it grows. A state follows from the one before by
motion of the edge, which stays at the first position that holds it (Sanner & Pastewka 2022,
doi:10.1016/j.jmps.2022.104781). Within, K is written as E* P/√π, so that P² = 2πw/E* at rest.

a, m    radius of the edge, and its mean over θ, nm;  r radius within the region, nm
s       separation of the undeformed bodies, nm;  Δ ``delta``, displacement, > 0 brings the bodies together, nm
E*, w   contact modulus, GPa, and work of adhesion, J/m²
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.transforms import lowlevel
from ..jit import kernel

#: Largest imbalance of an edge at rest, as a part of L = √(2πmw/E*), and most steps of motion.
TOLERANCE = 1e-4
_MOST_STEPS = 20_000

#: Powers (r/a)ⁿ that are neglected.
_NEGLIGIBLE = 1e-12

#: Axis of the transforms.
_ALONG_EDGE = np.array([1])

#: Results of a motion: at rest, lost, beyond the radii, too slow.
AT_REST, LOST, BEYOND, SLOW = range(4)


class Landscape(NamedTuple):
    """Displacements at which the stress intensity of a circular edge vanishes, g, by radius and angle."""

    radii: np.ndarray  # (nr,), uniform from one spacing on, nm
    edge_delta: np.ndarray  # (nr, nθ), g, nm
    slope: np.ndarray  # (nr, nθ), its derivative by the radius
    integral: np.ndarray  # (nr, nθ), its integral from the first radius, nm²


class State(NamedTuple):
    """An edge at rest."""

    delta: float  # nm
    force: float  # nN
    radius: np.ndarray  # (nθ,), nm
    second_order: float  # ⟨S²⟩/K₀², the part of w that the shape of the edge takes


def landscape(r, s, s_slope):
    """Return the :class:`Landscape` of a separation s(r, θ), nm, and of its derivative, on radii from zero on."""
    r = np.ascontiguousarray(r)  # another layout would be compiled once more
    spacing = r[1] - r[0]
    a = r[1:]
    harmonics = np.fft.rfft(s, axis=1)
    n = np.arange(harmonics.shape[1])
    integrand = np.fft.rfft(s_slope, axis=1)
    integrand[0, 1] *= 2.0  # s/r in the middle
    integrand[1:] += n * harmonics[1:] / a[:, None]
    g = _integrated(a, r, _weights(a, r), integrand)
    g[:, 0] += harmonics[0, 0]
    g = np.fft.irfft(g, s.shape[1], axis=1)
    integral = np.zeros_like(g)
    integral[1:] = np.cumsum(0.5 * spacing * (g[1:] + g[:-1]), axis=0)
    return Landscape(a, g, np.gradient(g, spacing, axis=0), integral)


@kernel
def _integrated(a, r, weights, integrand):
    """Return a Σ weights (r/a)ⁿ integrand over the radii r for each radius a and harmonic n (nr, nθ/2 + 1)."""
    out = np.zeros((a.size, integrand.shape[1]), np.complex128)
    for i in range(a.size):
        for j in range(i + 2):
            power = a[i] * weights[i, j]
            ratio = min(r[j] / a[i], 1.0)
            least = _NEGLIGIBLE * power
            for n in range(integrand.shape[1]):
                out[i, n] += power * integrand[j, n]
                power *= ratio
                if power < least:
                    break
    return out


def _weights(a, r):
    """Return ∫₀ᵃ f(r)/√(a² − r²) dr as weights (a, r) of the values of a function that is linear between radii."""
    spacing = r[1] - r[0]
    angle = np.arcsin(np.clip(r / a[:, None], 0.0, 1.0))
    root = -np.sqrt(np.clip(a[:, None] ** 2 - r**2, 0.0, None))
    constant = np.diff(angle, axis=1)
    linear = np.diff(root, axis=1)
    weights = np.zeros((a.size, r.size))
    weights[:, :-1] = (r[1:] * constant - linear) / spacing
    weights[:, 1:] += (linear - r[:-1] * constant) / spacing
    return weights


@kernel
def _imbalance(radii, edge_delta, slope, excess, delta, a, out):
    """Write the displacement g − Δ − √a ``excess`` that an edge lacks to rest; return its largest, and the largest g′.

    ``excess`` are by angle what P at rest exceeds the nonlocal part by, √nm.
    """
    largest = 0.0
    steepest = 1e-9
    for k in range(a.size):
        place = min(max((a[k] - radii[0]) / (radii[1] - radii[0]), 0.0), radii.size - 1.000001)
        i = int(place)
        part = place - i
        g = (1.0 - part) * edge_delta[i, k] + part * edge_delta[i + 1, k]
        out[k] = g - delta - np.sqrt(a[k]) * excess[k]
        largest = max(largest, abs(out[k]))
        steepest = max(steepest, (1.0 - part) * slope[i, k] + part * slope[i + 1, k])
    return largest, steepest


@kernel
def _weighted_by_order(a):
    """Return Σ |n| a_n e^{inθ} of an edge, (1, nθ)."""
    n = a.size
    values = np.empty((1, n))
    values[0] = a
    harmonics = np.empty((1, n // 2 + 1), np.complex128)
    lowlevel.r2c(values, harmonics, _ALONG_EDGE, True, 1.0, 1)
    for k in range(harmonics.size):
        harmonics[0, k] *= k / n
    lowlevel.c2r(harmonics, values, _ALONG_EDGE, False, 1.0, 1)
    return values


@kernel
def _implicit_motion(imbalance, L, stiffness):
    """Return an imbalance over 1 + |n| L/``stiffness``, and Σ |n| of that, (2, nθ)."""
    n = imbalance.size
    harmonics = np.empty((1, n // 2 + 1), np.complex128)
    motion = np.empty((2, n // 2 + 1), np.complex128)
    moved = np.empty((2, n))
    lowlevel.r2c(imbalance, harmonics, _ALONG_EDGE, True, 1.0, 1)
    for k in range(harmonics.size):
        motion[0, k] = harmonics[0, k] / (n + n * k * L / stiffness)
        motion[1, k] = k * motion[0, k]
    lowlevel.c2r(motion, moved, _ALONG_EDGE, False, 1.0, 1)
    return moved


@kernel
def move_to_rest(radii, edge_delta, slope, rest, delta, a):
    """Move an edge until it rests; return a result (``AT_REST`` …) and the number of steps.

    ``rest`` is P at rest, √nm. ``a`` is changed in place. Each step takes the nonlocal part implicitly: the imbalance
    is divided by g′ + (L/2m) |n|, with the steepest g′ of all angles.
    """
    n = a.size
    imbalance = np.empty((1, n))
    spread = _weighted_by_order(a)
    for step in range(_MOST_STEPS):
        mean = a.mean()
        stiffness = rest / (2.0 * mean)
        second = np.sum(spread[0] ** 2) * stiffness**2 / (2.0 * rest * n)
        excess = rest - second - stiffness * spread[0]
        largest, steepest = _imbalance(radii, edge_delta, slope, excess, delta, a, imbalance[0])
        L = rest * np.sqrt(mean)
        if largest < TOLERANCE * L:
            return AT_REST, step
        moved = _implicit_motion(imbalance, L, 2.0 * mean * steepest)
        scale = min(1.0 / steepest, (radii[1] - radii[0]) / np.abs(moved[0]).max())
        a -= scale * moved[0]
        spread[0] -= scale * moved[1]
        if a.min() < 1.001 * radii[0]:
            return LOST, step
        if a.max() > radii[-2]:
            return BEYOND, step
    return SLOW, _MOST_STEPS


class Front:
    """The edge of a contact on a :class:`Landscape`; each state is sought from the one before."""

    def __init__(self, shape, modulus, work):
        self.shape = shape
        self.modulus = modulus
        self.rest = np.sqrt(2.0 * np.pi * work / modulus)
        count = shape.edge_delta.shape[1]
        self.radius = np.full(count, 2.0 * shape.radii[1])

    def move(self, delta):
        """Move the edge to rest at a displacement, nm; return ``AT_REST``, ``LOST``, ``BEYOND`` or ``SLOW``."""
        a = self.radius.copy()
        shape = self.shape
        result, _ = move_to_rest(shape.radii, shape.edge_delta, shape.slope, self.rest, delta, a)
        if result == AT_REST:
            self.radius = a
        return result

    def state(self, delta):
        """Return the state of an edge at rest at a displacement, nm.

        Its force is F = 2E* ∮∫ (Δ − g) da dθ/2π, and the second order of the edge's shape.
        """
        radii = self.shape.radii
        a = self.radius
        place = np.clip((a - radii[0]) / (radii[1] - radii[0]), 0.0, radii.size - 1.000001)
        i = place.astype(int)
        part = place - i
        columns = np.arange(a.size)
        integral = (1.0 - part) * self.shape.integral[i, columns] + part * self.shape.integral[i + 1, columns]
        middle = radii[0] * (self.shape.edge_delta[0].mean() - delta)
        mean = a.mean()
        harmonics = np.fft.rfft(a)
        spread = np.fft.irfft(np.arange(harmonics.size) * harmonics, a.size)
        second = 0.5 * self.rest / np.sqrt(mean) * np.mean((a - mean) * spread)
        force = -2.0 * self.modulus * (middle + np.mean(integral - (a - radii[0]) * delta) + second)
        return State(delta, force, a, np.mean(spread**2) / (2.0 * mean) ** 2)


def approach(front, delta, step, preload):
    """Return the states of an approach from a displacement in steps (nm) until the force reaches the preload, nN.

    And the result of the last motion: other than ``AT_REST`` if the preload was not reached.
    """
    states = []
    while True:
        result = front.move(delta)
        if result == AT_REST:
            states.append(front.state(delta))
            if states[-1].force >= preload:
                return states, result
        elif result != LOST or states:
            return states, result
        delta += step


def retraction(front, delta, step):
    """Return the states of a retraction from a displacement in steps (nm), and the result of the last motion."""
    states = []
    while True:
        delta -= step
        result = front.move(delta)
        if result != AT_REST:
            return states, result
        states.append(front.state(delta))
