"""What kernels share to make, sort and look through arrays, against NumPy's own."""

import numpy as np
import pytest

from roughxr.kernels.arrays import ascending, line, lowest, median, table, unset
from roughxr.kernels.jit import kernel


@kernel
def made(rows, columns):
    return unset((rows,), 0), unset((rows, columns), 0.0), unset((rows, columns, 3), np.float32(0))


@pytest.mark.parametrize("shape", [(0, 0), (3, 0), (2, 5)])
def test_unset_arrays_have_the_shape_and_type_asked_for(shape):
    whole, double, single = made(*shape)
    assert [a.shape for a in (whole, double, single)] == [shape[:1], shape, (*shape, 3)]
    assert [a.dtype for a in (whole, double, single)] == [np.int64, np.float64, np.float32]
    assert all(a.flags.c_contiguous and a.flags.writeable for a in (whole, double, single))


@pytest.mark.parametrize("value", [0.5, 7, True, 1 + 2j, np.float32(3), np.int32(-1)])
def test_lines_and_tables_hold_the_value_in_its_type(value):
    expected = np.full((3, 4), value)
    for found, wanted in ((line(4, value), expected[0]), (table(3, 4, value), expected)):
        np.testing.assert_array_equal(found, wanted)
        assert found.dtype == wanted.dtype


@pytest.mark.parametrize("size", [0, 1, 2, 3, 8, 100, 1001])
@pytest.mark.parametrize("decimals", [0, 12], ids=["many equal", "all different"])
def test_sorting_keeps_equal_values_as_they_stand(size, decimals):
    values = np.round(np.random.default_rng(size).normal(size=size), decimals)
    np.testing.assert_array_equal(ascending(values), np.argsort(values, kind="stable"))
    assert lowest(values) == values.min(initial=np.inf)
    if size:
        assert median(values) == np.median(values)
