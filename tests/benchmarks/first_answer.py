"""How long the first answer takes: processor time of the first call of each solver, with an empty cache of kernels.

    python tests/benchmarks/first_answer.py [direct] [adhesive] [superpose] [asperities]

Each call runs in a process of its own whose NUMBA_CACHE_DIR is empty. Printed are seconds of processor time: of the
call itself and of the same call again. On a busy machine processor time rises too,
by half and more: compare runs side by side. Whole commands are measured by `commands.py`.
"""

import os
import subprocess
import sys
import tempfile
import time

CALLS = {
    "direct": "scan.contact.direct(delta=[5, 10, 15], subregions=([312.5], [937.5]))",
    "adhesive": "scan.contact.adhesive(delta=[5, 10, 15], subregions=([312.5], [937.5]), law='griffith', mesh=1)",
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


def main():
    """Measure what the command line names, or all."""
    if sys.argv[1:2] == ["--one"]:
        return one(sys.argv[2])
    for name in sys.argv[1:] or CALLS:
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
            subprocess.run([sys.executable, __file__, "--one", name], env=environment, check=True)


if __name__ == "__main__":
    main()
