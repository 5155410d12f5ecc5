"""How many small faults, put into a kernel one at a time, its tests notice.

    python tests/benchmarks/mutation.py [--only statistics] [--sample 20] [--seed 0] [--jobs 2] [--survivors]

For each file a sample of mutants is drawn: an operator, a comparison, a constant or a condition changed, or an
assignment left out. The tests named for the file run on each, kernels uncompiled, those alone that take less than
``--longest`` seconds so; a mutant is killed where one of them fails or the whole takes ten times as long. Some mutants
are no faults (a tolerance moved, < for <= on floating-point numbers), so that 100 % is out of reach.
"""

import argparse
import ast
import copy
import os
import signal
import sys
import time
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("MPLBACKEND", "Agg")

import dask.array  # noqa: F401  what every child needs, imported once
import numba
import numpy as np
import pytest
import scipy.stats  # noqa: F401
import xarray  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]

#: The files of each group, and the tests that should notice.
GROUPS = {
    "halfspace": (
        "roughxr/kernels/halfspace/*.py",
        ["halfspace", "warm_start", "displacement_control", "without_jit_cases", "yielding"],
    ),
    "adhesion": ("roughxr/kernels/adhesion/*.py", ["constrained_cells", "adhesion_smooth", "reference", "rigid"]),
    "asperity": (
        "roughxr/kernels/asperity/*.py",
        [
            "ellipse",
            "asperity_contact",
            "maugis",
            "superposition",
            "superposition_maugis",
            "pull_off_map",
            "largest_pull",
            "flattening",
            "rotation",
        ],
    ),
    "topography": ("roughxr/kernels/topography/*.py", ["peaks", "paraboloid", "envelope", "tile_stitching"]),
    "statistics": (
        "roughxr/statistics/*.py",
        [
            "statistics",
            "statistics_comparison",
            "statistics_debris",
            "statistics_laws",
            "statistics_pull_off",
            "statistics_uncertainty",
            "pooling",
        ],
    ),
}

#: Bytes of addresses that a child has: a mutant that asks for more is stopped, and with it not the machine.
_MEMORY = 6 << 30

_SWAPPED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Pow: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}


class Mutant(NamedTuple):
    """A file with one fault."""

    path: Path
    line: int
    words: str
    code: object


# ---------------------------------------------------------------- faults


def sites(tree):
    """Yield the nodes within functions that can be changed, but for annotations, decorators and what is raised."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            for statement in node.body:
                yield from _within(statement)


def _within(node):
    if isinstance(node, (ast.FunctionDef, ast.Raise)):
        return
    if changed(node) is not None:
        yield node
    for name, value in ast.iter_fields(node):
        if name != "annotation":
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _within(child)


def changed(node):
    """Return a node's fault, None where there is none to make."""
    if isinstance(node, (ast.BinOp, ast.BoolOp)) and type(node.op) in _SWAPPED:
        return _with(node, op=_SWAPPED[type(node.op)]())
    if isinstance(node, ast.Compare) and type(node.ops[0]) in _SWAPPED:
        return _with(node, ops=[_SWAPPED[type(node.ops[0])](), *node.ops[1:]])
    if isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
        return _with(node, value=_other(node.value))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
        return node.operand
    if isinstance(node, ast.AugAssign) and type(node.op) in _SWAPPED:
        return _with(node, op=_SWAPPED[type(node.op)]())
    if isinstance(node, (ast.If, ast.While, ast.IfExp)) and not isinstance(node.test, ast.Compare):
        return _with(node, test=ast.UnaryOp(ast.Not(), node.test))
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Subscript):
        return ast.Pass()
    return None


def _with(node, **changes):
    other = copy.copy(node)
    for name, value in changes.items():
        setattr(other, name, value)
    return other


def _other(value):
    if isinstance(value, bool):
        return not value
    return value + 1 if isinstance(value, int) else 1.3 * value + (value == 0)


def mutants(path, count, seed):
    """Return a sample of a file's mutants, and how many there are."""
    source = path.read_text(encoding="utf-8")
    total = len(list(sites(ast.parse(source))))
    drawn = np.random.default_rng([seed, total]).permutation(total)[:count]
    return [mutant(path, source, k) for k in sorted(drawn)], total


def mutant(path, source, k):
    """Return a file with its k-th fault."""
    tree = ast.parse(source)
    chosen = list(sites(tree))[k]
    fault = changed(chosen)
    words = f"{ast.unparse(chosen).splitlines()[0]} → {ast.unparse(fault).splitlines()[0]}"

    class Put(ast.NodeTransformer):
        def visit(self, node):
            return fault if node is chosen else self.generic_visit(node)

    changed_tree = ast.fix_missing_locations(ast.copy_location(Put().visit(tree), tree))
    for node in ast.walk(changed_tree):
        if not hasattr(node, "lineno") and isinstance(node, (ast.expr, ast.stmt)):
            ast.copy_location(node, chosen)
    return Mutant(path, chosen.lineno, words, compile(ast.fix_missing_locations(changed_tree), str(path), "exec"))


# ---------------------------------------------------------------- tests


class Times:
    """What each test that passes takes, of processor time; one that takes long is stopped."""

    def __init__(self, longest):
        self.longest = longest
        self.passed = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Note the time of a test with its fixtures."""
        began = time.process_time()
        found = yield
        if item.nodeid in self.passed:
            self.passed[item.nodeid] = time.process_time() - began
        return found

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        """Stop the test by a signal."""
        signal.signal(signal.SIGPROF, _stop)
        signal.setitimer(signal.ITIMER_PROF, self.longest)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)

    def pytest_runtest_logreport(self, report):
        """Note that a test passed."""
        if report.when == "call" and report.passed:
            self.passed[report.nodeid] = 0.0


def _stop(*_):
    pytest.fail("takes too long")


def run_tests(tests, *plugins):
    """Return pytest's exit status."""
    options = ["-x"] if not plugins else []
    options += ["-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:randomly", "-o", "addopts="]
    return pytest.main([*options, "--rootdir", str(ROOT), *tests], plugins=list(plugins))


def forked(work, compiled):
    """Start a function in a silent child, with or without compilation of kernels; return its process number."""
    child = os.fork()
    if child:
        return child
    os.setpgrp()
    numba.config.DISABLE_JIT = not compiled
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    status = 1
    try:
        status = work()
    finally:
        os._exit(status)


def quick_tests(files, longest, compiled):
    """Return the tests that pass in a short time, the shortest first, and what they take together."""
    read, write = os.pipe()

    def work():
        times = Times(longest)
        run_tests(files, times)
        os.write(write, repr(times.passed).encode())
        return 0

    child = forked(work, compiled)
    os.close(write)
    with os.fdopen(read) as pipe:
        passed = ast.literal_eval(pipe.read() or "{}")
    os.waitpid(child, 0)
    return sorted(passed, key=passed.get), sum(passed.values())


def survives(one, tests, limit):
    """Return, in a child that has so much processor time and memory, 0 if all tests pass on a mutant."""
    import resource
    from importlib.machinery import SourceFileLoader

    ordinary = SourceFileLoader.get_code

    def get_code(loader, name):
        return one.code if Path(loader.path) == one.path else ordinary(loader, name)

    SourceFileLoader.get_code = get_code
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    return int(run_tests(tests) != 0)


def outcomes(every, tests, limit, jobs, compiled):
    """Yield each mutant with whether it was killed."""
    waiting, running = list(every), {}
    while waiting or running:
        while waiting and len(running) < jobs:
            one = waiting.pop(0)
            running[forked(lambda one=one: survives(one, tests, limit), compiled)] = one
        child, status = os.wait()
        yield running.pop(child), status != 0


def main():
    """Print the share killed of each file and of each group."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help=f"groups ({', '.join(GROUPS)}) or parts of file names, with commas between")
    parser.add_argument("--sample", type=int, default=20, help="mutants of each file; default %(default)s")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--longest", type=float, default=2.0, help="processor seconds of a test; default %(default)s")
    parser.add_argument("--survivors", action="store_true", help="print the mutants that no test noticed")
    options = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    wanted = options.only.split(",") if options.only else list(GROUPS)
    for name, (pattern, tests) in GROUPS.items():
        files = [path for path in sorted(ROOT.glob(pattern)) if name in wanted or any(w in str(path) for w in wanted)]
        files = [path for path in files if mutants(path, 1, 0)[1]]
        if files:
            group(name, files, [f"tests/test_{test}.py" for test in tests], options)


def group(name, files, tests, options):
    """Print the results of one group."""
    compiled = name == "statistics"  # no kernels themselves
    tests, seconds = quick_tests([test for test in tests if Path(test).exists()], options.longest, compiled)
    print(f"{name}: {len(tests)} tests, {seconds:.1f} s", flush=True)
    killed = drawn = 0
    for path in files:
        some, total = mutants(path, options.sample, options.seed)
        found = list(outcomes(some, tests, 30 + int(10 * seconds), options.jobs, compiled))
        dead = sum(was_killed for _, was_killed in found)
        killed, drawn = killed + dead, drawn + len(found)
        print(f"  {path.relative_to(ROOT)}: {dead} of {len(found)} killed, of {total} possible", flush=True)
        for one, was_killed in found if options.survivors else ():
            if not was_killed:
                print(f"    line {one.line}: {one.words}", flush=True)
    print(f"{name}: {killed} of {drawn} killed, {killed / drawn:.0%}", flush=True)


if __name__ == "__main__":
    main()
