"""A small run with solves of every kind, about a second long, for tests of interruption and resumption."""

import functools
import os
import signal

import dask
import numpy as np

from roughxr import checkpointed
from roughxr.application import checkpoint
from roughxr.application.checkpoint import Checkpoint
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.jobs.spread import use_scheduler
from roughxr.statistics import pull_off

from .surfaces import glass_pair, rough, scan

CENTRES = (6, 5)
ARGUMENTS = {"subregions": CENTRES, "delta": [1.0, 2.0, 3.0]}


@functools.cache
def surface(seed=3):
    return glass_pair(scan(rough(96, rms=1.5, seed=seed), title=f"surface {seed}"))


def solutions(ds):
    return {
        "solutions/direct": direct(ds, **ARGUMENTS),
        "solutions/contact": direct(ds, fields=True, **ARGUMENTS),
        "solutions/energy": (summed := superpose(ds, delta=np.arange(-5, 5, 0.1), subregions=CENTRES)),
        "statistics/energy": pull_off(summed),
        "statistics/map": pull_off_map(ds, subregions=(40, 40)),
    }


def yield_solutions(ds):
    """Yield the groups one by one, the last several together."""
    yield {"solutions/direct": direct(ds, **ARGUMENTS)}
    yield {"solutions/contact": direct(ds, fields=True, **ARGUMENTS)}
    yield solutions(ds)


def run(output, *, seed=3, arguments=ARGUMENTS, stages=False, scheduler=None, **options):
    ds = surface(seed)
    compute = yield_solutions if stages else solutions
    with use_scheduler(scheduler):
        return checkpointed(lambda: compute(ds), output, scan=ds, arguments=arguments, **options)


def run_in_process(output, stops_after=None, ends_by=signal.SIGKILL, workers_by="spawn", **options):
    """Run as a child process, a file a batch, which ends itself after ``stops_after`` stored batches."""
    checkpoint._BETWEEN_FILES = -1.0
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if stops_after is not None:
        put = Checkpoint.put
        stored = []

        def put_and_stop(self, items, results):
            put(self, items, results)
            stored.append(items)
            if len(stored) == stops_after:
                os.kill(os.getpid(), ends_by)

        Checkpoint.put = put_and_stop
    if options.get("scheduler") == "processes":
        dask.config.set({"num_workers": 2, "multiprocessing.context": workers_by})
    try:
        run(output, **options)
    except BaseException as error:
        os._exit(130 if isinstance(error, KeyboardInterrupt) else 1)
