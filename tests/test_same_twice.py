"""The same solve gives the same bits, whatever the memory that it gets held before."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from roughxr.mechanics.kernels.adhesion.path import CONVERGED, follow_path
from roughxr.mechanics.kernels.adhesion.traction_laws import smooth_law
from roughxr.mechanics.kernels.halfspace import products

from . import half_space as kalker

LAW = smooth_law(exponential=(0.05, 0.8))


def gap(rows, columns):
    """Return the separation of a sphere of 200 cells over bumps of some 0.3 cells."""
    x, y = (np.arange(n) - 0.5 * (n - 1) for n in (rows, columns))
    bumps = 0.3 * np.abs(np.random.default_rng(1).normal(size=(rows, columns)))
    separation = (x[:, None] ** 2 + y**2) / 400.0 + bumps
    return separation - separation.min()


def solutions(rows, columns):
    """Return what an adhesive cycle, a sweep of displacements and a yielding load give, as bytes."""
    separation = gap(rows, columns)
    (path,) = follow_path(separation, np.array([0.0]), 2.0, LAW, preloads=[0.0], fields=True)
    assert path.status == CONVERGED
    pressed = kalker.sweep_arrays(separation, [1.0, 2.0], 1.0, 1.0, keep=2)
    loaded = kalker.loaded_arrays(separation, [5.0], 1.0, 1.0, hardness=kalker.Hardness(0.1), keep=1)
    return b"".join(
        array.tobytes() for array in (path.states, path.pressures, path.residual_heights, *pressed, *loaded)
    )


@pytest.mark.parametrize("cells", [121, 125, 128])
def test_nothing_beyond_the_table_of_coefficients_is_read(cells, monkeypatch):
    """Tables one row short made pull-offs of windows of 121 to 125 cells differ from call to call, or NaN."""
    table = products.coefficients_for((cells, 9))
    results = set()
    for behind in (0.0, 1.0, 1e300, np.nan):
        memory = np.full(table.size + 4 * len(table), behind)
        memory[: table.size] = table.ravel()
        within = memory[: table.size].reshape(table.shape)
        within.setflags(write=False)
        products._small_transfer.cache_clear()
        with monkeypatch.context() as patched:
            patched.setattr(products, "coefficients_for", lambda shape, film=None, within=within: within)
            results.add(solutions(cells, 9))
    assert len(results) == 1


def many_solves(count):
    """Print how many different solutions so many solves give, at windows of several shapes."""
    for rows, columns in ((125, 9), (12, 12)):
        results = set()
        for k in range(count):
            rubbish = [np.full((rows + k % 7) * 2**j, (np.nan, 1e300, -1.0)[k % 3]) for j in range(10)]
            del rubbish  # what is allocated next lies where this lay, and otherwise aligned
            results.add(solutions(rows, columns))
        print(rows, columns, len(results), hash_of(results))


def hash_of(results):
    """Return some digits that stand for a set of bytes."""
    return hashlib.sha256(b"".join(sorted(results))).hexdigest()


@pytest.mark.parametrize("filling", ["1", pytest.param("128", marks=pytest.mark.soak)])  # large negative and positive
def test_solves_in_one_process_and_in_another_are_equal_bit_by_bit_in_poisoned_memory(filling, capsys):
    """MALLOC_PERTURB_ lets the C library fill what it lends and what it takes back (glibc; elsewhere it is ignored)."""
    many_solves(2)
    printed = capsys.readouterr().out
    done = subprocess.run(
        [sys.executable, "-c", "from tests.test_same_twice import many_solves; many_solves(6)"],
        cwd=Path(__file__).parents[1],
        env={**os.environ, "MALLOC_PERTURB_": filling},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == printed
    assert [line.split()[2] for line in printed.splitlines()] == ["1", "1"], printed
