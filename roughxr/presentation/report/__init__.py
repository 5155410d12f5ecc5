"""Reports of a run: tables as text, the main numbers with their intervals, an HTML page to read and one to explore."""

from .beside_measured import measured_table, measured_words
from .budget import budget_table, headline
from .coming_off import COMING_OFF, coming_off_words, detachment_table, moments_of
from .explorer import explorer_page, write_explorer
from .html import page, write_report
from .intervals import interval_table
from .places import by_place
from .repeat import command
from .tables import METHODS, contact_table, formula_table, scan_table, text
from .warnings_shown import cautions, superposed

__all__ = [
    "COMING_OFF",
    "METHODS",
    "budget_table",
    "by_place",
    "cautions",
    "coming_off_words",
    "command",
    "contact_table",
    "detachment_table",
    "explorer_page",
    "formula_table",
    "headline",
    "interval_table",
    "measured_table",
    "measured_words",
    "moments_of",
    "page",
    "scan_table",
    "superposed",
    "text",
    "write_explorer",
    "write_report",
]
