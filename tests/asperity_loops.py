"""One asperity after another, for tests of many."""

from roughxr.kernels.arrays import unset
from roughxr.kernels.asperity.laws import Contact, asperity_contact, asperity_events, pick
from roughxr.kernels.jit import kernel


@kernel
def asperities_contact(delta, scales, spline):
    """The ``Contact`` of many asperities, each at its own displacements: all of shape (asperity, step)."""
    P, a, b = unset(delta.shape, 0.0), unset(delta.shape, 0.0), unset(delta.shape, 0.0)
    for i in range(delta.shape[0]):
        one = pick(scales, i)
        for j in range(delta.shape[1]):
            P[i, j], a[i, j], b[i, j] = asperity_contact(delta[i, j], one, spline)
    return Contact(P, a, b)


@kernel
def asperities_events(scales, law):
    """Events of many asperities, shape (event, quantity, asperity), ordered as ``Events`` and ``State``."""
    out = unset((3, 4, scales.a.size), 0.0)
    for i in range(scales.a.size):
        events = asperity_events(pick(scales, i), law)
        for e in range(3):
            out[e, 0, i], out[e, 1, i], out[e, 2, i], out[e, 3, i] = events[e]
    return out
