"""Contacts under a smooth law: their number, and their resolution by the mesh."""

import numpy as np
from scipy import ndimage


def contacts_and_resolution(state, closed, law):
    """Return the number of contacts, and the radius in cells of the smallest contact with a relevant tension.

    A contact is a set of touching cells connected by sides. Its size is the sum of the ``closed`` fractions of its
    cells (the remaining work of separation over the whole). Connected attracting cells are shared among the contacts
    that they surround, in proportion to the roots of the contacts' areas; those around no contact count as one. NaN
    where nothing attracts.
    """
    # cells with more than this part of the largest attraction belong to the contact that they surround
    members = state.touching | (state.pressure < -0.02 * law.strength)
    if not members.any():
        return 0, np.nan
    (contact, labels) = ndimage.label(state.touching)
    (parts, count) = ndimage.label(members)
    surrounded = np.zeros(labels + 1, int)  # connected part of the members around each contact
    surrounded[contact[state.touching]] = parts[state.touching]
    edge = np.sqrt(np.bincount(contact[members], minlength=labels + 1))
    whole = np.bincount(surrounded[1:], edge[1:], count + 1)
    unattached = np.flatnonzero(whole[1:] == 0) + 1
    attracting = members & ~state.touching

    def per_contact(values):
        shared = np.bincount(parts[attracting], values[attracting], count + 1)
        own = np.bincount(contact[state.touching], values[state.touching], labels + 1)[1:]
        return np.concatenate([own + shared[surrounded[1:]] * edge[1:] / whole[surrounded[1:]], shared[unattached]])

    tension = per_contact(np.maximum(-state.pressure, 0.0))
    size = per_contact(closed)
    # contacts with less than this part of the whole tension do not count for the resolution
    matters = tension >= min(0.1 * tension.sum(), tension.max())
    return labels, float(np.sqrt(size[matters].min() / np.pi))
