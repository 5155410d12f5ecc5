"""Reports of a run: its main numbers and cautions in words, a static and an interactive HTML page.

The names in ``__all__`` are public; runs and the command line use the others.
"""
# ruff: noqa: F401

from .caveats import cautions, superposition_notes
from .detachment import detachment_notes
from .explorer import explorer_page, write_explorer
from .report_page import page, write_report
from .run_numbers import run_moments
from .run_tables import run_errors, tables, text
from .summary import (
    CRITICAL,
    DETACHMENT,
    SUMMARY,
    by_place,
    headline,
    headline_lines,
    place_table,
    run_summary,
    summary_groups,
    with_mesh_error,
)

__all__ = ["cautions", "headline", "write_explorer", "write_report"]
