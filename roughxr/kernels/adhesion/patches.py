"""Contacts under a smooth law: their number, and how well the mesh resolves them."""

import numpy as np
from scipy import ndimage

#: Cells with more than this part of the largest attraction belong to the nearest contact.
_ATTRACTS = 0.02

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1


def contacts_and_resolution(state, closed, law):
    """Return the number of contacts, and the radius in cells of the smallest that bears a relevant part of the tension.

    Cells that touch and share a side are one contact. Its size counts each cell by its ``closed`` fraction, the work of
    separation that is left there. NaN where nothing attracts.
    """
    of, labels = ndimage.label(state.touching)
    members = state.touching | (state.pressure < -_ATTRACTS * law.strength)
    if not members.any():
        return 0, np.nan
    if labels:
        nearest = ndimage.distance_transform_edt(of == 0, return_distances=False, return_indices=True)
        of, count = of[tuple(nearest)], labels
    else:
        of, count = ndimage.label(members)
    of = of[members] - 1
    tension = np.bincount(of, np.maximum(-state.pressure[members], 0.0), count)
    size = np.bincount(of, closed[members], count)
    matters = tension >= min(_SHARE * tension.sum(), tension.max())
    return labels, float(np.sqrt(size[matters].min() / np.pi))
