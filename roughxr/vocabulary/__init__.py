"""The vocabulary: names, units and signs of everything that a Dataset holds.

schema  the table of names, validation at the door, labels on results, history
text    what stands in others' files, as it may be shown
units   conversion of input, by pint
"""
