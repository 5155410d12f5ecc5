"""Runs: from a scan, or several, to archives with figures, tables and reports."""
