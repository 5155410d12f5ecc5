"""The documentation's sources: nothing public is left out, and what they show of the command line is there.

Building them is a command of its own (.github/CONTRIBUTING.md), in which every warning is an error.
"""

import re
from pathlib import Path

import pytest

import roughxr
from roughxr import figures
from roughxr.accessor import ContactAccessor

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "notebooks" / "site"


def entries(page: Path) -> set[str]:
    """Return what a page's lists of functions name."""
    return set(re.findall(r"^   ([A-Za-z_0-9.]+)$", page.read_text(encoding="utf-8"), re.MULTILINE))


def test_every_public_function_has_its_page():
    public = {name for name in roughxr.__all__ if callable(getattr(roughxr, name))}
    assert public <= entries(PAGES / "api.rst")


def test_every_verb_of_the_accessor_has_its_page():
    verbs = {name for name in vars(ContactAccessor) if name[0] != "_"}
    assert verbs <= {name.rpartition(".")[2] for name in entries(PAGES / "api.rst")}


def test_every_figure_function_has_its_page():
    assert {f"figures.{name}" for name in figures.__all__} <= entries(PAGES / "api.rst")


def test_the_papers_two_methods_print_what_the_readme_shows():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    code, printed = re.search(r"```python\n([^`]*\.direct\(delta=[^`]*)```\n\n```text\n([^`]*)```", text).groups()
    *statements, direct, superposed = code.strip().splitlines()
    names: dict = {}
    exec("\n".join(statements), names)
    assert [repr(eval(line, names)) for line in (direct, superposed)] == printed.splitlines()


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted(PAGES.glob("*.md"))], ids=lambda page: page.name)
def test_python_that_pages_show_is_python(page):
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        compile(block, str(page), "exec")
