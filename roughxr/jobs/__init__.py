"""Many independent tasks, from a list of plain arguments to one array of results.

work          what a job is: a function, its arguments, the size of its results
executor      batches of tasks on threads, processes or a cluster
lazy          the same as a dask array
progress      how far it is
checkpoint    what a run keeps on disk until its archive is whole
fingerprint   what makes two runs the same
run           a run from an empty disk to a whole archive
"""
