"""Parallel computation of independent tasks, one for each contact centre.

spread       tasks on dask's schedulers: at once, later as a dask array, or within a run
records      the result of one contact centre as a record, and the Dataset of all of them
interrupts   Ctrl-C where Numba or Python hides it
progress     progress bars and the time left
"""
