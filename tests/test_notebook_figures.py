"""In a notebook every figure that is asked for appears, the library's and the user's own; it states one duration."""

import re
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="notebooks need nbformat")
nbclient = pytest.importorskip("nbclient", reason="notebooks need nbclient")

#: Cells, and how many pictures each is to show.
CELLS = (
    ("import roughxr; scan = roughxr.open_sample('glass')[{'x': slice(0, 64), 'y': slice(0, 64)}]", 0),
    ("roughxr.figures.scan_map(scan);", 1),
    ("import matplotlib.pyplot as plt; plt.plot([1, 2]); plt.show()", 1),
    ("roughxr.figures.scan_map(scan); roughxr.figures.scan_map(scan);", 2),
    ("fig, ax = plt.subplots(); ax.plot([1, 2]);", 1),
    ("scan.height.plot();", 1),
)


@pytest.mark.parametrize("first", ["", pytest.param("import matplotlib.pyplot as plt", marks=pytest.mark.soak)])
def test_every_figure_asked_for_appears(first, monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)  # a notebook's own is the one to be tried
    cells = [nbformat.v4.new_code_cell(source) for source in (first, *(source for source, _ in CELLS))]
    notebook = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    shown = [sum("image/png" in output.get("data", {}) for output in cell.outputs) for cell in notebook.cells]
    assert shown == [0, *(pictures for _, pictures in CELLS)]


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb")), ids=lambda path: path.stem
)
def test_a_notebook_states_its_duration_once(path):
    notebook = nbformat.read(path, as_version=4)
    text = notebook.cells[0].source
    assert len(re.findall(r"\*Runs in about [^*]+ on two cores\.\*", text)) == 1
    assert not re.search(r"takes\s+\S+\s+(to\s+\S+\s+)?minutes", text)
