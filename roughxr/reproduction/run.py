"""The paper's analysis repeated on the twin of its scan, and set beside what it prints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from ..bodies.pair import assign_pair
from ..runs.analysis import Plan, kept, show, told
from ..scans import open_sample
from ..specimen import specimen_of
from ..vocabulary.units import whole_number
from .figures import paper_figures
from .printed import PAIR, TWIN
from .tables import contact_table, scan_table

#: The paper's plan: 8 × 8 places, its two displacements among those solved, vertices at pixels.
PLAN = Plan(
    subregions=(8, 8),
    direct_deltas=np.array([1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]),
    sweep=np.round(np.arange(-50, 251) * 0.1, 10),
    contact_delta=17.0,
    patch="paper",
    vertex="pixel",
)


def paper(output: str | Path, *, budget: int = 8) -> dict[str, xr.Dataset]:
    """Repeat the paper on the glass twin: archive, figures 2–16 and the table of all methods.

    Parameters
    ----------
    output : path
        A folder, created if necessary: ``paper.nc``, ``overview.png``, ``figure-02.png`` …
        ``figure-16.png``, ``table.txt``, ``table-scan.csv`` and ``table-contact.csv``.
    budget : int
        As for `run`.

    Returns
    -------
    dict of str to Dataset
        The groups of the archive.

    Raises
    ------
    ValueError
        If ``paper.nc`` exists and holds another run.
    BlockingIOError
        If another process is computing it.

    Examples
    --------
    ``paper("results")`` takes minutes; its plan says what it solves:

    >>> PLAN.subregions, PLAN.direct_deltas.size, PLAN.sweep.size
    ((8, 8), 18, 301)
    """
    scan = specimen_of(assign_pair(open_sample("glass"), **PAIR))
    folder = Path(output)
    path = folder / "paper.nc"
    wanted = PLAN._replace(budget=whole_number(budget, "budget", least=0))
    with told(scan, wanted, path) as say:
        groups = kept(scan, wanted, say, path)
        show(groups, (scan_table(groups), contact_table(groups)), say, path, folder, [TWIN], paper_figures)
    return groups
