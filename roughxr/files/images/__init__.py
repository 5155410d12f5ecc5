"""Scans in files: microscopes' formats, containers, NetCDF; what is doubtful in them; files of scans."""
