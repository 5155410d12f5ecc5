"""Many independent tasks, from a list of plain arguments to one array of results.

spread       tasks on dask's schedulers: at once, later as a dask array, or within a run
records      one record for each place, and the Dataset of all of them
checkpoint   a run from an empty disk to a complete archive, which resumes after whatever stops it
progress     reports of how many subregions are finished
"""
