"""Files written whole or not at all, and others' files read in a process that can be ended.

archive         a run as one NetCDF file with groups
checksums       of all that an archive holds
disk            a temporary name first, then the final one
reader_process  a process that reads others' files, and can be ended
netcdf_reader   what it reads of a NetCDF file
"""
