"""A run told to its readers: tables as text, the main numbers with their intervals, a page to read and one to click."""

from .budget import budget_table, headline
from .explorer import explorer_page, write_explorer
from .html import page, write_report
from .intervals import interval_table
from .repeat import command
from .tables import METHODS, contact_table, formula_table, scan_table, text
from .warnings_shown import cautions, superposed

__all__ = [
    "METHODS",
    "budget_table",
    "cautions",
    "command",
    "contact_table",
    "explorer_page",
    "formula_table",
    "headline",
    "interval_table",
    "page",
    "scan_table",
    "superposed",
    "text",
    "write_explorer",
    "write_report",
]
