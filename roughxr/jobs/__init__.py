"""Many independent tasks, from a list of plain arguments to one array of results.

work          what a job is: a function, its arguments, the size of its results
schedulers    where tasks are computed: threads, worker processes or a cluster
executor      batches of tasks, handed over as they finish
lazy          one call for all solves: their tasks computed now, later or by a run
progress      how far it is
checkpoint    what a run keeps on disk until its archive is whole
fingerprint   what makes two runs the same
run           a run from an empty disk to a whole archive
"""
