"""Superposition against the direct simulation: the displacements at which their forces agree."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..jobs.records import converged, loading
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal

#: Largest difference, relative to the direct force, that counts as agreement.
_AGREEMENT = 0.1


@schema.verb("solution")
def force_ratio(superposed: xr.Dataset, direct: xr.Dataset) -> xr.Dataset:
    """Compare the force of superposed asperities with that of `direct` at each place and displacement.

    Parameters
    ----------
    superposed, direct : Dataset
        Two solutions at the same subregions and from the same datum, both without adhesion; the first is interpolated
        at the displacements of the second.

    Returns
    -------
    Dataset
        ``force_superposed``, ``force_direct`` (nN) and ``force_difference`` (relative to the direct force; NaN where
        that is 0) along (subregion, delta); ``agreeing``, the share of the places in contact that agree, and
        ``overlap_fraction``, the share of contacts that overlap a neighbour's, along delta; ``divergence_delta`` (nm)
        along subregion, beyond which they differ by more than 10 %, NaN if they agree to the end or never touch;
        ``mean_difference`` of the mean forces along delta, and ``mean_divergence_delta``.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> delta = [1.0, 2.0, 3.0]
    >>> solutions = [
    ...     xr.Dataset({"force": (("subregion", "delta"), [force])}, coords={"delta": delta})
    ...     for force in ([1.0, 2.1, 6.0], [1.0, 2.0, 3.0])
    ... ]
    >>> compared = roughxr.statistics.force_ratio(*solutions)
    >>> float(compared.divergence_delta[0]), compared.force_difference.values.round(3).tolist()
    (3.0, [[0.0, 0.05, 1.0]])
    """
    superposed = loading(superposed)
    direct = loading(schema.validate(direct, "solution"))
    _check_comparable(superposed, direct)
    superposed = superposed.drop_vars(set(superposed.coords) - set(superposed.dims))  # as direct's, but for rounding
    at = superposed.interp(delta=direct["delta"])
    truth = direct["force"].where(converged(direct))
    difference = (at["force"] / truth.where(truth > 0) - 1).transpose("subregion", "delta")
    mean = at["force"].mean("subregion") / truth.mean("subregion").where(lambda force: force > 0) - 1
    touching = difference.notnull()
    out = xr.Dataset(
        {
            "force_superposed": at["force"],
            "force_direct": truth,
            "force_difference": difference,
            "mean_difference": mean,
            "agreeing": (abs(difference) <= _AGREEMENT).sum("subregion")
            / touching.sum("subregion").where(lambda n: n > 0),
            "divergence_delta": ("subregion", [_divergence(row, direct["delta"].values) for row in difference.values]),
            "mean_divergence_delta": _divergence(mean.values, direct["delta"].values),
        }
    )
    if "contacts_overlapping" in at:
        contacts = at["contacts"].sum("subregion")
        out["overlap_fraction"] = at["contacts_overlapping"].sum("subregion") / contacts.where(contacts > 0)
    names = ("delta", "subregion", "subregion_x", "subregion_y", *schema.PAIR)
    out = out.drop_vars([name for name in out.coords if name not in names])
    missing = "NaN out of contact or not converged; divergence_delta: NaN where they agree to the end"
    out.attrs = {"agree_within": _AGREEMENT, "missing": missing}
    return schema.label(out)


def _check_comparable(superposed: xr.Dataset, direct: xr.Dataset):
    """Raise if two solutions cannot be compared, with the reason."""
    sizes = [ds.sizes["subregion"] for ds in (superposed, direct)]
    places = [name for name in ("subregion_x", "subregion_y") if name in superposed.coords and name in direct.coords]
    if sizes[0] != sizes[1] or not all(np.allclose(superposed[name], direct[name]) for name in places):
        raise Refusal("", "the same contact centres in both", f"{sizes[0]} and {sizes[1]} that differ")
    datums = [ds.attrs.get("datum", "highest_peak") for ds in (superposed, direct)]
    if datums[0] != datums[1]:
        raise Refusal("datum", "the same for both", f"{datums[0]!r} and {datums[1]!r}", "solve again")
    ends = [(float(ds["delta"].min()), float(ds["delta"].max())) for ds in (superposed, direct)]
    if ends[0][0] > ends[1][1] or ends[0][1] < ends[1][0]:
        raise Refusal("delta", "ranges that overlap", f"{ends[0]} and {ends[1]} nm")


def _divergence(difference: np.ndarray, delta: np.ndarray) -> float:
    """Return the displacement from which two forces differ to the end of the sweep, NaN if they agree at the end."""
    touching = np.flatnonzero(np.isfinite(difference))
    differs = np.abs(difference[touching]) > _AGREEMENT
    if not differs.any() or not differs[-1]:
        return np.nan
    agree = np.flatnonzero(~differs)
    return float(delta[touching[agree[-1] + 1 if agree.size else 0]])
