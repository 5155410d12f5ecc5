"""How kernels are compiled: all options in one place, and a word to who waits for it.

Compilation happens on the first call, never on import, and is cached on disk. Kernels release the GIL
and are serial: parallelism belongs to dask alone, since two parallel layers at once (``parallel=True``
below dask threads) can abort the process.
"""

import sys
import time
from multiprocessing import parent_process

from llvmlite.binding import parse_bitcode
from numba import njit, types
from numba.core import event
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, compile_result
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
    if inner or inline:
        options["pipeline_class"] = _PartCompiler
    compiled = njit(**options)(function)
    if isinstance(compiled, CPUDispatcher):
        compiled.__class__ = _Inner if options["no_cpython_wrapper"] else _Kernel
    return _with_cache(compiled)


class _Part(JITCodeLibrary):
    """What is only linked into other libraries: neither optimised nor made machine code by itself."""

    def finalize(self):
        """Link what it calls."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True

    def serialize_using_object_code(self):
        """Serialise."""
        return self.name, self._get_module_for_linking().as_bitcode()


class _PartCompiler(Compiler):
    """Compiles to a `_Part`."""

    def compile_extra(self, func):
        """Compile."""
        self.state.flags.no_compile = True
        self.state.library = _Part(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)._replace(entry_point=object())


class _PartCacheImpl(CompileResultCacheImpl):
    def rebuild(self, target_context, payload):
        (name, bitcode), fndesc, env, signature, _, _, _, reload_init, envs = payload
        for function in reload_init:
            function()
        library = _Part(target_context.codegen(), name)
        library._shared_module = parse_bitcode(bitcode)
        library._finalized = True
        return compile_result(target_context=target_context, typing_context=target_context.typing_context, library=library, environment=env, entry_point=object(),
           fndesc=fndesc, signature=signature, objectmode=False, lifted=(), reload_init=reload_init, referenced_envs=envs)


class _PartCache(FunctionCache):
    _impl_class = _PartCacheImpl


class _Kernel(CPUDispatcher):
    """A kernel that is compiled for a type, not anew for each number that its callers write out, as in ``f(x, 1)``.

    Numba would: it saves a sixth of the first superposition.
    """

    def get_call_template(self, args, kws):
        """Tell a caller's compilation what to call, for the types of its arguments."""
        plain = {name: types.unliteral(value) for name, value in kws.items()}
        return super().get_call_template([types.unliteral(value) for value in args], plain)


class _Inner(_Kernel):
    """A kernel without an entry for Python: to call it from there would end the interpreter."""

    def enable_caching(self):
        self._cache = _PartCache(self.py_func)

    def add_overload(self, cres):
        self.targetctx.insert_user_function(cres.entry_point, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres

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
