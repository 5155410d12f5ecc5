"""Compiled kernels belong to the present text of all files that they come from."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from roughxr.mechanics.kernels import jit

TEXT = "from roughxr.mechanics.kernels.jit import kernel\n{}\n\n@kernel\ndef {}(x):\n    return {}\n"


@pytest.mark.skipif(
    not hasattr(jit.kernel(lambda x: x), "py_func"), reason="NUMBA_DISABLE_JIT: every kernel is plain Python"
)
def test_stored_kernels_are_those_of_the_present_sources_and_older_ones_are_removed(tmp_path):
    """Numba itself would go on with what a kernel called when it was compiled."""
    folder = tmp_path / "pack"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "calling.py").write_text(TEXT.format("from .middle import middle", "calling", "middle(x)"))
    (folder / "middle.py").write_text(TEXT.format("from .called import called", "middle", "called(x)"))
    for times in (2, 5):
        (folder / "called.py").write_text(TEXT.format("", "called", f"{times} * x"))
        begin = [sys.executable, "-c", "from pack.calling import calling; print(calling(3))"]
        own_cache = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
        done = subprocess.run(begin, cwd=tmp_path, text=True, capture_output=True, check=True, env=own_cache)
        assert done.stdout == f"{3 * times}\n"
        assert len(list(tmp_path.rglob("calling.calling@*.nbi"))) == 1


def test_the_share_of_kernels_to_compile_falls_as_they_are_stored(tmp_path):
    """Where nothing is stored it is 1; a run states the time of its compiling by it."""
    begin = [
        sys.executable,
        "-c",
        "from roughxr.mechanics.kernels import jit; from roughxr.mechanics.kernels.asperity import ellipse;"
        "import numpy as np; before = jit.share_to_compile('asperity'); one = np.ones(2);"
        "ellipse.axis_ratios(one, one); print(before, jit.share_to_compile('asperity'))",
    ]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    run = [subprocess.run(begin, text=True, capture_output=True, check=True, env=environment) for _ in range(2)]
    (first, then), (later, _) = (map(float, done.stdout.split()) for done in run)
    assert first == 1 and then < 1 and later == then


def test_a_digest_follows_imports_and_nothing_else():
    love, layered, products, basins = (
        Path(jit.__file__).parent / name
        for name in ("halfspace/love.py", "halfspace/layered.py", "halfspace/products.py", "topography/basins.py")
    )
    assert layered in jit._imports(products) and basins not in jit._imports(products)
    assert love in jit._imports(layered)
    assert jit.digest(products) != jit.digest(love)


def test_kernels_stand_in_their_own_folder_and_are_named_by_files_of_the_package_alone(tmp_path, monkeypatch):
    """Beside an installed package stand NumPy, pandas, Numba: to parse them took 17 s at each start."""
    package = Path(jit.__file__).parents[1]
    monkeypatch.setattr(jit, "_PACKAGE", tmp_path / package.name)
    (tmp_path / "numpy.py").write_text("zeros = ones = None\n")
    (tmp_path / package.name).mkdir()
    (tmp_path / package.name / "called.py").write_text("from numpy import ones\n")
    calling = tmp_path / package.name / "calling.py"
    calling.write_text(f"from numpy import zeros\nfrom {package.name}.called import ones\n")
    assert jit._imports(calling) == {tmp_path / package.name / "called.py"}
    for file in package.rglob("*.py"):
        if file.parent not in (package / "kernels", *(package / "kernels").iterdir()):
            assert "@kernel" not in file.read_text(encoding="utf-8"), file


def test_numba_is_used_by_its_public_names_alone():
    for file in Path(jit.__file__).parents[1].rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_bytes())):
            modules = [name.name for name in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
            assert not any(name.startswith(("numba.", "llvmlite")) for name in modules), file
