"""Contacts under a smooth law: their number, and how well the mesh resolves them."""

import numpy as np
from scipy import ndimage

#: Cells with more than this part of the largest attraction belong to the contacts that they surround.
_ATTRACTS = 0.02

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1


def contacts_and_resolution(state, closed, law):
    """Return the number of contacts, and the radius in cells of the smallest that bears a relevant part of the tension.

    Cells that touch and share a side are one contact. Its size counts each cell by its ``closed`` fraction, the work of
    separation that is left there. Contacts share the attracting cells around them by the roots of their numbers of
    cells, so that no cell is equally near to two; what attracts around no contact counts as one. NaN where nothing
    attracts.
    """
    members = state.touching | (state.pressure < -_ATTRACTS * law.strength)
    if not members.any():
        return 0, np.nan
    (of, labels), (parts, count) = ndimage.label(state.touching), ndimage.label(members)
    surrounded = np.zeros(labels + 1, int)  # by which connected part of the members each contact is
    surrounded[of[state.touching]] = parts[state.touching]
    edge = np.sqrt(np.bincount(of[members], minlength=labels + 1))
    whole = np.bincount(surrounded[1:], edge[1:], count + 1)
    unattached, attracting = np.flatnonzero(whole[1:] == 0) + 1, members & ~state.touching

    def per_contact(values):
        shared = np.bincount(parts[attracting], values[attracting], count + 1)
        own = np.bincount(of[state.touching], values[state.touching], labels + 1)[1:]
        return np.concatenate([own + shared[surrounded[1:]] * edge[1:] / whole[surrounded[1:]], shared[unattached]])

    tension, size = per_contact(np.maximum(-state.pressure, 0.0)), per_contact(closed)
    matters = tension >= min(_SHARE * tension.sum(), tension.max())
    return labels, float(np.sqrt(size[matters].min() / np.pi))
