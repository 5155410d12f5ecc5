"""Cautions about a run's numbers, as sentences."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np
import xarray as xr

from ..contact.certificate import SOLVED, checked
from ..scans.plausibility import doubts
from ..statistics import smooth_pull_off
from ..vocabulary import schema
from ..vocabulary.numbers import number, percent
from .budget import resolution
from .intervals import flagged
from .summary import mesh_change
from .tables import share_at_pull_off

Run = Mapping[str, xr.Dataset]

#: Share of the force above the hardness from which on a caution is given.
_YIELDED_SHARE = 0.005

#: Median change of the pull-off, on a finer mesh with shorter steps, at which a caution is given.
_LARGEST_CHANGE = 0.1


def cautions(run: Run) -> list[str]:
    """Return cautions about a run's numbers, one sentence each, none if there is no reason for any.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    list of str

    Examples
    --------
    >>> from roughxr.scans.synthetic import self_affine
    >>> cautions({"scan": self_affine((16, 16), 10, rms=1, hurst=0.8, rolloff=80, seed=1)})[0]
    'The scan is synthetic: generated from a random seed, not measured.'
    """
    return [sentence for find in _FINDERS for sentence in find(run)]


def _coarse(run: Run) -> Iterator[str]:
    """Yield a caution where the simulation with adhesion has not converged in mesh and step."""
    if not {"solutions/finer", "statistics/adhesive"} <= set(run):
        return
    change = float(abs(mesh_change(run)).median())
    if change > _LARGEST_CHANGE:
        words = f"On a mesh twice as fine, with half the step, the median pull-off changes by {percent(change)}"
        yield f"{words}: the main numbers have at least this error; take a finer mesh (--mesh)."


def superposed(run: Run) -> list[str]:
    """Return what to expect of a run's superposed pull-offs, and which of them exceed the possible."""
    return [
        f"Superposed ({way}): {ds.attrs['expectation']}.{_above_smooth(ds)}"
        for way, ds in _groups(run, "solutions")
        if "expectation" in ds.attrs
    ]


def _groups(run: Run, kind: str) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield the groups of a kind, such as "solutions", each with a description of its method."""
    for name, ds in run.items():
        if name.startswith(f"{kind}/"):
            yield name.partition("/")[2].replace("_", " "), ds


def _above_smooth(ds: xr.Dataset) -> str:
    smooth = smooth_pull_off(ds)
    above = int((ds["pull_off_force"] > smooth).sum()) if "pull_off_force" in ds else 0
    if not above:
        return ""
    return (
        f" At {above} of {ds.sizes['subregion']} places the sum exceeds the pull-off from a smooth flat: there it is "
        "wrong, because the fitted patch is too wide or overlapping contacts are counted twice."
    )


def _of_the_scan(run: Run) -> Iterator[str]:
    if "scan" not in run:
        return
    if run["scan"].attrs.get("synthetic") == "yes":
        yield "The scan is synthetic: generated from a random seed, not measured."
    for doubt in doubts(run["scan"]):
        yield f"About the scan: {doubt}."


def _few(run: Run) -> Iterator[str]:
    """Yield cautions where nothing touches, or there is only one place."""
    if "solutions/direct" not in run:
        return
    force = run["solutions/direct"]["force"]
    if force.sizes["subregion"] == 1:
        yield "Only one place was computed: nothing is known of how places differ."
    if not bool((force > 0).any()):
        yield "Nothing touches at any displacement of the direct simulation: go deeper (--delta)."


def _debris(run: Run) -> Iterator[str]:
    flags = flagged(run)
    if flags is not None and flags.any():
        limit = number(flags.attrs["threshold_value"], flags.attrs["threshold_units"])
        places = f"{int(flags.sum())} of {flags.size} places hold debris"
        rule = f"by the rule ({flags.attrs['comment']}, {limit})"
        yield f"{places} {rule}; the main numbers are given with and without them."


def _unkept(run: Run) -> Iterator[str]:
    """Yield which solutions miss a condition of their contact; of mesh and edge other cautions tell."""
    for way, ds in _groups(run, "solutions"):
        if way in SOLVED and "converged" in ds:
            one = checked(ds)
            lost = one.words.values[~(one.met | one.check.isin(["mesh", "truncated"]))]
            if lost.size:
                yield f"Conditions of the contact are violated ({way}): {'; '.join(lost)}."


def _yielding(run: Run) -> Iterator[str]:
    """Yield cautions on how much is above the hardness in an elastic solution, or which results ignore the yield."""
    solved = {
        "solutions/direct": "in the direct simulation at its largest displacement",
        "solutions/adhesive": "in the simulation with adhesion at its preload",
    }
    known = [group for group in solved if group in run and "yielded_fraction" in run[group]]
    for group in known:
        yield from _above_hardness(run[group], solved[group])
    if known and any("plastic_work" in ds for ds in run.values()):
        yield "Superposition and rigid bodies in this run do not include yield: they stay elastic or rigid."


def _above_hardness(ds: xr.Dataset, where: str) -> Iterator[str]:
    name = "hardness" if "hardness" in ds.coords else "hardness_estimate"
    last = ds.isel(delta=-1) if "delta" in ds["yielded_fraction"].dims else ds
    force, area = (float(last[f"yielded{part}_fraction"].mean()) for part in ("", "_area"))
    if not force > _YIELDED_SHARE:
        return
    shares = f"{where} {percent(area)} of the contact area with {percent(force)} of the force lies"
    if "plastic_work" in ds:
        yield f"The softer body yields: {shares} at its hardness, {number(ds[name], 'GPa')}."
        return
    known = "the hardness" if name == "hardness" else "the hardness estimated for these materials"
    yield (
        f"The contact may not stay elastic: {shares} above {known}, {number(ds[name], 'GPa')}. Such summits "
        "yield; give the hardness (--hardness) to include this."
    )


def _truncated(run: Run) -> Iterator[str]:
    for words, group in (("direct simulation", "direct"), ("superposition", "energy")):
        if f"solutions/{group}" not in run or "truncated" not in run[f"solutions/{group}"]:
            continue
        flags = run[f"solutions/{group}"]["truncated"].astype(bool)
        places = int(flags.any("delta").sum()) if "delta" in flags.dims else int(flags.sum())
        if places:
            yield (
                f"At {places} of {flags.sizes['subregion']} places the contact reaches the scan's edge ({words}): the "
                "surface beyond it is missing, so the force is too low."
            )


def _unbracketed(run: Run) -> Iterator[str]:
    for way, ds in _groups(run, "statistics"):
        if "bracketed" in ds:
            pulls = ds["pull_off_force"].notnull()
            bad, none = int((pulls & ~ds["bracketed"].astype(bool)).sum()), int((~pulls).sum())
            if bad:
                yield f"Places whose sweep was too short ({way}): {bad}; there the largest pull is at its end."
            if none:
                yield f"Places where nothing pulls ({way}), left out of the pull-off statistics: {none}."


def _beyond_patch(run: Run) -> Iterator[str]:
    """Yield a caution on contacts at pull-off that overlap or are larger than the fitted patch."""
    if not {"solutions/energy", "statistics/energy"} <= set(run):
        return
    beyond, over = (share_at_pull_off(run, "energy", f"contacts_{k}") / 100 for k in ("beyond_patch", "overlapping"))
    if max(beyond, over) >= 0.05:
        yield (
            f"At pull-off {percent(beyond)} of the superposed contacts are wider than the patch of their fitted "
            f"paraboloid, and {percent(over)} overlap a neighbour: superposition of single asperities is not valid for "
            "these."
        )


def _saddles(run: Run) -> Iterator[str]:
    if "asperities" not in run or "saddle" not in run["asperities"]:
        return
    share = float(run["asperities"]["saddle"].astype(bool).mean())
    if share >= 0.05:
        yield f"{percent(share)} of the peaks have a saddle as fitted paraboloid, and are left out of superposition."


def _lattice(run: Run) -> Iterator[str]:
    """Yield a caution where the asperities' directions follow the pixels, unlike those of any real surface."""
    if "asperities" not in run:
        return
    angles = run["asperities"]["orientation"].dropna("asperity").values
    fourfold = float(np.cos(4 * angles).mean()) if angles.size else 0.0
    chance = 1 / np.sqrt(2 * max(angles.size, 1))
    if fourfold < max(3 * chance, 0.05) or abs(np.exp(2j * angles).mean()) > fourfold:
        return
    yield (
        f"The orientations of the asperities follow the pixel axes (mean of cos 4θ {fourfold:.2f}, by chance "
        f"{chance:.2f}): the asperities are hardly wider than a pixel, and their shapes are partly those of the "
        "pixels."
    )


def _unresolved(run: Run) -> Iterator[str]:
    """Yield a caution where pixels are too coarse for the contacts: fewer than ten of them touch."""
    if not {"scan", "solutions/direct"} <= set(run) or "contact_area" not in run["solutions/direct"]:
        return
    area = run["solutions/direct"]["contact_area"].values
    cell = float(np.prod(schema.pixel(run["scan"])))
    share = np.mean(area[area > 0] < 10 * cell) if (area > 0).any() else 0.0
    if share >= 0.05:
        few = f"In {percent(share)} of the elastic contacts fewer than ten pixels touch"
        yield f"{few}: the scan does not resolve them."


#: What looks for cautions, in the order of the page.
_FINDERS: tuple[Callable[[Run], Iterable[str]], ...] = (
    _of_the_scan,
    _debris,
    _few,
    _unkept,
    _coarse,
    _yielding,
    _truncated,
    _unbracketed,
    resolution,
    superposed,
    _beyond_patch,
    _saddles,
    _lattice,
    _unresolved,
)
