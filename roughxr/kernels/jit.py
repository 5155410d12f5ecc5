"""How kernels are compiled: all options in one place, and a word to who waits for it.

Compilation happens on the first call, never on import, and is cached on disk. Kernels release the GIL
and are serial: parallelism belongs to dask alone, since two parallel layers at once (``parallel=True``
below dask threads) can abort the process.
"""

import gc
import sys
import time
from multiprocessing import parent_process

from numba import njit, types
from numba.core import event
from numba.core.registry import CPUDispatcher

#: Ordinary kernels: IEEE arithmetic, division by zero gives inf or NaN as in NumPy. None is called from C.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}

#: What a sum may be allowed for speed: another order, and fused multiply-add. NaN and inf keep their meaning.
_REORDER = {"reassoc", "contract", "arcp", "nsz"}

#: Seconds of compilation after which it is told.
_PATIENCE = 1.0

_cached = True


def kernel(function=None, *, inner=False, reorder=False, inline=False):
    """Compile ``function`` on its first call.

    Parameters
    ----------
    inner : bool
        Called by kernels only, never from Python: an entry for Python costs each some 0.1 s of compilation, more where
        tuples of arrays pass through it.
    reorder : bool
        Let sums be reordered, so that loops over cells vectorise.
    inline : bool
        Compile as a part of its callers: for long functions that are called in one place. LLVM optimises all that
        a function calls anew with each caller, so that every level of long functions adds seconds to the first call.
    """
    if function is None:
        return lambda function: kernel(function, inner=inner, reorder=reorder, inline=inline)
    options = dict(_OPTIONS, no_cpython_wrapper=inner or inline)
    if reorder:
        options["fastmath"] = _REORDER
    if inline:
        options["inline"] = "always"
    compiled = _with_cache(njit(**options)(function))
    if isinstance(compiled, CPUDispatcher):
        compiled.__class__ = _Inner if options["no_cpython_wrapper"] else _Kernel
    return compiled


class _Kernel(CPUDispatcher):
    """A kernel that is compiled for a type, not anew for each number that its callers write out, as in ``f(x, 1)``.

    Numba would: it saves a sixth of the first superposition.
    """

    def compile(self, sig):
        """Compile for a signature. Python collects no garbage meanwhile, which took a sixth of the time."""
        enabled = gc.isenabled()
        gc.disable()
        try:
            return super().compile(sig)
        finally:
            if enabled:
                gc.enable()

    def get_call_template(self, args, kws):
        """Tell a caller's compilation what to call, for the types of its arguments."""
        plain = {name: types.unliteral(value) for name, value in kws.items()}
        return super().get_call_template([types.unliteral(value) for value in args], plain)


class _Inner(_Kernel):
    """A kernel without an entry for Python: to call it from there would end the interpreter."""

    def __call__(self, *arguments, **options):
        raise TypeError(f"{self.py_func.__name__}: called by kernels only (inner=True), found a call from Python")


def _with_cache(compiled):
    """Keep what is compiled on disk; where nothing can be written there, in memory only."""
    global _cached
    try:
        compiled.enable_caching()
    except RuntimeError:  # numba's, if it finds no place
        _cached = False
    except AttributeError:  # NUMBA_DISABLE_JIT: a plain function
        pass
    return compiled


class _Notice(event.Listener):
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
        if self.told or self.spent + time.monotonic() - self.begun < _PATIENCE:
            return
        self.told = True
        lost = "NOT kept, every process does it anew: set NUMBA_CACHE_DIR to a folder that can be written to"
        kept = "kept for later" if _cached else lost
        print(f"roughxr: compiling once (up to a minute), {kept}", file=sys.stderr, flush=True)


event.register("numba:compile", _Notice())
