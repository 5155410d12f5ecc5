"""Several scans of one surface as one analysis: the results of one function side by side along ``scan``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import xarray as xr

from ..vocabulary import schema
from ..vocabulary.verbs import verb
from .parameter_grid import refuse_other_deltas, verb_name


@verb
def over_scans(
    scans: Sequence[xr.Dataset] | Mapping[str, xr.Dataset], solve: Callable[..., xr.Dataset], **options: Any
) -> xr.Dataset:
    """Return the results of a function for several scans, concatenated along ``scan``.

    Parameters
    ----------
    scans : sequence or mapping of Dataset
        Scans of one surface, of any sizes, with the pair that the function needs. The coordinate ``scan`` holds a
        mapping's names; or the names of the files that the scans were opened from, if they differ; or numbers.
    solve : callable
        A function of a scan, such as `roughness`, `asperities`, `pull_off_map`, `adhesive`.
    **options
        Passed to ``solve``.

    Returns
    -------
    Dataset
        The results along ``scan``, for `pooled`; NaN beyond the places of a scan that has fewer. Lazy where the
        scans are.

    Raises
    ------
    ValueError
        If there is no scan, or displacements differ because they were not given.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans.synthetic import self_affine
    >>> make = {"rms": 1.0, "hurst": 0.8, "rolloff": 200}
    >>> scans = [self_affine((64, 64), 10, seed=seed, **make) for seed in (1, 2, 3)]
    >>> found = over_scans(scans, roughxr.roughness, spectra=False)
    >>> found.s_q.dims, found.scan.values.tolist()
    (('scan',), [0, 1, 2])
    """
    if len(scans) == 0:
        raise ValueError("scans: expected at least one, found none")
    names, each = _named(scans)
    parts = [solve(one, **options) for one in each]
    refuse_other_deltas(parts, "scan")
    parts = _padded(parts)
    how: dict[str, Any] = {"coords": "different", "compat": "equals", "join": "outer"}
    how |= {"data_vars": "all", "combine_attrs": "drop_conflicts"}
    along = xr.Variable("scan", names)
    out = xr.concat(parts, xr.DataArray(along, coords={"scan": along}, name="scan"), **how)
    return schema.record(schema.label(out), "over_scans", parts[0], solve=verb_name(solve), scans=len(each))


def _padded(parts: list[xr.Dataset]) -> list[xr.Dataset]:
    """Return parts of different sizes with flags as numbers, so that shorter ones can be padded with NaN."""
    if all(dict(part.sizes) == dict(parts[0].sizes) for part in parts):
        return parts
    return [part.assign({k: v.astype(float) for k, v in part.data_vars.items() if v.dtype == bool}) for part in parts]


def _named(scans: Any) -> tuple[list[Any], list[xr.Dataset]]:
    """Return names and scans; raise where they are not opened yet."""
    for one in scans.values() if isinstance(scans, Mapping) else scans:
        if not isinstance(one, xr.Dataset):
            raise ValueError(f"scans: expected Datasets, found {one!r}; use open_scan and assign_pair for each")
    if isinstance(scans, Mapping):
        return list(map(str, scans)), list(scans.values())
    files = [str(one.attrs.get("source_file", "")) for one in scans]
    distinct = all(files) and len(set(files)) == len(files)
    return (files if distinct else list(range(len(files)))), list(scans)
