"""Runs with checkpoints: a kill loses the batches being computed and those of the last second; the next call resumes.

Until the archive ``OUTPUT`` is complete, the folder ``OUTPUT.checkpoint`` next to it contains the identity of the run,
its log, and files of results, one for the batches of a second. An item is identified by a hash of everything that its
result depends on, a file by the hash of its items. Each file is written under a temporary name and renamed. Only the
main process writes, under a lock that is released when the process ends.
"""

from __future__ import annotations

import errno
import functools
import hashlib
import itertools
import json
import os
import shutil
import textwrap
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import dask
import filelock
import numpy as np
import xarray as xr

from .._version import __version__
from ..files.storage import atomic_write, remove_leftovers
from ..mechanics.jobs import spread
from ..mechanics.jobs.progress import print_line
from ..mechanics.jobs.spread import Failure, Tasks, contiguous
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.provenance import as_json, flat
from ..mechanics.vocabulary.refusal import FailedSubregions, Refusal
from . import archive

#: Results larger than this many bytes stay on the disk until the archive is written.
_IN_MEMORY = 2**24

#: Time (s) between two files of a solve's results: writing safely to a disk takes some 10 ms.
_BETWEEN_FILES = 1.0

#: Time (s) between two additions to the archive of an unfinished run: each copies and reads the file, in some 0.5 s.
_BETWEEN_ADDITIONS = 60.0

#: Attribute of the archive's root that contains the run's identity.
_IDENTITY = "run"


_FULL = "make room on the disk"
_NO_LOCKS = "choose an output on a file system that locks files"

#: Advice by the reason for which nothing can be written; else it is the folder's.
_ADVICE = dict.fromkeys((errno.ENOSPC, errno.EDQUOT, errno.EFBIG), _FULL)
_ADVICE |= dict.fromkeys((errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP), _NO_LOCKS)


def checkpointed(
    compute: Callable[[], Mapping[str, xr.Dataset] | Iterator[Mapping[str, xr.Dataset]]],
    output: str | os.PathLike,
    *,
    scan: xr.Dataset,
    arguments: Mapping[str, Any],
    title: str = "",
    missing: Callable[[], str] = lambda: "some of its groups are missing",
) -> dict[str, xr.Dataset]:
    """Compute the groups of an archive so that a kill costs only the places in progress and those of the last second.

    The results of every solve within ``compute`` (`direct`, `superpose`, `pull_off_map`, …) are stored in
    ``OUTPUT.checkpoint`` once a second, and at an interrupt. Called again after a crash, the run resumes from there; a
    finished run is read, not repeated. The values are bit by bit those that the same calls return without checkpoints.

    Parameters
    ----------
    compute : callable
        Returns the groups: names such as "solutions/direct", and Datasets. Or yields them in parts, which are written
        to the archive every minute and at an interrupt; until the last it is marked as unfinished. It must make
        the same calls when it resumes.
    output : path
        The archive, NetCDF-4. Each state of the file appears under this name once it is complete.
    scan : Dataset
        The scan, with its pair of bodies, that the groups are computed from.
    arguments : mapping
        All further arguments that the groups depend on. The same output is refused for another scan or other arguments;
        a finished run with the same ones is read without a call of ``compute``.
    title : str
        Stored as an attribute of the archive.
    missing : callable, optional
        Where ``compute`` yields: returns in words what is missing so far.

    Returns
    -------
    dict of str to Dataset
        The groups as the archive contains them, and ``log``: when the run was started, resumed and finished, and what
        failed. Fields are read from the file when they are used.

    Raises
    ------
    ValueError
        If ``output`` is damaged, or contains another run; the message states the arguments in which they differ.
    BlockingIOError
        If another process is computing the same output.
    OSError
        If the disk is full: call again afterwards.
    RuntimeError
        If subregions failed; the results of the others are stored.

    Examples
    --------
    >>> from pathlib import Path
    >>> import roughxr
    >>> import roughxr, tempfile
    >>> scan = roughxr.assign_pair(
    ...     roughxr.open_sample("glass"), sphere_radius=3000, young_modulus=75, poisson_ratio=0.22)
    >>> options = {"delta": [20.0, 40.0], "subregions": (2, 2)}
    >>> groups = roughxr.checkpointed(
    ...     lambda: {"solutions/direct": roughxr.direct(scan, **options)},
    ...     Path(tempfile.mkdtemp()) / "run.nc", scan=scan, arguments=options)
    >>> dict(groups["solutions/direct"].force.sizes)
    {'subregion': 4, 'delta': 2}
    """
    output = Path(output)
    identity = _identity(schema.in_package_units(scan), arguments)
    is_finished = output.exists() and archive.UNFINISHED not in _matching_root(output, identity)
    if is_finished and not _folder(output).exists():  # nothing is written, such as in a read-only folder
        return archive.load(output)
    written: Mapping[str, xr.Dataset] | None = None
    with Checkpoint(output) as checkpoint:
        if not output.exists() or archive.UNFINISHED in _matching_root(output, identity):
            resumed = checkpoint.begin(identity)
            attrs = {"title": title, _IDENTITY: _lines(identity)}
            try:
                with spread.compute_with(checkpoint):
                    written = _write(compute(), checkpoint, output, attrs, missing)
            except Exception:
                if not (resumed or checkpoint.stored):  # an option was refused before anything was computed
                    output.unlink(missing_ok=True)
                    checkpoint.finished = True
                raise
        checkpoint.finished = True
    return archive.load(output) if written is None else dict(written)


def _matching_root(output: Path, identity: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of an archive's root; raise if it is another run's."""
    root = archive.root_attributes(output)
    _refuse_other(_settings(root.get(_IDENTITY, "")), identity, output)
    return root


def _folder(output: Path) -> Path:
    """Return the folder of an unfinished run."""
    return output.with_name(output.name + ".checkpoint")


def _write(
    parts, checkpoint: Checkpoint, output: Path, attrs: dict[str, str], missing: Callable[[], str]
) -> Mapping[str, xr.Dataset] | None:
    """Write groups as they are computed, at intervals, except those that an unfinished archive contains.

    Return the archive's groups if all were written at once, else None. Groups that a kill loses are computed again from
    the stored results of their solves.
    """
    groups: dict[str, xr.Dataset] = {}
    written = time.monotonic()

    def add(unfinished: str | None) -> Mapping[str, xr.Dataset]:
        with dask.config.set(scheduler=dask.get):
            return archive.add(groups, output, {**attrs, archive.UNFINISHED: unfinished}, onto=output.exists())

    try:
        for part in [parts] if isinstance(parts, Mapping) else parts:
            groups |= part
            if part is not parts and time.monotonic() - written > _BETWEEN_ADDITIONS:
                add(missing())
                written = time.monotonic()
    except BaseException as error:
        if groups and not isinstance(error, OSError):  # such as of a full disk
            add(missing())
        raise
    checkpoint.log("all computed")
    groups["log"] = checkpoint.logged()
    is_new = not output.exists()
    added = add(None)
    return added if is_new else None


class Checkpoint:
    """The folder of an unfinished run beside ``output``, locked within its ``with`` block.

    It computes the tasks of the run's solves except those whose results are stored, and stores each batch.
    """

    def __init__(self, output: Path):
        self.output = output
        self.path = _folder(output)
        self.finished = False  # then the folder is removed
        self.stored: dict[str, tuple[str, int]] = {}  # file and row of each item's result
        self._unwritten: list[tuple[list[str], np.ndarray]] = []  # items and results of batches
        self._written = time.monotonic()
        self._lock = filelock.FileLock(self.path / "lock", timeout=0)

    def __enter__(self) -> Checkpoint:
        with self._writing():
            self.path.mkdir(parents=True, exist_ok=True)
            try:
                self._lock.acquire()
            except filelock.Timeout:
                raise BlockingIOError(
                    f"{self.path}: another run writes to this output; wait for it, end it, or choose another output"
                ) from None
        remove_leftovers(self.output.parent, self.output.name)
        remove_leftovers(self.path)
        return self

    def __exit__(self, *_) -> None:
        ended = self.finished or not (self.path / "identity.json").exists()
        for file in self.path.iterdir() if ended else ():
            if file.name != "lock":
                file.unlink(missing_ok=True)
        self._lock.release()
        if ended:
            shutil.rmtree(self.path, ignore_errors=True)

    def begin(self, identity: Mapping[str, Any]) -> bool:
        """Log that the run begins or resumes, and return whether it resumes; raise if another run's is stored."""
        file = self.path / "identity.json"
        stored = None
        try:
            stored = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
        except ValueError:
            print_line(f"{self.path}: its settings are damaged: everything is computed again")
            for batch in self.path.glob("*.npz"):
                batch.unlink()
        if stored is None:
            with self._writing(), atomic_write(file, is_own=True) as temporary:
                temporary.write_text(json.dumps(identity), encoding="utf-8")
        else:
            _refuse_other(stored, identity, self.path)
        self.log("begun" if stored is None else "resumed")
        for batch in sorted(self.path.glob("*.npz")):
            self._note(batch.name, self._read(batch.name)[0])
        return stored is not None

    def put(self, items: Sequence[str], results: np.ndarray) -> None:
        """Store the results of a batch; once this returns, they are safe on disk."""
        name = _file_name(items)
        with (
            self._writing(),
            atomic_write(self.path / name, is_own=True) as temporary,
            temporary.open("wb") as file,
        ):
            np.savez_compressed(file, items=np.array(items), results=results)
        self._note(name, items)

    def _collect(self, items: list[str], results: np.ndarray) -> None:
        """Store the results of a batch, together with those of the same second."""
        self._unwritten.append((items, results))
        is_large = len(self._unwritten) * results.nbytes > _IN_MEMORY
        if is_large or time.monotonic() - self._written > _BETWEEN_FILES:
            self._write()

    def _write(self) -> None:
        """Store the batches that were collected."""
        if self._unwritten:
            items, results = zip(*self._unwritten)
            self.put([*itertools.chain(*items)], np.concatenate(results))
        self._unwritten.clear()
        self._written = time.monotonic()

    def get(self, items: Sequence[str], dtype: np.dtype) -> np.ndarray:
        """Return the stored results of some items."""
        results = np.empty(len(items), dtype)
        for name in {self.stored[item][0] for item in items}:
            _, batch = self._read(name)
            if batch is None:
                raise OSError(f"{self.path / name}: it was damaged during the run; call again to repeat it")
            for k, item in enumerate(items):
                file, row = self.stored[item]
                if file == name:
                    results[k] = batch[row]
        return results

    def _read(self, name: str) -> tuple[list[str], np.ndarray | None]:
        """Return items and results of a batch; remove a damaged or foreign file, and log it."""
        try:
            with np.load(self.path / name, allow_pickle=False) as file:
                items = file["items"].tolist()
                results = file["results"]
            if name != _file_name(items) or len(items) != len(results):
                raise ValueError("another batch")
            return items, results
        except Exception:  # of NumPy, zipfile or zlib
            self.log(f"{name}: damaged or foreign, removed: its results are computed anew")
            (self.path / name).unlink(missing_ok=True)
            return [], None

    def _note(self, name: str, items: Sequence[str]) -> None:
        self.stored |= {item: (name, row) for row, item in enumerate(items)}

    def log(self, message: str) -> None:
        """Add a line to the run's log."""
        with self._writing(), (self.path / "log").open("a", encoding="utf-8") as file:
            file.write(f"{datetime.now(UTC).isoformat(timespec='seconds')} {' '.join(message.split())}\n")

    def logged(self) -> xr.Dataset:
        """Return the log: ``time`` and ``message`` along ``entry``."""
        lines = (self.path / "log").read_text(encoding="utf-8", errors="replace").splitlines()
        columns = zip(*(line.partition(" ")[::2] for line in lines))
        return xr.Dataset({key: ("entry", np.array(v, dtype=object)) for key, v in zip(("time", "message"), columns)})

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except BlockingIOError:
            raise
        except (OSError, NotImplementedError) as error:
            advice = _ADVICE.get(getattr(error, "errno", errno.ENOLCK), "choose a folder in which you may write")
            raise OSError(
                f"{self.path}: the checkpoint could not be written ({error}); finished results are safe: {advice}, "
                "and call again"
            ) from error

    def array(self, work: Tasks) -> Any:
        """Return the results, in memory or, if they are large, lazily from the checkpoint."""
        items = item_keys(work)
        missing = [k for k, item in enumerate(items) if item not in self.stored]
        if missing:
            self._compute(work, items, missing)
        if len(items) * work.dtype.itemsize <= _IN_MEMORY:
            return self.get(items, work.dtype)
        read = dask.delayed(self.get, pure=False)
        return spread.concatenate([(read(batch, work.dtype), len(batch)) for batch in work.batches(items)], work.dtype)

    def _compute(self, work: Tasks, items: list[str], missing: list[int]) -> None:
        failed = dict[str, int]()
        total = work.each * len(items)
        begun = time.monotonic()
        self._written = begun

        def receive(batch: Sequence[int], result: Any) -> None:
            if isinstance(result, Failure):
                first = batch[0] * work.each
                last = (batch[-1] + 1) * work.each - 1
                label = f"subregion {first}" if first == last else f"subregions {first} to {last}"
                failed[f"{label}: {result.reason}"] = work.each * len(batch)
                self.log(f"{work.name}: {label} failed: {result.reason}")
            else:
                self._collect([items[k] for k in batch], result)

        self.log(f"{work.name}: {total - work.each * len(missing)} of {total} subregions kept")
        try:
            spread.compute_each(work, missing, receive)
        finally:
            self._write()
        lost = sum(failed.values())
        took = time.monotonic() - begun
        self.log(f"{work.name}: {total - lost}/{total} subregions, {lost} failed, {took:.3g} s")
        if failed:
            raise FailedSubregions(
                f"{work.name}: {lost} of {total} subregions failed, first {next(iter(failed))}; the "
                "results of the others are stored: remove the cause and call again"
            )

    def finish(self, ds: xr.Dataset) -> xr.Dataset:
        """Return a result with its scalars in memory, and its fields still on the disk."""
        fields = [name for name, array in ds.data_vars.items() if {"subregion", "x", "y"} <= set(array.dims)]
        scalars = ds.drop_vars(fields).compute(scheduler=dask.get)
        return scalars.assign({name: ds[name] for name in fields}) if fields else scalars


def item_keys(work: Tasks) -> list[str]:
    """Return a hash for each item, of everything that its result depends on."""
    task = f"{work.task.__module__}.{work.task.__qualname__}"
    with dask.config.set({"tokenize.ensure-deterministic": True}):
        # contiguous, since dask takes a square array and its transpose for the same
        common = dask.base.tokenize(task, str(work.dtype), *map(contiguous, work.shared))
        return [dask.base.tokenize(common, *map(contiguous, values)) for values in work.arguments]


def _file_name(items: Sequence[str]) -> str:
    return f"{dask.base.tokenize(list(items))}.npz"


def _identity(scan: xr.Dataset, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the identity of a run: plain values, by name."""
    names = (scan.attrs.get(key) for key in ("title", "source_file", "source"))
    identity: dict[str, Any] = {"scan": next((str(name) for name in names if name), "scan without a title")}
    identity["scan_sha256"] = schema.height_hash(scan)
    identity |= {name: float(value) for name, value in schema.pair_coordinates(scan).items()}
    if "indenter_height" in scan:
        identity["indenter"] = dask.base.tokenize(*(scan[f"indenter_{part}"].values for part in ("x", "y", "height")))
    identity |= {key: as_json(value, _with_hash) for key, value in arguments.items()}
    return json.loads(json.dumps({**flat(identity), "roughxr": f"{__version__} (source {source_digest()})"}))


def _lines(identity: Mapping[str, Any]) -> str:
    """Return the identity of a run as text, a line for each setting."""
    return "\n".join(f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in identity.items())


def _settings(text: str) -> dict[str, Any]:
    """Return the identity of a run from its text; other text is no identity."""
    parts = (line.partition(" = ") for line in text.splitlines())
    try:
        return {name: json.loads(value) for name, _, value in parts}
    except ValueError:
        return {"settings": "unreadable"}


@functools.cache
def source_digest() -> str:
    """Return a digest of the package's source, so that two states of it never mix in one archive."""
    root = Path(__file__).parents[1]
    digest = hashlib.blake2b(digest_size=6)
    for file in sorted(root.rglob("*.py")):
        digest.update(file.relative_to(root).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


def _with_hash(array: np.ndarray) -> str:
    """Return a description that is unique to a long array."""
    return f"{array.size} values from {array.flat[0]:g} to {array.flat[-1]:g}, {dask.base.tokenize(array)[:12]}"


def _refuse_other(stored: Mapping[str, Any], wanted: Mapping[str, Any], path: Path) -> None:
    """Raise if the run on disk is another one; the message lists the differences."""
    different = [key for key in {**wanted, **stored} if stored.get(key) != wanted.get(key)]
    if not different:
        return
    plain = [key for key in different if not {type(run.get(key)) for run in (wanted, stored)} & {list, dict}]
    named = [key for key in plain if key != "scan_sha256" and " values from " not in str(wanted.get(key))]
    shown = (named or different)[:4]
    expected, existing = (
        ", ".join(textwrap.shorten(f"{key} {run.get(key)}", 80, placeholder="…") for key in shown)
        for run in (wanted, stored)
    )
    difference = f"a run with other settings: {existing}, instead of {expected}"
    if not any(key in wanted and key in stored for key in shown):  # such as resting positions in place of a grid
        difference = f"a run with other {', '.join(dict.fromkeys(key.partition('.')[0] for key in shown))}"
    raise Refusal(path, "no file or the same run", difference, "choose another output, or remove the file")
