"""How kernels are compiled: what only kernels may call says so instead of ending the interpreter."""

import subprocess
import sys

import pytest

from roughxr.kernels import jit
from roughxr.kernels.jit import kernel


@kernel(inner=True)
def doubled(x):
    return 2 * x


@kernel
def quadrupled(x):
    return doubled(doubled(x))


compiled = pytest.mark.skipif(
    not hasattr(quadrupled, "py_func"),
    reason="compilation is switched off (NUMBA_DISABLE_JIT): every kernel is plain Python",
)


@compiled
def test_inner_kernels_are_called_by_kernels_only():
    assert quadrupled(3) == 12
    with pytest.raises(TypeError, match="doubled: called by kernels only"):
        doubled(3)


#: A call of a small kernel for which numba finds no place to keep it, told from its first moment on.
_UNCACHED = """
from roughxr.kernels import jit
jit._PATIENCE = 0.0
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


@compiled
def test_one_compilation_serves_every_number_that_a_caller_writes_out(monkeypatch):
    # Compiled afresh: of what comes from the cache nothing tells how often it was compiled.
    monkeypatch.setattr(jit, "_with_cache", lambda compiled: compiled)

    @kernel(inner=True)
    def added(i, x):
        return i + x

    @kernel
    def sum_of_numbers():
        return added(1, 2.0) + added(3, 4.0)

    assert sum_of_numbers() == 10
    assert len(added.signatures) == 1
