"""The vocabulary: names, units and signs of everything that a Dataset holds.

variables   the table of names
schema      validation of input, labels of results, pixels and heights of a scan
provenance  the steps that made a Dataset
text        what stands in others' files, as it may be shown; warnings
units       conversion of input, by pint
numbers     numbers as they are printed
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["schema"])
