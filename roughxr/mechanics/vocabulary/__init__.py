"""The vocabulary: names, units and signs of all variables, conversion of units, and formatting of numbers.

table           the table of names
adhesion_laws   the table of laws of adhesion
error_sources   the table of sources of error
schema          validation of input, labels of results, pixels and heights of a scan
provenance      the history of a Dataset
text            escaping of control characters, suggestions for misspelt words, warnings
units           conversion of input, by pint
numbers         formatting of numbers
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["schema"])
