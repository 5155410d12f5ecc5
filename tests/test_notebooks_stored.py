"""What is compared of a notebook's outputs, and that no notebook names a folder that a reader does not have."""

import re

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook, new_output

from .notebooks import FOLDER, agree, differences, executed, outdated, small, words_of


def cell(text, pictures=0):
    outputs = [new_output("stream", name="stdout", text=text)]
    outputs += [new_output("display_data", data={"image/png": "", "text/plain": "<Figure>"})] * pictures
    return new_code_cell("show()", outputs=outputs)


def test_words_numbers_and_pictures_are_compared():
    stored = new_notebook(cells=[cell("mean 12.345 nN"), cell("done in 3 s"), cell("", pictures=1), cell("8 places")])
    same = new_notebook(cells=[cell("mean 12.346 nN"), cell("done in 41 s"), cell("", pictures=1), cell("8 places")])
    other = new_notebook(cells=[cell("mean 12.9 nN"), cell("done in 3 s"), cell("", pictures=2), cell("8 pixels")])
    assert differences(stored, same) == []
    found = " ".join(differences(stored, other))
    assert re.findall(r"cell (\d)", found) == ["2", "0", "3"]
    assert not agree("−1.5 nm", "1.5 nm")


def test_of_a_quick_run_only_numbers_that_hang_on_its_size_may_differ():
    stored = new_notebook(cells=[cell("mean 1 nN"), cell("mean 1 nN"), cell("", pictures=1)])
    stored.cells[0].metadata["tags"] = ["whole"]
    made = new_notebook(cells=[cell("mean 2 nN"), cell("mean 2 nN"), cell("")])
    found = " ".join(differences(stored, made, quick=True))
    assert re.findall(r"cell (\d)", found) == ["2", "1"]
    assert re.findall(r"cell (\d)", " ".join(differences(stored, made))) == ["2", "0", "1"]


def test_a_quick_run_begins_with_its_own_line_and_keeps_the_cells(tmp_path):
    path = tmp_path / "short.ipynb"
    notebook = new_notebook(cells=[new_code_cell("size = globals().get('size', 100)"), new_code_cell("print(size)")])
    nbformat.write(notebook, path)
    made = executed(path, "size = 2")
    assert [one.source for one in made.cells] == [one.source for one in notebook.cells]
    assert words_of(made.cells[1]) == "2\n" and words_of(executed(path).cells[1]) == "100\n"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_stored_pictures_stand_beside_the_code(path):
    """The site shows notebooks as they are stored: one without outputs would show no picture."""
    shown = [one for one in nbformat.read(path, as_version=4).cells if one.get("outputs")]
    assert shown, "store them: python tests/notebooks.py --store"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_name_no_folder_that_others_lack(path):
    code = "\n".join(one.source for one in nbformat.read(path, as_version=4).cells if one.cell_type == "code")
    assert not re.findall(r"\.\./\.\.|shared/|[\"']/\w+/", code)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_stored_outputs_are_those_of_the_code_beside_them(path):
    assert not outdated(nbformat.read(path, as_version=4)), "store them: python tests/notebooks.py --store"
    assert path.stat().st_size < 1_000_000  # they are for reading where they lie


def test_code_that_changed_since_is_noticed():
    stored = small(new_notebook(cells=[cell("1"), cell("2")]))
    assert outdated(stored) == []
    stored.cells[1].source += "  # and more"
    assert outdated(stored) == [1]
    assert outdated(new_notebook(cells=[new_code_cell("show()")])) == []
