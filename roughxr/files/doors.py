"""The doors of all files, read and written.

An input is an ordinary file that takes no data from others. An output is never a file that is read, nor an existing
file of another kind. A kind is told by the content, never by the name: the first line of a text, or a signature.
"""

from __future__ import annotations

import hashlib
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import h5py

from ..mechanics.vocabulary.refusal import Refusal

#: Name of this program in the pages and workbooks that it writes.
MARK = "roughxr"

#: First bytes of HDF5 files, zip archives and JPEG pictures; what follows in the last two differs by file.
_HDF5 = b"\x89HDF"
_ZIP = b"PK\3\4"
_JPEG = b"\xff\xd8\xff"

#: Kind of this program's pages.
_PAGE = b"<!doctype html>" + MARK.encode()

#: Longest first line of a table, and beginning of a page that contains the mark, bytes.
_LONGEST_LINE = 2**16

#: Errors of damaged zip and HDF5 files, which their readers report.
_UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, zipfile.BadZipFile, zlib.error)

#: Largest depth of nested groups.
_DEEPEST_GROUP = 50

#: Largest size of what a zip file or an HDF5 file unpacks to, over the size of the file; a size that is always allowed,
#: bytes; and the largest size of a zip file's content.
_LARGEST_RATIO = {"zip": 50, "hdf5": 200}
_ALWAYS_ALLOWED = {"zip": 2**22, "hdf5": 2**28}
_LARGEST_ZIP = 2**32


def refuse_special(path: Path) -> None:
    """Raise unless a path is that of an ordinary file: reading a pipe or device could wait for ever."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"{path}: expected a file, found a folder; name those in it, as {path}/*")
    if not stat.S_ISREG(mode):
        raise Refusal(path, "an ordinary file", "a pipe or device", "save it to a file first")


@contextmanager
def open_hdf5(path: Path) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading; raise if it takes data from other files."""
    refuse_other_files(path)
    with h5py.File(path) as file:
        yield file


def refuse_other_files(path: Path) -> None:
    """Raise if an HDF5 file takes data from other files of this machine, or nests groups without end.

    A stranger's file could name any file; the NetCDF library never returns from deeply nested groups. Raise, too, if an
    HDF5 or zip file unpacks to much more than its own size: such a file would fill the memory.
    """
    refuse_special(path)
    foreign, kind, content, _ = _survey(_StoredFile(path))
    largest = max(_ALWAYS_ALLOWED[kind], _LARGEST_RATIO[kind] * path.stat().st_size)
    largest = min(largest, _LARGEST_ZIP) if kind == "zip" else largest
    if content > largest:
        sizes = [f"{size / 2**20:.3g} MiB" for size in (largest, content)]
        raise Refusal(path, f"a content of at most {sizes[0]}, by its size", sizes[1], "save it anew in its program")
    if foreign:
        raise Refusal(
            path,
            "data in the file itself",
            f"{foreign!r} in another file",
            "ask its author for a file without external storage, virtual datasets and external links",
        )


def refuse_damage(path: Path) -> None:
    """Raise as `refuse_other_files`, or an OSError where HDF5 cannot read the description of all data.

    The NetCDF library never closes a file that it failed to open.
    """
    refuse_other_files(path)
    if fault := _survey(_StoredFile(path)).fault:
        raise OSError(fault)


class _Survey(NamedTuple):
    """What an archive contains: the first name whose data lie in another file, its kind and unpacked size (bytes)."""

    foreign: str = ""
    kind: str = "hdf5"
    content: int = 0
    fault: str = ""  # of a damaged file


class _StoredFile:
    """A file in its present state; equal to itself under another name, as after a temporary file was renamed."""

    def __init__(self, path: Path):
        state = path.stat()
        self.path = path
        self.state = state.st_dev, state.st_ino, state.st_mtime_ns, state.st_size

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _StoredFile) and self.state == other.state

    def __hash__(self) -> int:
        return hash(self.state)


#: Files that this process wrote, as they were then.
_own_files: set[_StoredFile] = set()


def note_own_file(path: Path) -> None:
    """Note that this process wrote all of a file: it is not searched as long as nothing changes it."""
    _own_files.add(_StoredFile(path))


@lru_cache(maxsize=64)
def _survey(file: _StoredFile) -> _Survey:
    """Return what a zip or HDF5 file contains."""
    path = file.path
    if file in _own_files:
        return _Survey()
    try:
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as archive:
                return _Survey(kind="zip", content=sum(member.file_size for member in archive.infolist()))
        if h5py.is_hdf5(path):
            with h5py.File(path) as opened:
                foreign, content = _foreign_data(opened)
                return _Survey(foreign, content=content)
    except Refusal:
        raise
    except _UNREADABLE as error:
        return _Survey(fault=str(error) or type(error).__name__)
    return _Survey()


def _foreign_data(file: h5py.File) -> tuple[str, int]:
    """Return the name of the first dataset or group whose data lie in another file, or none, and the unpacked bytes."""
    groups: list[h5py.Group] = [file]
    content = 0
    visited = set()
    while groups:
        group = groups.pop()
        if group.name.count("/") > _DEEPEST_GROUP:
            raise Refusal(file.filename, f"groups nested at most {_DEEPEST_GROUP} deep", "more")
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                return name, content
            if not isinstance(link, h5py.HardLink):
                continue
            item = group[name]
            if isinstance(item, h5py.Dataset) and (item.is_virtual or item.external):
                return name, content
            for attribute in item.attrs:
                with suppress(TypeError):  # of a type that numpy lacks
                    item.attrs[attribute]
            content += item.nbytes if isinstance(item, h5py.Dataset) else 0
            address = h5py.h5o.get_info(item.id).addr
            if isinstance(item, h5py.Group) and address not in visited:
                groups.append(item)
            visited.add(address)
    return "", content


def refuse_place(path: Path) -> None:
    """Raise unless a path can be that of a new file, or is an ordinary file."""
    if path.exists() and not path.is_file():
        raise Refusal(path, "the name of a file", "a folder" if path.is_dir() else "a pipe or device")
    above = next((folder for folder in path.parents if folder.exists()), path.parent)
    if not above.is_dir():
        raise Refusal(path, "a name in a folder", f"a file, {above}")


def refuse_replacement(path: Path, new: Path) -> None:
    """Raise if a path is that of an existing file of another kind than the new file that would replace it."""
    if path.exists():
        _refuse_other_kind(path, kind_of(new))


def refuse_other_page(path: Path) -> None:
    """Raise if a path is no page's name, or that of an existing file that is no page of this program."""
    _refuse_other_kind(path, _PAGE)
    if path.suffix.lower() not in (".html", ".htm"):
        raise Refusal(path, "the name of a page, ending in .html", f"the ending {path.suffix!r}")


def _refuse_other_kind(path: Path, kind: bytes) -> None:
    if path.exists() and path.stat().st_size and kind_of(path) != kind:
        expected = "a new name, or that of an earlier output of the same kind"
        raise Refusal(path, expected, "another file", "give another name")


def refuse_source(path: Path, attrs: Mapping[Any, Any]) -> None:
    """Raise if a path is that of the file from which a Dataset with these attributes was read."""
    if "source_sha256" not in attrs or not path.is_file():
        return
    with path.open("rb") as file:
        is_source = hashlib.file_digest(file, "sha256").hexdigest() == attrs["source_sha256"]
    if is_source:
        raise Refusal(path, "another name than that of the file that was read", "the same", "give another name")


def kind_of(path: Path) -> bytes:
    """Return what tells the kind of a file: its signature, the first line of a table, the first words of a comment."""
    with path.open("rb") as file:
        head = file.read(_LONGEST_LINE)
    if head.startswith(_HDF5):
        return _HDF5 + b" with groups" * _has_groups(path)
    if head.startswith(_ZIP):
        return _ZIP + MARK.encode() * _is_own_workbook(path)
    if head.startswith(_JPEG):
        return _JPEG
    line = head.partition(b"\n")[0].strip()
    if line.startswith(b"<"):
        return line.lower() + MARK.encode() * (f'content="{MARK}"'.encode() in head)
    return b" ".join(line.split()[:2]) if line.startswith(b"#") else line


def is_own_page(path: Path) -> bool:
    """Return whether a file is a page that this program wrote."""
    return path.is_file() and kind_of(path) == _PAGE


def _has_groups(path: Path) -> bool:
    """Return whether an HDF5 file has groups, as the archive of a run; a damaged file has none."""
    with suppress(*_UNREADABLE), open_hdf5(path) as file:
        return any(file.get(name, getclass=True) is h5py.Group for name in file)
    return False


def _is_own_workbook(path: Path) -> bool:
    """Return whether a zip file is a workbook that states this program as its creator."""
    with suppress(*_UNREADABLE), zipfile.ZipFile(path) as archive, archive.open("docProps/core.xml") as properties:
        return f">{MARK}</dc:creator>".encode() in properties.read(_LONGEST_LINE)
    return False
