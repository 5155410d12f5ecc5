"""Runs: from a scan to an archive with figures, tables and a report."""
