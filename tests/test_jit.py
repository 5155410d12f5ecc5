"""How kernels are compiled: for Python and for other kernels, each once, and kept on disk."""

import gc
import subprocess
import sys
from types import FunctionType

import pytest

from roughxr.kernels import jit
from roughxr.kernels.jit import kernel


@kernel
def doubled(x):
    return 2 * x


@kernel
def quadrupled(x):
    return doubled(doubled(x))


@kernel
def eightfold(x):
    return doubled(quadrupled(x))


def calling(function, **kernels):
    """Return a kernel afresh, not from the cache, that calls others under the names of those it knows."""
    names = {"__name__": __name__, **kernels}
    other = FunctionType(function.py_func.__code__, names, function.py_func.__name__)
    return jit._compiler(other, targetoptions=function.targetoptions)


compiled = pytest.mark.skipif(
    not hasattr(quadrupled, "py_func"),
    reason="compilation is switched off (NUMBA_DISABLE_JIT): every kernel is plain Python",
)
linking = pytest.mark.skipif(
    jit._compiler is None or not hasattr(quadrupled, "py_func"),
    reason="kernels are compiled by numba.njit alone (ROUGHXR_PLAIN_NUMBA, another version), or not at all",
)


@linking
def test_a_kernel_is_compiled_for_those_that_call_it():
    called_by_kernels, called_by_python = kernel(doubled.py_func), kernel(doubled.py_func)
    assert (calling(quadrupled, doubled=called_by_kernels)(3), called_by_python(3)) == (12, 6)
    assert not called_by_kernels.signatures and called_by_kernels.part.signatures
    assert called_by_python.signatures and not called_by_python.part.signatures


@linking
def test_what_kernels_call_is_kept_with_all_that_it_calls():
    assert eightfold(3) == 24  # compiled here or before: what it calls is on disk
    anew = kernel(quadrupled.py_func)
    assert calling(eightfold, doubled=kernel(doubled.py_func), quadrupled=anew)(3) == 24
    assert sum(anew.part.stats.cache_hits.values()) == 1 and not anew.part.stats.cache_misses


@linking
@pytest.mark.parametrize("enabled", [True, False])
def test_garbage_is_collected_after_compiling_as_before(enabled):
    before = gc.isenabled()
    try:
        gc.enable() if enabled else gc.disable()
        assert calling(doubled)(2) == 4
        assert gc.isenabled() == enabled
    finally:
        gc.enable() if before else gc.disable()


#: A call of a small kernel for which numba finds no place to keep it, told from its first moment on.
_UNCACHED = """
from roughxr.kernels import jit
jit._SILENT_SECONDS = 0.0
exec("def tripled(x): return 3 * x", place := {"__name__": "roughxr.kernels.nowhere"})
assert jit.kernel(place["tripled"])(2) == 6
"""


@compiled
def test_each_of_two_processes_that_compile_at_once_without_a_cache_says_so_and_what_to_do():
    command = [sys.executable, "-c", _UNCACHED]
    both = [subprocess.Popen(command, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    for said in [process.communicate(timeout=300)[1] for process in both]:
        assert said.count("compiling once") == 1, said
        assert "NOT kept" in said and "NUMBA_CACHE_DIR" in said


@linking
def test_one_compilation_serves_every_number_that_a_caller_writes_out(monkeypatch):
    # Compiled afresh: of what comes from the cache nothing tells how often it was compiled.
    monkeypatch.setattr(jit, "with_cache", lambda compiled: compiled)

    @kernel
    def added(i, x):
        return i + x

    @kernel
    def sum_of_numbers():
        return added(1, 2.0) + added(3, 4.0)

    assert sum_of_numbers() == 10
    assert len(added.part.signatures) == 1


#: What happens to Numba one day, and what is done then: kernels that call kernels, compiled afresh.
CHANGES = {
    "a private name is gone": "import numba.core.caching as c; del c.CompileResultCacheImpl",
    "a class has other methods": "import numba.core.codegen as c; c.JITCodeLibrary = object",
    "a newer version": "import numba; numba.__version__ = '1.2.3'",
    "an older version": "import numba; numba.__version__ = '0.62.1'",
    "a version of another form": "import numba; numba.__version__ = 'unknown'",
    "it is asked for": "import os; os.environ['ROUGHXR_PLAIN_NUMBA'] = '1'",
}

_SORTED = """
from roughxr.kernels import jit
from roughxr.kernels.arrays import ascending
import numpy as np
assert ascending(np.array([3.0, 1.0, 2.0])).tolist() == [1, 2, 0]
"""

_BY_NJIT = """
assert jit._compiler is None
assert type(ascending).__module__.startswith("numba."), type(ascending)
"""


@compiled
@pytest.mark.parametrize("change", CHANGES)
def test_kernels_are_compiled_by_njit_alone_where_the_quicker_way_is_not_known_to_work(change):
    done = subprocess.run([sys.executable, "-c", CHANGES[change] + _SORTED + _BY_NJIT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@compiled
def test_without_numbas_events_nobody_is_told_and_all_else_is_as_before():
    gone = "import sys, numba; sys.modules['numba.core.event'] = None"
    done = subprocess.run([sys.executable, "-c", gone + _SORTED], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@compiled
def test_kept_kernels_are_those_of_the_present_source(tmp_path):
    """Numba itself would go on with what a kernel called when it was compiled."""
    text = "from roughxr.kernels.jit import kernel\n{}\n\n@kernel\ndef {}(x):\n    return {}\n"
    (tmp_path / "caller.py").write_text(text.format("from called import called", "caller", "called(x)"))
    call = "from roughxr.kernels import jit; jit._source = {!r}; from caller import caller; print(caller(3))"
    for times in (2, 5):
        (tmp_path / "called.py").write_text(text.format("", "called", f"{times} * x"))
        begin = [sys.executable, "-c", call.format(jit._digest(tmp_path))]
        told = subprocess.run(begin, cwd=tmp_path, text=True, capture_output=True, check=True)
        assert told.stdout == f"{3 * times}\n"
