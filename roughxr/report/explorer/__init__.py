"""A run as an interactive page: a map of the scan with its places, and the results at the place that is chosen.

The page is self-contained, its script included: it needs no network, no server and no library.
"""

from .writing import explorer_page, write_explorer

__all__ = ["explorer_page", "write_explorer"]
