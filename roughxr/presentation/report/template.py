"""Pages made of a template, in which others' text can do no harm."""

from __future__ import annotations

from typing import Any

from ...vocabulary.text import printable


def filled(package: str, **values: Any) -> str:
    """Return a package's ``page.html``, filled; text is escaped for HTML, and its control characters written out."""
    import jinja2

    options = {"autoescape": True, "trim_blocks": True, "lstrip_blocks": True, "finalize": _shown}
    environment = jinja2.Environment(loader=jinja2.PackageLoader(package, "."), **options)
    return environment.get_template("page.html").render(**values)


def _shown(value: Any) -> Any:
    return printable(value, keep="\n\t") if type(value) is str else value
