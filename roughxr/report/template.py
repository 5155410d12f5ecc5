"""Pages from a template, with all text from files escaped."""

from __future__ import annotations

import base64
import os
from pathlib import Path
from typing import Any

import xarray as xr

from ..archive import whole
from ..vocabulary.text import printable


def filled(package: str, **values: Any) -> str:
    """Return a package's ``page.html``, filled; text is escaped for HTML, and its control characters written out."""
    import jinja2

    options: dict[str, Any] = {"autoescape": True, "trim_blocks": True, "lstrip_blocks": True, "finalize": _shown}
    environment = jinja2.Environment(loader=jinja2.PackageLoader(package, "."), **options)
    return environment.get_template("page.html").render(**values)


def written(text: str, archive: Path, output: str | os.PathLike | None, name: str) -> Path:
    """Write a page, by default under this name beside its archive, and return its path."""
    output = archive.with_name(name) if output is None else Path(output)
    with whole(output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return output


def as_uri(png: bytes) -> str:
    """Return an image as text that stands inside a page."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def title(scan: xr.Dataset) -> str:
    """Return the title of a page about a scan."""
    return str(scan.attrs.get("title") or scan.attrs.get("source_file") or "A run of roughxr")


def _shown(value: Any) -> Any:
    return printable(value, keep="\n\t") if type(value) is str else value
