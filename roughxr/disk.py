"""How files are written, whole or not at all, and NetCDF read, by one thread at a time."""

from __future__ import annotations

import contextlib
import glob
import os
import secrets
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

#: How netCDF4 begins its RuntimeErrors, which is all that it says of a full disk.
_NETCDF = "NetCDF: "

#: An interrupt came while none was let through.
_interrupted = threading.Event()


@contextmanager
def whole(path: str | os.PathLike) -> Iterator[Path]:
    """Give a path to write to, and the file its real name once it is on the disk; or leave no trace.

    Parameters
    ----------
    path : path
        The file. Its folder is made where it is not there; what was there under this name stays until the end.

    Yields
    ------
    Path
        Beside ``path``, hidden, with its ending.

    Raises
    ------
    OSError
        If it cannot be written: names the file and the room on its disk.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "result.txt"
    >>> with whole(path) as temporary:
    ...     _ = temporary.write_text("all of it")
    >>> [file.name for file in path.parent.iterdir()]
    ['result.txt']
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.touch(exist_ok=False)
        yield temporary
        _to_disk(temporary)
        os.replace(temporary, path)
        _to_disk(path.parent)
    except BaseException as error:
        with uninterrupted():  # a second one must not leave what the first was to remove
            room = _room(path)
            _discard(temporary)
        if isinstance(error, OSError) or (isinstance(error, RuntimeError) and str(error).startswith(_NETCDF)):
            raise OSError(
                f"{path}: could not be written ({error}), nothing is left of it; its disk had room for {room}: "
                "make room, see that you may write there, and call again"
            ) from error
        raise


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let an interrupt (Ctrl-C) wait until the end of the block.

    Within xarray it would leave the lock of the NetCDF library taken: whatever reads or closes a file then waits
    for ever. Only the main thread is ever interrupted; in others this does nothing.

    Examples
    --------
    >>> try:
    ...     with uninterrupted():
    ...         signal.raise_signal(signal.SIGINT)
    ...         print("written")
    ... except KeyboardInterrupt:
    ...     print("interrupted")
    written
    interrupted
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before) or before is _wait:
        yield
        return
    _interrupted.clear()
    signal.signal(signal.SIGINT, _wait)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if _interrupted.is_set():
            _interrupted.clear()
            signal.raise_signal(signal.SIGINT)


def _wait(*_: Any) -> None:
    _interrupted.set()


def unless_interrupted(block: Any) -> Any:
    """Return ``block``, or end here if an interrupt waits: between two pieces of what takes long to write."""
    if _interrupted.is_set():
        _interrupted.clear()
        raise KeyboardInterrupt
    return block


@contextmanager
def opened(path: str | os.PathLike, **options: Any) -> Iterator[xr.Dataset]:
    """Open a NetCDF file while nothing else of this process is in the NetCDF library, and close it.

    The library crashes where two threads are in it. xarray locks it to read data, not to read what a file says of
    them; here its lock is held from opening to closing, so that others may read lazily meanwhile.

    Parameters
    ----------
    path : path
    **options
        For `xarray.open_dataset`.

    Yields
    ------
    Dataset
        To be read within the block.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "a.nc"
    >>> with whole(path) as temporary:
    ...     _ = xr.Dataset({"a": ("x", [1, 2])}).to_netcdf(temporary, group="b/c")
    >>> groups(path)
    ['b/c']
    >>> with opened(path, group="b/c") as ds:
    ...     ds["a"].values.tolist()
    [1, 2]
    """
    with uninterrupted(), NETCDF4_PYTHON_LOCK, xr.open_dataset(path, engine="netcdf4", lock=False, **options) as ds:
        yield ds


def groups(path: str | os.PathLike) -> list[str]:
    """Return the names of the groups of a NetCDF file, but for those that only hold others."""
    with uninterrupted(), NETCDF4_PYTHON_LOCK, netCDF4.Dataset(path) as file:
        return [group.path.strip("/") for group in _below(file) if group.variables or not group.groups]


def _below(group: netCDF4.Dataset) -> Iterator[netCDF4.Dataset]:
    for child in group.groups.values():
        yield child
        yield from _below(child)


def as_characters(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Return the encoding that stores text as characters of fixed width, which read back as the same text.

    As strings of variable length, xarray's choice, they kill the interpreter that opens a file which it has open
    already, such as in a data tree (Unidata/netcdf4-python issues 261 and 1444, HDFGroup/hdf5 issue 5359).

    Examples
    --------
    >>> as_characters(xr.Dataset({"law": ("k", ["jkr", "hertz"]), "force": ("k", [1.0, 2.0])}))
    {'law': {'dtype': 'S1'}}
    """
    texts = (name for name, variable in ds.variables.items() if _is_text(variable))
    return {str(name): {"dtype": "S1"} for name in texts}


def _is_text(variable: xr.Variable) -> bool:
    if variable.dtype.kind != "O":
        return variable.dtype.kind == "U"
    return variable.size > 0 and all(isinstance(value, str) for value in np.ravel(variable.values))


def leftovers(path: Path) -> list[Path]:
    """Return what a process that was killed while it wrote ``path`` left beside it."""
    return list(path.parent.glob(glob.escape(f".{path.name}.") + "*.part" + glob.escape(path.suffix)))


def _room(path: Path) -> str:
    try:
        return f"{shutil.disk_usage(path.parent).free / 1e6:.3g} MB"
    except OSError:
        return "nothing: there is no such folder"


def _discard(temporary: Path) -> None:
    """Remove a file and free its room, also where HDF5 failed to write it: it holds such files open for good."""
    with contextlib.suppress(OSError):
        _end_writing(temporary)
        os.truncate(temporary, 0)
    with contextlib.suppress(OSError):
        temporary.unlink(missing_ok=True)


def _end_writing(temporary: Path) -> None:
    """Make read-only what this process has open of a file, or a later flush would fill the disk again.

    It is not closed: HDF5 takes another file for this one if that gets its inode.
    """
    if not os.path.isdir("/dev/fd"):
        return  # Windows
    file, readable = os.stat(temporary), os.open(temporary, os.O_RDONLY)
    for handle in set(map(int, os.listdir("/dev/fd"))) - {readable}:
        with contextlib.suppress(OSError):  # such as the folder's own handle, closed by now
            if os.path.samestat(os.fstat(handle), file):
                os.dup2(readable, handle, inheritable=False)
    os.close(readable)


def _to_disk(path: Path) -> None:
    """Have what was written, file or folder, reach the disk, so that a power cut cannot take it back."""
    if os.name == "nt" and path.is_dir():
        return  # Windows opens no folders
    handle = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
