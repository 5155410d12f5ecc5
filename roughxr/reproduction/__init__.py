"""What only the comparison with the paper needs, and nothing else knows: its plan, its printed values, its figures.

run      `paper`, the run on the embedded twin of its scan
printed  the paper's own numbers, and how to read them
tables   the main numbers of a run beside them
figures  its figures 2–16
"""

from .figures import paper_figures
from .run import paper
from .tables import contact_table, scan_table

__all__ = ["contact_table", "paper", "paper_figures", "scan_table"]
