"""Pull-offs of several files as one Dataset: their places in sequence, with the file that each comes from."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr


def together(paths: Sequence[Any], datasets: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the pull-offs of several files along one ``subregion``."""
    if len(datasets) == 1:
        return datasets[0]
    kinds = sorted({ds.attrs["measured"] for ds in datasets})
    if len(kinds) != 1:
        raise ValueError(f"path: expected files of one kind, found {', '.join(kinds) or 'no file'}")
    common = set.intersection(*(set(map(str, ds.variables)) for ds in datasets))
    named = [
        ds[sorted(common)].assign_coords(file=("subregion", [Path(path).name] * ds.sizes["subregion"]))
        for path, ds in zip(paths, datasets)
    ]
    parts = [ds.drop_vars("subregion", errors="ignore") for ds in named]
    how = {"data_vars": "minimal", "coords": "minimal", "compat": "override", "combine_attrs": "drop_conflicts"}
    out = xr.concat(parts, "subregion", join="outer", **how)
    out = out.assign_coords(subregion=range(out.sizes["subregion"]))
    hashes = "".join(ds.attrs["source_sha256"] for ds in datasets)
    out.attrs["source_file"] = f"{Path(paths[0]).name} and {len(paths) - 1} more"
    out.attrs["source_sha256"] = hashlib.sha256(hashes.encode()).hexdigest()
    return out
