"""The paper's analysis repeated on a synthetic twin of its scan, with its main numbers compared to the printed ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from .. import figures, report
from ..bodies.pair import assign_pair, elastic
from ..bodies.substances import MATERIALS
from ..contact.mesh import Mesh
from ..runs.analysis import Plan, execute
from ..scans import open_sample
from ..specimen import specimen_of
from ..statistics import debris, force_ratio
from ..studies.extrapolation import with_hardness
from ..vocabulary.units import Quantity, whole_number
from .numbered_figures import paper_figures, strongest_place
from .printed import CONTACT, PAIR, SCAN, TWIN

Run = Mapping[str, xr.Dataset]

#: The paper's plan: 8 × 8 places, its two displacements among those solved, its own sums first.
PLAN = Plan(
    subregions=(8, 8),
    direct_deltas=np.array([1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]),
    sweep=np.round(np.arange(-50, 251) * 0.1, 10),
    contact_delta=17.0,
    superposed=("published", "self_similar", "energy"),
    mesh=Mesh(step=0.4),
    extrapolated=9,  # each takes some seconds
)

_MICRO = 1e-3  # µN per nN

#: Displacements (nm) at which the paper shows distributions of forces, at which both methods agree in it, and at which
#: it prints forces over those on a smooth flat.
_DISTRIBUTION_DELTAS, _AGREEMENT_DELTAS, _SMOOTH_DELTAS = (5.08, 15.4), (9.0, 10.0, 12.0), (10.0, 20.0)


def paper(
    output: str | Path,
    *,
    budget: int = 4,
    materials: str | Sequence[str] | None = None,
    hardness: Quantity | None = None,
    command: str = "roughxr paper",
) -> dict[str, xr.Dataset]:
    """Repeat the paper on the glass twin, and return the groups of the archive.

    Parameters
    ----------
    output : path
        A folder: ``paper.nc``, ``overview.png``, ``figure-02.png`` … ``figure-16.png``, ``table.txt``,
        ``table-scan.csv`` and ``table-contact.csv``.
    budget, command
        As for `run`.
    materials : str or list of str, optional
        Bodies in place of the paper's glass, as for `assign_pair`; the radius stays.
    hardness : number or quantity, optional
        GPa, by default that of the materials, of glass 6. At it the bodies yield where the roughness is extrapolated
        below the pixel; all else stays elastic, as in the paper.
    """
    pair = PAIR if materials is None else {"sphere_radius": PAIR["sphere_radius"], "materials": materials}
    if materials is None and hardness is None:
        hardness = MATERIALS["glass"].hardness
    scan = specimen_of(elastic(assign_pair(open_sample("glass"), **pair, hardness=hardness)))
    folder = Path(output)
    wanted = PLAN._replace(budget=whole_number(budget, "budget", least=0))

    def draw_figures(run: Run) -> Iterator[tuple[str, object]]:
        yield "overview", figures.overview(run)
        yield from paper_figures(run)

    assumed = f"Of the best estimate: {with_hardness(scan.scan)[1]}."
    files: dict[str, Any] = {"tables": _tables, "notes": [TWIN, assumed], "draw_figures": draw_figures}
    groups = execute(scan, wanted, folder / "paper.nc", folder, command=command, **files)
    print((folder / "table.txt").read_text(encoding="utf-8").rstrip("\n"))
    return groups


def _tables(run: Run) -> dict[str, pd.DataFrame]:
    """Return the tables of a run, with the printed values in two of them."""
    printed = {"Pull-off force by method": contact_table(run), "Scan and asperities": scan_table(run)}
    return report.tables(run) | printed


def scan_table(run: Run) -> pd.DataFrame:
    """Return the main numbers of scan and asperities with the printed ones in the first columns."""
    table, height, residual = report.scan_table(run), run["scan"]["height"], run["reconstruction"].attrs["residual_rms"]
    rows = {"original - reconstructed, rms [nm]": residual}
    for name, power in (("R_q", 2), ("R_a", 1)):
        own, envelope = (
            float((abs(h) ** power).mean() ** (1 / power)) for h in (height, run["reconstruction"]["height"])
        )
        rows |= {f"{name} about zero, original [nm]": own, f"{name} about zero, reconstructed [nm]": envelope}
        rows[f"{name}, reconstructed above original [%]"] = 100 * (envelope / own - 1)
    angles = run["asperities"]["orientation"].values
    counts = np.histogram(angles[np.isfinite(angles)], bins=12, range=(-np.pi / 2, np.pi / 2))[0]
    rows["isotropy of directions (1: isotropic)"] = float(counts.min() / max(counts.max(), 1))
    whole = pd.concat([table, pd.DataFrame({"scan": rows})])
    order = [*SCAN, *(name for name in table.index if name not in SCAN)]
    return _with_printed(whole.loc[order].rename_axis("quantity"), SCAN)


def contact_table(run: Run) -> pd.DataFrame:
    """Return pull-offs by method and forces without adhesion, with the printed ones in the first columns."""
    table = report.contact_table(run)
    more = pd.DataFrame({method: _strongest_rows(run, method) for method in table} | {"direct": _direct_rows(run)})
    return _with_printed(pd.concat([table, more]).rename_axis("quantity"), CONTACT)


def _with_printed(table: pd.DataFrame, printed: Mapping[str, tuple[float, str]]) -> pd.DataFrame:
    """Return a table with the printed values in its first column, and how to read them in the second."""
    paper = pd.DataFrame.from_dict(printed, orient="index", columns=["paper", "paper's is"], dtype=object)
    paper = paper.reindex(table.index).astype({"paper": float}).fillna({"paper's is": ""})
    return paper.join(table)


def _strongest_rows(run: Run, method: str) -> dict[str, float]:
    """Return values at the place of figure 15."""
    place, solution = {"subregion": strongest_place(run)}, run[f"solutions/{method}"]
    pull_off = float(run[f"statistics/{method}"]["pull_off_force"].isel(place))
    rows = {"pull-off, place of figure 15 [µN]": _MICRO * pull_off}
    if "force" not in solution or solution.sizes["delta"] < 2:
        return rows  # with a preload, and for rigid bodies, there are only events
    force = solution["force"].isel(place)
    pulling = force["delta"].values[force.values < 0]
    return rows | {
        "that place, first displacement with adhesion [nm]": float(pulling.min(initial=np.inf)),
        "that place, last displacement with adhesion [nm]": float(pulling.max(initial=-np.inf)),
    }


def _direct_rows(run: Run) -> dict[str, float]:
    direct, superposed, smooth = (run[f"solutions/{name}"] for name in ("direct", "hertz", "smooth"))
    rows: dict[str, float] = {}
    for delta in _DISTRIBUTION_DELTAS:
        force = _MICRO * direct["force"].sel(delta=delta, method="nearest").values
        values = {"mean": force.mean(), "std": force.std(ddof=1), "second group": second_group(force)}
        rows |= {f"force at {delta:g} nm, {name} [µN]": float(value) for name, value in values.items()}
    for delta in _SMOOTH_DELTAS:
        rough, flat = (ds["force"].sel(delta=delta, method="nearest").mean() for ds in (direct, smooth))
        rows[f"rough / smooth force at {delta:g} nm"] = float(rough / flat)
    clean = np.flatnonzero(~debris(run["asperities"], direct).values)
    ratio = force_ratio(superposed.isel(subregion=clean), direct.isel(subregion=clean))
    difference = ratio["mean_difference"].sel(delta=list(_AGREEMENT_DELTAS), method="nearest").values
    rows |= {
        f"superposed / direct at {delta:g} nm, no debris": 1 + float(value)
        for delta, value in zip(_AGREEMENT_DELTAS, difference)
    }
    agree = (abs(ratio["force_difference"]) <= 0.1).any("delta")
    return rows | {"places without debris where both forces agree within 10 %": float(agree.sum())}


def second_group(values: np.ndarray) -> float:
    """Return the mean of the values above the widest gap between consecutive ones."""
    values = np.sort(values)
    return float(values[np.argmax(np.diff(values)) + 1 :].mean()) if values.size > 1 else np.nan
