"""Execute every notebook from its folder; compare what comes out with what is stored, or store it.

Run as a script: ``python tests/notebooks.py`` executes all, one on every core, and fails where words, numbers or the
count of pictures differ from what a notebook holds (one that holds no outputs is executed only);
``python tests/notebooks.py --store`` writes the outputs into the notebooks, pictures as small PNG files, with a mark of
the code that made them. Names of notebooks restrict either.

A notebook that takes minutes may hold, in its own metadata under ``quick``, a line of code that lets it do with less:
that line goes before its cells, unless ``--all`` or ``--store`` asks for the whole. What then differs are the numbers
of cells with the tag ``whole``, which are not compared; all else is.
"""

import argparse
import base64
import hashlib
import io
import math
import os
import re
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat.v4 import new_code_cell

FOLDER = Path(__file__).parents[1] / "notebooks"

#: Numbers in outputs agree within this part: machines differ in the last digits.
_AGREE = 2e-3

#: Pixels that a stored picture is wide, the most that do not make it too large, and its colours: it is for reading
#: where it lies.
_WIDTHS, _LARGE, _COLOURS = (640, 520, 420), 50_000, 64

#: What takes longest begins first, so that no core is left alone with it.
_FIRST = ("the-paper", "rigid-bodies", "adhesion-verdict")

_NUMBER = re.compile(r"[-−]?\d+\.?\d*(?:e[-+]?\d+)?")

#: What differs from run to run: addresses, and times that something took.
_FLEETING = re.compile(r"0x[0-9a-f]+|\b\d+(?:\.\d+)? (?:ms|s|min)\b")


def words_of(cell) -> str:
    """Return what a cell prints and shows as text, but for warnings and progress on standard error."""
    parts = []
    for output in cell.get("outputs", ()):
        if output.output_type == "stream" and output.name == "stdout":
            parts.append(output.text)
        elif "data" in output and "image/png" not in output.data:
            parts.append("".join(output.data.get("text/plain", "")))
    return _FLEETING.sub("", "\n".join(parts))


def pictures_of(cell) -> int:
    """Return how many pictures a cell shows."""
    return sum("image/png" in output.get("data", {}) for output in cell.get("outputs", ()))


def agree(one: str, other: str) -> bool:
    """Say whether two texts have the same words, and numbers that agree.

    >>> agree("mean 1.2345 nN", "mean 1.2346 nN"), agree("mean 1.2 nN", "mean 1.3 nN"), agree("a 1", "b 1")
    (True, False, False)
    """
    if _NUMBER.sub("#", one).split() != _NUMBER.sub("#", other).split():
        return False
    pairs = zip(*([float(text.replace("−", "-")) for text in _NUMBER.findall(words)] for words in (one, other)))
    return all(math.isclose(a, b, rel_tol=_AGREE, abs_tol=1e-9) for a, b in pairs)


def differences(stored, made, quick: bool = False) -> list[str]:
    """Return in words which cells came out other than they are stored, of a quick run but for some cells' numbers."""
    code = [(k, *cells) for k, cells in enumerate(zip(stored.cells, made.cells)) if cells[0].cell_type == "code"]
    found = [
        f"cell {k}: {pictures_of(a)} pictures stored, {pictures_of(b)} made"
        for k, a, b in code
        if pictures_of(a) != pictures_of(b)
    ]
    code = [(k, a, b) for k, a, b in code if not (quick and "whole" in a.metadata.get("tags", ()))]
    return found + [f"cell {k}: its words or numbers differ" for k, a, b in code if not agree(words_of(a), words_of(b))]


def source_mark(cell) -> str:
    """Return what tells a cell's code from any other."""
    return hashlib.sha256(cell.source.encode()).hexdigest()[:16]


def outdated(notebook) -> list[int]:
    """Return the cells whose code is not that of which the outputs are stored; none of a notebook without outputs."""
    code = [(k, cell) for k, cell in enumerate(notebook.cells) if cell.cell_type == "code"]
    if not any(cell.get("outputs") for _, cell in code):
        return []
    return [k for k, cell in code if cell.metadata.get("outputs_of") != source_mark(cell)]


def small(notebook):
    """Return a notebook with small pictures, without what standard error said, times or a kernel's own marks."""
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            cell.metadata["outputs_of"] = source_mark(cell)
            cell.outputs = [o for o in cell.outputs if not (o.output_type == "stream" and o.name == "stderr")]
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = _small_picture(output.data["image/png"])
    return notebook


def _small_picture(encoded: str) -> str:
    from PIL import Image

    picture = Image.open(io.BytesIO(base64.b64decode(encoded))).convert("RGB")
    for width in _WIDTHS:
        if picture.width > width:
            picture = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
        buffer = io.BytesIO()
        picture.quantize(_COLOURS).save(buffer, "PNG", optimize=True)
        if buffer.tell() < _LARGE:
            break
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def executed(path: Path, first: str = ""):
    """Return a notebook as it comes out of a run from its own folder, some code before its own."""
    notebook = nbformat.read(path, as_version=4)
    before = [new_code_cell(first)] if first else []
    notebook.cells = before + notebook.cells
    NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": str(FOLDER)}}).execute()
    notebook.cells = notebook.cells[len(before) :]
    return notebook


def judged(path: Path, store: bool, whole: bool) -> tuple[str, bool]:
    """Execute a notebook, and return what came of it in words, and whether it is wrong."""
    start, stored = time.perf_counter(), nbformat.read(path, as_version=4)
    quick = "" if store or whole else stored.metadata.get("quick", "")
    try:
        made = executed(path, quick)
    except CellExecutionError as error:
        return f"{path.name}: {error}", True
    if store:
        nbformat.write(small(made), path)
    bare = not any(cell.get("outputs") for cell in stored.cells)
    found = [] if store or bare else differences(stored, made, bool(quick))
    state = "stored" if store else "bare" if bare else "; ".join(found) or "as stored" + ", but for size" * bool(quick)
    return f"{path.name}: {time.perf_counter() - start:.0f} s, {state}", bool(found)


def main() -> int:
    """Return 0 if every notebook runs, and says what it is stored with."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help="notebooks such as first-steps; default: all")
    parser.add_argument("--store", action="store_true", help="write the outputs into the notebooks")
    parser.add_argument("--all", action="store_true", help="execute all of those, too, that can do with less")
    options = parser.parse_args()
    os.environ.pop("MPLBACKEND", None)  # a notebook's own shows pictures where they are asked for
    order = {name: k for k, name in enumerate(_FIRST)}
    paths = [path for path in sorted(FOLDER.glob("*.ipynb")) if not options.names or path.stem in options.names]
    paths.sort(key=lambda path: order.get(path.stem, len(order)))
    wrong = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in as_completed([pool.submit(judged, path, options.store, options.all) for path in paths]):
            told, failed = done.result()
            print(told, flush=True)
            wrong += failed
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
