"""Scans: levelling, regions, roughness and spectra, tip, editing, made surfaces."""
