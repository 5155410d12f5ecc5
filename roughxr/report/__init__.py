"""A run told to its readers: tables as text, the main numbers with their intervals, and one page that holds all."""

from .cautions import cautions
from .command import command
from .intervals import interval_table
from .page import page, write_report
from .tables import METHODS, contact_table, scan_table, text

__all__ = [
    "METHODS",
    "cautions",
    "command",
    "contact_table",
    "interval_table",
    "page",
    "scan_table",
    "text",
    "write_report",
]
