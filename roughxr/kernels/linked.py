"""Kernels compiled in half the time and less, by what is not public in Numba; `jit` decides whether.

What a kernel calls is optimised once, together with it. Numba by itself optimises every function and makes machine code
of it, and does both again with each function that calls it: with long functions that call long ones, level upon level,
that was half of a first call. Here a kernel that other kernels call is a *part*: LLVM code that is linked into the
kernel that Python calls, the *entry*, and made machine code there, all at once. A function that ``numba.njit`` compiles
does not link what a part calls.
"""

import gc
from contextlib import contextmanager
from functools import cached_property
from pickle import UnpicklingError
from types import MappingProxyType

from llvmlite.binding import parse_bitcode
from numba import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags, compile_result
from numba.core.registry import CPUDispatcher

from . import jit

#: What is used of these classes beyond their public part; a name that is missing is found at import.
_USED = {
    JITCodeLibrary: ("add_linking_library", "finalize", "_finalize_dynamic_globals", "_get_module_for_linking"),
    Compiler: ("compile_extra",),
    CompileResultCacheImpl: ("reduce", "rebuild"),
    FunctionCache: ("_index_key", "_impl_class", "flush", "load_overload"),
    CPUDispatcher: ("get_call_template", "get_overload", "compile", "add_overload", "enable_caching"),
    Flags: ("values",),
}
for _class, _names in _USED.items():
    for _name in _names:
        getattr(_class, _name)


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


class _Cache(FunctionCache):
    """Files that are begun anew where they cannot be read: another release may have left them, of types now gone."""

    def load_overload(self, sig, target_context):
        """Return what is kept for a signature, None where nothing is."""
        try:
            return super().load_overload(sig, target_context)
        except (ImportError, AttributeError, EOFError, UnpicklingError):
            self.flush()
            return None


class _EntryCache(_Cache):
    """Where entries are kept: in the files that plain ``njit`` uses, which cannot link them."""

    def _index_key(self, sig, codegen):
        """Return by what an entry is found, and nothing else."""
        return *super()._index_key(sig, codegen), "entry"


class _PartCache(_Cache):
    """Where parts are kept: in the files of the entries."""

    _impl_class = _PartStored

    def _index_key(self, sig, codegen):
        """Return by what a part is found, which its entry is not."""
        return *super()._index_key(sig, codegen), "part"


class Kernel(CPUDispatcher):
    """A kernel: an entry for Python, and a part for other kernels, each compiled when it is first called."""

    def __init__(self, py_func, locals=None, targetoptions=None, pipeline_class=_EntryCompiler):
        super().__init__(py_func, locals or {}, targetoptions or {}, pipeline_class)

    @cached_property
    def part(self):
        """What other kernels call."""
        return jit.with_cache(_Part(self.py_func, targetoptions=dict(self.targetoptions, no_cpython_wrapper=True)))

    def enable_caching(self):
        """Keep what is compiled on disk."""
        self._cache = _EntryCache(self.py_func)

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
