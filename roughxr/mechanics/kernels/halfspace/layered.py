"""Displacement of a half space under a bonded film: the influence coefficients of a uniformly loaded square.

A pressure p̂(q) sinks a film of thickness h, bonded to a half space, by û(q) = 2 p̂ F(qh)/(E₁* q), with s = qh and

    F(s) = [1 + 4κ s e⁻²ˢ − λκ e⁻⁴ˢ] / [1 − (λ + κ + 4κ s²) e⁻²ˢ + λκ e⁻⁴ˢ],
    κ = (m − 1)/(m + 3 − 4ν₁),     λ = 1 − 4(1 − ν₁)/(1 + m (3 − 4ν₂)),     m = μ₁/μ₂

(Burmister 1945; O'Sullivan & King 1988), 1 film and 2 base, E₁* = E₁/(1 − ν₁²): F → 1 for large s, E₁*/E₂* for small.
The film's own half space has F = 1, Love's coefficients. The rest is smooth, and fitted by images, F − 1 = Σ cₖ e⁻ᵃˢ:
each is the displacement 1/√(r² + (aₖ h)²) by a charge at the depth aₖ h, in closed form for squares. So nothing is
periodic, and far away the base alone answers. F is met to 1e-8 (m ≤ 3), or 1e-6 of F(0) (m ≤ 1000). Source: own.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from .love import cell_integrals, love_coefficients

#: Number of images.
_IMAGES = 50

#: Their least depth.
_SHALLOW = 1.2

#: Their greatest depth at m ≤ 1.
_DEEP = 60.0

#: Values of s at which they are fitted.
_FITTED_AT = np.geomspace(1e-5, 30.0, 1500)

#: From so many cells on a square's mean is that of its second derivatives (5e-8 of Love's).
_NEAR = 24

#: Number of distances between which they are interpolated.
_DISTANCES = 400

#: Displacements that are negative by more than this part of Love's count as upward.
_UPWARD = 1e-6


class Film(NamedTuple):
    """A film bonded to a half space, as one of a pair of bodies."""

    thickness: float  # cells, or nm
    share: float  # E*/E₁* of the pair and the film
    mismatch: float  # m = μ₁/μ₂; 0 on a rigid base
    ratio: float  # ν₁
    base_ratio: float  # ν₂

    def on_cells(self, dx):
        """Return the film with its thickness in cells of a side."""
        return self._replace(thickness=self.thickness / dx)

    def compliance(self, s):
        """Return F at s = q h."""
        return compliance(s, *self[2:])

    def softening(self, length):
        """Compliance of the pair at wavenumber 1/length (in units of the thickness) over that on the film's half space.

        Without the film at infinite length.
        """
        return 1.0 + self.share * (self.compliance(self.thickness / length) - 1.0)

    @property
    @lru_cache(maxsize=64)  # noqa: B019
    def stiffness(self):
        """Stiffness of a cell over that on the film's half space, at most 1."""
        return min(1.0, love_coefficients(1, 1)[0, 0] / influence_coefficients(1, 1, self)[0, 0])

    @property
    @lru_cache(maxsize=64)  # noqa: B019
    def bulges(self):
        """Whether a load lifts the surface anywhere, so that cells beyond the overlap may touch."""
        r = np.geomspace(0.01, 1e3, 200)
        (depths, parts) = images(*self[2:])
        return bool((1.0 + self.share * (r * (parts @ _distant(r, depths[:, None], 0.0)))).min() < -_UPWARD)


def compliance(s, m, ratio, base_ratio):
    """Return F at s = q h, the compliance over that of the film's own half space."""
    if np.ndim(s) == 0 and s == 0.0:
        return m * (1.0 - base_ratio) / (1.0 - ratio)
    k = (m - 1.0) / (m + 3.0 - 4.0 * ratio)
    p = 1.0 - 4.0 * (1.0 - ratio) / (1.0 + m * (3.0 - 4.0 * base_ratio))
    e = np.exp(-2.0 * s)
    return (1.0 + 4.0 * k * s * e - p * k * e**2) / (1.0 - (p + k + 4.0 * k * s**2) * e + p * k * e**2)


def contact_at_pull_off(radius, work, modulus, film):
    """Return the radius (nm) of JKR's contact of spheres at pull-off, and the contact modulus (GPa) at that size.

    ``modulus`` is the contact modulus with the film's half space, or without a film (None).
    """

    def contact_radius(size_modulus):
        return (9 * np.pi * work * radius**2 / (8 * size_modulus)) ** (1 / 3)

    contact = contact_radius(modulus)
    if film is None:
        return contact, modulus + 0.0 * contact
    # iterations of a contact's radius, each of which leaves at most two thirds of its error
    for _ in range(30):
        contact = np.sqrt(contact * contact_radius(modulus / film.softening(contact)))
    return contact, modulus / film.softening(contact)


@lru_cache(maxsize=64)
def images(m, ratio, base_ratio):
    """Return depths, in thicknesses, and parts of the images whose sum of exponentials is F − 1."""
    s = np.append(_FITTED_AT, 0.0)
    target = np.append(compliance(_FITTED_AT, m, ratio, base_ratio), compliance(0.0, m, ratio, base_ratio)) - 1.0
    depths = np.geomspace(_SHALLOW, _DEEP * max(1.0, m), _IMAGES)
    return depths, np.linalg.lstsq(np.exp(-s[:, None] * depths), target, rcond=1e-14)[0]


@lru_cache(maxsize=32)
def influence_coefficients(rows, columns, film=None):
    """Return the displacements at offsets (i, j) of a unit pressure on a cell (read only); Love's without a film.

    Examples
    --------
    A film of the material of its base is none:

    >>> film = Film(thickness=2.0, share=1.0, mismatch=1.0, ratio=0.3, base_ratio=0.3)
    >>> bool(abs(influence_coefficients(64, 64, film) - love_coefficients(64, 64)).max() < 1e-9)
    True
    """
    if film is None:
        return love_coefficients(rows, columns)
    depths, parts = images(*film[2:])
    depths = film.thickness * depths[:, None]
    table = np.zeros((rows, columns))
    distance = np.hypot(np.arange(rows)[:, None], np.arange(columns))
    if distance[-1, -1] > _NEAR:
        r = np.geomspace(_NEAR, distance[-1, -1], _DISTANCES)
        far = CubicSpline(np.log(r), parts @ _distant(r, depths, 1.0 / 24.0))
        table[:] = far(np.log(np.maximum(distance, _NEAR)))
    near = table[:_NEAR, :_NEAR]
    near[:] = np.tensordot(parts, cell_integrals(*near.shape, depths[..., None]), 1)
    out = love_coefficients(rows, columns) + film.share / np.pi * table
    out.setflags(write=False)
    return out


def _distant(r, depths, curvature):
    """Return 1/√(r² + d²) of images at each depth, and ``curvature`` times its Laplacian: 1/24 for means over cells."""
    inverse = 1.0 / np.hypot(r, depths)
    return inverse + curvature * inverse**5 * (r**2 - 2.0 * depths**2)
