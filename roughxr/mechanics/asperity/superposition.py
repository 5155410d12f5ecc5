"""Superposition: the contact of a sphere with a scan's asperities, each independent of the others."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr

from ..bodies.layer import largest_contact, need_small_contacts
from ..jobs import spread
from ..jobs.records import Layout, labelled
from ..kernels.asperity import contact_sums as sums
from ..scans import regions
from ..specimen import ask_about_depth
from ..vocabulary import schema
from ..vocabulary.numbers import format_number
from ..vocabulary.text import Argument, IncompleteResult, Phrase, warn
from ..vocabulary.units import Places, Quantities
from .asperity_sum import DEFAULT, Asperities, Summands, SumOptions, exact_pull_offs, law_attributes, read_summands
from .catalogue import DoubtfulAsperities
from .expectation import expectation, warn_above_smooth

_STATES = {
    "force": float,
    "contact_area": float,
    "contacts": int,
    "contacts_beyond_patch": int,
    "contacts_overlapping": int,
    "truncated": bool,
}
_EVENTS: dict[str, type] = {"excluded_asperities": int}

#: Variables of laws with adhesion, independent of the displacements.
_PULL_OFF: dict[str, type] = {"pull_off_force": float, "pull_off_delta": float}

#: Displacements around each pull-off, from the end of a branch to zero force, over the median distance from the end of
#: an asperity's branch to its first touch.
_AROUND_PULL_OFF = np.array([-0.53, -0.5, -0.35, -0.2, 0.0, 0.2, 0.4, 0.7, 1.0, 1.4, 1.8, 2.5])

#: Largest number of states of a default sweep with displacements around each pull-off.
_MOST_STATES = 1_000_000


@schema.recorded
def superpose(
    ds: xr.Dataset,
    *,
    delta: Quantities | None = None,
    subregions: Places = None,
    law: str | None = None,
    formulation: str = DEFAULT,
) -> xr.Dataset:
    """Sum the contacts of all asperities with a sphere at each contact centre, on retraction.

    Each asperity follows its stable branch down to the branch's end, δ_i = −3^{−1/3} δ_c without range: that is where
    it detaches. On approach, bodies without range jump into contact at δ_i = 0, so the force between is that of
    retraction only. (Cheng, Dunn & Brach call −3^{−1/3} the jump *on*.)

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned pair (its asperities are detected with the default patch; for formulation="published"
        with the paper's, 5 × 5 pixels and vertices at pixels), or an asperity catalogue with an assigned pair.
    delta : array_like, optional
        Displacements, nm, ascending; by default 301, from before the first touch of any place until the last place is
        indented by four times the median displacement at which asperities detach, and for up to 250 places twelve
        around the pull-off of each place, so that each force curve attains its pull-off; without adhesion 301, until
        the last place is indented by the depth of the median place below the highest peak.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, by default those on ``ds``, else one in its middle.
    law : {"jkr", "dugdale", "hertz"}, optional
        Adhesion of zero range, of finite range (Maugis's law between JKR and DMT, for 0.02 < λ = 1.157 μ < 50, see
        `tabor`), or none; by default "jkr". For a humid pair "dugdale" with the range and work of liquid and solids.
    formulation : {"energy", "self_similar", "published"}
        For law="jkr", the adhesion of an ellipse. "energy": the energy is stationary in both axes; "self_similar":
        Hertz's shape (the paper's derivation, corrected); "published": the paper to the letter, with λ² for λ and
        without the sphere's curvature, which the others add to the asperity's. law="hertz" with "published" is the
        paper's sum without adhesion.

    Returns
    -------
    Dataset
        ``force`` (nN, negative for attraction) and ``contact_area`` (nm²) along (subregion, delta); the number of
        ``contacts``, of those larger than the patch of their paraboloid, and of those that overlap one of their eight
        nearest neighbours, which superposition does not describe; ``truncated``, if an asperity at the scan's edge is
        in contact; ``excluded_asperities``, the number of saddles. With adhesion also the exact ``pull_off_force`` and
        ``pull_off_delta`` of `pull_off_map`, and as attributes the ``expected_ratio`` to the pull-off of `adhesive`,
        with ``expected_low`` and ``expected_high``, or by what it is unknown. Lazy if the scan is a dask array.

    Raises
    ------
    ValueError
        If JKR's contact of the median asperity at pull-off is wider than a tenth of an assigned layer: the sum takes
        the surface as a half space. States with wider contacts are NaN.

    Warns
    -----
    UserWarning
        If a pull-off exceeds that of the same sphere on a smooth flat, with the probable cause (input in memory only);
        if a hardness is assigned: asperities stay elastic.

    Notes
    -----
    "dugdale" neglects the attraction across a gap, before an asperity touches and after it detaches: on a surface of
    1.5 nm rms less than 1 % of the pull-off for λ > 0.5, some 5 % at λ = 0.2, and half of it at λ = 0.02.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 15–24 and 35, printed with λ² for λ and with the sign of eq. 35 reversed. Maugis, J.
    Colloid Interface Sci. 150, 243 (1992), doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> sweep = scan.contact.superpose(delta=np.arange(-5, 15, 0.5), subregions=(2, 2))
    >>> bool((sweep.pull_off_force > 0).all())
    True
    """
    summands = read_summands(ds, law, formulation, coated=True)
    ds = summands.ds
    law = summands.law
    options = summands.options
    adheres = options.adheres
    lazy = summands.lazy
    positions = regions.centres_of(ds, subregions)
    if "hardness" in ds.coords:
        warn(
            "superposed asperities stay elastic, found an assigned hardness; take `direct` or `adhesive`, which let "
            "the bodies yield, or drop the hardness",
            DoubtfulAsperities,
            what="hardness",
        )
    if schema.is_coated(ds) and adheres:
        need_small_contacts(ds, summands.median_contact)
    centres = [tuple(point) for point in regions.points(positions).tolist()]
    if delta is None:
        deltas = _default_sweep(summands, centres)
    else:
        deltas = schema.ascending(delta, "nm", "delta")
        if not lazy:
            ask_about_depth(float(deltas[-1]), options.radius, ds["height"].values)
    events = _EVENTS | (_PULL_OFF if adheres else {})
    layout = Layout({"delta": deltas}, _STATES, events)
    solve = partial(spread.task_results, name="superpose", lazy=lazy)
    records = solve(_superpose, centres, layout.dtype, summands.prepared, options, layout)
    out = labelled(records, layout, ds, positions)
    out["excluded_asperities"] = out["excluded_asperities"].variable[0]
    out.attrs = {"datum": "highest_peak", "method": "superpose", **law_attributes(law, formulation, options)}
    if adheres:
        out.attrs |= expectation(summands.catalogue, options.law)
    out = spread.finish(out)
    if schema.is_coated(ds):
        out = _without_wide_contacts(out, largest_contact(ds))
    if adheres and not lazy:
        warn_above_smooth(out["pull_off_force"].values, summands.catalogue, law)
    if delta is not None and not lazy and not adheres:  # else the pull-off is a result, whatever the displacements
        _warn_if_untouched(out)
    return out


def _warn_if_untouched(out: xr.Dataset) -> None:
    """Warn if no place has a contact at any displacement: zero forces are easily misread."""
    if not bool((out["contacts"] > 0).any()):
        warn(
            Phrase(
                f"nothing touches down to {format_number(out['delta'][-1], 'nm')} below the highest point of the "
                "scan: all forces are 0; leave ",
                Argument("delta", ...),
                " out, so that every place is touched",
            ),
            IncompleteResult,
            what="delta",
        )


def _without_wide_contacts(ds: xr.Dataset, limit: float) -> xr.Dataset:
    """Return a sum without the states whose contacts have a larger mean radius (nm)."""
    is_small = ds["contact_area"] <= np.pi * limit**2 * ds["contacts"]
    if bool(is_small.all()):
        return ds
    states = ds[["force", "contact_area"]].where(is_small)
    reason = f"NaN where contacts are wider than {limit:.3g} nm, a tenth of the layer"
    return ds.assign(states).assign_attrs(missing=reason)


def _default_sweep(summands: Summands, centres: list[tuple[float, float]]) -> np.ndarray:
    """Return displacements from before the first adhesion of any place to well beyond the first touch of the last."""
    field = summands.prepared.field
    options = summands.options
    # number of displacements of a default sweep
    steps = 301
    offsets = np.array([sums.offsets(field, x, y, options.radius) for x, y in centres])
    touches = offsets.min(axis=1, initial=np.inf)
    touches = touches[np.isfinite(touches)]  # of places where an asperity is below the sphere
    if touches.size == 0:
        return np.linspace(-1, 1, steps)
    reaches = np.abs(field.scales.end * field.scales.delta)
    first = (offsets - 1.2 * reaches).min()
    last = touches.max() + (4 * np.median(reaches) or np.median(touches))
    coarse = np.round(np.linspace(first, last, steps), 4)
    grid = summands.prepared.grid
    is_long = len(centres) * (steps + len(centres) * _AROUND_PULL_OFF.size) > _MOST_STATES
    if grid is None or is_long:
        return coarse
    x, y = np.array(centres).T.copy()
    pull_offs = exact_pull_offs(x, y, grid, summands.options)["pull_off_delta"]
    near_pull_offs = pull_offs[:, None] + np.median(reaches) * _AROUND_PULL_OFF
    return np.union1d(coarse, near_pull_offs[np.isfinite(near_pull_offs)])


def _superpose(x: float, y: float, prepared: Asperities, options: SumOptions, layout: Layout) -> np.ndarray:
    """Sum the asperities of one subregion at all displacements; a task."""
    field, patch_radius, excluded, grid = prepared
    offset = sums.offsets(field, x, y, options.radius)
    summed = sums.superpose(layout.axes["delta"], field, offset, patch_radius, options.kernel_law().spline)
    record = layout.blank()
    for name, values in zip(_STATES, summed):
        record[name] = values
    record["excluded_asperities"] = excluded
    if grid is not None:
        pull = exact_pull_offs(np.array([x]), np.array([y]), grid, options)[0]
        for name in _PULL_OFF:
            record[name] = pull[name]
    return record
