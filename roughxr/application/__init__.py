"""The application: runs, their archives, and what people read of them.

archive       NetCDF files of runs; `checkpoint`, a run that resumes
samples       scans that come with the package
tables        results as tables
headline      the answer in words; `sentences`, results in words
dem           input for particle codes
figures       figures of results
report        words, tables and pages of a run
runs          from scans to archives with figures and pages
reproduction  the paper's plan, printed values, tables and figures
cli           the command line
wording       what people read, as text files
"""
