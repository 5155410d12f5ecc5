"""Execute every notebook from its folder, one on every core; fail where a cell raises.

``python tests/notebooks.py --store`` writes the outputs into the notebooks, pictures as PNG files with twice the dots,
the package's cautions as text.
Names of notebooks restrict either. A notebook that takes minutes may contain, in its own metadata under ``quick``, a
line of code that reduces its size: it is executed first, unless with ``--store``.
"""

import argparse
import base64
import io
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat.v4 import new_code_cell

FOLDER = Path(__file__).parents[1] / "notebooks"

#: Size (bytes) from which a picture, the map of a rough scan, is stored with half the dots.
_LARGE = 300_000

#: Executed first. Each caution is printed once as part of the output, without the path of the kernel's file; a change
#: that a library announces is an error.
_CAUTIONS = """
import functools, warnings
once = functools.lru_cache(maxsize=None)(print)
warnings.showwarning = lambda message, category, *place, **more: once(f"{category.__name__}: {message}")
warnings.filterwarnings("error", category=FutureWarning)
"""

#: Executed first, too, where outputs are stored.
_TWICE_THE_DOTS = "%config InlineBackend.figure_format = 'retina'"

#: What takes longest begins first, so that no core is left alone with it.
_FIRST = ("pull-off-statistics", "rigid-bodies", "adhesion-verdict")


def small(notebook):
    """Return a notebook with small pictures, without standard error, times or metadata of the kernel."""
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        cell.metadata.pop("outputs_of", None)
        if cell.cell_type == "code":
            cell.outputs = [out for out in cell.outputs if not (out.output_type == "stream" and out.name == "stderr")]
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = _small_picture(output.data["image/png"])
    return notebook


def _small_picture(encoded: str) -> str:
    from PIL import Image

    picture = Image.open(io.BytesIO(base64.b64decode(encoded))).convert("RGB")
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True)
    if buffer.tell() > _LARGE:
        buffer = io.BytesIO()
        smaller = picture.resize((picture.width // 2, picture.height // 2), Image.Resampling.LANCZOS)
        smaller.save(buffer, "PNG", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def execute(path: Path, store: bool) -> tuple[str, bool]:
    """Execute a notebook; return its outcome in words, and whether a cell raised."""
    start = time.perf_counter()
    notebook = nbformat.read(path, as_version=4)
    first = _TWICE_THE_DOTS if store else notebook.metadata.get("quick", "")
    notebook.cells = [new_code_cell(_CAUTIONS + first), *notebook.cells]
    try:
        NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": str(FOLDER)}}).execute()
    except CellExecutionError as error:
        return f"{path.name}: {error}", True
    if store:
        notebook.cells = notebook.cells[1:]
        for number, cell in enumerate((cell for cell in notebook.cells if cell.cell_type == "code"), 1):
            cell.execution_count = number
            for output in cell.outputs:
                if "execution_count" in output:
                    output.execution_count = number
        nbformat.write(small(notebook), path)
    return f"{path.name}: {time.perf_counter() - start:.0f} s{', stored' * store}", False


def main() -> int:
    """Return 0 if every notebook runs."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help="notebooks such as first-steps; default: all")
    parser.add_argument("--store", action="store_true", help="write the outputs into the notebooks")
    options = parser.parse_args()
    os.environ.pop("MPLBACKEND", None)  # a notebook's own shows pictures where they are asked for
    order = {name: k for k, name in enumerate(_FIRST)}
    paths = [path for path in sorted(FOLDER.glob("*.ipynb")) if not options.names or path.stem in options.names]
    paths.sort(key=lambda path: order.get(path.stem, len(order)))
    failures = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in as_completed([pool.submit(execute, path, options.store) for path in paths]):
            report, failed = done.result()
            print(report, flush=True)
            failures += failed
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
