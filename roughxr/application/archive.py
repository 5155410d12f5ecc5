"""Archives: one NetCDF-4 file for a run, with a group for each Dataset, replaced only by a complete new version.

Groups are plain Datasets (scan, asperities, solutions, statistics) whose attributes record how each was made;
`xarray.open_datatree` reads them unchanged. The archive of an unfinished run contains the groups computed so far; the
attribute `UNFINISHED` of its root lists what is missing.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import netCDF4
import numpy as np
import xarray as xr

from .._version import __version__
from ..files.doors import note_own_file, open_hdf5
from ..files.storage import (
    as_characters,
    atomic_write,
    open_locked_raw,
    refuse_unstorable,
    uninterrupted,
    unless_interrupted,
)
from ..mechanics.vocabulary.provenance import as_json
from ..mechanics.vocabulary.refusal import Refusal
from ..mechanics.vocabulary.schema import in_package_units
from ..mechanics.vocabulary.text import warn

__all__ = ["load", "save"]

#: Zlib's level 1: half the size of fields in a tenth of the time of level 9.
_COMPRESSED = {"zlib": True, "complevel": 1}

#: Attribute of the root of an unfinished run: what is missing.
UNFINISHED = "unfinished"

#: Attribute of the root: a line for each group, the SHA-256 of its attributes and of its variables other than fields.
_CHECKSUMS = "checksums"

#: Fields are read in chunks of this many bytes, or of one subregion if that is larger.
_CHUNK = 2**23


def save(
    groups: Mapping[str, xr.Dataset],
    path: str | os.PathLike,
    *,
    title: str = "",
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

    Returns
    -------
    Path

    Raises
    ------
    OSError
        If it cannot be written, for example because the disk is full.

    Examples
    --------
    >>> from pathlib import Path
    >>> import xarray as xr
    >>> import roughxr
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> path = roughxr.archive.save({"scan": xr.Dataset({"height": ("x", [1.0, 2.0])})}, Path(folder) / "run.nc")
    >>> xr.open_datatree(path)["scan/height"].values.tolist()
    [1.0, 2.0]
    """
    values = getattr(groups, "values", dict)
    if isinstance(groups, xr.Dataset) or not all(isinstance(ds, xr.Dataset) for ds in values()):
        advice = "name each, as {'scan': scan}"
        raise Refusal("groups", "Datasets by the names of their groups", type(groups).__name__, advice)
    add(groups, Path(path), {"title": title}, onto=False)
    return Path(path)


def add(
    groups: Mapping[str, xr.Dataset], path: Path, attrs: Mapping[str, Any], *, onto: bool = True
) -> dict[str, xr.Dataset]:
    """Add the groups that an archive lacks, or write a new archive, and return what it then contains of them.

    ``attrs`` are set at its root; None removes one. A copy of the file is changed and renamed, so that the archive is
    valid whenever the process is stopped.
    """
    if onto:
        with open_locked_raw(path) as file:
            existing = group_names(file)
        groups = {name: ds for name, ds in groups.items() if name not in existing}
    else:
        attrs = {"Conventions": "CF-1.11", "source": f"roughxr {__version__}", **attrs}
    groups = {name: _storable(in_package_units(ds), name) for name, ds in groups.items()}
    lazy = {name: [key for key in ds.data_vars if ds[key].chunks] for name, ds in groups.items()}
    loaded = {name: ds.drop_vars(lazy[name]).compute() for name, ds in groups.items()}
    with atomic_write(path) as temporary:
        if onto:
            shutil.copyfile(path, temporary)
        with open_locked_raw(temporary, "a" if onto else "w") as file:
            _write_groups(file, loaded)
            contents = f"in groups, open with xarray.open_datatree: {', '.join(group_names(file))}"
            _set_attributes(file, {**attrs, "comment": contents})
            stored = _with_checksums(file, path, [name for name in groups if not lazy[name]])
        for name, keys in lazy.items():
            for key in keys:
                _write_field(groups[name][[key]], key, temporary, name)
        if any(lazy.values()):
            with open_locked_raw(temporary, "a") as file:
                stored |= _with_checksums(file, path, [name for name in groups if lazy[name]])
        note_own_file(temporary)
    return {name: stored[name] for name in sorted(stored)}


def _with_checksums(file: netCDF4.Dataset, path: Path, names: Iterable[str]) -> dict[str, xr.Dataset]:
    """Return groups as an open file contains them, whose checksums are written to its root."""
    stored = {name: _read_group(path, name, file[name]) for name in names}
    checksums = _checksums(getattr(file, _CHECKSUMS, "")) | {name: group.checksum for name, group in stored.items()}
    file.setncattr(_CHECKSUMS, "\n".join(map(" ".join, checksums.items())))
    return {name: group.ds for name, group in stored.items()}


def _set_attributes(file: netCDF4.Dataset, attrs: Mapping[str, Any]) -> None:
    """Set attributes of an archive's root; None removes one."""
    stored = file.ncattrs()
    for name, value in attrs.items():
        if value is not None:
            file.setncattr(name, value)
        elif name in stored:
            file.delncattr(name)


def _write_field(ds: xr.Dataset, key: Any, path: Path, group: str) -> None:
    """Write one lazy variable: chunks that several variables share would otherwise all stay in memory."""
    field = ds[key].data
    ds = ds.assign({key: ds[key].copy(data=field.map_blocks(unless_interrupted, meta=field._meta))})
    with uninterrupted():
        ds.to_netcdf(path, mode="a", group=group, encoding=_encoding(ds), engine="netcdf4")


class _LateWriter:
    """Writes values once all variables are defined: the library stores all definitions anew for each change of mode."""

    def __init__(self) -> None:
        self.values: list[tuple[Any, Any]] = []

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Note the values of a variable, as xarray's writers do."""
        self.values.append((source, target))

    def write(self) -> None:
        """Write all values."""
        for source, target in self.values:
            target[...] = source


def _write_groups(file: netCDF4.Dataset, groups: Mapping[str, xr.Dataset]) -> None:
    """Write Datasets in memory as groups of an open file."""
    writer = _LateWriter()
    for name, ds in groups.items():
        encoding = _encoding(ds)
        variables, attrs = xr.conventions.encode_dataset_coordinates(ds)
        for key, options in encoding.items():
            variables[key].encoding = options
        store = xr.backends.NetCDF4DataStore(file.createGroup(name), mode="a", lock=False)
        store.store(variables, attrs, set(encoding), writer)
    writer.write()


def _encoding(ds: xr.Dataset) -> dict[str, dict]:
    """Return the encoding of each variable: HDF5's checksums, and fields in one chunk for each subregion and state.

    The library's default chunks span many subregions, and would be decompressed and compressed again for each of them.
    """
    encoding = as_characters(ds)
    for name, variable in ds.variables.items():
        if not variable.ndim:
            continue
        packed = _COMPRESSED if name in ds.data_vars else {}
        encoding[str(name)] = encoding.get(str(name), {}) | packed | {"fletcher32": True}
        if variable.dims[:1] == ("subregion",) and {"x", "y"} <= set(variable.dims) and variable.size:
            sizes = (n if dim in ("x", "y") else 1 for dim, n in variable.sizes.items())
            encoding[str(name)]["chunksizes"] = tuple(sizes)
    return encoding


def load(path: str | os.PathLike) -> dict[str, xr.Dataset]:
    """Return the groups of an archive by name.

    Parameters
    ----------
    path : path
        A file that `save` wrote, or the folder of a run.

    Returns
    -------
    dict of str to Dataset
        In memory, except for fields along ``subregion``, which are lazy: each is read when it is used.

    Raises
    ------
    ValueError
        If it is damaged, or takes data from other files. Each group has a checksum of its attributes and variables; of
        a field, HDF5's checksums and the positions of all its parts are checked when it is read.

    Examples
    --------
    >>> from pathlib import Path
    >>> import xarray as xr
    >>> import roughxr
    >>> import tempfile
    >>> ds = xr.Dataset({"force": ("subregion", [1.0, 2.0])})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     groups = roughxr.archive.load(roughxr.archive.save({"solutions/direct": ds}, Path(folder) / "run.nc"))
    >>> float(groups["solutions/direct"].force.sum())
    3.0
    """
    path = run_archive(Path(path))
    with _damage_explained(path), open_locked_raw(path) as file:
        missing = getattr(file, UNFINISHED, "")
        checksums = _checksums(getattr(file, _CHECKSUMS, ""))
        if not checksums and file.groups and str(getattr(file, "source", "")).startswith("roughxr "):
            raise ValueError("it lacks the checksums of its groups")
        groups = {name: _read_group(path, name, file[name], has_checksum=bool(checksums)) for name in group_names(file)}
        for name, group in groups.items():
            if group.checksum != checksums.get(name, ""):
                raise ValueError(f"{name} is not as it was written")
    if missing:
        warn(f"{path}: the run is not finished, {missing}; the same command continues it")
    return {name: group.ds for name, group in groups.items()}


def _checksums(stored: str | bytes) -> dict[str, str]:
    """Return the checksums of an archive's groups by its attribute; empty for files of other programs."""
    lines = stored.decode() if isinstance(stored, bytes) else str(stored)
    return dict(line.rpartition(" ")[::2] for line in lines.splitlines())


def _checksum(ds: xr.Dataset) -> str:
    """Return the SHA-256 of a Dataset's attributes and of its variables other than fields."""
    digest = hashlib.sha256()
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        meaning = [name, variable.dims, variable.shape, sorted(as_json(variable.attrs).items())]
        digest.update(json.dumps(meaning, default=str).encode())
        if not _is_field(variable):
            plain = variable.values if variable.dtype.kind in "biufcmM" else variable.values.astype("U")
            digest.update(np.ascontiguousarray(plain, plain.dtype.newbyteorder("<")).tobytes())
    digest.update(json.dumps(sorted(as_json(ds.attrs).items()), default=str).encode())
    return digest.hexdigest()


def root_attributes(path: Path) -> dict[str, Any]:
    """Return the attributes of an archive's root."""
    with _damage_explained(path), open_locked_raw(path) as root:
        return {name: root.getncattr(name) for name in root.ncattrs()}


@contextmanager
def _damage_explained(path: Path) -> Iterator[None]:
    """Raise any library error on a damaged archive as a ValueError that explains it."""
    try:
        yield
    except (FileNotFoundError, PermissionError, IsADirectoryError, Refusal):
        raise
    except Exception as error:
        if path.is_file() and not h5py.is_hdf5(path):
            raise Refusal(
                path,
                "the archive of a run",
                "another kind of file, such as a scan, or damage at its beginning",
                "roughxr run makes an archive of a scan",
            ) from error
        reason = getattr(error, "strerror", None) or error
        raise Refusal(
            path,
            "an intact archive",
            f"it damaged, cut short or overwritten: {reason}",
            "use a copy, or repeat the run under another name; xarray.open_datatree reads what can be read",
        ) from error


class _StoredGroup(NamedTuple):
    """A group of an archive, in memory except for its fields, which are lazy."""

    ds: xr.Dataset
    checksum: str


def _read_group(path: Path, name: str, group: netCDF4.Group, has_checksum: bool = True) -> _StoredGroup:
    """Return a group of an open file, with the checksum of what it contains; without one in files of other programs."""
    ds = xr.decode_cf(xr.backends.NetCDF4DataStore(group, lock=False))
    fields = [key for key, array in ds.data_vars.items() if _is_field(array)]
    for key in ds.variables.keys() - set(fields):
        ds.variables[key].load()
    checksum = _checksum(ds) if has_checksum else ""
    for key in fields:
        ds.variables[key].data = _StoredField(path, name, ds[key], checksum).lazy()
    ds.set_close(None)  # the file is closed by others
    return _StoredGroup(ds, checksum)


def _is_field(array: xr.DataArray | xr.Variable) -> bool:
    """Return whether a variable is a field: floating-point numbers along ``subregion`` and ``x``."""
    return array.dims[:1] == ("subregion",) and "x" in array.dims and array.dtype.kind == "f"


class _StoredField:
    """A field of an archive, whose file is opened for each read and closed again.

    ``checksum`` is that of its group: a file that was replaced by another run's has another one.
    """

    def __init__(self, path: Path, group: str, array: xr.DataArray, checksum: str):
        self.path = path
        self.group = group
        self.checksum = checksum
        self.is_checked = False
        self.name = array.name
        self.shape = array.shape
        self.dtype = array.dtype
        self.ndim = array.ndim

    def __getitem__(self, part: tuple) -> np.ndarray:
        with _damage_explained(self.path), uninterrupted(), open_hdf5(self.path) as file:
            if _checksums(file.attrs.get(_CHECKSUMS, "")).get(self.group, "") != self.checksum:
                raise ValueError(f"{self.group} was replaced after it was loaded; load it again")
            field = file[f"{self.group}/{self.name}"]
            if not self.is_checked:
                self._check_chunks(field)
            self.is_checked = True
            return field[part]

    def _check_chunks(self, field: h5py.Dataset) -> None:
        """Raise unless the field has all its chunks, each at its own position: HDF5 reads others as missing values."""
        if field.chunks is None:
            return
        positions = set()
        field.id.chunk_iter(lambda chunk: positions.add(chunk.chunk_offset))
        starts = (range(0, size, step) for size, step in zip(field.shape, field.chunks))
        if positions != set(itertools.product(*starts)):
            raise ValueError(f"{self.group}/{self.name} lacks parts")

    def lazy(self) -> Any:
        """Return the variable as a dask array in chunks of whole subregions."""
        import dask.array as da  # not at the top: few files have fields, and it takes longer than all else here

        plane = self.dtype.itemsize * int(np.prod(self.shape[1:]))
        meta = np.empty((0,) * self.ndim, self.dtype)
        chunks = (max(_CHUNK // max(plane, 1), 1), *self.shape[1:])
        return da.from_array(self, chunks, name=False, fancy=False, meta=meta)


def _storable(ds: xr.Dataset, group: str) -> xr.Dataset:
    """Return ``ds`` without the encodings of its source file; raise for an attribute that cannot be stored."""
    refuse_unstorable(ds, group)
    is_encoded = ds.encoding or any(variable.encoding for variable in ds.variables.values())
    return ds.drop_encoding() if is_encoded else ds


def run_archive(path: Path) -> Path:
    """Return the path of the only archive in a run's folder; the path of a file is returned unchanged."""
    if not path.is_dir():
        return path
    archives = [path / name for name in ("run.nc", "paper.nc") if (path / name).is_file()]
    files = sorted(path.glob("*.nc"))
    archives = archives or [file for file in files if _has_statistics(file)] or files
    if len(archives) != 1:
        archives = archives or sorted(path.glob("*/run.nc"))  # of several scans
        listed = ", ".join(str(file.relative_to(path)) for file in archives) or "none"
        raise Refusal(path, "a folder with one archive", listed, "give the file itself")
    return archives[0]


def _has_statistics(path: Path) -> bool:
    """Return whether a file is the archive of a run, and no scan or another NetCDF file."""
    if not h5py.is_hdf5(path):
        return False
    with h5py.File(path) as root:
        return "statistics" in root


def checked_names(door: Callable) -> Callable:
    """Return a function that takes a run, and names a variable, attribute or group that the run's archive lacks."""

    @functools.wraps(door)
    def checked(*arguments: Any, **options: Any):
        try:
            return door(*arguments, **options)
        except KeyError as error:
            lookup: BaseException = error
            while lookup.__context__ is not None:  # of a mapping, below the Dataset's
                lookup = lookup.__context__
            expected = f"{lookup.args[0]!r} in the archive of the run"
            writer = "none: another version of roughxr wrote it"
            raise Refusal("", expected, writer, "repeat the run under another name") from error

    return checked


def group_names(file: netCDF4.Dataset) -> list[str]:
    """Return the sorted names of the groups of a file, except those that only contain other groups."""
    names = []
    for group in file.groups.values():
        if group.variables or not group.groups:
            names.append(group.path.strip("/"))
        names += group_names(group)
    return sorted(names)
