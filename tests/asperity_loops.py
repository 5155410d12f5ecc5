"""Contacts of single asperities computed one by one, and their detachment and first contact, for tests."""

from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.asperity import jkr
from roughxr.mechanics.kernels.asperity.asperity_laws import ENERGY, AsperityContact, asperity_contact, scales_of
from roughxr.mechanics.kernels.asperity.elliptic_jkr import EllipseState
from roughxr.mechanics.kernels.asperity.elliptic_table import lookup, mark_at_row
from roughxr.mechanics.kernels.jit import kernel


class Events(NamedTuple):
    """States (P nN, a nm, b nm, δ nm) at which an asperity detaches or comes into contact.

    On a soft spring it detaches at ``largest_tension``, at fixed displacement at ``branch_end``, where Cheng, Dunn &
    Brach also let it jump into contact. Without long-range forces it jumps into contact at ``touch``, δ = 0. NaN where
    there is no peak, 0 where nothing adheres.
    """

    largest_tension: EllipseState
    branch_end: EllipseState
    touch: EllipseState


def _state(P, a, b, delta, scales):
    """Return a starred state (b* divided by λ) in nN and nm."""
    return EllipseState(scales.P * P, scales.a * a, scales.a * scales.axis_ratio * b, scales.delta * delta)


def asperity_events(scales, law):
    """Return the ``Events`` of one asperity."""
    if scales.end == 0.0 or np.isnan(scales.end):
        nothing = EllipseState(scales.end, scales.end, scales.end, scales.end)
        return Events(nothing, nothing, nothing)
    if law.code >= ENERGY:
        P = mark_at_row(law.marks, scales.row, 1)
        a = mark_at_row(law.marks, scales.row, 2)
        b = mark_at_row(law.marks, scales.row, 3)
        delta = mark_at_row(law.marks, scales.row, 4)
        P_end, a_end, b_end = lookup(law.spline, scales.row, 0.0)
    else:
        P = -1.0
        a = 1.0
        b = 1.0
        delta = -1.0 / 3.0
        P_end = -5.0 / 9.0
        a_end = jkr.END_A
        b_end = jkr.END_A
    touch = asperity_contact(0.0, scales, law.spline)
    return Events(
        _state(P, a, b, delta, scales),
        _state(P_end, a_end, b_end, scales.end, scales),
        EllipseState(touch.P, touch.a, touch.b, 0.0),
    )


@kernel
def asperities_contact(delta, scales, spline):
    """The ``AsperityContact`` of many asperities, each at its own displacements: all of shape (asperity, step)."""
    P = np.empty(delta.shape)
    a = np.empty(delta.shape)
    b = np.empty(delta.shape)
    for i in range(delta.shape[0]):
        scales_here = scales_of(scales, i)
        for j in range(delta.shape[1]):
            P[i, j], a[i, j], b[i, j] = asperity_contact(delta[i, j], scales_here, spline)
    return AsperityContact(P, a, b)
