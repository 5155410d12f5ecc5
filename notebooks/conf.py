"""The documentation: ``sphinx-build -W notebooks build/site`` builds it from docstrings, pages and stored notebooks."""

import shutil
import warnings
from pathlib import Path

import matplotlib
import sphinx_autosummary_accessors
from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

import roughxr

matplotlib.use("Agg")

# The gallery's meshes are coarse, of which roughxr warns; Sphinx's own warnings are no Python warnings.
warnings.simplefilter("ignore", UserWarning)

# Pages of functions are written anew, lest one stay that is gone.
shutil.rmtree(Path(__file__).parent / "site" / "generated", ignore_errors=True)

project = "roughxr"
author = "the authors of roughxr"
copyright = "the authors of roughxr, BSD-3-Clause"
version = release = roughxr.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "matplotlib.sphinxext.plot_directive",
    "sphinx_autosummary_accessors",
]
templates_path = [sphinx_autosummary_accessors.templates_path]
exclude_patterns = [".ipynb_checkpoints"]
default_role = "autolink"

# Notebooks are shown as they are stored; tests/notebooks.py tells whether that is what they say today.
nb_execution_mode = "off"
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3

autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False

plot_pre_code = ""
plot_include_source = True
plot_html_show_source_link = False
plot_html_show_formats = False
plot_formats = [("png", 130)]

html_theme = "pydata_sphinx_theme"
html_static_path = ["site/static"]
html_css_files = ["narrow.css"]
html_title = f"roughxr {version}"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"show_prev_next": False, "navigation_with_keys": False, "header_links_before_dropdown": 6}
_ALONE = "start how-to concepts physics gallery paper-values speed peers changelog"
html_sidebars = {f"site/{page}": [] for page in _ALONE.split()}  # pages with no other below them
html_math_renderer = "mathml"


def _inline(writer, node):
    writer.body.append(tex2mathml(node.astext()))
    raise SkipNode


def _block(writer, node):
    writer.body.append(f'<div style="overflow-x: auto; margin: 1em 0">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise SkipNode


def setup(app):
    """Let browsers draw formulas by themselves, so that the pages need no network."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
