"""The vocabulary: names, units and signs of everything that a Dataset holds.

schema  the table of names, validation at the door, labels on results, history
units   conversion of input, by pint
"""
