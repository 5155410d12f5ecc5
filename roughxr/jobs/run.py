"""A run with checkpoints: kept results are read, missing ones computed and kept, and groups written as they are whole.

Only the main process writes. Whatever stops the run costs at most the batches in flight; called again, it resumes.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import dask
import numpy as np
import xarray as xr

from .. import archive
from ..files import disk
from ..vocabulary.verbs import verb
from . import lazy as parallel
from .checkpoint import Checkpoint
from .executor import Failure, each_finished
from .fingerprint import identity, keys_of, refuse_other
from .progress import say
from .schedulers import on
from .work import Work, in_memory, stacked

#: Results larger than this many bytes stay on the disk until the archive is written.
_IN_MEMORY = 2**24

#: Subregions whose scalars are read at once where they are stored among fields.
_SLAB = 256

#: Whether solves return stored results only, and compute nothing.
_ONLY_KEPT: ContextVar[bool] = ContextVar("only_kept", default=False)

#: Attribute of the archive's root that holds the run's identity.
_IDENTITY = "run"


@verb
def checkpointed(
    compute: Callable[[], Mapping[str, xr.Dataset] | Iterator[Mapping[str, xr.Dataset]]],
    output: str | os.PathLike,
    *,
    scan: xr.Dataset,
    arguments: Mapping[str, Any] | None = None,
    title: str = "",
    scheduler: str | None = None,
    missing: Callable[[], str] | None = None,
) -> dict[str, xr.Dataset]:
    """Compute the groups of an archive so that a crash costs only the batches in flight.

    The results of every solve within ``compute`` (`direct`, `superpose`, `pull_off_map`, …) are kept in
    ``OUTPUT.checkpoint`` as they finish, in batches of subregions that take about half a second. Called again after a
    crash, the run resumes from there; a finished run is read, not repeated. The values are bit by bit those that the
    same calls return without checkpoints.

    Parameters
    ----------
    compute : callable
        Returns the groups: names such as "solutions/direct", and Datasets. Or yields them in parts, each written
        to the archive, which is marked as unfinished until the last. It is called again to resume, and must then make
        the same calls.
    output : path
        The archive, NetCDF-4. Each state of the file appears under this name once it is complete.
    scan : Dataset
        The scan, with its pair of bodies, that the groups are computed from: the same output is refused for another
        scan.
    arguments : mapping, optional
        Further arguments that the groups depend on, by name: the same output is refused for other arguments.
    title : str
        Stored as an attribute of the archive.
    scheduler : str, optional
        "threads", "processes", "synchronous", or the address of a ``dask scheduler`` such as
        "tcp://node1:8786". By default the active ``distributed.Client``, else what dask is configured for.
    missing : callable, optional
        Where ``compute`` yields: returns in words what is missing so far, stored in the unfinished archive.

    Returns
    -------
    dict of str to Dataset
        The groups as the archive holds them, and ``log``: when the run was started, resumed and finished, and what
        failed. Fields are read from the file when they are used.

    Raises
    ------
    ValueError
        If ``output`` is damaged, or holds another run; the message says in which arguments they differ.
    BlockingIOError
        If another process is computing the same output.
    OSError
        If the disk is full: the kept results are safe, call again when there is room; or if no scheduler answers.
    RuntimeError
        If subregions failed; the results of the others are kept.

    Examples
    --------
    >>> import roughxr, tempfile
    >>> scan = roughxr.assign_pair(
    ...     roughxr.open_sample("glass"), sphere_radius=3000, young_modulus=75, poisson_ratio=0.22)
    >>> options = {"delta": [5.0, 10.0], "subregions": (2, 2)}
    >>> groups = checkpointed(
    ...     lambda: {"solutions/direct": roughxr.direct(scan, **options)},
    ...     Path(tempfile.mkdtemp()) / "run.nc", scan=scan, arguments=options)
    >>> dict(groups["solutions/direct"].force.sizes)
    {'subregion': 4, 'delta': 2}
    """
    output = Path(output)
    asked = identity(scan, arguments or {})
    checkpoint, finished = Checkpoint(output), False
    try:
        root = _root_of(output) if output.exists() else {archive.UNFINISHED: "nothing"}
        if output.exists():
            refuse_other(json.loads(root.get(_IDENTITY, "{}")), asked, output)
        if archive.UNFINISHED in root:
            attrs = {"title": title, _IDENTITY: json.dumps(asked)}
            with on(scheduler), parallel.computed_by(_WithCheckpoints(checkpoint)):
                _begin(checkpoint, output, asked)
                _write(compute(), checkpoint, output, attrs, missing or (lambda: "some of its groups are missing"))
        finished = True
    finally:
        checkpoint.close(remove=finished or not checkpoint.identity())
    return archive.load(output)


def _write(found, checkpoint: Checkpoint, output: Path, attrs: dict[str, str], missing: Callable[[], str]) -> None:
    """Write the groups as they are found; those that an unfinished archive has are as they were written."""
    groups: dict[str, xr.Dataset] = {}
    for more in () if isinstance(found, Mapping) else found:
        groups |= more
        _add(groups, output, {**attrs, archive.UNFINISHED: missing()})
    checkpoint.say("all computed")
    groups |= found if isinstance(found, Mapping) else {}
    groups["log"] = checkpoint.log()
    _add(groups, output, {**attrs, archive.UNFINISHED: None})


def _add(groups: Mapping[str, xr.Dataset], output: Path, attrs: dict[str, Any]) -> None:
    """Write the groups that an archive lacks, and say what it is in the attributes of its root."""
    with dask.config.set(scheduler="synchronous"):
        if not output.exists():
            archive.save(groups, output, attrs={name: one for name, one in attrs.items() if one is not None})
            return
        with disk.raw(output) as file:
            there = set(disk.names_in(file))
        archive.add({name: ds for name, ds in groups.items() if name not in there}, output, attrs)


def _root_of(output: Path) -> dict[str, Any]:
    """Return what the root of an archive says; nothing for a file that no run wrote."""
    with output.open("rb") as file:
        if file.read(4) != b"\x89HDF":
            return {}
    archive.verify(output)
    return archive.root_of(output)


def _begin(checkpoint: Checkpoint, output: Path, asked: dict[str, Any]) -> None:
    """Log that the run begins or resumes; raise if the output belongs to another run."""
    known = checkpoint.identity()
    if known is None:
        checkpoint.identify(asked)
        checkpoint.say("begun")
    else:
        refuse_other(known, asked, checkpoint.path)
        checkpoint.say("resumed")
        for leftover in disk.leftovers(output):
            leftover.unlink(missing_ok=True)


@contextmanager
def only_kept() -> Iterator[None]:
    """Let the solves of a checkpointed run return what is kept within the block, and NaN for all else."""
    token = _ONLY_KEPT.set(True)
    try:
        yield
    finally:
        _ONLY_KEPT.reset(token)


def _unknown(count: int, dtype: np.dtype) -> np.ndarray:
    """Return results without values: NaN, and False or 0 where there is no NaN."""
    unknown = np.zeros(count, dtype)
    for name in dtype.names or [...]:
        if unknown[name].dtype.kind == "f":
            unknown[name] = np.nan
    return unknown


class _WithCheckpoints:
    """Computes the tasks of a run's solves except those whose results are kept, and keeps each batch as it finishes."""

    def __init__(self, checkpoint: Checkpoint):
        self.checkpoint = checkpoint
        self.known: dict[bytes, np.ndarray] = {}  # results by item: a place that two solves share is solved once

    def array(self, work: Work) -> Any:
        """Return the results, in memory or, if they are large, lazily from the checkpoint."""
        work = in_memory(work)
        stage, items = keys_of(work)
        kept = {k for batch in self.checkpoint.kept(stage) for k in batch}
        for k in (k for k, item in enumerate(items) if k not in kept and item in self.known):
            self.checkpoint.put(stage, k, self.known[items[k]][np.newaxis])
            kept.add(k)
        missing = [k for k in range(len(items)) if k not in kept]
        if _ONLY_KEPT.get():
            say(f"{work.name}: {work.each * len(kept)} subregions kept")
        elif missing:
            self._compute(work, stage, missing)
        else:
            say(f"{work.name}: {work.each * len(work.arguments)} subregions, all kept")
        batches = self.checkpoint.kept(stage)
        if len(work.arguments) * work.dtype.itemsize <= _IN_MEMORY:
            results = _unknown(len(items), work.dtype)
            for batch in batches:
                results[batch.start : batch.stop] = self.checkpoint.get(stage, batch.start, work.dtype)
            self.known |= {items[k]: results[k] for batch in batches for k in batch}
            return results
        read = dask.delayed(self.checkpoint.get, pure=False)
        return stacked([(read(stage, batch.start, work.dtype), len(batch)) for batch in batches], work.dtype)

    def _compute(self, work: Work, stage: str, missing: list[int]) -> None:
        failures, total = [], work.each * len(work.arguments)

        def receive(batch: range, result: Any) -> None:
            if isinstance(result, Failure):
                failures.append(f"{_subregions(work, batch[0])}: {result.reason}")
                self.checkpoint.say(f"{work.name}: {_subregions(work, batch[0])} failed: {result.reason}")
            else:
                self.checkpoint.put(stage, batch[0], result)

        self.checkpoint.say(f"{work.name}: {total - work.each * len(missing)} of {total} subregions kept")
        progress = each_finished(work, missing, receive)
        self.checkpoint.say(f"{work.name}: {progress.text()}, {progress.seconds():.3g} s")
        if failures:
            raise RuntimeError(
                f"{work.name}: {progress.failed} of {total} subregions failed, first {failures[0]}; the "
                "results of the others are kept: remove the cause and call again"
            )

    def finish(self, ds: xr.Dataset) -> xr.Dataset:
        """Return a result with its scalars in memory, and its fields still on the disk."""
        fields = [name for name, array in ds.data_vars.items() if {"subregion", "x", "y"} <= set(array.dims)]
        scalars = _in_slabs(ds.drop_vars(fields)) if fields else ds.compute(scheduler="synchronous")
        return scalars.assign({name: ds[name] for name in fields})


def _in_slabs(ds: xr.Dataset) -> xr.Dataset:
    """Compute variables cut out of larger chunks, some hundred subregions at a time: all would not fit in memory."""
    slabs = (ds.isel(subregion=slice(k, k + _SLAB)) for k in range(0, ds.sizes["subregion"], _SLAB))
    computed = [slab.compute(scheduler="synchronous") for slab in slabs]
    return xr.concat(computed, "subregion", data_vars="minimal", coords="minimal", compat="override")


def _subregions(work: Work, item: int) -> str:
    """Return the name of the subregions that an item holds."""
    first = item * work.each
    return f"subregion {first}" if work.each == 1 else f"subregions {first} to {first + work.each - 1}"
