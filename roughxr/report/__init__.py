"""Reports of a run: its main numbers and cautions in words, an HTML page to read and one to explore.

Four names are for users; the tables and sentences beside them are what runs and the command line print.
"""
# ruff: noqa: F401

from .caveats import cautions, superposed
from .detachment import CRITICAL, DETACHMENT, detachment_notes, detachment_table, moments_of
from .explorer import explorer_page, write_explorer
from .report_page import page, write_report
from .run_tables import budget_table, contact_table, force_table, formula_table, main_numbers, scan_table, tables, text
from .summary import SUMMARY, by_place, headline, place_table, recorded, run_summary, with_mesh_error

__all__ = ["cautions", "headline", "write_explorer", "write_report"]
