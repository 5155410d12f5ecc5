"""Runs: from a scan's file to an archive with figures and a report.

analysis      `run`, and `paper`, the run on the embedded sample
paper_values  the paper's own numbers
"""
