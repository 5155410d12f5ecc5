"""The options of `adhesive`, read into an `Adhesion` or refused.

law         the pair's law of adhesion and its length, with condensed liquid
step, cell  the usual mesh, from the range of adhesion and JKR's lengths
depth       the largest depth of loading to a preload
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies.liquid import Menisci
from ..bodies.pair_record import Pair
from ..specimen import Specimen, specimen_of
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS, AUTO, EXPONENTIAL, JKR, SHORT_RANGE, read_law
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, Phrase
from ..vocabulary.units import whole_number
from .adhesion_on_cells import Adhesion, interaction_range, largest_cell
from .cycle import MOST_CELLS, overlapping_cells
from .estimates import automatic_law, median_tabor
from .mesh import FRONT, MOST_REFINED, Mesh, TooManyCells
from .problem import Problem, deepest, hertz_displacement, places, read_problem, surface_at

#: The usual step in ranges of adhesion; the longer of this and the next is taken.
_STEP_OF_RANGE = 5 / 6

#: The usual step as a part of JKR's displacement δ_c.
_STEP_OF_DISPLACEMENT = 1 / 40

#: The first steps of a run are longer by this factor; a few places are repeated with half of them.
LONG_STEP = 1.6

#: A mesh whose cells are the scan's pixels.
_AS_SCANNED = Mesh(1, None)


def read_adhesion(specimen: Specimen, law: str, *, preloads, mesh: Mesh, cycles) -> Adhesion:
    """Return the `Adhesion` of a pair, a law and options; raise if an option is out of its range."""
    law, tabor = chosen_law(specimen, law)
    step, first_cell = _usual_step_and_cell(specimen)
    settings = Adhesion(
        preloads=preloads,
        refine=0 if isinstance(mesh.cells, str) else mesh.cells,
        by_front=mesh.cells == FRONT,
        on_cells=mesh.cells != FRONT,
        accuracy=np.nan if mesh.accuracy is None else mesh.accuracy,
        step=step if mesh.step is None else mesh.step,
        first_cell=first_cell,
        capture=None if ADHESION_LAWS[law].has_range or not specimen.pair.solid_work > 0 else _capture(specimen),
        cycles=whole_number(cycles, "cycles", least=1),
        tabor=tabor,
        **pair_law(specimen.pair, law),
    )
    if settings.cycles > 1 and not preloads.size:
        raise Refusal("cycles", "one with displacements (delta)", cycles, "leave delta or cycles out")
    return settings


def longest_step(specimen: Specimen, mesh: Mesh) -> float:
    """Return the longest step (nm) of a mesh: as stated, or the usual step."""
    return usual_step(specimen) if mesh.step is None else mesh.step


def usual_step(specimen: Specimen) -> float:
    """Return the longest step (nm) of a mesh that does not state any."""
    return _usual_step_and_cell(specimen)[0]


def _usual_step_and_cell(specimen: Specimen) -> tuple[float, float]:
    """Return the usual step and the side of the first cells (nm), from the range and JKR's lengths."""
    pair = specimen.pair
    pair.need("contact_modulus", "work_of_adhesion")
    radius = _contact_radius(specimen.heights, specimen.pixel, specimen.indenter.mean_radius)
    contact_radius, modulus = pair.contact_at_pull_off(radius, pair.work)
    displacement = 0.75 * (np.pi**2 * pair.work**2 * radius / modulus**2) ** (1 / 3)
    length = pair.range
    step = max(_STEP_OF_RANGE * length, _STEP_OF_DISPLACEMENT * displacement)
    # side of the cells on the coarsest mesh without range, in ranges of adhesion and as a part of JKR's radius a_c: the
    # larger of both
    return step, max((50 / 3) * length, 0.1 * contact_radius)


def preload_problem(
    ds: xr.Dataset | Specimen, *, preload: Any = 0.0, law: str = EXPONENTIAL, mesh: Mesh = _AS_SCANNED
) -> tuple[Problem, Adhesion]:
    """Return the problem and `Adhesion` of a cycle to a preload (nN) on one mesh.

    The only displacement of the problem is the largest depth (nm beyond first contact) of loading.
    """
    specimen = specimen_of(ds)
    adhesion = read_adhesion(specimen, law, preloads=read_preloads(preload), mesh=mesh, cycles=1)
    depth = [settling_depth(specimen, adhesion)]
    at = specimen.centres(None)
    problem = read_problem(specimen, at, delta=depth, datum="first_contact", refine=max(adhesion.refine, 1))
    need_resolved_law(adhesion, problem)
    return problem, adhesion


def chosen_law(specimen: Specimen, law: str) -> tuple[str, float]:
    """Return the name of a law, "auto" by the pair and the asperities, and Tabor's parameter if that decided.

    Raise if nothing is known of the adhesion.
    """
    name = read_law(law, "adhesive")
    pair = specimen.pair
    pair.need("work_of_adhesion")
    if name != AUTO:
        return name, np.nan
    if pair.menisci is not None or pair.yields:
        return EXPONENTIAL, np.nan
    if not pair.solid_work > 0:
        return JKR, np.nan
    parameter = _tabor_parameter(specimen)
    return automatic_law(parameter), parameter


def changes_the_law(tabor: float) -> bool:
    """Return whether a factor of 2 in Tabor's parameter, by which "auto" chose the law, changes it."""
    return SHORT_RANGE / 2 <= tabor <= 2 * SHORT_RANGE


def pair_law(pair: Pair, law: str) -> dict[str, Any]:
    """Return a law with its length and work; raise if a yielding pair is too soft for it."""
    if pair.menisci is not None:
        return _law_with_liquid(pair, law, pair.menisci)
    length = pair.range_of(law)
    if pair.yields:
        _need_hardness_above(pair.hardness, pair.solid_work, length, law)
    return {"law": law, "length": length if ADHESION_LAWS[law].has_range else np.nan, "work": pair.solid_work}


def _capture(specimen: Specimen) -> float:
    """Return the gap (nm) at which the pair's attraction snaps in a summit of the scan."""
    return snap_in_gap(specimen.pair.range, median_tabor(specimen))


def _tabor_parameter(specimen: Specimen) -> float:
    """Return the median of Tabor's parameter over the asperities; without asperities, that of the sphere."""
    parameter = median_tabor(specimen)
    if np.isfinite(parameter) or specimen.indenter.map:
        return parameter
    return float(specimen.pair.tabor_parameters(specimen.pair.sphere_radius)[0])


def snap_in_gap(length: float, parameter: float) -> float:
    """Return the gap (nm) at which van der Waals attraction of a range z₀ (nm) snaps a sphere into contact.

    It is the undeformed gap (2.641 µ^{3/7} − 1) z₀ with Tabor's parameter µ (Wu, J. Adhesion 86 (2010) 1071). The
    balance of attraction and elasticity gives the power; a solution of the sphere's equations confirms the factor to
    0.7 % at µ of 1 to 100 (``tests/test_soft_bodies.py``). Below 0.7 a sphere does not jump.
    """
    # Tabor's parameter above which a sphere jumps into contact
    return (2.641 * parameter ** (3 / 7) - 1.0) * length if parameter > 0.7 else 0.0


def _law_with_liquid(pair: Pair, law: str, menisci: Menisci) -> dict[str, Any]:
    """Return the solids' law under and beyond condensed liquid, and the liquid."""
    if not ADHESION_LAWS[law].takes_liquid:
        raise Refusal("law", f"{EXPONENTIAL!r} for the solids of a humid pair", f"{law!r}")
    length = pair.range
    beyond = np.exp(-menisci.height / length)
    work = pair.solid_work * (menisci.share + (1 - menisci.share) * beyond)
    if pair.yields:
        _need_hardness_above(pair.hardness, work + menisci.capillary_pressure * length, length, EXPONENTIAL)
    return {"law": EXPONENTIAL, "length": length, "work": work, "liquid": menisci}


def _need_hardness_above(hardness: float, work: float, length: float, law: str) -> None:
    """Raise if a yielding body has no adhesion, or yields under adhesion alone."""
    advice = "or assign no hardness, for elastic bodies"
    if work == 0:
        raise Refusal("work_of_adhesion", "more than 0 for bodies that yield", "0", f"take direct, {advice}")
    if ADHESION_LAWS[law].has_range and hardness <= work / length:  # without range the tension is unbounded
        raise Refusal(
            "hardness",
            f"more than the adhesive traction, {work / length:.3g} GPa over {length:.3g} nm",
            f"{hardness:.3g} GPa",
            Phrase("assign the ", Argument("adhesion_range"), f" that belongs to the work of adhesion, {advice}"),
        )


def read_preloads(preload: Any) -> np.ndarray:
    """Return preloads in nN, ascending; raise if any is negative."""
    stated = 0.0 if preload is None else preload
    values = schema.ascending(stated, "nN", "preload")
    if values[0] < 0:
        raise Refusal("preload", "at least 0 nN (a particle that settles)", f"{values[0]:g} nN")
    return values


def settling_depth(specimen: Specimen, adhesion: Adhesion) -> float:
    """Return the largest depth (nm) beyond first contact of loading to the largest preload.

    It is the depth of a smooth sphere under that load and its adhesion, by Hertz's and JKR's formulas, and
    four standard deviations of the heights: nearly all of the surface lies higher.
    """
    pair = specimen.pair
    modulus = pair.contact_modulus / (max(1.0, pair.layer.softening(np.inf)) if pair.layer else 1.0)
    radius = specimen.indenter.mean_radius
    load = float(adhesion.preloads[-1]) + 6 * np.pi * adhesion.whole_work * radius
    hertz = hertz_displacement(load, radius, modulus)
    if pair.yields:  # a fully plastic sphere has the area load/hardness
        hertz += load / (2 * np.pi * radius * pair.hardness)
    # depth of loading to a preload beyond the depth of a smooth sphere, in standard deviations of the heights
    return float(hertz + 4.0 * specimen.heights.std() + 12 * np.nan_to_num(adhesion.length))


def _contact_radius(heights: np.ndarray, pixel: float, radius: float) -> float:
    """Return the radius (nm) in JKR's lengths that scale steps and cells: the indenter's, at most the scan's L²/2z.

    Over the half-width L of a scan with heights within z, an indenter of a larger radius acts as a plane.
    """
    half = 0.5 * pixel * min(heights.shape)
    rise = float(np.ptp(heights))
    return min(radius, half**2 / (2 * rise)) if rise > 0 else radius


def need_resolved_law(adhesion: Adhesion, problem: Problem) -> None:
    """Raise if no permitted mesh resolves the traction of the law: the forces would be wrong."""
    law = ADHESION_LAWS[adhesion.law]
    cell = law.refused_cell * largest_cell(adhesion, problem)
    smallest = problem.pixel / (adhesion.refine or MOST_REFINED)
    if smallest > cell:
        refine = int(np.ceil(problem.pixel / cell))
        advice = Phrase("take ", Argument("law", law.rival))
        if refine <= MOST_REFINED:
            advice = Phrase("take ", Argument("mesh", refine), ", or ", Argument("law", law.rival))
        raise Refusal(
            Phrase(Argument("law", adhesion.law)),
            f"cells of at most {cell:.3g} nm (larger ones do not resolve its traction)",
            f"{smallest:.3g} nm",
            advice,
        )


def need_few_cells(specimen: Specimen, problem: Problem, adhesion: Adhesion, positions: xr.Dataset, reach) -> None:
    """Refuse one mesh for all places with too many cells at any place; name the finest possible mesh."""
    if not adhesion.refine:
        return
    solved, shape = places(specimen, positions, reach)
    if shape[0] * shape[1] * adhesion.refine**2 <= MOST_CELLS:  # windows are wider than the overlap
        return
    surfaces = [surface_at(place, problem._replace(refine=1)) for place in solved]
    cells = max(overlapping_cells(surface, problem, adhesion) for surface in surfaces)
    if cells * adhesion.refine**2 > MOST_CELLS:
        finest = int(np.sqrt(MOST_CELLS / cells))
        advice: str = "take a smaller preload or delta, or a coarser scan"
        if finest:
            advice = Phrase("take ", Argument("mesh", finest))
        raise TooManyCells(
            "mesh",
            f"at most {MOST_CELLS:g} cells within the interaction range",
            f"{cells * adhesion.refine**2:.3g} with mesh={adhesion.refine}",
            advice,
        )


def window_half_width(specimen: Specimen, problem: Problem, adhesion: Adhesion) -> float:
    """Return the half-width (nm) of the windows: the overlap, and the surface lifted by adhesion."""
    if problem.indenter.map:
        return problem.indenter.half_width(np.inf)
    depth = deepest(specimen, problem._replace(first_contact=problem.first_contact or adhesion.preloads.size > 0))
    if np.isinf(depth):
        return np.inf
    attraction = interaction_range(adhesion, problem)
    reach = problem.indenter.half_width(depth)
    for _ in range(20):  # JKR's contact of radius a lifts the surface by √(2πaw/E*)
        uplift = np.sqrt(2 * np.pi * reach * adhesion.whole_work / problem.softest)
        reach = problem.indenter.half_width(depth + uplift + attraction)
    return reach + problem.pixel
