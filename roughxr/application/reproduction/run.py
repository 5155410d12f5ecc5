"""The paper's analysis repeated on a synthetic twin of its scan, with its main numbers compared to the printed ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from ...mechanics.asperity.catalogue import asperities
from ...mechanics.asperity.superposition import superpose
from ...mechanics.bodies.pair import assign_pair, elastic
from ...mechanics.bodies.substances import MATERIALS
from ...mechanics.contact.mesh import Mesh
from ...mechanics.specimen import specimen_of
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.adhesion_laws import HERTZ
from ...mechanics.vocabulary.text import without_warnings
from ..runs import analysis
from ..runs import folder as run_folder
from ..runs.analysis import execute
from ..runs.parts import Part, Task
from ..runs.plan import Plan
from ..samples import open_sample
from .numbered_figures import FIGURES, SIMULATED_FIGURES, paper_figures
from .printed import PAIR, TWIN
from .printed_tables import FORMULATIONS, PATCHES, explanations, paper_tables

Run = Mapping[str, xr.Dataset]

#: The paper's plan: 8 × 8 places, its two displacements among those solved, its own sums first, no detachment.
PLAN = Plan(
    subregions=(8, 8),
    direct_deltas=np.array([1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]),
    sweep=np.round(np.arange(-50, 251) * 0.1, 10),
    contact_delta=17.0,
    superposed=("published", "self_similar", "energy"),
    mesh=Mesh(step=0.4),
    budget=0,
    directions=0,
)

#: Stages of a run: those whose results the paper shows, and the simulation that its sums are compared with.
_PAPER_PARTS = ("asperities", "direct", "superposition")
_COMPARISON = "adhesive"

#: Duration (s) of the simulation with adhesion at each place of the twin, on two cores.
_EACH_PLACE = 0.4


def paper(output: str | Path, *, command: str = "roughxr paper") -> dict[str, xr.Dataset]:
    """Repeat the paper on the glass twin, compare it with the simulation with adhesion, and return all groups.

    The paper's tables are printed, and its figures written, before the simulation with adhesion begins. This completes
    the table by pull-off forces, and adds the figures that show them.

    Parameters
    ----------
    output : path
        A folder: ``paper.nc``, ``figure-02.png`` … ``figure-16.png``, ``superposition-by-place.png``, ``table.txt``
        and its parts as CSV, ``places.csv`` and ``report.html``.
    command : str
        As for `run`.

    Notes
    -----
    The bodies stay elastic, as in the paper; results state the share of the contact above the hardness of glass, 6 GPa.
    """
    glass = assign_pair(open_sample("glass"), **PAIR, hardness=MATERIALS["glass"].hardness)
    folder = Path(output)
    printed: dict[str, pd.DataFrame] = {}
    completed: dict[str, pd.DataFrame] = {}
    drawn: set[str] = set()

    def answer_first(task: Task) -> dict[str, xr.Dataset]:
        made = paper_tables(task.groups)
        text = run_folder.tables_text(made, [TWIN], explanations=explanations(task.groups, made))
        names = [name for name in FIGURES if name not in SIMULATED_FIGURES]
        run_folder.write_tables(made, text, folder)
        run_folder.write_figures(task.groups, lambda run: paper_figures(run, names), folder)
        print(text)
        printed.update(made)
        drawn.update(names)
        return {}

    def whole_text(run: Run, tables: Mapping[str, pd.DataFrame]) -> str:
        completed.update(tables)
        return _as_text(run, tables)

    groups = execute(
        specimen_of(elastic(glass)),
        PLAN,
        folder / "paper.nc",
        folder,
        command=command,
        parts=_parts(answer_first),
        tables=_tables,
        as_text=whole_text,
        draw_figures=lambda run: paper_figures(run, [name for name in FIGURES if name not in drawn]),
    )
    new = {title: table for title, table in completed.items() if not table.equals(printed.get(title))}
    print(_as_text(groups, new).rstrip())
    return groups


def _as_text(run: Run, tables: Mapping[str, pd.DataFrame]) -> str:
    return run_folder.tables_text(tables, [TWIN, *run_folder.notes(run)], explanations=explanations(run, tables))


def _parts(answer_first: Callable[[Task], dict[str, xr.Dataset]]) -> list[Part]:
    """Return the stages of the paper, one that gives its answer, and the simulation that it is compared with."""
    paper = [part for part in analysis.PARTS if part.name in _PAPER_PARTS]
    comparison = [part._replace(each=_EACH_PLACE) for part in analysis.PARTS if part.name == _COMPARISON]
    return [
        *paper,
        Part("corrections", "the paper's sums, corrected", lambda task: True, 0.4, 0.0, corrections),
        Part("paper", "the paper's table and figures", lambda task: True, 4.0, 0.0, answer_first),
        *comparison,
    ]


def corrections(task: Task) -> dict[str, xr.Dataset]:
    """Return the pull-off with formulas and patch changed one at a time, and the corrected sum without adhesion."""
    corrected = elastic(asperities(task.specimen.scan))
    catalogues = {"paper": elastic(task.groups["asperities"]), "auto": corrected}
    options = {"delta": [0.0], **task.options}  # the exact pull-off does not depend on the displacements
    forces = [
        [
            without_warnings(superpose, catalogues[patch], formulation=name, **options)["pull_off_force"]
            for patch in PATCHES
        ]
        for name in FORMULATIONS
    ]
    dims = ("formulation", "patch", "subregion")
    places = task.groups["statistics/published"]
    positions = {name: places[name].variable for name in ("subregion", "subregion_x", "subregion_y")}
    coords = {"formulation": list(FORMULATIONS), "patch": list(PATCHES), **positions}
    pull_off = schema.label(xr.Dataset({"pull_off_force": (dims, np.array(forces))}, coords))
    return {
        "statistics/corrections": pull_off,
        "solutions/hertz_corrected": superpose(corrected, delta=task.plan.sweep, law=HERTZ, **task.options),
    }


def _tables(run: Run, general_tables: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return the paper's tables, then those of any run."""
    made = paper_tables(run, general_tables)
    return made | {title: table for title, table in general_tables.items() if title not in made}
