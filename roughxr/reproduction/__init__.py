"""Reproduction of Cheng, Dunn & Brach: their plan, their printed values and their figures 2–16."""

from .numbered_figures import paper_figures
from .run import contact_table, paper, scan_table

__all__ = ["contact_table", "paper", "paper_figures", "scan_table"]
