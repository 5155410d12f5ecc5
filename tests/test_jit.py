"""Compiled kernels belong to the present text of all files that they come from."""

import ast
import importlib
import sys
from collections import defaultdict
from pathlib import Path

import numba
import pytest

from roughxr.mechanics.kernels import jit

TEXT = "from roughxr.mechanics.kernels.jit import kernel\n{}\n\n@kernel\ndef {}(x):\n    return {}\n"


needs_compiler = pytest.mark.skipif(
    not hasattr(jit.kernel(lambda x: x), "py_func"), reason="NUMBA_DISABLE_JIT: every kernel is plain Python"
)


@pytest.fixture
def pack(tmp_path, monkeypatch):
    """Return the folder of a package of kernels, which stores them beside their files."""
    folder = tmp_path / "pack"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "calling.py").write_text(TEXT.format("from .middle import middle", "calling", "middle(x)"))
    (folder / "middle.py").write_text(TEXT.format("from .called import called", "middle", "called(x)"))
    (folder / "called.py").write_text(TEXT.format("", "called", "2 * x"))
    (folder / "uncalled.py").write_text(TEXT.format("", "uncalled", "x"))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    yield folder
    forget_kernels(monkeypatch)


def forget_kernels(monkeypatch):
    """Forget modules and stored names of the package of kernels, as a new process does."""
    for name in [name for name in sys.modules if name.split(".")[0] == "pack"]:
        del sys.modules[name]
    for stored in (jit.digest, jit._imports, jit._stored):
        stored.cache_clear()
    monkeypatch.setattr(jit, "_KERNELS", defaultdict(list))


@needs_compiler
def test_stored_kernels_are_those_of_the_present_sources_and_older_ones_are_removed(pack, monkeypatch):
    """Numba itself would go on with what a kernel called when it was compiled."""
    for times in (2, 10):  # of another length: Python's compiled files are dated to the second
        (pack / "called.py").write_text(TEXT.format("", "called", f"{times} * x"))
        forget_kernels(monkeypatch)
        assert importlib.import_module("pack.calling").calling(3) == 3 * times
        assert len(list(pack.rglob("calling.calling@*.nbi"))) == 1


@needs_compiler
def test_the_share_of_kernels_to_compile_falls_as_they_are_stored(pack, monkeypatch):
    """Where nothing is stored it is 1; a run states the time of its compiling by it."""
    shares = []
    for _ in range(2):
        forget_kernels(monkeypatch)
        importlib.import_module("pack.uncalled")
        calling = importlib.import_module("pack.calling").calling
        shares.append(jit.share_to_compile("pack"))
        calling(3)
        shares.append(jit.share_to_compile("pack"))
    assert shares == [1, 0.25, 0.25, 0.25]


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
