"""Reports of a run: its main numbers and cautions in words, an HTML page to read and one to explore.

Four names are for users; the tables and sentences beside them are what runs and the command line print.
"""
# ruff: noqa: F401

from .budget import budget_table
from .command_line import command
from .detachment_section import COMING_OFF, coming_off_words, detachment_table, moments_of
from .explorer import explorer_page, write_explorer
from .html import page, write_report
from .intervals import interval_table
from .measured_section import measured_table, measured_words
from .places import by_place, with_mesh_error
from .run_warnings import cautions, superposed
from .summary import SUMMARY, headline, recorded
from .tables import METHODS, contact_table, formula_table, scan_table, text

__all__ = ["cautions", "headline", "write_explorer", "write_report"]
