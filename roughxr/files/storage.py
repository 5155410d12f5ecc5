"""Storage: files that are written whole or not at all, and the NetCDF library, which one thread uses at a time."""

from __future__ import annotations

import glob
import os
import re
import secrets
import signal
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

from ..mechanics.vocabulary.refusal import Refusal
from .doors import refuse_damage, refuse_place, refuse_replacement

#: Names that NetCDF allows.
_NETCDF_NAME = re.compile(r"[A-Za-z0-9_\u0080-\U0010ffff]([^\x00-\x1f\x7f/]*[^\x00-\x20\x7f/])?")

#: Set when an interrupt came while interrupts were delayed.
_interrupted = threading.Event()


def refuse_unstorable(ds: xr.Dataset, what: str) -> None:
    """Raise for attributes, names and values that no NetCDF file can store."""
    names = [*ds.variables, *ds.dims]
    for attrs in (ds.attrs, *(variable.attrs for variable in ds.variables.values())):
        names += attrs
        for key, value in attrs.items():
            if not _is_storable(value):
                raise Refusal(what, "attributes of text, numbers or arrays", f"{key}={value!r}")
    for name in names:
        if not isinstance(name, str) or not _NETCDF_NAME.fullmatch(name):
            expected = "names that begin with a letter, digit or _ and are free of '/' and control characters"
            raise Refusal(what, expected, f"{name!r}", "rename it")
    for name, variable in ds.variables.items():
        if variable.dtype.kind not in "biufSUMmO":
            raise Refusal(what, "real numbers or text", f"{name} of type {variable.dtype}", "store parts of it")


def _is_storable(value: Any) -> bool:
    """Return whether an attribute's value is text, a number, or a row of them."""
    if value is None or isinstance(value, (dict, bool)):
        return False
    array = np.asarray(value)
    return array.ndim <= 1 and array.dtype.kind in "iufSU"


@contextmanager
def atomic_write(path: str | os.PathLike, *, is_own: bool = False) -> Iterator[Path]:
    """Yield a temporary path to write to; rename the file to ``path`` at the end, or remove it after an error.

    An existing file of another kind is refused, except of a name that ``is_own``, in a folder of this program's files.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.roughxr{path.suffix}")
    try:
        refuse_place(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.touch(exist_ok=False)
        yield temporary
        _flush(temporary)
        if not is_own:
            refuse_replacement(path, temporary)
        os.replace(temporary, path)
        _flush(path.parent)
    except BaseException as error:
        with uninterrupted(), suppress(OSError):
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) or _is_of_netcdf(error):
            raise OSError(
                f"{path}: could not be written ({error}); no part of it is kept: make room, check your permission to "
                "write there, and call again"
            ) from error
        raise


def _is_of_netcdf(error: BaseException) -> bool:
    """Return whether the NetCDF library raised an error: it reports a full disk as a RuntimeError."""
    *_, (raising, _) = traceback.walk_tb(error.__traceback__)
    return isinstance(error, RuntimeError) and "netCDF4" in raising.f_code.co_filename


def remove_leftovers(folder: Path, name: str = "*") -> None:
    """Remove the temporary files that a killed process left in a folder."""
    for file in folder.glob("." + (name if name == "*" else glob.escape(name)) + ".????????.roughxr*"):
        file.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    """Flush a file or folder to the disk, so that it survives a power cut."""
    if os.name == "nt" and path.is_dir():
        return  # Windows opens no folders
    handle = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Delay an interrupt (Ctrl-C) until the end of the block.

    An interrupt within xarray would leave the lock of the NetCDF library locked, and the next access to a file would
    wait forever. Only the main thread is interrupted; in others this does nothing.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before) or before is _note_interrupt:
        yield
        return
    _interrupted.clear()
    signal.signal(signal.SIGINT, _note_interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if _interrupted.is_set():
            _interrupted.clear()
            signal.raise_signal(signal.SIGINT)


def _note_interrupt(*_: Any) -> None:
    _interrupted.set()


def unless_interrupted(block: Any) -> Any:
    """Return a block of a long write unchanged, or raise if an interrupt is pending."""
    if _interrupted.is_set():
        _interrupted.clear()
        raise KeyboardInterrupt
    return block


@contextmanager
def open_locked(path: str | os.PathLike, **options: Any) -> Iterator[xr.Dataset]:
    """Open a NetCDF file under the global lock of the NetCDF library, and close it at the end of the block.

    The library crashes if two threads use it at once. xarray locks it while it reads data, but not metadata.
    """
    refuse_damage(Path(path))
    with uninterrupted(), NETCDF4_PYTHON_LOCK, xr.open_dataset(path, engine="netcdf4", lock=False, **options) as ds:
        yield ds


def check_name(path: str | os.PathLike) -> None:
    """Raise unless the NetCDF library, which knows UTF-8 alone, can take the path."""
    if any("\udc80" <= character <= "\udcff" for character in os.fspath(path)):  # bytes that are no UTF-8
        raise Refusal(path, "a path in UTF-8, as NetCDF files need", "another", "rename the file or its folder")


@contextmanager
def open_locked_raw(path: str | os.PathLike, mode: Literal["r", "a", "w"] = "r") -> Iterator[netCDF4.Dataset]:
    """Open a NetCDF file as `open_locked` does, but without xarray."""
    check_name(path)
    if mode == "r":
        refuse_damage(Path(path))
    with uninterrupted(), NETCDF4_PYTHON_LOCK, netCDF4.Dataset(path, mode) as file:
        yield file


def as_characters(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Return the encoding that stores text as characters of fixed width, which read back as the same text.

    Strings of variable length, xarray's default, crash the interpreter that opens a file which it has open
    already, such as in a data tree (Unidata/netcdf4-python issues 261 and 1444, HDFGroup/hdf5 issue 5359).
    """
    return {str(name): {"dtype": "S1"} for name, variable in ds.variables.items() if _is_text(variable)}


def _is_text(variable: xr.Variable) -> bool:
    if variable.dtype.kind != "O":
        return variable.dtype.kind == "U"
    return variable.size > 0 and all(isinstance(value, str) for value in np.ravel(variable.values))
