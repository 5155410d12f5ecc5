"""How kernels are compiled: by Numba on the first call, never on import, and stored on disk.

Kernels release the GIL and are serial: parallelism belongs to dask alone, since two parallel layers at once
(``parallel=True`` below dask threads) can abort the process.

Compiled code contains all that a kernel calls, but Numba asks only whether the kernel's own file has changed. So each
kernel is stored under a name with a digest of its file and of all kernel files that this imports. Files of other
digests are removed.
"""

import ast
import hashlib
from collections import defaultdict
from functools import cache
from pathlib import Path

from numba import njit

#: IEEE arithmetic; division by zero gives inf or NaN as in NumPy. Nothing calls kernels as C functions.
_OPTIONS = {"nogil": True, "no_cfunc_wrapper": True, "error_model": "numpy"}

#: LLVM's flags for sums that may be reordered and fused for speed. NaN and inf keep their meaning.
_REORDER = {"reassoc", "contract", "arcp", "nsz"}

#: Compiled kernels by the name of their folder.
_KERNELS = defaultdict(list)

#: Folder of the package, below which all kernels and all that they call stand.
_PACKAGE = Path(__file__).parents[2]


@cache
def _imports(file):
    """Return the files of the package that a file imports; other packages are not searched."""
    if not file.is_file():  # inside an archive
        return frozenset()
    files = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.ImportFrom) and (node.level or node.module.split(".")[0] == _PACKAGE.name):
            start = file.parents[node.level - 1] if node.level else _PACKAGE.parent
            module = start.joinpath(*(node.module or "").split("."))
            names = [module, *(module / name.name for name in node.names)]
            files |= {name.with_suffix(".py") for name in names}
    return frozenset(filter(Path.is_file, files))


@cache
def digest(file):
    """Return a hash of the text of a kernel file and of all kernel files that it imports."""
    files = {file}
    added = {file}
    while added:
        added = set().union(*map(_imports, added)) - files
        files |= added
    text = b"".join(source.read_bytes() for source in sorted(files) if source.is_file())
    return hashlib.sha256(text).hexdigest()[:12]


def kernel(function=None, *, reorder=False):
    """Compile ``function`` on its first call; with ``reorder`` sums may be reordered, so that loops vectorise."""
    if function is None:
        return lambda function: kernel(function, reorder=reorder)
    options = {**_OPTIONS, "fastmath": _REORDER} if reorder else _OPTIONS
    name = function.__qualname__.split("@")[0]
    function.__qualname__ = f"{name}@{digest(Path(function.__code__.co_filename))}"  # names the files on disk
    try:
        compiled = njit(cache=True, **options)(function)
    except RuntimeError:  # Numba finds no folder to write to
        return njit(**options)(function)
    if hasattr(compiled, "stats"):  # not with NUMBA_DISABLE_JIT
        _KERNELS[Path(function.__code__.co_filename).parent.name].append(compiled)
        _remove_others(Path(compiled.stats.cache_path), f"{function.__module__.split('.')[-1]}.{name}@", function)
    return compiled


def share_to_compile(folder):
    """Return the share of the imported kernels in a folder that are not stored on the disk; 0 without any."""
    kernels = _KERNELS[folder]
    to_compile = [compiled for compiled in kernels if not _is_stored(compiled)]
    return len(to_compile) / max(len(kernels), 1)


def _is_stored(compiled):
    name = compiled.py_func.__qualname__
    return any(Path(compiled.stats.cache_path).glob(f"*{name}-*.nbi"))


@cache
def _stored(folder):
    """Return the names of the compiled files in a folder, listed once."""
    return [file.name for file in folder.glob("*@*.nb?")]


def _remove_others(folder, begins, function):
    """Remove the compiled files of a kernel whose sources have changed since."""
    for name in _stored(folder):
        if name.startswith(begins) and function.__qualname__ not in name:
            (folder / name).unlink(missing_ok=True)
