"""How long the first answer takes: processor time of the first call of each solver, with an empty cache of kernels.

    python tests/benchmarks/first_answer.py [direct] [adhesive] [superpose] [asperities] [place] [paper]

Each call runs in a process of its own whose NUMBA_CACHE_DIR is empty. Printed are seconds of processor time: of the
call itself, of the same call again, and how many functions were compiled. For ``paper``, which is the whole command,
they are those of the process, and once more with the kernels kept from the first time; ``place`` is the same at one
place in place of 64 and without the error budget, which compiles the same kernels and takes a minute. On a busy machine
processor time rises too, by half and more: compare runs side by side.
"""

import os
import resource
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


def command(arguments, cache):
    """Run Python in a process of its own; return its processor time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "MPLBACKEND": "Agg"}
    subprocess.run([sys.executable, *arguments], env=environment, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


#: The paper's command: whole, and at one place.
COMMANDS = {
    "paper": "import sys; from roughxr.reproduction import paper; paper(sys.argv[1])",
    "place": """if True:
        import sys
        from roughxr.reproduction import run
        run.PLAN = run.PLAN._replace(subregions=(1, 1))
        run.paper(sys.argv[1], budget=0)""",
}


def paper(name):
    """Print what the paper's command takes from an empty cache, and then."""
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as out:
        took = [command(["-c", COMMANDS[name], f"{out}/{k}"], cache) for k in range(2)]
    print(f"{name:>10}: {took[0]:6.2f} s, again {took[1]:5.2f} s, {took[0] - took[1]:.2f} s more from an empty cache")


def main():
    """Measure what the command line names, or all."""
    if sys.argv[1:2] == ["--one"]:
        return one(sys.argv[2])
    for name in sys.argv[1:] or [*CALLS, *COMMANDS]:
        if name in COMMANDS:
            paper(name)
        else:
            with tempfile.TemporaryDirectory() as cache:
                command([__file__, "--one", name], cache)


if __name__ == "__main__":
    main()
