"""What is shown: figures, reports, tables.

figures  any result as a picture
report   a run as one page, and as a page to click through
exports  results as tables for other programs
"""
