"""Files: scans, force curves and tables as microscopes write them, read and evaluated; scans written.

doors   every input and output: kinds of files, refusals
images  scans: readers of microscopes' formats, containers, NetCDF; `open_scan`, `to_file`
curves  pull-off forces: tables, images of adhesion, force-distance curves and what they hold
"""
