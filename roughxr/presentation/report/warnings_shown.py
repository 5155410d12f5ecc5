"""Cautions about a run's numbers, as sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr

from ...contact.certificate import SOLVED, checked
from ...scans.plausibility import doubts
from ...statistics import smooth_pull_off
from ...vocabulary import schema
from ...vocabulary.numbers import number, percent
from ...vocabulary.verbs import verb
from .budget import resolution
from .intervals import flagged
from .tables import mesh_change, share_at_pull_off

Run = Mapping[str, xr.Dataset]

#: Share of the force above the hardness from which on a caution is given.
_YIELDED_SHARE = 0.005

#: Median change of the pull-off, on a finer mesh with shorter steps, at which a caution is given.
_LARGEST_CHANGE = 0.1


@verb
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
    said = [
        _synthetic(run),
        *([f"About the scan: {doubt}." for doubt in doubts(run["scan"])] if "scan" in run else []),
        _debris(run),
        *_few(run),
        *_unkept(run),
        _coarse(run),
        *_yielding(run),
        *_truncated(run),
        *_unbracketed(run),
        *resolution(run),
    ]
    return [
        sentence
        for sentence in (*said, *superposed(run), _beyond_patch(run), _saddles(run), _lattice(run), _unresolved(run))
        if sentence
    ]


def _coarse(run: Run) -> str:
    """Return a caution where the simulation with adhesion has not converged in mesh and step."""
    if not {"solutions/finer", "statistics/adhesive"} <= set(run):
        return ""
    change = float(abs(mesh_change(run)).median())
    if not change > _LARGEST_CHANGE:
        return ""
    words = f"On a mesh twice as fine, with half the step, the median pull-off changes by {percent(change)}"
    return f"{words}: the main numbers have at least this error; take a finer mesh (--mesh)."


@verb
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


def _synthetic(run: Run) -> str:
    made = "scan" in run and run["scan"].attrs.get("synthetic") == "yes"
    return "The scan is synthetic: generated from a random seed, not measured." if made else ""


def _few(run: Run) -> list[str]:
    """Return cautions where nothing touches, or there is only one place."""
    said = []
    if "solutions/direct" in run:
        force = run["solutions/direct"]["force"]
        if force.sizes["subregion"] == 1:
            said.append("Only one place was computed: nothing is known of how places differ.")
        if not bool((force > 0).any()):
            said.append("Nothing touches at any displacement of the direct simulation: go deeper (--delta).")
    return said


def _debris(run: Run) -> str:
    flags = flagged(run)
    if flags is None or not flags.any():
        return ""
    limit = number(flags.attrs["threshold_value"], flags.attrs["threshold_units"])
    places = f"{int(flags.sum())} of {flags.size} places hold debris"
    return (
        f"{places} by the rule ({flags.attrs['comment']}, {limit}); the main numbers are given with and without them."
    )


def _unkept(run: Run) -> list[str]:
    """Return which solutions miss a condition of their contact; of mesh and edge other cautions tell."""
    told = {way: checked(ds) for way, ds in _groups(run, "solutions") if way in SOLVED and "converged" in ds}
    lost = {way: one.words.values[~(one.kept | one.check.isin(["mesh", "truncated"]))] for way, one in told.items()}
    return [
        f"Conditions of the contact are violated ({way}): {'; '.join(words)}."
        for way, words in lost.items()
        if words.size
    ]


def _yielding(run: Run) -> list[str]:
    """Return cautions on how much is above the hardness in an elastic solution, or which results ignore the yield."""
    said = []
    for words, group, where in (
        ("the direct simulation", "solutions/direct", "at its largest displacement"),
        ("the simulation with adhesion", "solutions/adhesive", "at its preload"),
    ):
        if group in run and "yielded_fraction" in run[group]:
            said.append(_above_hardness(run[group], words, where))
    if said and any("plastic_work" in ds for ds in run.values()):
        said.append("Superposition and rigid bodies in this run do not include yield: they stay elastic or rigid.")
    return said


def _above_hardness(ds: xr.Dataset, words: str, where: str) -> str:
    name = "hardness" if "hardness" in ds.coords else "hardness_estimate"
    last = ds.isel(delta=-1) if "delta" in ds["yielded_fraction"].dims else ds
    force, area = (float(last[f"yielded{part}_fraction"].mean()) for part in ("", "_area"))
    if not force > _YIELDED_SHARE:
        return ""
    shares = f"{where} {percent(area)} of the contact area with {percent(force)} of the force lies"
    if "plastic_work" in ds:
        return f"The softer body yields: in {words} {shares} at its hardness, {number(ds[name], 'GPa')}."
    known = "the hardness" if name == "hardness" else "the hardness estimated for these materials"
    return (
        f"The contact may not stay elastic: in {words} {shares} above {known}, {number(ds[name], 'GPa')}. Such summits "
        "yield; give the hardness (--hardness) to include this."
    )


def _truncated(run: Run) -> list[str]:
    said = []
    for words, group in (("direct simulation", "direct"), ("superposition", "energy")):
        if f"solutions/{group}" not in run or "truncated" not in run[f"solutions/{group}"]:
            continue
        flags = run[f"solutions/{group}"]["truncated"].astype(bool)
        places = int(flags.any("delta").sum()) if "delta" in flags.dims else int(flags.sum())
        if places:
            said.append(
                f"At {places} of {flags.sizes['subregion']} places the contact reaches the scan's edge ({words}): the "
                "surface beyond it is missing, so the force is too low."
            )
    return said


def _unbracketed(run: Run) -> list[str]:
    said = []
    for way, ds in _groups(run, "statistics"):
        if "bracketed" in ds:
            pulls = ds["pull_off_force"].notnull()
            bad, none = int((pulls & ~ds["bracketed"].astype(bool)).sum()), int((~pulls).sum())
            if bad:
                said.append(f"Places whose sweep was too short ({way}): {bad}; there the largest pull is at its end.")
            if none:
                said.append(f"Places where nothing pulls ({way}), left out of the pull-off statistics: {none}.")
    return said


def _beyond_patch(run: Run) -> str:
    """Return a caution on contacts at pull-off that overlap or are larger than the fitted patch."""
    if not {"solutions/energy", "statistics/energy"} <= set(run):
        return ""
    beyond, over = (share_at_pull_off(run, "energy", f"contacts_{k}") / 100 for k in ("beyond_patch", "overlapping"))
    if not max(beyond, over) >= 0.05:
        return ""
    return (
        f"At pull-off {percent(beyond)} of the superposed contacts are wider than the patch of their fitted "
        f"paraboloid, and {percent(over)} overlap a neighbour: superposition of single asperities is not valid for "
        "these."
    )


def _saddles(run: Run) -> str:
    if "asperities" not in run or "saddle" not in run["asperities"]:
        return ""
    share = float(run["asperities"]["saddle"].astype(bool).mean())
    words = "of the peaks have a saddle as fitted paraboloid, and are left out of superposition."
    return f"{percent(share)} {words}" if share >= 0.05 else ""


def _lattice(run: Run) -> str:
    """Return a caution where the asperities' directions follow the pixels, unlike those of any real surface."""
    if "asperities" not in run:
        return ""
    angles = run["asperities"]["orientation"].dropna("asperity").values
    fourfold = float(np.cos(4 * angles).mean()) if angles.size else 0.0
    chance = 1 / np.sqrt(2 * max(angles.size, 1))
    if fourfold < max(3 * chance, 0.05) or abs(np.exp(2j * angles).mean()) > fourfold:
        return ""
    return (
        f"The orientations of the asperities follow the pixel axes (mean of cos 4θ {fourfold:.2f}, by chance "
        f"{chance:.2f}): the asperities are hardly wider than a pixel, and their shapes are partly those of the "
        "pixels."
    )


def _unresolved(run: Run) -> str:
    """Return a caution where pixels are too coarse for the contacts: fewer than ten of them touch."""
    if not {"scan", "solutions/direct"} <= set(run) or "contact_area" not in run["solutions/direct"]:
        return ""
    area = run["solutions/direct"]["contact_area"].values
    cell = float(np.prod(schema.pixel(run["scan"])))
    share = np.mean(area[area > 0] < 10 * cell) if (area > 0).any() else 0.0
    if share < 0.05:
        return ""
    return f"In {percent(share)} of the elastic contacts fewer than ten pixels touch: the scan does not resolve them."
