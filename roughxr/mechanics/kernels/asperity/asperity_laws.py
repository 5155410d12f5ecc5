"""Load and contact ellipse of an asperity, an elliptic paraboloid, at a prescribed displacement, by any law.

hertz               no adhesion
published           generalized JKR to the letter of Cheng, Dunn & Brach, eqs. 15-24: λ² where λ is due
self_similar        the same derivation corrected: an ellipse of Hertz's shape at every load
energy              shape free, energy stationary in both axes (``elliptic_jkr``)
dugdale             between JKR and DMT (``maugis``): the sphere's law in the self-similar ellipse's units

An adhesive asperity stays in contact below δ = 0, down to the end of its stable branch; beyond, P = a = b = 0. The
published law is the self-similar law with λw for w. With w = 0 every law is Hertz's, and ends at δ = 0.

A, B    half the principal curvatures, 0 < A ≤ B, nm⁻¹; otherwise it is not a peak, and its scales, load and ellipse
        are NaN. If the other body is curved, A and B are the composite curvatures
E*      ``E_star``, contact modulus, GPa;  w = 2γ, work of adhesion, J/m²
δ, P    ``delta``, displacement, nm, > 0 brings the bodies together;  load, nN, > 0 pushes
a, b    semi-axes of the contact ellipse, a along the flattest direction, nm

Beyond B/A = 10⁴ (``elliptic_table.LARGEST_RATIO``, ellipses hundreds of times longer than wide) the law of
free shape uses the starred curves of 10⁴ with the scales of the true B/A.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from roughxr.mechanics.kernels.asperity import elliptic_jkr, elliptic_table, jkr, maugis
from roughxr.mechanics.kernels.asperity.branches import closed_contact
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio, shape, stiffness
from roughxr.mechanics.kernels.asperity.elliptic_table import EMPTY, END, lookup, mark_at_row, table_row
from roughxr.mechanics.kernels.jit import kernel

#: Laws without range, and those with a range.
ASPERITY_LAWS = ("hertz", "published", "self_similar", "energy")
RANGED = ("dugdale",)
HERTZ, PUBLISHED, SELF_SIMILAR, ENERGY, DUGDALE = range(5)


class AsperityLaw(NamedTuple):
    """A law's code, its table (empty for closed forms), and the length that sets its range."""

    code: int
    spline: np.ndarray  # coefficients of the branch (``elliptic_table.Table``)
    marks: np.ndarray
    range: float  # nm: z₀ of dugdale; NaN for the others


class Scales(NamedTuple):
    """The scales that make contacts of one or many asperities dimensionless; a and P of Hertz at ``delta`` = 1 nm."""

    a: Any  # nm
    P: Any  # nN
    delta: Any  # nm
    axis_ratio: Any  # λ of Hertz's ellipse
    end: Any  # δ* where the stable branch ends; 0 without adhesion
    row: Any  # position in the law's table


class AsperityContact(NamedTuple):
    """Load nN and semi-axes nm."""

    P: float
    a: float
    b: float


@cache
def law(name, length=np.nan):
    """Return the law with a name of ``ASPERITY_LAWS`` or ``RANGED``, with its table, read on first use."""
    if name in RANGED:
        return AsperityLaw(DUGDALE, *maugis.table(), float(length))
    code = ASPERITY_LAWS.index(name)
    return AsperityLaw(code, *(elliptic_table.table() if code == ENERGY else EMPTY), np.nan)


@kernel
def asperity_scales(A, B, E_star, w, law):
    """Return the ``Scales`` of an asperity."""
    lam = shape(A, B)
    if np.isnan(lam):
        return Scales(np.nan, np.nan, np.nan, np.nan, np.nan, np.nan)
    if law.code == HERTZ or w == 0.0:
        beta, H = stiffness(A, B, lam, E_star)
        return Scales(1.0 / np.sqrt(beta), H, 1.0, lam, 0.0, 0.0)
    unit = jkr.ellipse_units(A, B, lam, E_star, lam * w if law.code == PUBLISHED else w)
    if law.code < ENERGY:
        return Scales(unit.a, unit.P, unit.delta, lam, jkr.END_DELTA, 0.0)
    if law.code == DUGDALE:
        row = maugis.table_row(maugis.parameter(maugis.tabor(A, B, E_star, w, law.range)))
    else:
        row = table_row(B / A)
    return Scales(unit.a, unit.P, unit.delta, lam, mark_at_row(law.marks, row, END), row)


@kernel
def asperity_contact(delta, scales, spline):
    """Return the stable ``AsperityContact`` of an asperity at displacement ``delta``; ``spline`` belongs to its law."""
    delta_star = delta / scales.delta
    if not delta_star >= scales.end:
        nothing = 0.0 if delta_star < scales.end else np.nan
        return AsperityContact(nothing, nothing, nothing)
    if scales.end < 0.0 and spline.size > 0:
        P, a, b = lookup(spline, scales.row, delta_star - scales.end)
    else:
        P, a, b = closed_contact(delta_star, scales.end)
    return AsperityContact(scales.P * P, scales.a * a, scales.a * scales.axis_ratio * b)


@kernel
def scales_of(scales, i):
    """Return the scales of asperity ``i`` out of those of many."""
    return Scales(scales.a[i], scales.P[i], scales.delta[i], scales.axis_ratio[i], scales.end[i], scales.row[i])


def asperities_scales(A, B, E_star, w, law):
    """Return the ``Scales`` of many asperities: A, B and each field have shape (asperity,)."""
    return Scales(*_scales_of_each(A, B, E_star, w, law).T.copy())


@kernel
def _scales_of_each(A, B, E_star, w, law):
    out = np.empty((A.size, 6))
    for i in range(A.size):
        scales = asperity_scales(A[i], B[i], E_star, w, law)
        for k in range(6):  # compiles in a tenth of the time of a row's assignment
            out[i, k] = scales[k]
    return out


def subset(scales, which):
    """Return the scales of the asperities ``which``, in that order."""
    return Scales(*(field[which] for field in scales))


def branch_end(name, ratio):
    """Return δ* at the end of an adhesive law's stable branch, without the table."""
    if name == "energy" and ratio > 1.0:
        return elliptic_jkr.contact_at(ratio, elliptic_jkr.branch_end(ratio)).delta
    return jkr.END_DELTA


def branch_states(name, delta, ratio, *, stable):
    """Return an adhesive law's starred states at displacements δ* between the ends of one branch.

    In these units only b* of ``published`` and ``self_similar`` depends on ``ratio`` = B/A.
    """
    if name == "energy" and ratio > 1.0:
        return elliptic_jkr.states_at_displacement(ratio, delta, stable=stable)
    semi_axis = jkr.stable_semi_axis if stable else jkr.unstable_semi_axis
    a = np.array([semi_axis(value) for value in delta])
    return elliptic_jkr.EllipseState(jkr.load(a), a, axis_ratio(ratio) * a, delta)
