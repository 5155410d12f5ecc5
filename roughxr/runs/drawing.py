"""A run's figures, drawn by another process while the last of its places are solved."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import xarray as xr

from .. import archive, figures, report

#: What the other process runs, with archive, folder, and module and name of the function that yields the figures.
_COMMAND = "import sys; from roughxr.runs.drawing import _as_asked; _as_asked(*sys.argv[1:])"


class Drawing:
    """The figures of a run that do not depend on its error budget."""

    def __init__(self, path: Path, folder: Path | None, drawn: Callable = figures.run_figures):
        self.path, self.folder, self.drawn = path, folder, drawn
        self.pictures: Mapping[str, report.Picture] = {}  # of the page, where another process has drawn all

    @contextmanager
    def beside(self) -> Iterator[None]:
        """Draw from the unfinished archive in another process during the block; what ends the block early ends it too.

        A thread would not do: matplotlib holds Python's lock. Where the process fails, all is drawn in `finish`.
        """
        if self.folder is None or os.cpu_count() == 1 or getattr(sys, "frozen", False):
            yield
            return
        asked = [str(self.path), str(self.folder), self.drawn.__module__, self.drawn.__name__]
        paths = os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
        how: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        how["env"] = os.environ | {"PYTHONPATH": paths.rstrip(os.pathsep)}
        with (
            TemporaryFile() as found,  # a pipe would hold the other process up until it is read
            subprocess.Popen([sys.executable, "-c", _COMMAND, *asked], stdout=found, **how) as other,
        ):
            try:
                yield
                other.wait()
            except BaseException:
                other.kill()
                raise
            if other.returncode == 0:
                found.seek(0)
                self.pictures = pickle.load(found)

    def finish(self, groups: Mapping[str, xr.Dataset]) -> None:
        """Draw into the folder what is not drawn yet."""
        assert self.folder is not None
        if not self.pictures:
            _draw(groups, self.folder, self.drawn)
        for name, figure in figures.budget_figures(groups):
            figures.save(figure, self.folder / f"{name}.png", dpi=220)


def _draw(groups: Mapping[str, xr.Dataset], folder: Path, drawn: Callable) -> None:
    groups["solutions/contact"].load()  # else each of its figures reads the fields from the file again
    figures.save(figures.overview(groups), folder / "overview.png", dpi=150)
    for name, figure in drawn(groups):
        figures.save(figure, folder / f"{name}.png")


def _as_asked(path: str, folder: str, module: str, name: str) -> None:
    """Draw the figures from an archive, and write those of the page to standard output."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the archive is not finished
        groups = {name: ds.load() for name, ds in archive.load(path).items()}
    _draw(groups, Path(folder), getattr(import_module(module), name))
    sys.stdout.buffer.write(pickle.dumps(report.drawn_pictures(groups)))
