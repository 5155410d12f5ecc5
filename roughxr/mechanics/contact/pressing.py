"""Pull-offs that depend on how hard the sphere was pressed."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Change of a pull-off by pressing, over the pull-off, beyond which both are the ends of a range: no error by itself.
LARGEST_SETTLING = 0.5


def settling_changes(pulls: Any, pressed: Any) -> Any:
    """Return the relative changes of pull-offs by pressing; 0 where nothing adheres."""
    return np.abs(pressed - pulls) / np.where(pulls > 0, pulls, np.inf)


def settled_errors(errors: Any, pulls: Any, pressed: Any) -> Any:
    """Return the errors of pull-offs with their changes by pressing, except for ranges; NaN if these are not known.

    Larger errors of a range belong to other contacts, which the range includes.
    """
    changes = settling_changes(pulls, pressed)
    return np.where(changes > LARGEST_SETTLING, np.minimum(errors, LARGEST_SETTLING), np.hypot(errors, changes))


def is_range(pulls: Any, pressed: Any) -> Any:
    """Return where pull-offs are ranges, by how hard the sphere was pressed."""
    return settling_changes(pulls, pressed) > LARGEST_SETTLING
