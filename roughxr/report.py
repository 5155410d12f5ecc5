"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page."""

from .application.report.caveats import cautions
from .application.report.explorer import write_explorer
from .application.report.report_page import write_report
from .application.report.summary import headline

__all__ = [
    "cautions",
    "headline",
    "write_explorer",
    "write_report",
]
