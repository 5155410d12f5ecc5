"""Reproduction of Cheng, Dunn & Brach: their plan, their printed values and their figures 2–16."""

from .numbered_figures import paper_figures
from .printed_tables import contact_table, paper_tables, scan_table
from .run import paper

__all__ = ["contact_table", "paper", "paper_figures", "paper_tables", "scan_table"]
