"""What a run keeps until it is finished: results, identity and log in one SQLite file, which is also its lock.

SQLite commits a batch wholly or not at all, through crashes and power cuts, and its lock ends with the process that
holds it, however that ends: there are no stale locks. Rows that were changed on the disk, which SQLite does not
notice, are found by the hash that each of them keeps of itself.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import zlib
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

#: Each row ends with the hash of what is before it.
_TABLES = {
    "identity": "(text TEXT, hash BLOB)",
    "log": "(time TEXT, message TEXT, hash BLOB)",
    "batches": "(stage TEXT, first INTEGER, count INTEGER, data BLOB, hash BLOB, PRIMARY KEY (stage, first))",
}

#: Zlib's level 1: fields shrink to a fraction of their size, faster than the disk writes.
_LEVEL = 1


class Checkpoint:
    """The unfinished run beside ``output``, open and locked until `close`.

    Raises
    ------
    BlockingIOError
        If another process has the checkpoint open.
    OSError
        If the file cannot be written.
    """

    def __init__(self, output: Path):
        self.path = output.with_name(output.name + ".checkpoint")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.set_aside: Path | None = None
        try:
            self._connection = _connect(self.path)
        except sqlite3.DatabaseError as error:
            _refuse_unless_damaged(error, self.path)
            self.set_aside = _put_aside(self.path)
            self._connection = _connect(self.path)
        if self.set_aside:
            self.say(f"damaged checkpoint set aside as {self.set_aside.name}")

    def close(self, *, remove: bool = False) -> None:
        """Close the file; where ``remove``, delete it first, while it is still locked, if the system allows that."""
        left = _files(self.path) if remove else []
        try:
            if remove:
                self.path.unlink(missing_ok=True)
        except PermissionError:  # Windows's, as long as it is open
            left.append(self.path)
        self._connection.close()
        for file in left:
            file.unlink(missing_ok=True)

    def identity(self) -> dict[str, Any] | None:
        """Return the identity of the run, None for a new one."""
        rows = _sound(self._connection, "identity")
        return json.loads(rows[0][0]) if rows else None

    def identify(self, identity: dict[str, Any]) -> None:
        """Store the identity of the run."""
        self._insert("identity", json.dumps(identity))

    def put(self, stage: str, first: int, result: np.ndarray) -> None:
        """Keep the results of one batch, whose first item is ``first``; once this returns, they are safe on disk."""
        plain = np.ascontiguousarray(result, dtype=result.dtype.newbyteorder("<"))
        self._insert("batches", stage, first, len(result), zlib.compress(plain.view(np.uint8).data, _LEVEL))

    def get(self, stage: str, first: int, dtype: np.dtype) -> np.ndarray:
        """Return the results of the batch whose first item is ``first``, one of type ``dtype`` for each item."""
        query = "SELECT * FROM batches WHERE stage = ? AND first = ?"
        row = self._execute(query, (stage, first)).fetchone()
        if row is None or not _is_sound(row):
            raise OSError(f"{self.path}: stored results were damaged during the run; call again to repeat them")
        return np.frombuffer(zlib.decompress(row[3]), dtype.newbyteorder("<")).astype(dtype.base)

    def kept(self, stage: str) -> list[range]:
        """Return the batches whose results are kept and undamaged, in order; damaged ones are deleted."""
        kept, damaged = [], []
        for number, *row in self._execute("SELECT rowid, * FROM batches WHERE stage = ? ORDER BY first", (stage,)):
            if _is_sound(row):
                kept.append(range(row[1], row[1] + row[2]))
            else:
                damaged.append(number)
        for number in damaged:
            self._execute("DELETE FROM batches WHERE rowid = ?", (number,))
            self.say("damaged results thrown away: they are computed anew")
        return kept

    def say(self, message: str) -> None:
        """Add a line to the run's log."""
        self._insert("log", datetime.now(UTC).isoformat(timespec="seconds"), message)

    def log(self) -> xr.Dataset:
        """Return the log: ``time`` and ``message`` along ``entry``, without lines that were damaged."""
        times, messages = (np.array(column, dtype=object) for column in zip(*_sound(self._connection, "log")))
        return xr.Dataset({"time": ("entry", times), "message": ("entry", messages)})

    def _insert(self, table: str, *values: Any) -> None:
        """Add a row with its hash."""
        row = (*values, _hash(values))
        self._execute(f"INSERT OR REPLACE INTO {table} VALUES ({', '.join('?' * len(row))})", row)

    def _execute(self, command: str, values: tuple) -> sqlite3.Cursor:
        try:
            return self._connection.execute(command, values)
        except sqlite3.DatabaseError as error:
            raise OSError(
                f"{self.path}: the checkpoint could not be written ({error}); what was kept before is safe: "
                "make room on the disk and call again"
            ) from error


def _connect(path: Path) -> sqlite3.Connection:
    """Return an exclusive connection, in which each command is committed to the disk by itself."""
    connection = sqlite3.connect(path, timeout=0.0, isolation_level=None, check_same_thread=False)
    try:
        connection.execute("PRAGMA locking_mode = EXCLUSIVE")
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        _check(connection)
    except UnicodeDecodeError as error:  # by SQLite's own words, which quote what is damaged
        connection.close()
        raise sqlite3.DatabaseError("malformed") from error
    except BaseException:
        connection.close()
        raise
    return connection


def _check(connection: sqlite3.Connection) -> None:
    """Make the tables where there are none; raise a DatabaseError unless they can be relied on, row by row."""
    connection.text_factory = lambda text: text.decode(errors="backslashreplace")
    (verdict,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
    if verdict != "ok":
        raise sqlite3.DatabaseError(verdict)
    made = dict(connection.execute("SELECT name, sql FROM sqlite_schema WHERE sql NOT NULL"))
    if not made:
        for name, columns in _TABLES.items():
            connection.execute(f"CREATE TABLE {name} {columns}")
    elif made != {name: f"CREATE TABLE {name} {columns}" for name, columns in _TABLES.items()}:
        raise sqlite3.DatabaseError("other tables")
    count = connection.execute("SELECT count(*) FROM identity").fetchone()
    if count != (len(_sound(connection, "identity")),):
        raise sqlite3.DatabaseError("another identity")


def _sound(connection: sqlite3.Connection, table: str) -> list[tuple]:
    """Return the rows of a table that are as they were written, in that order, without their hashes."""
    return [row[:-1] for row in connection.execute(f"SELECT * FROM {table} ORDER BY rowid") if _is_sound(row)]


def _is_sound(row: Sequence[Any]) -> bool:
    return _hash(row[:-1]) == row[-1]


def _refuse_unless_damaged(error: sqlite3.DatabaseError, path: Path) -> None:
    if "locked" in str(error):
        raise BlockingIOError(
            f"{path}: another run writes to this output; wait for it, end it, or give the output another name"
        ) from error
    if isinstance(error, sqlite3.OperationalError) and "malformed" not in str(error):
        raise OSError(
            f"{path}: the checkpoint could not be opened ({error}): "
            "make room on its disk, see that you may write there, and call again"
        ) from error


def _put_aside(path: Path) -> Path:
    """Rename a damaged checkpoint and return its new name."""
    numbers = (n for n in range(1, 1000) if not path.with_name(f"{path.name}.damaged-{n}").exists())
    aside = path.with_name(f"{path.name}.damaged-{next(numbers)}")
    os.replace(path, aside)
    for file in _files(path):
        file.unlink(missing_ok=True)
    return aside


def _files(path: Path) -> list[Path]:
    """Return the files that SQLite may leave beside a database."""
    return [path.with_name(path.name + end) for end in ("-wal", "-shm", "-journal")]


def _hash(row: Sequence[Any]) -> bytes:
    """Return a hash of all values of a row, and of where one ends and the next begins."""
    digest = hashlib.blake2b(digest_size=16)
    for value in row:
        text = value if isinstance(value, bytes) else repr(value).encode()
        digest.update(f"{type(value).__name__} {len(text)} ".encode())
        digest.update(text)
    return digest.digest()
