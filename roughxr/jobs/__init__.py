"""Many independent tasks, from a list of plain arguments to one array of results.

work          a job: a function, its arguments, the dtype of its results
schedulers    where tasks are computed: threads, worker processes or a cluster
records       one record for each place, and the Dataset of all of them
executor      batches of tasks, whose results are handed over as they finish
lazy          how every solve has its tasks computed: now, later as a dask array, or within a run
progress      reports of how many items are finished
checkpoint    what a run keeps on disk until its archive is complete
fingerprint   what identifies a run
run           a run from an empty disk to a complete archive
"""
