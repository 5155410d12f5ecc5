"""How kernels are compiled: what only kernels may call says so instead of ending the interpreter."""

import pytest

from roughxr.kernels.jit import kernel


@kernel(inner=True)
def doubled(x):
    return 2 * x


@kernel
def quadrupled(x):
    return doubled(doubled(x))


def test_inner_kernels_are_called_by_kernels_only():
    if not hasattr(quadrupled, "py_func"):
        pytest.skip("compilation is switched off (NUMBA_DISABLE_JIT): every kernel is plain Python")
    assert quadrupled(3) == 12
    with pytest.raises(TypeError, match="doubled: called by kernels only"):
        doubled(3)


@kernel
def sum_of_numbers():
    return added(1, 2.0) + added(3, 4.0)


@kernel(inner=True)
def added(i, x):
    return i + x


def test_one_compilation_serves_every_number_that_a_caller_writes_out():
    if not hasattr(sum_of_numbers, "py_func"):
        pytest.skip("compilation is switched off (NUMBA_DISABLE_JIT): every kernel is plain Python")
    assert sum_of_numbers() == 10
    assert len(added.signatures) == 1
