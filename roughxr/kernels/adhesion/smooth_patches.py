"""Which cells belong to which contact, and how well the mesh shows it."""

import numpy as np
from scipy import ndimage

#: Cells that attract with more than this part of the largest traction belong to the contact that is nearest to them.
_ATTRACTS = 0.02

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1


def contacts_and_resolution(state, closed, law):
    """Return how many contacts there are, and the radius in cells of the smallest that bears enough of the tension.

    Cells that touch and share a side are one contact. A contact's size counts each cell by the part of the work of
    separation that is left to do there, ``closed``. NaN where nothing attracts.
    """
    of, found = ndimage.label(state.touching)
    members = state.touching | (state.pressure < -_ATTRACTS * law.strength)
    if not members.any():
        return 0, np.nan
    if found:
        nearest = ndimage.distance_transform_edt(of == 0, return_distances=False, return_indices=True)
        of, count = of[tuple(nearest)], found
    else:
        of, count = ndimage.label(members)
    of = of[members] - 1
    tension = np.bincount(of, np.maximum(-state.pressure[members], 0.0), count)
    size = np.bincount(of, closed[members], count)
    matters = tension >= min(_SHARE * tension.sum(), tension.max())
    return found, float(np.sqrt(size[matters].min() / np.pi))
