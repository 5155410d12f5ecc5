"""How long the first answer takes on a fresh machine: README's commands, and the first call of each solver.

    python tests/benchmarks/first_answer.py [paper] [pytest]
    python tests/benchmarks/first_answer.py [direct] [adhesive] [superpose] [asperities]

``paper`` and ``pytest`` are README's first command and its tests, taken from it and run in a clone with an environment
of their own, so that all kernels are compiled: wall and processor time (s) of each part, and their sum. Aims on two
idle cores: 120 and 300 s of wall time. pip takes packages from its cache, as far as it has them.

Solvers run in a process of their own whose NUMBA_CACHE_DIR is empty. Printed are seconds of processor time: of the
call itself and of the same call again. On a busy machine processor time rises too,
by half and more: compare runs side by side. Whole commands on scans are measured by `commands.py`.
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CALLS = {
    "direct": "scan.contact.direct(delta=[5, 10, 15], subregions=([312.5], [937.5]))",
    "adhesive": "scan.contact.adhesive(delta=[5, 10, 15], subregions=([312.5], [937.5]), law='jkr', mesh=1)",
    "superpose": "scan.contact.superpose(delta=[0, 5, 10, 15], subregions=(2, 2))",
    "asperities": "scan.contact.asperities()",
}


def one(name):
    """Make one call twice in this process and print what it took."""
    import warnings

    import roughxr

    warnings.simplefilter("ignore")
    scan = roughxr.open_sample("glass").contact.assign_pair(
        sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675
    )
    begun = time.process_time()
    eval(CALLS[name], {"scan": scan})
    first = time.process_time()
    eval(CALLS[name], {"scan": scan})
    again = time.process_time()
    print(f"{name:>10}: {first - begun:6.2f} s, again {again - first:5.2f} s")


def readme(name):
    """Run the command of README that ends with this program in a clone, and print what each of its parts took."""
    repository = Path(__file__).parents[2]
    line = re.search(rf"^python3 -m venv .*\b{name}\b.*$", (repository / "README.md").read_text(), re.MULTILINE)[0]
    hidden = ("NUMBA_CACHE_DIR", "PYTHONPATH", "VIRTUAL_ENV")
    environment = {key: value for key, value in os.environ.items() if key not in hidden} | {"MPLBACKEND": "Agg"}
    print(f"{os.cpu_count()} cores, load at the beginning {os.getloadavg()[0]:.1f}")
    walls = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["git", "clone", "-q", repository, folder], check=True)
        for part in line.split(" && "):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            begun = time.monotonic()
            subprocess.run(part, shell=True, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            walls.append(time.monotonic() - begun)
            used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
            print(f"{walls[-1]:7.1f} s of wall, {used:7.1f} s of processor time: {part}", flush=True)
    print(f"{sum(walls):7.1f} s of wall time in all")


def main():
    """Measure what the command line names, or all."""
    if sys.argv[1:2] == ["--one"]:
        return one(sys.argv[2])
    for name in sys.argv[1:] or CALLS:
        if name not in CALLS:
            readme(name)
            continue
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
            subprocess.run([sys.executable, __file__, "--one", name], env=environment, check=True)


if __name__ == "__main__":
    main()
