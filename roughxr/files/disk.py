"""Files written completely or not at all, and NetCDF files read by one thread at a time."""

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
from typing import Any, Literal

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK, NetCDF4DataStore

#: Beginning of netCDF4's RuntimeErrors; it reports a full disk in no clearer way.
_NETCDF = "NetCDF: "

#: Set when an interrupt came while interrupts were held back.
_interrupted = threading.Event()


@contextmanager
def whole(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a path to write to; afterwards rename the file to its real name, or after an error leave no trace."""
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
        with uninterrupted():  # a second interrupt must not keep the first one's clean-up from finishing
            room = _room(path)
            _discard(temporary)
        if isinstance(error, OSError) or (isinstance(error, RuntimeError) and str(error).startswith(_NETCDF)):
            raise OSError(
                f"{path}: could not be written ({error}); no part of it is kept; its disk has {room} free: "
                "make room, check your permission to write there, and call again"
            ) from error
        raise


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Delay an interrupt (Ctrl-C) until the end of the block.

    Within xarray it would leave the lock of the NetCDF library taken: whatever reads or closes a file then waits
    for ever. Only the main thread is ever interrupted; in others this does nothing.
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
    """Return ``block``, or raise if an interrupt is pending: for use between two pieces of a long write."""
    if _interrupted.is_set():
        _interrupted.clear()
        raise KeyboardInterrupt
    return block


@contextmanager
def opened(path: str | os.PathLike, **options: Any) -> Iterator[xr.Dataset]:
    """Open a NetCDF file while nothing else of this process is in the NetCDF library, and close it.

    The library crashes where two threads are in it. xarray locks it while data are read, but not while metadata are;
    here its lock is held while the file is opened and closed, so that others may read lazily meanwhile.
    """
    with uninterrupted(), NETCDF4_PYTHON_LOCK, xr.open_dataset(path, engine="netcdf4", lock=False, **options) as ds:
        yield ds


def each_group(path: str | os.PathLike) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield name and Dataset of each group of a NetCDF file that holds more than groups; the file is opened once.

    Read each Dataset before the next is asked for.
    """
    with raw(path) as file:
        for name in names_in(file):
            yield name, xr.open_dataset(NetCDF4DataStore(file[name], lock=False), engine="store")


def names_in(file: netCDF4.Dataset) -> list[str]:
    """Return the names of the groups of a file, except those that only hold other groups."""
    return [group.path.strip("/") for group in _below(file) if group.variables or not group.groups]


@contextmanager
def raw(path: str | os.PathLike, mode: Literal["r", "a"] = "r") -> Iterator[netCDF4.Dataset]:
    """Open a NetCDF file as `opened` does, but without xarray."""
    with uninterrupted(), NETCDF4_PYTHON_LOCK, netCDF4.Dataset(path, mode) as file:
        yield file


def _below(group: netCDF4.Dataset) -> Iterator[netCDF4.Dataset]:
    for child in group.groups.values():
        yield child
        yield from _below(child)


def as_characters(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Return the encoding that stores text as characters of fixed width, which read back as the same text.

    Strings of variable length, xarray's default, crash the interpreter that opens a file which it has open
    already, such as in a data tree (Unidata/netcdf4-python issues 261 and 1444, HDFGroup/hdf5 issue 5359).
    """
    texts = (name for name, variable in ds.variables.items() if _is_text(variable))
    return {str(name): {"dtype": "S1"} for name in texts}


def _is_text(variable: xr.Variable) -> bool:
    if variable.dtype.kind != "O":
        return variable.dtype.kind == "U"
    return variable.size > 0 and all(isinstance(value, str) for value in np.ravel(variable.values))


def leftovers(path: Path) -> list[Path]:
    """Return the files that a process left beside ``path`` if it was killed while writing."""
    return list(path.parent.glob(glob.escape(f".{path.name}.") + "*.part" + glob.escape(path.suffix)))


def _room(path: Path) -> str:
    try:
        return f"{shutil.disk_usage(path.parent).free / 1e6:.3g} MB"
    except OSError:
        return "no space (there is no such folder)"


def _discard(temporary: Path) -> None:
    """Remove a file and free its space, also where HDF5 failed to write it: HDF5 holds such files open for good."""
    with contextlib.suppress(OSError):
        _end_writing(temporary)
        os.truncate(temporary, 0)
    with contextlib.suppress(OSError):
        temporary.unlink(missing_ok=True)


def _end_writing(temporary: Path) -> None:
    """Make the handles that this process has open on a file read-only, or a later flush would fill the disk again.

    They are not closed: HDF5 would take another file for this one if it got its inode.
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
    """Flush a file or folder to the disk, so that it survives a power cut."""
    if os.name == "nt" and path.is_dir():
        return  # Windows opens no folders
    handle = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
