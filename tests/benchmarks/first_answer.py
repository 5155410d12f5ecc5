"""How long the first answer takes: processor time of the first call of each solver, with an empty cache of kernels.

    python tests/benchmarks/first_answer.py [direct] [adhesive] [superpose] [asperities] [place] [paper] [help]

Each call runs in a process of its own whose NUMBA_CACHE_DIR is empty. Printed are seconds of processor time: of the
call itself, of the same call again, and how many functions were compiled. For ``paper``, which is the whole command,
they are those of the process, and once more with the kernels kept from the first time, each with the wall time, what
it took to the first estimate on the screen, and the peak memory; ``place`` is the same at one place in place of 64
and without the error budget, which compiles the same kernels and takes a minute; ``help`` is ``roughxr --help``. On a
busy machine processor time rises too, by half and more: compare runs side by side.
"""

import os
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

import psutil

CALLS = {
    "direct": "scan.contact.direct(delta=[5, 10, 15], subregions=([312.5], [937.5]))",
    "adhesive": "scan.contact.adhesive(delta=[5, 10, 15], subregions=([312.5], [937.5]), law='griffith', mesh=1)",
    "superpose": "scan.contact.superpose(delta=[0, 5, 10, 15], subregions=(2, 2))",
    "asperities": "scan.contact.asperities()",
}


def one(name):
    """Make one call twice in this process and print what it took."""
    import warnings

    from numba.core import event

    import roughxr

    warnings.simplefilter("ignore")
    scan = roughxr.open_sample("glass").contact.assign_pair(
        sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675
    )
    with event.install_recorder("numba:compile") as compiled:
        begun = time.process_time()
        eval(CALLS[name], {"scan": scan})
        first = time.process_time()
    eval(CALLS[name], {"scan": scan})
    again = time.process_time()
    print(f"{name:>10}: {first - begun:6.2f} s, again {again - first:5.2f} s, {len(compiled.buffer) // 2} compiled")


class Took(NamedTuple):
    """What a command took: processor and wall time, processor time until its first estimate (s), and memory (MiB)."""

    processor: float
    wall: float
    first: float
    memory: float

    def __str__(self):
        told = f", first estimate after {self.first:.1f} s of processor time" if self.first else ""
        return f"{self.processor:6.2f} s ({self.wall:.1f} s wall{told}, {self.memory:.0f} MiB)"


def command(arguments, cache, *, quiet=False):
    """Run Python in a process of its own; return what it took."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "MPLBACKEND": "Agg"}
    begun, first = time.monotonic(), 0.0
    streams = {"stdout": subprocess.DEVNULL if quiet else None, "stderr": subprocess.PIPE if quiet else None}
    process = subprocess.Popen([sys.executable, *arguments], env=environment, text=True, **streams)
    for line in process.stderr or ():
        if "pull-off" in line and not first:
            first = sum(psutil.Process(process.pid).cpu_times()[:2])
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if status:
        raise SystemExit(f"{arguments}: ended with {process.returncode}")
    return Took(used.ru_utime + used.ru_stime, time.monotonic() - begun, first, used.ru_maxrss / 1024)


#: The paper's command: whole, and at one place.
COMMANDS = {
    "paper": "import sys; from roughxr.cli import main; main(['paper', '-o', sys.argv[1]])",
    "place": """if True:
        import sys
        from roughxr.reproduction import run
        run.PLAN = run.PLAN._replace(subregions=(1, 1))
        run.paper(sys.argv[1], budget=0)""",
    "help": "from roughxr.cli import main; main(['--help'])",
}


def whole(name):
    """Print what a whole command takes from an empty cache, and then."""
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as out:
        for when in ("cold", "warm"):
            print(f"{name:>10}, {when}: {command(['-c', COMMANDS[name], f'{out}/{when}'], cache, quiet=True)}")


def main():
    """Measure what the command line names, or all."""
    if sys.argv[1:2] == ["--one"]:
        return one(sys.argv[2])
    for name in sys.argv[1:] or [*CALLS, *COMMANDS]:
        if name in COMMANDS:
            whole(name)
        else:
            with tempfile.TemporaryDirectory() as cache:
                command([__file__, "--one", name], cache)


if __name__ == "__main__":
    main()
