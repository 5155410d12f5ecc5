"""What the children of ``test_runs`` share: everything that ``a_run`` needs, imported and compiled."""

import dask

from .a_run import solutions, surface

with dask.config.set(scheduler="synchronous"):
    solutions(surface())
