"""`rolling`: the moment that resists rolling, by direction, from asperities or from the contacts of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.layer import largest_contact
from ..bodies.pair_record import read_pair
from ..jobs import spread
from ..jobs.records import Layout, converged, labelled, warn_unconverged
from ..kernels.asperity import contact_sums as sums
from ..kernels.asperity import rotation
from ..kernels.asperity.asperity_laws import subset
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS, JKR
from ..vocabulary.numbers import format_number
from ..vocabulary.refusal import Refusal, shown
from ..vocabulary.text import warn
from ..vocabulary.units import Places, Quantities, Quantity, is_whole, magnitude, whole_number
from .asperity_sum import DEFAULT, Asperities, Summands, SumOptions, exact_pull_offs, law_attributes, read_summands
from .catalogue import DoubtfulAsperities

_MOMENTS = ("resisting_moment", "hinge_distance", "tipping_force", "tipping_hinge_distance")
_STATES = {name: float for name in (*_MOMENTS, "lever")}
_EVENTS: dict[str, type] = {
    "pull_off_force": float,
    "pull_off_delta": float,
    "contact_area": float,
    "weakest_direction": float,
    "stiffest_direction": float,
    "weakest_ties": bool,
    "stiffest_ties": bool,
    "converged": bool,
}
_SIMULATED_STATES: dict[str, type] = {"contacts": int, "lever_error": float, "mesh": int}
_ASPERITY_STATES = {"rest_delta": float, "contacts": int, "truncated": bool}

#: Variables of a solution with moments (`contact.adhesion`), and their names in that of `rolling`.
KEPT = {
    **{name: name for name in _STATES},
    **{f"{end}_{kind}": f"{end}_{kind}" for end in ("weakest", "stiffest") for kind in ("direction", "ties")},
    "contacts": "contacts",
    "lever_error": "lever_error",
    "lever_mesh": "mesh",
    "rest_contact_area": "contact_area",
}

#: Why a number is missing, by the kind of input.
MISSING = {
    "superpose": "NaN where nothing is in contact under this force, nothing adheres or no resting position exists",
    "adhesive": "NaN where no state of the retraction is in contact, or any of them has not converged",
    "rigid": "NaN where no state is in contact",
}

#: Largest gap of cells in contact in `adhesive`, in sides of a cell, by rounding.
_CLOSED_GAP = 1e-6

#: Largest gap of cells in contact in `rigid`, in lengths of its law.
_RIGID_GAP = 1.25

#: Moments that differ by less than this share of the largest are equal but for rounding.
_EQUAL_MOMENTS = 1e-6


@schema.recorded
def rolling(
    ds: xr.Dataset,
    *,
    directions: Quantities = 24,
    normal_force: Quantity = 0.0,
    subregions: Places = None,
) -> xr.Dataset:
    """Return the largest moment by which contact, adhesion and normal force resist rolling, by direction.

    From a scan or a catalogue: the sphere rests on its asperities under ``normal_force``, then turns as a rigid body
    about the foremost edge of its contact, and the asperities behind detach one after the other, by JKR's law. From a
    solution by `adhesive` or `rigid` with fields: the largest moment about the foremost cell in contact over the states
    of the retraction, in which the sphere does not turn. Cells of `rigid` within 1.25 of its law's length are in
    contact.

    Parameters
    ----------
    ds : Dataset
        A scan or an asperity catalogue with an assigned dry pair, or a solution by `adhesive` or `rigid` with
        ``fields=True``. A layer below asperities counts as a thick one, with a warning where it is not.
    directions : int or array_like
        Directions of rolling: a number of them, spaced evenly, or angles from x towards y, rad.
    normal_force : number or quantity
        Force on the sphere's axis as it begins to roll, nN, positive towards the surface; for example its weight. It
        must be positive without adhesion.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres: by default those on ``ds``, else one in its middle; not for a solution, which has its own.

    Returns
    -------
    Dataset
        Along (subregion, direction): ``resisting_moment`` (nN nm), negative where the sphere rolls off by itself;
        ``hinge_distance`` (nm) from the sphere's axis to the edge at that moment, negative if the axis lies beyond
        the edge; ``lever`` (nm), the moment over the pull-off force; ``tipping_force`` (nN), the normal force at the
        axis that alone tips the sphere, inf if none does, and ``tipping_hinge_distance`` (nm), the edge's distance
        then. Along subregion: ``weakest_direction`` and ``stiffest_direction`` (rad), the first of several equal
        directions, with ``weakest_ties`` and ``stiffest_ties`` if there are several; ``pull_off_force`` (nN),
        ``pull_off_delta`` (nm), ``contact_area`` (nm², at rest), ``contacts`` (at rest: asperities, or patches of the
        simulation two pixels or more apart). For asperities also ``rest_delta`` (nm from the highest peak) and
        ``truncated``; for a simulation ``mesh`` and ``lever_error``, the relative error of the lever in any
        direction over the mean of all. It is known if several meshes were solved, as in runs. NaN without contact or if
        not ``converged``, as the attribute ``missing`` explains. Lazy if the scan is.

    Raises
    ------
    ValueError
        If a scan's pair is humid, there is neither adhesion nor a normal force, or a solution has no pressures on
        retraction.

    Notes
    -----
    For one JKR contact the moment is the largest −P a = (15/16)(5/4)^(2/3) P_c a_c = 1.087872 P_c a_c; for two contacts
    far apart P_c times their distance; for N equal contacts on a ring of radius ρ ≫ a_c 0.8770 N P_c ρ, and N P_c ρ by
    the states of a retraction, in which all of them pull at once. Without adhesion, stiff contacts under a load L
    resist by L times the edge's distance. Asperities stay elastic, also with a hardness.

    The moment about the edge of a single contact is an upper bound of its resistance: an elastic adhesive contact
    closes in front as it opens behind, and resists by its adhesion hysteresis alone.

    The sphere does not settle sideways (but see `resting`, with ``on`` these asperities). On one or two ``contacts`` a
    real sphere would roll on until it rests on three; such places resist little, and detach first in `critical_load`
    and `resuspension`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = scan.contact.rolling(directions=8, subregions=(2, 2))
    >>> moments.resisting_moment.dims, moments.resisting_moment.units
    (('subregion', 'direction'), 'nN nm')
    """
    ds = schema.entered_dataset(ds)
    angles = read_directions(directions)
    push = float(magnitude(normal_force, "nN", "normal_force"))
    is_solution = "force" in ds or "pull_off_force" in ds
    if is_solution and "height" not in ds:
        if subregions is not None:
            raise Refusal("subregions", "none with a solution", "some", "leave it out")
        method = "rigid" if ds.attrs.get("method") == "rigid" else "adhesive"
        return _labelled_moments(_solution_moments(ds, angles, push), method, push)
    if schema.is_humid(ds):
        raise Refusal(
            "humidity",
            "a dry pair",
            "a humid one, whose menisci merge",
            "take the moments of ds.contact.rigid(delta=[…], fields=True) or ds.contact.adhesive(delta=[…], "
            "fields=True)",
        )
    summands = read_summands(ds, JKR, DEFAULT, coated=True)
    if not (summands.options.work_of_adhesion > 0 or push > 0):
        raise Refusal("normal_force", "a positive force in nN without adhesion", f"{push:g}")
    if schema.is_coated(ds):
        _warn_of_a_thin_layer(ds, summands.median_contact)
    out = _asperity_moments(summands, angles, push, subregions)
    out.attrs |= law_attributes(summands.law, summands.formulation, summands.options)
    out = _labelled_moments(out, "superpose", push)
    if isinstance(subregions, xr.Dataset) and "supports" in subregions and not spread.is_lazy(out):
        _warn_of_lost_supports(float(out["contacts"].mean()), float(subregions["supports"].mean()))
    return out


def read_directions(directions: Quantities) -> np.ndarray:
    """Return directions of rolling (rad), ascending; a number of them is spaced evenly."""
    if not is_whole(directions):
        if np.ndim(directions) == 0:  # type: ignore[arg-type]
            raise Refusal("directions", "their number, a whole one, or several directions in rad", shown(directions))
        return schema.ascending(directions, "rad", "directions")
    count = whole_number(directions, "directions", least=1)
    return 2 * np.pi * np.arange(count) / count


def split_moments(ds: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Return a solution with moments (`contact.adhesion`) without them, and they in the form of `rolling`."""
    moments = ds[[*KEPT, "pull_off_force", "pull_off_delta", "converged"]].rename(KEPT)
    solution = ds.drop_vars([*KEPT, "direction"])
    return solution, schema.record(_labelled_moments(moments, "adhesive", 0.0), "rolling")


def _warn_of_a_thin_layer(ds: xr.Dataset, radius: float) -> None:
    """Warn where contacts (radius, nm) are too wide for the layer to count as a half space."""
    if radius > largest_contact(ds):
        warn(
            f"taken as a thick one, found {float(ds['layer_thickness']):.3g} nm below contacts of {radius:.2g} nm; the "
            "moments neglect its base; take adhesive with fields=True, or a run, for both",
            DoubtfulAsperities,
            what="layer",
        )


def _warn_of_lost_supports(contacts: float, supports: float) -> None:
    """Warn where spheres touch much fewer asperities than summits that supported them at rest."""
    if contacts < 0.6 * supports:  # two of three supports suffice
        warn(
            f"{format_number(contacts)} asperities in contact on average, where {format_number(supports)} summits of "
            "the scan support a sphere at rest; take resting(on=ds.contact.asperities()), else moments are too small",
            DoubtfulAsperities,
            what="subregions",
        )


def _labelled_moments(out: xr.Dataset, method: str, normal_force: float) -> xr.Dataset:
    """Return the result with labels."""
    out.attrs |= {"method": method, "normal_force": normal_force, "missing": MISSING[method]}
    if not out.chunks:
        warn_unconverged(out, "their moments are NaN")
    return schema.label(out)


def _asperity_moments(summands: Summands, angles, load, subregions) -> xr.Dataset:
    """Roll the sphere off the asperities at each contact centre."""
    positions = regions.centres_of(summands.ds, subregions)
    centres = [tuple(point) for point in regions.points(positions).tolist()]
    layout = Layout({"direction": angles}, _STATES, _EVENTS | _ASPERITY_STATES)
    solve = partial(spread.task_results, name="rolling", lazy=summands.lazy)
    records = solve(_roll, centres, layout.dtype, summands.prepared, summands.options, layout, load)
    out = labelled(records, layout, summands.ds, positions)
    return spread.finish(out.assign_attrs(datum="highest_peak"))


def _roll(x: float, y: float, prepared: Asperities, options: SumOptions, layout: Layout, load: float) -> np.ndarray:
    """Roll the sphere off one place; a task."""
    field = prepared.field
    record = layout.blank()
    if prepared.grid is not None:
        pull = exact_pull_offs(np.array([x]), np.array([y]), prepared.grid, options)[0]
        record["pull_off_force"] = pull["pull_off_force"]
        record["pull_off_delta"] = pull["pull_off_delta"]
    offset = sums.offsets(field, x, y, options.radius)
    spline = options.kernel_law().spline
    near, rest = _displacement_at_rest(field, offset, float(record["pull_off_delta"]), load, spline)
    record["converged"] = not np.isinf(rest)
    if not np.isfinite(rest):
        return record
    supporting = near[offset[near] + field.scales.end[near] * field.scales.delta[near] <= rest]
    scales = subset(field.scales, supporting)
    u = field.x[supporting] - x
    v = field.y[supporting] - y
    delta = rest - offset[supporting]
    moments = rotation.resisting_moments(
        layout.axes["direction"], u, v, field.orientation[supporting], delta, scales, load, spline
    )
    record["rest_delta"] = rest
    record["contacts"] = supporting.size
    record["truncated"] = field.at_edge[supporting].any()
    record["contact_area"] = rotation.total_force(rest, offset[supporting], scales, spline)[1]
    return _put(record, layout, moments.T)


def _displacement_at_rest(
    field: sums.Field, offset: np.ndarray, pull_off: float, load: float, spline: np.ndarray
) -> tuple:
    """Return the nearby asperities and the displacement (nm) at which the sphere rests under a load; NaN if none."""
    onset = offset + field.scales.end * field.scales.delta
    if offset.size == 0:
        return np.arange(0), np.nan
    start = pull_off if np.isfinite(pull_off) else float(onset.min())
    reach = 4 * max(float(np.median(field.scales.delta)), 0.1)
    for _ in range(60):
        near = np.flatnonzero(onset <= start + reach)
        rest = rotation.resting_displacement(offset[near], subset(field.scales, near), load, start, spline)
        if rest <= start + reach or near.size == offset.size:
            return near, rest
        reach *= 2
    return near, np.inf  # it rests on some that are left out


def _put(record: np.ndarray, layout: Layout, moments: np.ndarray) -> np.ndarray:
    """Write results (4, direction), and the variables that follow from them, into a record."""
    moment = moments[rotation.MOMENT]
    angles = layout.axes["direction"]
    if np.isnan(moment).any():
        return record
    for name, values in zip(_MOMENTS, moments):
        record[name] = values
    record["lever"] = moment / record["pull_off_force"]
    for name, sign in (("weakest", 1.0), ("stiffest", -1.0)):
        first, several = weakest(sign * moment)
        record[f"{name}_direction"] = angles[first]
        record[f"{name}_ties"] = several
    return record


def weakest(moment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the index (last axis) of the first least moment, and whether others equal it."""
    equal = moment <= moment.min(axis=-1, keepdims=True) + _EQUAL_MOMENTS * np.abs(moment).max(axis=-1, keepdims=True)
    return equal.argmax(axis=-1), equal.sum(axis=-1) > 1


class Footprint(NamedTuple):
    """One state's contact and pressures, as far as moments depend on them."""

    touching: np.ndarray  # (x, y)
    push: float  # nN, the sum over all cells
    push_x: float  # nN nm, the sum of push times x
    push_y: float  # nN nm
    edges: np.ndarray  # (direction,) nm, distance of the foremost edge; -inf without contact

    def moved(self, x: float, y: float, angles: np.ndarray) -> Footprint:
        """Return the footprint with x and y (nm) added to the places of all cells."""
        return Footprint(
            self.touching,
            self.push,
            self.push_x + x * self.push,
            self.push_y + y * self.push,
            self.edges + x * np.cos(angles) + y * np.sin(angles),
        )


class States(NamedTuple):
    """The states of one place's retraction."""

    footprints: Sequence[Footprint]
    force: np.ndarray  # nN
    area: np.ndarray  # nm²
    refine: int  # cells along a side of a pixel


def footprint(push: np.ndarray, touching: np.ndarray, x: np.ndarray, y: np.ndarray, side, angles) -> Footprint:
    """Return the footprint of pushes (nN) on cells of a side (nm) at x and y (nm), in some directions (rad).

    The front of a patch of n cells lies beyond its foremost cell's centre by the radius of a disc of the cell's area,
    over n^(1/6): a disc in any position on the cells then has its radius on average, within 1 %.
    """
    from scipy.ndimage import label

    edges = np.full(np.shape(angles), -np.inf)
    rows, columns = np.nonzero(touching)
    if rows.size:
        patch = label(touching, np.ones((3, 3)))[0][rows, columns]
        beyond = side / np.sqrt(np.pi) * np.bincount(patch)[patch] ** (-1 / 6)
        edges = (np.outer(np.cos(angles), x[rows]) + np.outer(np.sin(angles), y[columns]) + beyond).max(axis=1)
    along_x = push.sum(axis=1)
    return Footprint(touching, along_x.sum(), along_x @ x, push.sum(axis=0) @ y, edges)


def states_layout(angles: np.ndarray) -> Layout:
    """Return the layout of moments in these directions (rad) from the states of a simulation."""
    return Layout({"direction": angles}, _STATES, _EVENTS | _SIMULATED_STATES)


def touching_cells(gap: np.ndarray, pressure: np.ndarray, side: float, opening: float = 0.0) -> np.ndarray:
    """Return the cells (of a side in nm) of the simulation with adhesion that are in contact.

    ``opening`` (nm) is the gap at the edge of contacts by a law without range, see `edge_opening`.
    """
    return (gap <= max(_CLOSED_GAP * side, opening)) | (pressure > 0)


def edge_opening(law: str, work: float, modulus: float, side: float) -> float:
    """Return the gap (nm) at which half of the work is done in the cohesive zone of a law without range, else 0."""
    return float(np.sqrt(work * side / modulus)) if not ADHESION_LAWS[law].has_range else 0.0


def lever_change(record: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest change of the lever in any direction, over the mean of all directions; NaN without a lever."""
    lever = reference["lever"]
    return float(np.abs(record["lever"] - lever).max() / np.abs(lever).mean())


def _solution_moments(ds: xr.Dataset, angles: np.ndarray, load: float) -> xr.Dataset:
    """Return the largest moments over the retraction of a solution."""
    stiff = ds.attrs.get("method") == "rigid"
    if "pressure" not in ds or not ("branch" in ds["pressure"].dims or stiff) or "pull_off_force" not in ds:
        raise Refusal(
            "",
            "a scan, a catalogue, or a solution of adhesive or rigid with pressures on retraction",
            "none",
            "solve with fields=True; with adhesion also with displacements (delta)",
        )
    layout = states_layout(angles)
    out = ds if stiff else ds.sel(branch="retraction", drop=True)
    records = np.stack([_place_moments(out.isel(subregion=k), layout, load) for k in range(ds.sizes["subregion"])])
    centres = xr.Dataset(coords={name: ds[name] for name in ("subregion", "subregion_x", "subregion_y")})
    return labelled(records, layout, ds, centres)


def _place_moments(ds: xr.Dataset, layout: Layout, load: float) -> np.ndarray:
    """Return the record of one place of a solution."""
    fields = ds.transpose("delta", "x", "y", ...)
    pressure = fields["pressure"].values
    touching = _touching_in_solution(ds, fields["gap"].values, pressure)
    x, y = (ds[axis].values + float(ds.get(f"subpixel_{axis}", 0.0)) for axis in "xy")
    cell = float(x[1] - x[0]) * float(y[1] - y[0])
    area = ds["contact_area"].values if "contact_area" in ds else touching.sum(axis=(1, 2)) * cell
    refine = int(ds["mesh"].max() if "mesh" in ds else ds.attrs.get("mesh", 1))
    known = {name: ds[name] for name in ("pull_off_force", "pull_off_delta")}
    force = ds["force"].values
    if not ADHESION_LAWS[ds.attrs["law"]].has_range:  # the states' cohesive zone holds more than the pull-off
        pressure = pressure * min(float(known["pull_off_force"]) / max(-force.min(), 1e-300), 1.0)
    side = np.sqrt(cell)
    push = np.nan_to_num(pressure) * cell
    angles = layout.axes["direction"]
    footprints = [footprint(*fields, x, y, side, angles) for fields in zip(push, touching)]
    states = States(footprints, force, area, refine)
    return moments_of_states(states, layout, load, converged=bool(np.all(converged(ds))), **known)


def _touching_in_solution(ds: xr.Dataset, gap: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Return the cells in contact of the states of a solution."""
    if ds.attrs.get("method") == "rigid":
        length = next(ds.attrs[name] for name in ("closest_approach", "adhesion_range") if name in ds.attrs)
        return gap <= _RIGID_GAP * length
    side = float(ds["x"][1] - ds["x"][0])
    pair = read_pair(ds, "contact_modulus", "work_of_adhesion")
    opening = edge_opening(ds.attrs["law"], pair.solid_work, pair.contact_modulus, side)
    return touching_cells(gap, pressure, side, opening)


def moments_of_states(states: States, layout: Layout, load: float, **known: Any) -> np.ndarray:
    """Return the record of one place; ``known`` contains its pull-off and whether its states converged."""
    from scipy.ndimage import binary_dilation, label

    record = layout.blank()
    angles = layout.axes["direction"]
    for name, value in known.items():
        record[name] = value
    record["mesh"] = states.refine
    largest = np.array([[-np.inf], [np.nan], [-np.inf], [np.nan]]) * np.ones(angles.size)
    for state in states.footprints:
        if state.touching.any():
            _include_state(state, angles, load, largest)
    largest[rotation.TIPPING_FORCE, largest[rotation.TIPPING_FORCE] == -np.inf] = np.inf
    rest = _state_at_rest(states.area, states.force, load)
    record["contact_area"] = np.nan if rest is None else states.area[rest]
    if rest is not None:  # patches less than two pixels apart count as one contact
        square = np.ones((3, 3))
        near = binary_dilation(states.footprints[rest].touching, square, iterations=max(states.refine, 1))
        record["contacts"] = label(near, square)[1]
    complete = record["converged"] and np.isfinite(largest[rotation.MOMENT]).all()
    return _put(record, layout, largest if complete else np.full_like(largest, np.nan))


def _state_at_rest(area: np.ndarray, force: np.ndarray, load: float) -> int | None:
    """Return the state at which the force first falls to the load on retraction; None without contact.

    Later states are not used: their force may be near the load again, but few contacts remain.
    """
    touching = np.flatnonzero(area > 0)[::-1]
    if not touching.size:
        return None
    unbalance = force[touching] - load
    rest = int((unbalance <= 0).argmax()) if (unbalance <= 0).any() else touching.size - 1
    nearest = touching[max(rest - 1, 0) : rest + 1]
    return int(nearest[np.abs(force[nearest] - load).argmin()])


def _include_state(state: Footprint, angles: np.ndarray, load: float, largest: np.ndarray) -> None:
    """Update results (4, direction) with a state's moment about the front of its contact, if that is larger."""
    edge = state.edges
    moment = (load - state.push) * edge + np.cos(angles) * state.push_x + np.sin(angles) * state.push_y
    more = moment > largest[rotation.MOMENT]
    largest[: rotation.TIPPING_FORCE, more] = moment[more], edge[more]
    with np.errstate(divide="ignore", invalid="ignore"):
        pull = np.where(edge > 0, moment / edge, -np.inf)
    more = pull > largest[rotation.TIPPING_FORCE]
    largest[rotation.TIPPING_FORCE :, more] = pull[more], edge[more]
