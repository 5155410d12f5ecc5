"""Files of our own, written whole or not at all.

archive         a run as one NetCDF file with groups
checksums       of all that an archive holds
disk            a temporary name first, then the final one
reader_process  a process that reads others' files, and can be ended
netcdf_reader   what it looks at of a NetCDF file
"""
