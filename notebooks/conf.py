"""The documentation: ``sphinx-build -W notebooks build/site`` builds it from docstrings, pages and stored notebooks."""

import contextlib
import io
import shutil
import tempfile
import warnings
from pathlib import Path

import matplotlib
from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

import roughxr

matplotlib.use("Agg")

# The example pages use coarse meshes, of which roughxr warns; Sphinx's own warnings are no Python warnings.
warnings.simplefilter("ignore", UserWarning)

# Pages of functions are written anew, lest one stay that is gone.
shutil.rmtree(Path(__file__).parent / "site" / "generated", ignore_errors=True)

project = "roughxr"
author = "The roughxr developers"
copyright = "The roughxr developers, BSD-3-Clause"
version = release = roughxr.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
]
exclude_patterns = [".ipynb_checkpoints"]
default_role = "autolink"

# Notebooks are shown as they are stored; tests/notebooks.py --store executes and stores them.
nb_execution_mode = "off"
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
myst_title_to_header = True

autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "pydata_sphinx_theme"
html_static_path = ["site/static"]
html_css_files = ["narrow.css"]
html_title = f"roughxr {version}"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"show_prev_next": False, "navigation_with_keys": False, "header_links_before_dropdown": 6}
_ALONE = "start how-to concepts physics below-the-pixel against-experiment speed other-programs"
_ALONE += " equations citing changelog"
html_sidebars = {f"site/{page}": [] for page in _ALONE.split()}  # pages with no other below them
html_math_renderer = "mathml"


def _inline(writer, node):
    writer.body.append(tex2mathml(node.astext()))
    raise SkipNode


def _block(writer, node):
    writer.body.append(f'<div style="overflow-x: auto; margin: 1em 0">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise SkipNode


def _explored(app, error):
    """Write the page to click through that how-to links to: few places, a coarse mesh."""
    if error or app.builder.name != "html":
        return
    pair = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "work_of_adhesion": 1.35}
    scan = roughxr.assign_pair(roughxr.open_sample("glass"), **pair)
    places = roughxr.scans.regions.centres(scan, (4, 4))
    groups = {
        "scan": scan,
        "asperities": roughxr.asperities(scan),
        "solutions/adhesive": roughxr.adhesive(scan, law="jkr", mesh=2, subregions=places),
        "solutions/direct": roughxr.direct(scan, subregions=places),
        "solutions/energy": roughxr.superpose(scan, subregions=places),
    }
    page = roughxr.report.explorer_page(groups, archive_name="example.nc")
    (Path(app.outdir) / "explore.html").write_text(page, encoding="utf-8")


def _reported(app, error):
    """Write the finished report that the first page links to: a run of the real scan at nine places."""
    if error or app.builder.name != "html":
        return
    scan = roughxr.assign_pair(roughxr.open_sample("rough"), sphere_radius="3 um", materials="glass/silicon")
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        roughxr.run(scan, folder, subregions=(3, 3), budget=0)
        shutil.copy(Path(folder) / "report.html", app.outdir)


def setup(app):
    """Let browsers draw formulas by themselves, so that the pages need no network; build the example pages."""
    app.connect("build-finished", _explored)
    app.connect("build-finished", _reported)
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
