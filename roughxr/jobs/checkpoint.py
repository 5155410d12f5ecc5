"""What a run keeps until it is finished: results, identity and log in one SQLite file, which is also its lock.

SQLite commits a batch wholly or not at all, through crashes and power cuts, and its lock ends with the process that
holds it, however that ends: there are no stale locks. Results that were changed on the disk, which SQLite does not
notice, are found by the hash that is kept with each.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import zlib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

_TABLES = """
    CREATE TABLE IF NOT EXISTS identity (text TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS log (time TEXT NOT NULL, message TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS batches (
        stage TEXT NOT NULL, first INTEGER NOT NULL, count INTEGER NOT NULL, hash BLOB NOT NULL, data BLOB NOT NULL,
        PRIMARY KEY (stage, first)
    );
"""

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
        """Close the file, and remove it when the run is finished."""
        if remove:
            self.path.unlink(missing_ok=True)
        self._connection.close()
        if remove:
            for file in _files(self.path):
                file.unlink(missing_ok=True)

    def identity(self) -> dict[str, Any] | None:
        """Return the identity of the run, None for a new one."""
        row = self._connection.execute("SELECT text FROM identity").fetchone()
        return None if row is None else json.loads(row[0])

    def identify(self, identity: dict[str, Any]) -> None:
        """Store the identity of the run."""
        self._write("INSERT INTO identity VALUES (?)", (json.dumps(identity),))

    def put(self, stage: str, first: int, result: np.ndarray) -> None:
        """Keep the results of one batch, whose first item is ``first``; once this returns, they are safe on disk."""
        plain = np.ascontiguousarray(result, dtype=result.dtype.newbyteorder("<"))
        data = zlib.compress(plain.view(np.uint8), _LEVEL)
        row = (stage, first, len(result), _hash(data), data)
        self._write("INSERT OR REPLACE INTO batches VALUES (?, ?, ?, ?, ?)", row)

    def get(self, stage: str, first: int, dtype: np.dtype) -> np.ndarray:
        """Return the results of the batch whose first item is ``first``, one of type ``dtype`` for each item."""
        query = "SELECT data FROM batches WHERE stage = ? AND first = ?"
        (data,) = self._connection.execute(query, (stage, first)).fetchone()
        return np.frombuffer(zlib.decompress(data), dtype.newbyteorder("<")).astype(dtype.base)

    def kept(self, stage: str) -> list[range]:
        """Return the batches whose results are kept and undamaged, in order; damaged ones are deleted."""
        kept, damaged = [], []
        query = "SELECT first, count, hash, data FROM batches WHERE stage = ? ORDER BY first"
        for first, count, expected, data in self._connection.execute(query, (stage,)):
            (kept if _hash(data) == expected else damaged).append(range(first, first + count))
        for batch in damaged:
            self._write("DELETE FROM batches WHERE stage = ? AND first = ?", (stage, batch.start))
            self.say(f"damaged results {batch.start} to {batch.stop - 1} thrown away")
        return kept

    def say(self, message: str) -> None:
        """Add a line to the run's log."""
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self._write("INSERT INTO log VALUES (?, ?)", (now, message))

    def log(self) -> xr.Dataset:
        """Return the log: ``time`` and ``message`` along ``entry``."""
        rows = self._connection.execute("SELECT time, message FROM log ORDER BY rowid").fetchall()
        times, messages = (np.array(column, dtype=object) for column in zip(*rows))
        return xr.Dataset({"time": ("entry", times), "message": ("entry", messages)})

    def _write(self, command: str, values: tuple) -> None:
        try:
            self._connection.execute(command, values)
        except sqlite3.OperationalError as error:
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
        (verdict,) = connection.execute("PRAGMA quick_check(1)").fetchone()
        if verdict != "ok":
            raise sqlite3.DatabaseError(verdict)
        connection.executescript(_TABLES)
    except BaseException:
        connection.close()
        raise
    return connection


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


def _hash(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=16).digest()
