"""`report` and `explore`: the pages of a finished run."""

from __future__ import annotations

import webbrowser
from argparse import Namespace

from ..report import write_explorer, write_report


def report(options: Namespace) -> None:
    """Write the report."""
    print(f"written to {write_report(options.run, options.output)}")


def explore(options: Namespace) -> None:
    """Write the page to click through, and show it if asked to."""
    page = write_explorer(options.run, options.output)
    print(f"written to {page}")
    if options.open:
        webbrowser.open(page.resolve().as_uri())
