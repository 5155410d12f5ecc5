"""Files of our own, written whole or not at all.

archive  a run as one NetCDF file with groups
disk     a temporary name first, then the final one
"""
