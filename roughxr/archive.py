"""A run as one NetCDF-4 file with sibling groups; each state of the file appears complete or not at all.

Groups are plain Datasets (scan, asperities, solutions, statistics), each with attributes that say how it was
made; `xarray.open_datatree` reads them back as they were. The archive of an unfinished run holds the groups
computed so far; the attribute `UNFINISHED` of its root says what is missing.
"""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import dask.array as da
import numpy as np
import xarray as xr

from ._version import __version__
from .files import checksums, netcdf_reader, reader_process
from .files.disk import (
    as_characters,
    each_group,
    names_in,
    opened,
    raw,
    uninterrupted,
    unless_interrupted,
    whole,
)
from .vocabulary.verbs import verb, warn

__all__ = ["load", "save", "verify"]

#: Zlib's level 1: half the size of fields in a tenth of the time of level 9.
_COMPRESSED = {"zlib": True, "complevel": 1}

#: Attribute of the root of an unfinished run: what is missing.
UNFINISHED = "unfinished"

#: Fields are read in chunks of this many bytes, or of one subregion if that is larger.
_CHUNK = 2**23


@verb
def save(
    groups: Mapping[str, xr.Dataset],
    path: str | os.PathLike,
    *,
    title: str = "",
    attrs: Mapping[str, Any] | None = None,
) -> Path:
    """Write Datasets as groups of one NetCDF-4 file.

    Parameters
    ----------
    groups : mapping of str to Dataset
        Group names, such as "scan" or "solutions/direct", and their Datasets. Lazy variables are computed and written
        chunk by chunk, never held whole.
    path : path
        The file. It appears under this name only once it is complete.
    title : str, optional
        Stored as an attribute of the root.
    attrs : mapping, optional
        Further attributes of the root.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If a group holds something that NetCDF cannot store.
    OSError
        If it cannot be written, for example because the disk is full.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> path = save({"scan": xr.Dataset({"height": ("x", [1.0, 2.0])})}, Path(folder) / "run.nc")
    >>> xr.open_datatree(path)["scan/height"].values.tolist()
    [1.0, 2.0]
    """
    root = {"Conventions": "CF-1.11", "title": title, "source": f"roughxr {__version__}", **(attrs or {})}
    return add(groups, Path(path), root, onto=False)


def add(groups: Mapping[str, xr.Dataset], path: Path, attrs: Mapping[str, Any], *, onto: bool = True) -> Path:
    """Add groups to an archive, or make one of them, and set attributes of its root; None removes one.

    The file is copied first: whatever ends the process, it is as before or as it is to be.
    """
    there = {name: value for name, value in attrs.items() if value is not None}
    stored = {name: _storable(ds, name) for name, ds in groups.items()}
    later = {name: [key for key in ds.data_vars if ds[key].chunks] for name, ds in stored.items()}
    now = {name: ds.drop_vars(later[name]).compute() for name, ds in stored.items()}
    tree = xr.DataTree.from_dict({"/": xr.Dataset(attrs=there), **now})
    encoding = {node.path: _compressed(node.dataset) for node in tree.subtree}
    with whole(path) as temporary:
        if onto:
            shutil.copyfile(path, temporary)
        with uninterrupted():
            tree.to_netcdf(temporary, mode="a" if onto else "w", encoding=encoding, engine="netcdf4")
        for name, key in ((name, key) for name, keys in later.items() for key in keys):
            # one by one: chunks from which several variables are cut would all stay in memory until the last of them
            one = stored[name][[key]]
            one[key].data = da.map_blocks(unless_interrupted, one[key].data, meta=one[key].data._meta)
            with uninterrupted():
                one.to_netcdf(temporary, mode="a", group=name, encoding=_compressed(one), engine="netcdf4")
        with raw(temporary, "a") as file:
            for name in set(attrs) - set(there) & set(file.ncattrs()):
                file.delncattr(name)
            file.comment = f"in groups, open with xarray.open_datatree: {', '.join(sorted(names_in(file)))}"
            checksums.write(file)
    return path


def _compressed(ds: xr.Dataset) -> dict[str, dict]:
    """Return the encoding of each variable: fields in one chunk for each subregion and displacement.

    The library's default chunks span many subregions: each subregion written would unpack and pack them again.
    """
    encoding = as_characters(ds)
    for name, variable in ds.data_vars.items():
        if variable.ndim:
            encoding[str(name)] = encoding.get(str(name), {}) | _COMPRESSED
        if variable.dims[:1] == ("subregion",) and {"x", "y"} <= set(variable.dims) and variable.size:
            sizes = (n if dim in ("x", "y") else 1 for dim, n in variable.sizes.items())
            encoding[str(name)]["chunksizes"] = tuple(sizes)
    return encoding


def load(path: str | os.PathLike) -> dict[str, xr.Dataset]:
    """Return the groups of an archive by name.

    Parameters
    ----------
    path : path
        A file that `save` wrote.

    Returns
    -------
    dict of str to Dataset
        In memory, except for fields along ``subregion``, which are lazy: each is read, and verified, when it is used.

    Raises
    ------
    ValueError
        If it is damaged, by its checksums; archives of earlier versions have none.
    OSError
        If it does not exist or cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> ds = xr.Dataset({"force": ("subregion", [1.0, 2.0])})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     groups = load(save({"solutions/direct": ds}, Path(folder) / "run.nc"))
    >>> float(groups["solutions/direct"].force.sum())
    3.0
    """
    path = Path(path)
    kept = verify(path)
    if missing := root_of(path).get(UNFINISHED):
        warn(f"{path}: the run is not finished, {missing}; the same command continues it")
    with _in_words(path):
        return {name: _without_fields(path, name, ds, kept.get(f"/{name}", {})) for name, ds in each_group(path)}


def root_of(path: Path) -> dict[str, Any]:
    """Return the attributes of an archive's root."""
    with opened(path) as root:
        return dict(root.attrs)


def verify(path: Path) -> dict[str, dict[str, Any]]:
    """Return the checksums that an archive keeps, all but those of its fields verified.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict
        By group, the checksum of each variable, and those of each part of a field; empty where the file keeps none.

    Raises
    ------
    ValueError
        If it is damaged.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sorted(verify(save({"scan": xr.Dataset({"height": ("x", [1.0])})}, Path(folder) / "run.nc")))
    ['/', '/scan']
    """
    with _in_words(path):
        reader_process.ask(path, netcdf_reader.__file__)
        with raw(path) as file:
            return checksums.read(file)


@contextmanager
def _in_words(path: Path) -> Iterator[None]:
    """Raise whatever the libraries say of a damaged archive as one error."""
    try:
        yield
    except (FileNotFoundError, PermissionError, IsADirectoryError):
        raise
    except Exception as error:
        raise ValueError(
            f"{path}: expected an intact archive, found it damaged or changed, at: {error}; use a copy, or repeat "
            "the run under another name; xarray.open_datatree reads what can be read"
        ) from error


def _without_fields(path: Path, group: str, ds: xr.Dataset, kept: Mapping[str, Any]) -> xr.Dataset:
    """Return a group in memory, except for its fields."""
    fields = [name for name, array in ds.data_vars.items() if checksums.is_field(array.dims, array.dtype)]
    lazy = {name: _Stored(path, group, ds[name], kept.get(str(name))).later() for name in fields}
    return ds.drop_vars(fields).load().assign({name: ds[name].copy(data=lazy[name]).variable for name in fields})


class _Stored:
    """A field of an archive, whose file is open only while a part of it is read."""

    def __init__(self, path: Path, group: str, array: xr.DataArray, kept: list[str] | None):
        self.path, self.group, self.name, self.dims, self.kept = path, group, array.name, array.dims, kept
        self.shape, self.dtype, self.ndim = array.shape, array.dtype, array.ndim

    def __getitem__(self, part: tuple) -> np.ndarray:
        count = checksums.planes_from(self.dims)
        with _in_words(self.path), opened(self.path, group=self.group, cache=False) as ds:
            values = ds[self.name][part[:count]].values  # whole planes, as they are packed
            self._verify(part[:count], values)
        return values[(..., *part[count:])]

    def _verify(self, part: tuple, values: np.ndarray) -> None:
        """Raise unless the planes read are as they were written."""
        if self.kept is None:
            return
        leading = self.shape[: checksums.planes_from(self.dims)]
        expected = np.arange(math.prod(leading)).reshape(leading)[part].ravel()
        if [self.kept[k] for k in expected] != checksums.of_planes(values, self.dims):
            raise ValueError(f"{self.group}/{self.name}")

    def later(self) -> da.Array:
        """Return the variable as a dask array in chunks of whole subregions."""
        one, meta = self.dtype.itemsize * int(np.prod(self.shape[1:])), np.empty((0,) * self.ndim, self.dtype)
        chunks = (max(_CHUNK // max(one, 1), 1), *self.shape[1:])
        return da.from_array(self, chunks, name=False, fancy=False, meta=meta)


def _storable(ds: xr.Dataset, group: str) -> xr.Dataset:
    """Return ``ds`` without the encodings of its source file; raise for an attribute that cannot be stored."""
    out = ds.drop_encoding()
    for attrs in (out.attrs, *(one.attrs for one in out.variables.values())):
        for key, value in attrs.items():
            if value is None or isinstance(value, (dict, bool)):
                raise ValueError(f"{group}: expected attributes of text, numbers or arrays, found {key}={value!r}")
    return out


def of_run(path: Path) -> Path:
    """Return the archive in a run's folder, the only one; a file as it is."""
    if not path.is_dir():
        return path
    archives = [path / name for name in ("run.nc", "paper.nc") if (path / name).is_file()]
    archives = archives or sorted(path.glob("*.nc"))
    if len(archives) != 1:
        listed = ", ".join(file.name for file in archives) or "none"
        raise ValueError(f"{path}: expected a folder with one archive, found: {listed}; give the file itself")
    return archives[0]
