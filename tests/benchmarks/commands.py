"""What whole commands take: processor and wall time, until the first estimate is on the screen, and peak memory.

    python tests/benchmarks/commands.py [help] [import] [places] [paper] [run] [--cold] [--against PATH]
    python tests/benchmarks/commands.py --scans PATH [PATH ...] [--pairs glass polystyrene] [--limit SECONDS]

Each command runs in a process of its own. ``places`` is ``paper`` at four places in place of 64, which compiles the
same kernels; not with ``--against``. ``run`` is README's run on a scan. Kernels come from Numba's cache as it is, so
that a first run fills it; with ``--cold`` each command runs with an empty cache, and then with what this holds.

``--against`` runs each command in turn with this package and with another, a checkout or an environment with
``bin/python``, and prints the ratios of their processor times: of the whole command, and of its part until the
simulation with adhesion begins, which is the paper's own, over the whole command of the other.

``--scans`` runs ``roughxr run SCAN`` with defaults on files, or on all files of a folder, for each pair: a sphere of
glass, 0.5 µm in radius, on silicon, and one of polystyrene, 5 µm in radius, on glass. Its table also has the cells to a
pixel that the run chose, and the mean pull-off that it told last. A run that takes longer than the limit is
interrupted, and its row says where. Where a file is refused, the refusal stands in place of a row.

Processor seconds rise too on a busy machine, by half and more: compare runs side by side.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import NamedTuple

import psutil

_PLACES = """if True:
    import sys
    from roughxr.application.reproduction import run
    run.PLAN = run.PLAN._replace(subregions=(2, 2))
    run.paper(sys.argv[1])"""

#: README's scan and its bodies.
_SCAN = Path(__file__).resolve().parents[2] / "datasets" / "rough.nc"
_SPHERE = ["--sphere-radius", "500 nm", "--materials", "glass/silicon"]

#: Arguments of Python, to which the folder of the output is added.
COMMANDS = {
    "help": lambda out: ["-m", "roughxr", "--help"],
    "import": lambda out: ["-c", "import roughxr"],
    "places": lambda out: ["-c", _PLACES, out],
    "paper": lambda out: ["-m", "roughxr", "paper", "-o", out],
    "run": lambda out: ["-m", "roughxr", "run", str(_SCAN), *_SPHERE, "-o", out],
}

#: How a command may end: well, or interrupted, by its own word or by Python's as it closes.
_ENDS = (0, 130, -signal.SIGINT)

#: A line of progress with an estimate.
_ESTIMATE = re.compile(r"(?:First estimate.*: )?(Mean pull-off \d.*?\))")

#: Options of `roughxr run` for each pair.
PAIRS = {
    "glass": ["--radius", "0.5 um", "--materials", "glass/silicon"],
    "polystyrene": ["--radius", "5 um", "--materials", "polystyrene/glass"],
}


class Took(NamedTuple):
    """What a command took: processor and wall time, processor time until its first estimate (s), memory (MiB)."""

    processor: float
    wall: float
    first: float
    paper: float  # processor time (s) until the simulation with adhesion begins
    memory: float
    estimate: str  # the last estimate on the screen
    stage: str  # the last words of progress
    status: int  # of the process

    def __str__(self):
        return f"{self.processor:7.2f} {self.wall:7.1f} {self.first:6.1f} {self.memory:5.0f}"


def command(arguments, cache=None, limit=None, package=None):
    """Run Python in a process of its own, interrupted after ``limit`` seconds; return what it took."""
    environment = {**os.environ, "MPLBACKEND": "Agg", **({"NUMBA_CACHE_DIR": cache} if cache else {})}
    python = sys.executable
    if package is not None and (package / "bin" / "python").exists():
        python = package / "bin" / "python"
    elif package is not None:
        environment["PYTHONPATH"] = str(package)
    begun = time.monotonic()
    first = 0.0
    paper = 0.0
    estimate_shown = ""
    stage_shown = ""
    line = ""
    streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    # elsewhere than in a checkout, which ``-c`` would import before any other
    process = subprocess.Popen([python, *arguments], env=environment, text=True, cwd=tempfile.gettempdir(), **streams)
    alarm = threading.Timer(limit or threading.TIMEOUT_MAX, process.send_signal, [signal.SIGINT])
    alarm.daemon = True
    alarm.start()
    for line in process.stderr:
        if estimate := _ESTIMATE.match(line):
            first = first or sum(psutil.Process(process.pid).cpu_times()[:2])
            estimate_shown = estimate[1]
        if line.startswith("stage "):
            stage_shown = line.split(":")[0]
            if "simulation with adhesion" in line and not paper:
                paper = sum(psutil.Process(process.pid).cpu_times()[:2])
    _, status, used = os.wait4(process.pid, 0)
    alarm.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in _ENDS:
        print(f"ended with {process.returncode}: {line.strip()}")
    wall = time.monotonic() - begun
    memory = used.ru_maxrss / 1024
    processor = used.ru_utime + used.ru_stime
    return Took(processor, wall, first, paper, memory, estimate_shown, stage_shown, process.returncode)


def whole(name, cold):
    """Print what a whole command takes; with ``cold`` from an empty cache, and then."""
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as out:
        for when in ("cold", "warm") if cold else ("warm",):
            print(f"{name:>10}, {when} {command(COMMANDS[name](f'{out}/{when}'), cache if cold else None)}", flush=True)


def compared(name, cold, other):
    """Print what a whole command takes with this package and with another in turn, and the ratios."""
    packages = {"this": Path(__file__).resolve().parents[2], "other": other.resolve()}
    with tempfile.TemporaryDirectory() as folder:
        for when in ("cold", "warm") if cold else ("warm",):
            took = {}
            for side, package in packages.items():
                out = Path(folder, side)
                out.mkdir(exist_ok=True)
                cache = str(out / "cache") if cold else None
                took[side] = command(COMMANDS[name](str(out / when)), cache, package=package)
                print(f"{name:>10}, {when} {took[side]}  {side}", flush=True)
            of_whole, of_part = (
                seconds / took["other"].processor for seconds in (took["this"].processor, took["this"].paper)
            )
            print(f"{name:>10}, {when} ratio {of_whole:.2f}, of the paper's part {of_part:.2f}", flush=True)


def on_scan(path, pair, limit):
    """Print what a run on a scan takes, and what it found."""
    from roughxr import archive  # not before: the peak of a process begins at that of the one that starts it

    with tempfile.TemporaryDirectory() as out:
        took = command(["-m", "roughxr", "run", str(path), *PAIRS[pair], "-o", out], limit=limit)
        if took.status not in _ENDS:
            return
        kept = Path(out) / "run.nc"
        solved = archive.load(kept).get("solutions/adhesive") if kept.exists() else None
    places, mesh = (solved.sizes["subregion"], int(solved["mesh"].max())) if solved else ("–", "–")
    interrupted = f"interrupted in {took.stage}: " if took.status else ""
    print(f"{path.name:30} {pair:12} {places:>6} {mesh:>4} {took}  {interrupted}{took.estimate}", flush=True)


def main():
    """Measure what the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commands", nargs="*", help=", ".join(COMMANDS))
    parser.add_argument("--cold", action="store_true", help="with an empty cache of kernels, then again")
    parser.add_argument("--against", type=Path, metavar="PATH", help="a checkout or an environment to compare with")
    parser.add_argument("--scans", nargs="+", type=Path, default=[], metavar="PATH", help="files or folders")
    parser.add_argument("--pairs", nargs="+", choices=PAIRS, default=list(PAIRS))
    parser.add_argument("--limit", type=float, help="seconds after which a run on a scan is interrupted")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a command started in the background would ignore it
    unit = f"{'proc. s':>7} {'wall s':>7} {'told':>6} {'MiB':>5}"
    names = options.commands or ([] if options.scans else COMMANDS)
    if names:
        print(f"{'command':>16} {unit}")
    for name in names:
        if options.against is None:
            whole(name, options.cold)
        else:
            compared(name, options.cold, options.against)
    if options.scans:
        print(f"{'scan':30} {'sphere':12} {'places':>6} {'mesh':>4} {unit}  pull-off")
    for pair in options.pairs if options.scans else ():
        for path in options.scans:
            for file in sorted(path.iterdir()) if path.is_dir() else [path]:
                on_scan(file, pair, options.limit)


if __name__ == "__main__":
    main()
