"""Execute every notebook from its folder, and see to it that none is stored with outputs.

Run as a script: ``python tests/notebooks.py``.
"""

import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[1] / "notebooks"


def stored_outputs(notebook):
    """Return the number of cells that hold outputs or an execution count."""
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return sum(bool(cell.outputs) or cell.execution_count is not None for cell in code)


def main():
    """Return 0 if every notebook runs and is stored bare."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        notebook = nbformat.read(path, as_version=4)
        if stored_outputs(notebook):
            print(f"{path.name}: expected no stored outputs, found {stored_outputs(notebook)} cells; clear them")
            return 1
        start = time.perf_counter()
        NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(FOLDER)}}).execute()
        print(f"{path.name}: {time.perf_counter() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
