"""The documentation: ``sphinx-build -W notebooks build/site`` builds it from docstrings, pages and stored notebooks."""

import contextlib
import io
import shutil
import sys
import tempfile
import warnings
import zlib
from pathlib import Path

import matplotlib
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

import roughxr

sys.path.insert(0, str(Path(__file__).parent))

from gallery import write_gallery
from verification import table

matplotlib.use("Agg")

# Modules under the names by which users know them.
sys.modules |= {f"roughxr.{name}": getattr(roughxr, name) for name in ("reference", "schema")}
sys.modules |= {f"roughxr.scans.{name}": getattr(roughxr.scans, name) for name in ("regions", "synthetic")}

# The example pages use coarse meshes, of which roughxr warns; Sphinx's own warnings are no Python warnings.
warnings.simplefilter("ignore", UserWarning)

# Pages of functions are written anew, lest one stay that is gone.
GENERATED = Path(__file__).parent / "site" / "generated"
shutil.rmtree(GENERATED, ignore_errors=True)

project = "roughxr"
author = "The roughxr developers"
copyright = "The roughxr developers, BSD-3-Clause"
version = release = roughxr.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.napoleon",
]
# Pages of other packages that are linked, listed here so that building needs no network.
_LINKED = {
    "xarray": ("https://docs.xarray.dev/en/stable/", "generated", ("Dataset", "DataArray", "open_dataset")),
    "numpy": ("https://numpy.org/doc/stable/", "reference/generated", ("histogram_bin_edges",)),
    "scipy": ("https://docs.scipy.org/doc/scipy/", "reference/generated", ("signal.get_window",)),
}
intersphinx_mapping = {name: (site, str(GENERATED / f"{name}.inv")) for name, (site, _, _) in _LINKED.items()}

exclude_patterns = [".ipynb_checkpoints"]
default_role = "autolink"

# Notebooks are shown as they are stored; tests/notebooks.py --store executes and stores them.
nb_execution_mode = "off"
myst_enable_extensions = ["dollarmath", "colon_fence", "attrs_inline"]
myst_heading_anchors = 3
myst_title_to_header = True

autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = True
napoleon_type_aliases = {name: f":class:`~xarray.{name}`" for name in ("Dataset", "DataArray")}

# Names of packages are resolved; other words of a type, such as "number or quantity", are prose; fields have no page.
nitpicky = True
nitpick_ignore_regex = [("py:class", r"(?!roughxr|xarray|numpy).*"), ("py:obj", r"roughxr\.(\w+\.)*[A-Z]\w+\.\w+")]

html_theme = "pydata_sphinx_theme"
html_static_path = ["site/static"]
html_css_files = ["narrow.css"]
html_title = f"roughxr {version}"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"show_prev_next": False, "navigation_with_keys": False, "header_links_before_dropdown": 7}
_ALONE = "start five-and-five tutorial faq gallery verification concepts physics below-the-pixel"
_ALONE += " against-experiment speed other-programs equations citing changelog"
html_sidebars = {f"site/{page}": [] for page in _ALONE.split()}  # pages with no other below them
html_math_renderer = "mathml"


def _inline(writer, node):
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def _block(writer, node):
    writer.body.append(f'<div style="overflow-x: auto; margin: 1em 0">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode


def _documented_elsewhere(app, env, node, contnode):
    """Return the link of a name that is documented in another module of the package."""
    domain = env.get_domain("py")
    names = [name for name in domain.objects if name.endswith(f".{node.get('reftarget')}")]
    if node.get("refdomain") != "py" or len(names) != 1:
        return None
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", names[0], node, contnode)


_README_RUN = "roughxr run datasets/rough.nc --sphere-radius '500 nm' --materials glass/silicon -o run"


def _example_run(app, error):
    """Write the report and the interactive page that the first page links to: those of the README's run."""
    if error or app.builder.name != "html":
        return
    scan = roughxr.assign_pair(roughxr.open_sample("rough"), sphere_radius="500 nm", materials="glass/silicon")
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        roughxr.run(scan, folder, command=_README_RUN)
        roughxr.report.write_explorer(folder, Path(app.outdir) / "explore.html")
        shutil.copy(Path(folder) / "report.html", app.outdir)


def _computed_pages():
    """Write what is computed: the gallery's pictures, the comparison with closed forms, lists of linked pages."""
    GENERATED.mkdir()
    for package, (_, folder, names) in _LINKED.items():
        head = f"# Sphinx inventory version 2\n# Project: {package}\n# Version: \n# compressed by zlib\n"
        kinds = {name: "class" if name[0].isupper() else "function" for name in names}
        lines = "".join(
            f"{package}.{name} py:{kind} 1 {folder}/{package}.{name}.html#$ -\n" for name, kind in kinds.items()
        )
        (GENERATED / f"{package}.inv").write_bytes(head.encode() + zlib.compress(lines.encode()))
    (GENERATED / "gallery.txt").write_text(write_gallery(GENERATED), encoding="utf-8")
    (GENERATED / "verification.txt").write_text(table(), encoding="utf-8")


def _describe_pictures(app, doctree):
    """Give the pictures of notebooks the title of their section as alternative text."""
    for image in doctree.findall(nodes.image):
        section = image.parent
        while not isinstance(section, (nodes.section, nodes.document)):
            section = section.parent
        title = section.next_node(nodes.title)
        if title is not None:
            image.setdefault("alt", f"Figure: {title.astext()}")


def setup(app):
    """Let browsers draw formulas by themselves, so that the pages need no network; build the example pages."""
    _computed_pages()
    app.connect("doctree-read", _describe_pictures)
    app.connect("missing-reference", _documented_elsewhere)
    app.connect("build-finished", _example_run)
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
