"""How kernels are compiled: all options in one place, and a word to who waits for it.

Compilation happens on the first call, never on import, and is cached on disk. Kernels release the GIL
and are serial: parallelism belongs to dask alone, since two parallel layers at once (``parallel=True``
below dask threads) can abort the process.

Kernels are called by Python and by kernels only. They are compiled in the quick way of `linked`, which builds on names
of Numba's that are not public, where Numba's version is one that it was tried with and the names are there. Otherwise,
or with ROUGHXR_PLAIN_NUMBA=1 in the environment, by ``numba.njit`` alone: the same kernels, and two to three times
as long a first call (`tests/benchmarks/first_answer.py`).

What is kept on disk holds all that a kernel calls, and Numba asks only whether the kernel's own file has changed. After
an upgrade, which leaves kept files in place, old code would give numbers without a word. So kernels are kept under a
name that changes with the source of any.
"""

import hashlib
import os
import sys
import time
from multiprocessing import parent_process
from pathlib import Path

import numba
from numba import njit

try:
    from numba.core.event import Listener, register
except ImportError:  # nobody is told then
    Listener, register = object, lambda *_: None

#: Ordinary kernels: IEEE arithmetic, division by zero gives inf or NaN as in NumPy. None is called from C.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}

#: What a sum may be allowed for speed: another order, and fused multiply-add. NaN and inf keep their meaning.
_REORDER = {"reassoc", "contract", "arcp", "nsz"}

#: Seconds of compilation after which it is told.
_SILENT_SECONDS = 1.0

_cached = True


#: The versions of Numba that `linked` was tried with: the first, and the first beyond.
_TESTED = (0, 63), (0, 69)


def _quick():
    """Return the quicker compiler, None where it is not known to work."""
    try:
        version = tuple(map(int, numba.__version__.split(".")[:2]))
        if os.environ.get("ROUGHXR_PLAIN_NUMBA", "0") not in ("", "0") or not _TESTED[0] <= version < _TESTED[1]:
            return None
        from . import linked
    except Exception:  # whatever a missing or changed name leads to
        return None
    return linked.Kernel


_compiler = _quick()


def _digest(folder):
    """Return some digits that stand for the text of all modules in a folder and below."""
    files = sorted(folder.rglob("*.py"))  # none where they are in an archive
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:8]


_source = _digest(Path(__file__).parent)


def kernel(function=None, *, reorder=False):
    """Compile ``function`` on its first call; with ``reorder`` sums may be reordered, so that loops vectorise."""
    if function is None:
        return lambda function: kernel(function, reorder=reorder)
    options = dict(_OPTIONS, fastmath=_REORDER) if reorder else _OPTIONS
    function.__qualname__ = f"{function.__qualname__.split('@')[0]}@{_source}"  # by which Numba names what it keeps
    compiled = njit(**options)(function)
    if not hasattr(compiled, "py_func"):
        return compiled  # with NUMBA_DISABLE_JIT it is the function itself
    if _compiler is not None:
        compiled = _compiler(function, targetoptions=compiled.targetoptions)
    return with_cache(compiled)


def with_cache(compiled):
    """Keep what is compiled on disk; where nothing can be written there, in memory only."""
    global _cached
    try:
        compiled.enable_caching()
    except RuntimeError:  # numba's, if it finds no place
        _cached = False
    return compiled


class _Notice(Listener):
    """Says once on standard error that compiling takes a while, from the process that the user looks at."""

    def __init__(self):
        self.depth, self.begun, self.spent, self.told = 0, 0.0, 0.0, parent_process() is not None

    def on_start(self, started):
        """Count in; numba calls this when it begins to compile a function, not when it finds one in the cache."""
        if not started.data["dispatcher"].__module__.startswith(__package__):
            return
        if self.depth == 0:
            self.begun = time.monotonic()
        self.depth += 1
        self._tell()

    def on_end(self, ended):
        """Count out."""
        if not ended.data["dispatcher"].__module__.startswith(__package__):
            return
        self._tell()
        self.depth -= 1
        if self.depth == 0:
            self.spent += time.monotonic() - self.begun

    def _tell(self):
        if self.told or self.spent + time.monotonic() - self.begun < _SILENT_SECONDS:
            return
        self.told = True
        lost = "NOT kept, every process does it anew: set NUMBA_CACHE_DIR to a folder that can be written to"
        kept = "kept for later" if _cached else lost
        print(f"roughxr: compiling once (up to a minute), {kept}", file=sys.stderr, flush=True)


register("numba:compile", _Notice())
