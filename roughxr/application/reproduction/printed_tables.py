"""The paper's tables: its printed values beside ours, its slips corrected one at a time, its conclusion tested."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ...mechanics.bodies.pair_record import read_pair
from ...mechanics.contact import reference
from ...mechanics.statistics import smooth_pull_off
from ...mechanics.statistics.sampling import mean_of_places
from ...mechanics.vocabulary.adhesion_laws import HERTZ
from .. import report
from ..wording import render_sentence
from .conclusion import (
    SIMULATION,
    SUMS,
    comparison_table,
    conclusion_values,
    delta_from_highest_point,
    has_simulation,
)
from .numbered_figures import (
    last_without_contact,
    places_without_debris,
    smooth_sphere,
    strongest_place,
    surpassing_delta,
)
from .printed import CONCLUSION, FORCE, PULL_OFF, SCAN

Run = Mapping[str, xr.Dataset]

_MICRO = 1e-3  # µN per nN

#: The paper's formulas and those corrected, at the paper's patch and at the default one.
FORMULATIONS = {"published": "published", "self_similar": "with λ for λ², and the sphere's curvature"}
PATCHES = {"paper": "patch 5 × 5 pixels", "auto": "patch by wavelength"}

#: Displacements (nm) at which the paper shows distributions of forces, at which we compare both methods, by ratio and
#: on the paper's linear axes, and at which it prints forces over those on a smooth flat.
_DISTRIBUTION_DELTAS = (5.08, 15.4)
_RATIO_DELTAS = (9.0, 10.0, 11.0, 12.0)
_AXIS_DELTAS = (11.0, 12.0, 13.0)
_SMOOTH_DELTAS = (10.0, 20.0)

#: Part of the mean force at 20 nm within which two curves are one line on linear axes.
_LINE_WIDTH = 0.02

#: Titles of the tables.
_CONTACT, _COMPARISON, _FORCE = "Pull-off force by method", "Superposition place by place", "Force without adhesion"
_INTERVALS = "Pull-off force"  # of any run
_CORRECTIONS, _SCAN = "Pull-off force with one change at a time, mean ± std [µN]", "Scan and asperities"

#: What stands below each table.
_EXPLAINED = {
    _CONTACT: "contact",
    _COMPARISON: "conclusion",
    _FORCE: "force",
    _SCAN: "scan",
    _INTERVALS: "intervals",
}


def paper_tables(run: Run, general_tables: Mapping[str, pd.DataFrame] | None = None) -> dict[str, pd.DataFrame]:
    """Return the paper's tables by their titles: with its printed values, and with its slips corrected.

    ``general_tables`` are the tables that any run has, where they are known already.
    """
    return {
        _CONTACT: contact_table(run),
        _COMPARISON: _with_printed(comparison_table(run), CONCLUSION),
        _FORCE: force_table(run),
        _CORRECTIONS: correction_table(run),
        _SCAN: scan_table(run, general_tables),
    }


def explanations(run: Run, titles: Iterable[str]) -> dict[str, str]:
    """Return what stands below tables with these titles: their columns, what is counted, and what follows."""
    values = conclusion_values(run) | _simulation_values(run)
    values["untouched_delta"] = last_without_contact(places_without_debris(run, "direct"))
    coords = run["statistics/published"].coords
    if "debris_share" in coords:
        values["places_on_debris"] = float(coords["on_debris"].sum())
        values["debris_share"] = 100 * float(coords["debris_share"])
    return {title: render_sentence("paper.toml", _EXPLAINED[title], values) for title in titles if title in _EXPLAINED}


def _simulation_values(run: Run) -> dict[str, float]:
    """Return the adhesion range and the cell of the simulation with adhesion, nm, if there is one."""
    if not has_simulation(run):
        return {}
    pull_off = run[f"statistics/{SIMULATION}"]
    cell = float(run["scan"]["x"].diff("x").mean() / pull_off["mesh"].max())
    return {"adhesion_range": pull_off.attrs.get("adhesion_length_nm", 0.0), "cell": cell}


def _with_printed(table: pd.DataFrame, printed: Mapping[str, tuple[float, str]]) -> pd.DataFrame:
    """Return a table with the printed values in its first column, and how to read them in the second."""
    paper = pd.DataFrame.from_dict(printed, orient="index", columns=["paper", "paper's is"], dtype=object)
    paper = paper.reindex(table.index).astype({"paper": float}).fillna({"paper's is": ""})
    return paper.join(table).rename_axis("quantity")


def contact_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by the paper's sum, the corrected ones and the simulation, the printed one first."""
    methods = [method for method in (*SUMS, SIMULATION) if f"statistics/{method}" in run]
    rows = {method: _pull_off_rows(run, method) | _strongest_rows(run, method) for method in methods}
    return _with_printed(pd.DataFrame(rows), PULL_OFF)


def _pull_off_rows(run: Run, method: str) -> dict[str, float]:
    force = _MICRO * run[f"statistics/{method}"]["pull_off_force"]
    smooth = _MICRO * smooth_pull_off(run[f"solutions/{method}"])
    delta = delta_from_highest_point(run, method)
    mean = float(force.mean())
    return {
        "pull-off, smooth sphere [µN]": smooth,
        "pull-off, mean [µN]": mean,
        "pull-off, mean, debris by area [µN]": mean_of_places(force),
        "pull-off, std [µN]": float(force.std(ddof=1)),
        "pull-off, largest [µN]": float(force.max()),
        "pull-off, rough / smooth": mean / smooth,
        "pull-off, reduced by roughness [%]": 100 * (1 - mean / smooth),
        "displacement at pull-off, mean [nm]": float(delta.mean()),
        "displacement at pull-off, std [nm]": float(delta.std(ddof=1)),
        "places that adhere": float(force.notnull().sum()),
    }


def _strongest_rows(run: Run, method: str) -> dict[str, float]:
    """Return values at the place of figure 15, and where the force exceeds that on a smooth flat."""
    place = {"subregion": strongest_place(run)}
    solution = run[f"solutions/{method}"]
    pull_off = float(run[f"statistics/{method}"]["pull_off_force"].isel(place))
    rows = {
        "figure 15, pull-off [µN]": _MICRO * pull_off,
        "figure 15, rough / smooth": pull_off / smooth_pull_off(solution),
    }
    if "force" not in solution:
        return rows  # the simulation has only events
    force = solution["force"].isel(place)
    smooth = smooth_sphere(solution)["force"]
    pulling = force["delta"].values[force.values < 0]
    return rows | {
        "figure 15, attraction from [nm]": float(pulling.min(initial=np.inf)),
        "figure 15, attraction to [nm]": float(pulling.max(initial=-np.inf)),
        "figure 15, above smooth from [nm]": surpassing_delta(force, smooth),
        "mean force above smooth from [nm]": surpassing_delta(solution["force"].mean("subregion"), smooth),
    }


def force_table(run: Run) -> pd.DataFrame:
    """Return forces without adhesion of the simulation and of both sums, with the printed ones in the first columns."""
    sums = {"published": HERTZ, "corrected": "hertz_corrected"}
    columns = {"direct": _direct_rows(run)} | {name: _agreement_rows(run, key) for name, key in sums.items()}
    return _with_printed(pd.DataFrame(columns), FORCE)


def _direct_rows(run: Run) -> dict[str, float]:
    direct, smooth = (run[f"solutions/{name}"] for name in ("direct", "smooth"))
    pair = read_pair(smooth)
    hertz = reference.hertz(smooth["delta"].values, radius=pair.sphere_radius, contact_modulus=pair.contact_modulus)
    rows = {"smooth flat, difference from Hertz [%]": 100 * float(abs(smooth["force"] / hertz["force"] - 1).max())}
    for delta in _DISTRIBUTION_DELTAS:
        force = _MICRO * direct["force"].sel(delta=delta, method="nearest").values
        mean = float(force.mean())
        std = float(force.std(ddof=1))
        rows |= {
            f"at {delta:g} nm, mean [µN]": mean,
            f"at {delta:g} nm, std [µN]": std,
            f"at {delta:g} nm, std / mean": std / mean if mean else np.nan,
            f"at {delta:g} nm, second group [µN]": float(second_group(force).mean()),
        }
    for delta in _SMOOTH_DELTAS:
        rough, flat = (ds["force"].sel(delta=delta, method="nearest").mean() for ds in (direct, smooth))
        rows[f"rough / smooth at {delta:g} nm"] = float(rough / flat)
    return rows | {"places without debris": float(places_without_debris(run, "direct").sizes["subregion"])}


def _at(values: xr.DataArray, deltas: Iterable[float], name: str) -> dict[str, float]:
    """Return values at the nearest displacements (nm), by name and displacement."""
    return {f"{name} at {delta:g} nm": float(values.sel(delta=delta, method="nearest")) for delta in deltas}


def _agreement_rows(run: Run, name: str) -> dict[str, float]:
    """Return how a sum without adhesion agrees with the direct simulation, by ratio and on the paper's linear axes."""
    solved = places_without_debris(run, "direct")["force"]
    summed = places_without_debris(run, name)["force"].interp(delta=solved["delta"])
    means = summed.mean("subregion"), solved.mean("subregion")
    ratio = means[0] / means[1]
    is_one_line = abs(summed - solved) <= _LINE_WIDTH * means[1].sel(delta=20, method="nearest")
    alike = is_one_line.sum("subregion")
    return _at(ratio, _RATIO_DELTAS, "sum / direct") | _at(alike, _AXIS_DELTAS, "places within 2 %")


def correction_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by formulas and patch, and the ratios of the means by each change alone, as text."""
    force = _MICRO * run["statistics/corrections"]["pull_off_force"].transpose("formulation", "patch", "subregion")
    mean = force.mean("subregion").values
    spread = force.std("subregion", ddof=1).values
    texts = [[f"{m:.2f} ± {s:.2f}" for m, s in zip(*row)] for row in zip(mean, spread)]
    texts = [[*row, f"{by_patch:.2f}"] for row, by_patch in zip(texts, mean[:, 1] / mean[:, 0])]
    texts.append([*(f"{by_formulas:.1f}" for by_formulas in mean[1] / mean[0]), ""])
    index = pd.Index([*FORMULATIONS.values(), "ratio"], name="formulas")
    return pd.DataFrame(texts, index=index, columns=[*PATCHES.values(), "ratio"])


def scan_table(run: Run, general_tables: Mapping[str, pd.DataFrame] | None = None) -> pd.DataFrame:
    """Return the main numbers of scan and asperities with the printed ones in the first columns."""
    table = (general_tables or report.tables(run))[_SCAN]
    rows = _reconstruction_rows(run) | _asperity_rows(run["asperities"])
    whole = pd.concat([table, pd.DataFrame({"scan": rows})])
    order = [*SCAN, *(name for name in whole.index if name not in SCAN)]
    return _with_printed(whole.loc[order], SCAN)


def _reconstruction_rows(run: Run) -> dict[str, float]:
    """Return R_a and R_q of scan and reconstruction, and their difference."""
    height = run["scan"]["height"]
    rows = {"original - reconstructed, rms [nm]": run["reconstruction"].attrs["residual_rms"]}
    for name, power in (("R_q", 2), ("R_a", 1)):
        scan_row, envelope = (
            float((abs(h) ** power).mean() ** (1 / power)) for h in (height, run["reconstruction"]["height"])
        )
        rows |= {f"{name} about zero, original [nm]": scan_row, f"{name} about zero, reconstructed [nm]": envelope}
        rows[f"{name}, reconstructed above original [%]"] = 100 * (envelope / scan_row - 1)
    return rows


def _asperity_rows(catalogue: xr.Dataset) -> dict[str, float]:
    """Return the second group of peaks, the shape of the axis ratios' distribution, and the isotropy of directions."""
    from scipy import stats

    debris_peaks = second_group(catalogue["height"].values)
    ratio = catalogue["axis_ratio"].dropna("asperity").values
    gaussian = stats.norm(ratio.mean(), ratio.std(ddof=1))
    angles = catalogue["orientation"].values
    counts = np.histogram(angles[np.isfinite(angles)], bins=12, range=(-np.pi / 2, np.pi / 2))[0]
    return {
        "peak height, second group, mean [nm]": float(debris_peaks.mean()),
        "peaks in the second group": float(debris_peaks.size),
        "axis ratio b/a, skewness": float(stats.skew(ratio)),
        "axis ratio b/a, cdf off Gaussian's [%]": 100 * float(stats.kstest(ratio, gaussian.cdf).statistic),
        "isotropy of directions (1: isotropic)": float(counts.min() / max(counts.max(), 1)),
        "asperities with a < 10 b [%]": 100 * float((ratio > 0.1).mean()),
    }


def second_group(values: np.ndarray) -> np.ndarray:
    """Return the values above the widest gap between consecutive ones; none of fewer than two."""
    values = np.sort(values)
    return values[np.argmax(np.diff(values)) + 1 :] if values.size > 1 else values[:0]
