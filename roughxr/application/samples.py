"""Scans shipped with the library."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from ..files.storage import open_locked
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.refusal import Refusal
from ..mechanics.vocabulary.text import did_you_mean

#: Folder of the samples in an installed package, and in a checkout.
_FOLDERS = (Path(__file__).parents[1] / "datasets", Path(__file__).parents[2] / "datasets")


def open_sample(name: str = "glass") -> xr.Dataset:
    """Return a scan shipped with the library, in memory.

    Parameters
    ----------
    name : {"glass", "rough"}
        "glass" is a synthetic twin of the unpublished glass scan of Cheng, Dunn & Brach: made from a seed by
        `synthetic` and fitted to their figures. It is not a measurement. "rough" is measured: a quarter of a scan of a
        randomly rough surface, 5 µm wide; its attributes state its source and licence.

    Returns
    -------
    Dataset
        ``height`` (x, y), nm.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> dict(scan.sizes), scan.attrs["synthetic"]
    ({'x': 512, 'y': 512}, 'yes')
    """
    samples = {path.stem: path for folder in _FOLDERS for path in folder.glob("*.nc")}
    if name not in samples:
        raise Refusal(
            "name",
            f"one of {', '.join(sorted(samples)) or '(none installed)'}",
            f"{name!r}{did_you_mean(name, samples)}",
        )
    with open_locked(samples[name]) as ds:
        return schema.validate(ds.load().drop_encoding(), "scan")
