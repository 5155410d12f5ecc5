"""The paper's analysis repeated on a synthetic twin of its scan, with its main numbers compared to the printed ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from .. import report
from ..asperity.catalogue import asperities
from ..asperity.superposition import superpose
from ..bodies.pair import assign_pair, elastic
from ..bodies.pair_record import read_pair
from ..bodies.substances import MATERIALS
from ..contact import reference
from ..contact.mesh import Mesh
from ..runs import analysis
from ..runs import folder as run_folder
from ..runs.analysis import execute
from ..runs.parts import Part, Task
from ..runs.plan import Plan
from ..scans import open_sample
from ..specimen import specimen_of
from ..statistics import debris
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import HERTZ
from ..vocabulary.text import without_warnings
from .numbered_figures import (
    FIGURES,
    SIMULATED_FIGURES,
    counted_equally,
    paper_figures,
    smooth_sphere,
    strongest_place,
    surpassing_delta,
)
from .printed import CONTACT, PAIR, SCAN, TWIN

Run = Mapping[str, xr.Dataset]

#: The paper's plan: 8 × 8 places, its two displacements among those solved, its own sums first, no error budget.
PLAN = Plan(
    subregions=(8, 8),
    direct_deltas=np.array([1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]),
    sweep=np.round(np.arange(-50, 251) * 0.1, 10),
    contact_delta=17.0,
    superposed=("published", "self_similar", "energy"),
    mesh=Mesh(step=0.4),
    budget=0,
)

_MICRO = 1e-3  # µN per nN

#: Stages of a run: those whose results the paper shows, and the simulation that its sums are compared with.
_PAPER_PARTS = ("asperities", "direct", "superposition")
_COMPARISON = "adhesive"

#: The paper's formulas and those corrected, at the paper's patch and at the default one.
_FORMULATIONS = {"published": "published", "self_similar": "with λ for λ², and the sphere's curvature"}
_PATCHES = {"paper": "patch of 5 × 5 pixels", "auto": "patch by the shortest wavelength"}

#: Displacements (nm) at which the paper shows distributions of forces, at which we compare both methods, by ratio and
#: on the paper's linear axes, and at which it prints forces over those on a smooth flat.
_DISTRIBUTION_DELTAS = (5.08, 15.4)
_RATIO_DELTAS = (9.0, 10.0, 11.0, 12.0)
_AXIS_DELTAS = (11.0, 12.0, 13.0)
_SMOOTH_DELTAS = (10.0, 20.0)

#: Part of the mean force at 20 nm within which two curves are one line on linear axes.
_LINE_WIDTH = 0.02


def paper(output: str | Path, *, command: str = "roughxr paper") -> dict[str, xr.Dataset]:
    """Repeat the paper on the glass twin, compare it with the simulation with adhesion, and return all groups.

    The paper's tables are printed, and its figures written, before the simulation with adhesion begins. This completes
    the table by pull-off forces, and adds the figures that show them.

    Parameters
    ----------
    output : path
        A folder: ``paper.nc``, ``figure-02.png`` … ``figure-16.png``, ``table.txt``, ``table-scan.csv``,
        ``table-contact.csv``, ``places.csv`` and ``report.html``.
    command : str
        As for `run`.

    Notes
    -----
    The bodies stay elastic, as in the paper; results state the share of the contact above the hardness of glass, 6 GPa.
    """
    glass = assign_pair(open_sample("glass"), **PAIR, hardness=MATERIALS["glass"].hardness)
    folder = Path(output)
    printed: dict[str, pd.DataFrame] = {}
    drawn: set[str] = set()

    def answer_first(task: Task) -> dict[str, xr.Dataset]:
        made = paper_tables(task.groups)
        text = run_folder.tables_text(made, [TWIN])
        names = [name for name in FIGURES if name not in SIMULATED_FIGURES]
        run_folder.write_tables(made, text, folder)
        run_folder.write_figures(task.groups, lambda run: paper_figures(run, names), folder)
        print(text)
        printed.update(made)
        drawn.update(names)
        return {}

    groups = execute(
        specimen_of(elastic(glass)),
        PLAN,
        folder / "paper.nc",
        folder,
        command=command,
        parts=_parts(answer_first),
        tables=_tables,
        as_text=_as_text,
        draw_figures=lambda run: paper_figures(run, [name for name in FIGURES if name not in drawn]),
    )
    new = {title: table for title, table in _tables(groups).items() if not table.equals(printed.get(title))}
    print(_as_text(groups, new).rstrip())
    return groups


def _as_text(run: Run, tables: Mapping[str, pd.DataFrame]) -> str:
    return run_folder.tables_text(tables, [TWIN, *run_folder.notes(run)])


def _parts(answer_first: Callable[[Task], dict[str, xr.Dataset]]) -> list[Part]:
    """Return the stages of the paper, one that gives its answer, and the simulation that it is compared with."""
    paper = [part for part in analysis.PARTS if part.name in _PAPER_PARTS]
    comparison = [part for part in analysis.PARTS if part.name == _COMPARISON]
    return [
        *paper,
        Part("corrections", "the paper's sums, corrected", lambda task: True, 2.0, 0.0, corrections),
        Part("paper", "the paper's table and figures", lambda task: True, 8.0, 0.0, answer_first),
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
            for patch in _PATCHES
        ]
        for name in _FORMULATIONS
    ]
    dims = ("formulation", "patch", "subregion")
    names = {"formulation": list(_FORMULATIONS), "patch": list(_PATCHES)}
    pull_off = schema.label(xr.Dataset({"pull_off_force": (dims, np.array(forces))}, names))
    return {
        "statistics/corrections": pull_off,
        "solutions/hertz_corrected": superpose(corrected, delta=task.plan.sweep, law=HERTZ, **task.options),
    }


def paper_tables(run: Run) -> dict[str, pd.DataFrame]:
    """Return the paper's tables: with its printed values, and with its slips corrected one at a time."""
    return {
        "Pull-off force by method": contact_table(run),
        "Pull-off force with one change at a time, mean ± std [µN]": correction_table(run),
        "Scan and asperities": scan_table(run),
    }


def _tables(run: Run) -> dict[str, pd.DataFrame]:
    """Return the paper's tables, then those of any run."""
    made = paper_tables(run)
    return made | {title: table for title, table in report.tables(run).items() if title not in made}


def correction_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by formulas and patch, and the ratios of the means by each change alone, as text."""
    force = _MICRO * run["statistics/corrections"]["pull_off_force"].transpose("formulation", "patch", "subregion")
    mean = force.mean("subregion").values
    spread = force.std("subregion", ddof=1).values
    texts = [[f"{m:.2f} ± {s:.2f}" for m, s in zip(*row)] for row in zip(mean, spread)]
    texts = [[*row, f"{by_patch:.2f}"] for row, by_patch in zip(texts, mean[:, 1] / mean[:, 0])]
    texts.append([*(f"{by_formulas:.1f}" for by_formulas in mean[1] / mean[0]), ""])
    index = pd.Index([*_FORMULATIONS.values(), "ratio"], name="formulas")
    return pd.DataFrame(texts, index=index, columns=[*_PATCHES.values(), "ratio"])


def scan_table(run: Run) -> pd.DataFrame:
    """Return the main numbers of scan and asperities with the printed ones in the first columns."""
    table = report.scan_table(run)
    height = run["scan"]["height"]
    residual = run["reconstruction"].attrs["residual_rms"]
    rows = {"original - reconstructed, rms [nm]": residual}
    for name, power in (("R_q", 2), ("R_a", 1)):
        scan_row, envelope = (
            float((abs(h) ** power).mean() ** (1 / power)) for h in (height, run["reconstruction"]["height"])
        )
        rows |= {f"{name} about zero, original [nm]": scan_row, f"{name} about zero, reconstructed [nm]": envelope}
        rows[f"{name}, reconstructed above original [%]"] = 100 * (envelope / scan_row - 1)
    angles = run["asperities"]["orientation"].values
    counts = np.histogram(angles[np.isfinite(angles)], bins=12, range=(-np.pi / 2, np.pi / 2))[0]
    rows["isotropy of directions (1: isotropic)"] = float(counts.min() / max(counts.max(), 1))
    ratio = run["asperities"]["axis_ratio"].dropna("asperity")
    rows["asperities with a < 10 b [%]"] = 100 * float((ratio > 0.1).mean())
    whole = pd.concat([table, pd.DataFrame({"scan": rows})])
    order = [*SCAN, *(name for name in table.index if name not in SCAN)]
    return _with_printed(whole.loc[order].rename_axis("quantity"), SCAN)


def contact_table(run: Run) -> pd.DataFrame:
    """Return pull-offs by method and forces without adhesion, with the printed ones in the first columns."""
    table = report.contact_table(counted_equally(run))
    columns = {method: _strongest_rows(run, method) for method in table} | {"direct": _direct_rows(run)}
    for method, sum_without_adhesion in (("published", HERTZ), ("energy", "hertz_corrected")):
        columns[method] |= _agreement_rows(run, sum_without_adhesion)
    return _with_printed(pd.concat([table, pd.DataFrame(columns)]).rename_axis("quantity"), CONTACT)


def _with_printed(table: pd.DataFrame, printed: Mapping[str, tuple[float, str]]) -> pd.DataFrame:
    """Return a table with the printed values in its first column, and how to read them in the second."""
    paper = pd.DataFrame.from_dict(printed, orient="index", columns=["paper", "paper's is"], dtype=object)
    paper = paper.reindex(table.index).astype({"paper": float}).fillna({"paper's is": ""})
    return paper.join(table)


def _strongest_rows(run: Run, method: str) -> dict[str, float]:
    """Return values at the place of figure 15, and where the force exceeds that on a smooth flat."""
    place = {"subregion": strongest_place(run)}
    solution = run[f"solutions/{method}"]
    pull_off = float(run[f"statistics/{method}"]["pull_off_force"].isel(place))
    rows = {"pull-off, place of figure 15 [µN]": _MICRO * pull_off}
    if "force" not in solution or solution.sizes["delta"] < 2:
        return rows  # with a preload, and for rigid bodies, there are only events
    force = solution["force"].isel(place)
    smooth = smooth_sphere(solution)["force"]
    pulling = force["delta"].values[force.values < 0]
    return rows | {
        "that place, first displacement with adhesion [nm]": float(pulling.min(initial=np.inf)),
        "that place, last displacement with adhesion [nm]": float(pulling.max(initial=-np.inf)),
        "rough above smooth from, place of figure 15 [nm]": surpassing_delta(force, smooth),
        "rough above smooth from, mean force [nm]": surpassing_delta(solution["force"].mean("subregion"), smooth),
    }


def _direct_rows(run: Run) -> dict[str, float]:
    direct, smooth = (run[f"solutions/{name}"] for name in ("direct", "smooth"))
    pair = read_pair(smooth)
    hertz = reference.hertz(smooth["delta"].values, radius=pair.sphere_radius, contact_modulus=pair.contact_modulus)[
        "force"
    ]
    rows = {"smooth flat, largest difference from Hertz [%]": 100 * float(abs(smooth["force"] / hertz - 1).max())}
    for delta in _DISTRIBUTION_DELTAS:
        force = _MICRO * direct["force"].sel(delta=delta, method="nearest").values
        values = {"mean": force.mean(), "std": force.std(ddof=1), "second group": second_group(force)}
        rows |= {f"force at {delta:g} nm, {name} [µN]": float(value) for name, value in values.items()}
    for delta in _SMOOTH_DELTAS:
        rough, flat = (ds["force"].sel(delta=delta, method="nearest").mean() for ds in (direct, smooth))
        rows[f"rough / smooth force at {delta:g} nm"] = float(rough / flat)
    return rows


def _agreement_rows(run: Run, name: str) -> dict[str, float]:
    """Return how a sum without adhesion agrees with the direct simulation, by ratio and on the paper's linear axes."""
    direct = run["solutions/direct"]
    clean = {"subregion": np.flatnonzero(~debris(run["asperities"], direct).values)}
    solved = direct["force"].isel(clean)
    summed = run[f"solutions/{name}"]["force"].isel(clean).interp(delta=solved["delta"])
    means = summed.mean("subregion"), solved.mean("subregion")
    ratio = means[0] / means[1]
    is_one_line = abs(summed - solved) <= _LINE_WIDTH * means[1].sel(delta=20, method="nearest")
    rows = {
        f"superposed / direct at {delta:g} nm, no debris": float(ratio.sel(delta=delta, method="nearest"))
        for delta in _RATIO_DELTAS
    }
    return rows | {
        f"places within 2 % of the mean at 20 nm, at {delta:g} nm, no debris": float(
            is_one_line.sel(delta=delta, method="nearest").sum()
        )
        for delta in _AXIS_DELTAS
    }


def second_group(values: np.ndarray) -> float:
    """Return the mean of the values above the widest gap between consecutive ones."""
    values = np.sort(values)
    return float(values[np.argmax(np.diff(values)) + 1 :].mean()) if values.size > 1 else np.nan
