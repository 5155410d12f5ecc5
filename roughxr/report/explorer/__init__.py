"""A run as one page to click through: the scan with its places, and what happens at the one that is chosen.

The page holds everything that it shows and the script that shows it; it needs no network, no server and no library.
"""

from .writing import explorer_page, write_explorer

__all__ = ["explorer_page", "write_explorer"]
