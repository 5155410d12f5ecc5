"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page.

The names in ``__all__`` are public; runs and the command line use the others.
"""
# ruff: noqa: F401

from .caveats import cautions, superposition_notes
from .detachment import DETACHMENT, detachment_notes, detachment_table, run_moments
from .explorer import explorer_page, write_explorer
from .report_page import page, write_report
from .run_tables import (
    budget_table,
    contact_table,
    force_table,
    formula_table,
    full_budget,
    main_numbers,
    scan_table,
    tables,
    text,
)
from .summary import CRITICAL, SUMMARY, by_place, headline, place_table, run_summary, summary_groups, with_mesh_error

__all__ = ["cautions", "headline", "write_explorer", "write_report"]
