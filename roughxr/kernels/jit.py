"""How kernels are compiled: all options in one place, and a word to who waits for it.

Compilation happens on the first call, never on import, and is cached on disk. Kernels release the GIL
and are serial: parallelism belongs to dask alone, since two parallel layers at once (``parallel=True``
below dask threads) can abort the process.

What a kernel calls is optimised once, together with it. Numba by itself optimises every function and makes machine code
of it, and does both again with each function that calls it: with long functions that call long ones, level upon level,
that was half of a first call. Here a kernel that other kernels call is a *part*: LLVM code that is linked into the
kernel that Python calls, the *entry*, and made machine code there, all at once. So kernels are called by Python and by
kernels only: a function that ``numba.njit`` compiles does not link what a part calls.

Parts build on classes of Numba's that are not public, tried with 0.63, 0.65 and 0.68. Should one change, ``njit`` with
``_OPTIONS`` in place of ``_Kernel`` gives the same kernels, compiled in about twice the time.
"""

import gc
import sys
import time
from contextlib import contextmanager
from functools import cached_property
from multiprocessing import parent_process
from types import MappingProxyType

from llvmlite.binding import parse_bitcode
from numba import njit, types
from numba.core import event
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags, compile_result
from numba.core.registry import CPUDispatcher

#: Ordinary kernels: IEEE arithmetic, division by zero gives inf or NaN as in NumPy. None is called from C.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}

#: What a sum may be allowed for speed: another order, and fused multiply-add. NaN and inf keep their meaning.
_REORDER = {"reassoc", "contract", "arcp", "nsz"}

#: Seconds of compilation after which it is told.
_PATIENCE = 1.0

_cached = True


def kernel(function=None, *, reorder=False):
    """Compile ``function`` on its first call, from Python or from another kernel.

    Parameters
    ----------
    reorder : bool
        Let sums be reordered, so that loops over cells vectorise.
    """
    if function is None:
        return lambda function: kernel(function, reorder=reorder)
    options = dict(_OPTIONS, fastmath=_REORDER) if reorder else _OPTIONS
    compiled = njit(**options)(function)
    if isinstance(compiled, CPUDispatcher):  # with NUMBA_DISABLE_JIT it is the function itself
        compiled = _with_cache(_Kernel(function, targetoptions=compiled.targetoptions))
    return compiled


def _with_cache(compiled):
    """Keep what is compiled on disk; where nothing can be written there, in memory only."""
    global _cached
    try:
        compiled.enable_caching()
    except RuntimeError:  # numba's, if it finds no place
        _cached = False
    return compiled


@contextmanager
def _uncollected():
    """Keep Python from looking for garbage in what a compiler makes: it finds none, in a sixth of a first call."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class _EntryLibrary(JITCodeLibrary):
    """Compiled code that links all that its parts call."""

    def add_linking_library(self, library):
        """Link what is called, and what that calls."""
        for one in (library, *library._linking_libraries) if isinstance(library, _PartLibrary) else (library,):
            if one not in self._linking_libraries:
                super().add_linking_library(one)


class _PartLibrary(_EntryLibrary):
    """A function on its own, its callees beside it: to be optimised with them where all is linked."""

    def finalize(self):
        """Leave it at that."""
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalize_dynamic_globals()
        self._finalized = True

    def pieces(self):
        """Return name and LLVM of the function and of all that it calls."""
        return [(one.name, one._get_module_for_linking().as_bitcode()) for one in (self, *self._linking_libraries)]

    @classmethod
    def of(cls, codegen, pieces, reload_init):
        """Return the library with such `pieces`, and what is to be done where they are loaded."""
        first, *others = [cls(codegen, name) for name, _ in pieces]
        for library, (_, bitcode) in zip((first, *others), pieces):
            library._shared_module, library._finalized = parse_bitcode(bitcode), True
        first._linking_libraries = others
        first._reload_init.update(reload_init)
        return first


class _Flags(Flags):
    """Numba's options, quicker to compare: numba does so some twenty thousand times in a first call."""

    _DEFAULTS = MappingProxyType(Flags().values())

    def values(self):
        """Return all options."""
        return {**self._DEFAULTS, **self._values}


class _EntryCompiler(Compiler):
    """Compiles what Python calls."""

    def compile_extra(self, function):
        """Compile the function; return numba's CompileResult."""
        self.state.flags = _Flags(self.state.flags)
        self.state.library = _EntryLibrary(self.state.targetctx.codegen(), function.__qualname__)
        self.state.library.enable_object_caching()
        compiled = super().compile_extra(function)
        for environment in compiled._find_referenced_environments():
            compiled.codegen.set_env(environment.env_name, environment)
        return compiled


class _PartCompiler(Compiler):
    """Compiles what kernels call."""

    def compile_extra(self, function):
        """Compile the function; return numba's CompileResult."""
        self.state.flags = _Flags(self.state.flags)
        self.state.flags.no_compile = True
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), function.__qualname__)
        return super().compile_extra(function)._replace(entry_point=object())  # by which numba knows it


class _PartStored(CompileResultCacheImpl):
    """A part as it is kept on disk."""

    def reduce(self, compiled):
        """Return what can be pickled."""
        compiled.fndesc.typemap = compiled.fndesc.calltypes = None
        return {
            "pieces": compiled.library.pieces(),
            "reload_init": tuple(compiled.library._reload_init),
            "fndesc": compiled.fndesc,
            "environment": compiled.environment,
            "signature": compiled.signature,
        }

    def rebuild(self, target_context, kept):
        """Return numba's CompileResult of it."""
        for initialize in kept["reload_init"]:
            initialize()
        return compile_result(
            library=_PartLibrary.of(target_context.codegen(), kept.pop("pieces"), kept["reload_init"]),
            entry_point=object(),
            target_context=target_context,
            typing_context=target_context.typing_context,
            objectmode=False,
            lifted=(),
            **kept,
        )


class _PartCache(FunctionCache):
    """Where parts are kept: in the files of the entries."""

    _impl_class = _PartStored

    def _index_key(self, sig, codegen):
        """Return by what a part is found, which its entry is not."""
        return *super()._index_key(sig, codegen), "part"


class _Kernel(CPUDispatcher):
    """A kernel: an entry for Python, and a part for other kernels, each compiled when it is first called."""

    def __init__(self, py_func, locals=None, targetoptions=None, pipeline_class=_EntryCompiler):
        super().__init__(py_func, locals or {}, targetoptions or {}, pipeline_class)

    @cached_property
    def part(self):
        """What other kernels call."""
        return _with_cache(_Part(self.py_func, targetoptions=dict(self.targetoptions, no_cpython_wrapper=True)))

    def compile(self, sig):
        """Compile for a signature; return what is to be called."""
        with _uncollected():
            return super().compile(sig)

    def get_call_template(self, args, kws):
        """Tell a caller's compilation what to call."""
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig):
        """Return by what numba knows the part."""
        return self.part.get_overload(sig)


class _Part(CPUDispatcher):
    """A kernel that kernels call.

    It is compiled for types, not anew for each number that its callers write out, as in ``f(x, 1)``. Numba would: it
    saves a sixth of the first superposition.
    """

    def __init__(self, py_func, locals=None, targetoptions=None, pipeline_class=_PartCompiler):
        super().__init__(py_func, locals or {}, targetoptions or {}, pipeline_class)

    def enable_caching(self):
        """Keep what is compiled on disk."""
        self._cache = _PartCache(self.py_func)

    def add_overload(self, compiled):
        """Make known what was compiled."""
        self.targetctx.insert_user_function(compiled.entry_point, compiled.fndesc, [compiled.library])
        self.overloads[tuple(compiled.signature.args)] = compiled

    def get_call_template(self, args, kws):
        """Tell a caller's compilation what to call, for the types of its arguments."""
        plain = {name: types.unliteral(value) for name, value in kws.items()}
        return super().get_call_template([types.unliteral(value) for value in args], plain)


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
