"""How many small faults, put into a kernel one at a time, its tests notice.

    python tests/benchmarks/mutation.py [--only statistics] [--sample 20] [--seed 0 1] [--jobs 2] [--survivors]

For each file and seed a sample of mutants is drawn: an operator, a comparison, a constant or a condition changed, or an
assignment left out. First the tests named for the file run on each with kernels uncompiled, those alone that take less
than ``--longest`` seconds so. Mutants that survive meet the others of them that take less than ``--longest-compiled``
seconds, kernels compiled: those of the file and of all that import it anew, the others as they were. A mutant is killed
where a test fails, ends the process, or takes ten times as long as it did. Some mutants are no faults (a tolerance
moved, < for <= on floating-point numbers), so that 100 % is out of reach.
"""

import argparse
import ast
import copy
import os
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("MPLBACKEND", "Agg")

import dask
import dask.array  # what every child needs, imported once
import numba
import numpy as np
import pytest
import scipy.stats  # noqa: F401
import xarray  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]

#: The files of each group, and the tests that should notice. Where parts of a group have tests of their own, each part
#: has them here.
GROUPS = {
    "halfspace": {
        "roughxr/kernels/halfspace/*.py": [
            "halfspace",
            "warm_start",
            "displacement_control",
            "without_jit_cases",
            "yielding",
            "contact_problem",
            "direct",
        ]
    },
    "adhesion": {
        "roughxr/kernels/adhesion/traction_laws.py roughxr/kernels/adhesion/path.py": [
            "smooth_parts",
            "single_cells",
            "adhesive",
            "yielding_adhesive",
        ],
        "roughxr/kernels/adhesion/rigid.py roughxr/kernels/adhesion/potentials.py": ["rigid", "reference"],
        "roughxr/kernels/adhesion/smooth_*.py roughxr/kernels/adhesion/newton_system.py": [
            "smooth_parts",
            "single_cells",
            "adhesion_smooth",
            "yielding_adhesive",
            "adhesive",
        ],
    },
    "asperity": {
        "roughxr/kernels/asperity/*.py": [
            "ellipse",
            "asperity_contact",
            "maugis",
            "superposition",
            "superposition_maugis",
            "pull_off_map",
            "largest_pull",
            "rotation",
        ]
    },
    "topography": {"roughxr/kernels/topography/*.py": ["peaks", "paraboloid", "envelope", "tile_stitching"]},
    "statistics": {
        "roughxr/statistics/*.py": [
            "statistics",
            "statistics_comparison",
            "statistics_debris",
            "statistics_laws",
            "statistics_pull_off",
            "statistics_uncertainty",
            "pooling",
        ]
    },
}

#: Tests that compare with processes of their own, which have no fault.
_ELSEWHERE = "not scheduler and not processes and not workers"

#: A test may take this many times as long on a mutant, and some seconds more; compiled ones also those to compile in.
_SLOWER, _MORE, _COMPILING = 10, 2, 60

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


def without_fault(path):
    """Return a file as it is, for comparison."""
    code = compile(path.read_text(encoding="utf-8"), str(path), "exec")
    return Mutant(path, 0, "as it is", code)


# ---------------------------------------------------------------- tests


class Tests(NamedTuple):
    """Tests and what each takes, s of processor time; and where what they compile is kept, None for uncompiled ones."""

    seconds: dict
    cache: Path | None

    @property
    def total(self):
        """What they take together, s."""
        return sum(self.seconds.values())


class Times:
    """What each test that passes takes, of processor time; one that takes long is stopped."""

    def __init__(self, longest):
        self.longest = longest
        self.passed = {}
        self.running = False

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Note the time of a test with its fixtures."""
        began = time.process_time()
        found = yield
        if item.nodeid in self.passed:
            self.passed[item.nodeid] = time.process_time() - began
        return found

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item):
        """Stop a test's fixtures by a signal, as the test itself."""
        signal.signal(signal.SIGPROF, self._stop)
        signal.setitimer(signal.ITIMER_PROF, self.longest)
        self.running = True
        try:
            return (yield)
        finally:
            self.running = False
            signal.setitimer(signal.ITIMER_PROF, 0)

    pytest_runtest_call = pytest_runtest_setup

    def _stop(self, *_):
        if self.running:
            pytest.fail("takes too long", pytrace=False)

    def pytest_runtest_logreport(self, report):
        """Note that a test passed."""
        if report.when == "call" and report.passed:
            self.passed[report.nodeid] = 0.0


class Limits:
    """Ends the process with the first test that takes far longer than it did, within compiled code too."""

    def __init__(self, tests):
        self.seconds, self.more = tests.seconds, _MORE + (_COMPILING if tests.cache else 0)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Have a signal sent after the time of a test with its fixtures."""
        signal.setitimer(signal.ITIMER_PROF, _SLOWER * self.seconds[item.nodeid] + self.more)
        return (yield)


def run_tests(tests, *options, plugin):
    """Return pytest's exit status."""
    options = [
        *options,
        "-q",
        "--no-header",
        "--tb=no",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:randomly",
        "-o",
        "addopts=",
    ]
    return pytest.main([*options, "--rootdir", str(ROOT), *tests], plugins=[plugin])


def forked(work, cache):
    """Start a function in a silent child, kernels compiled where there is a cache; return its process number."""
    child = os.fork()
    if child:
        return child
    os.setpgrp()
    dask.config.set(scheduler="synchronous")  # a test that is stopped would wait for threads of its own
    numba.config.DISABLE_JIT, numba.config.CACHE_DIR = cache is None, str(cache or "")
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    status = 1
    try:
        status = work()
    finally:
        os._exit(status)


def passing(tests, longest, cache):
    """Return the `Tests` that pass in a short time, in files' order, of each the shortest first."""
    read, write = os.pipe()

    def work():
        times = Times(longest)
        run_tests(tests, "-k", _ELSEWHERE, "-m", "not soak", plugin=times)
        os.write(write, repr(times.passed).encode())
        return 0

    child = forked(work, cache)
    os.close(write)
    with os.fdopen(read) as pipe:
        passed = ast.literal_eval(pipe.read() or "{}")
    os.waitpid(child, 0)
    files = list(dict.fromkeys(name.split("::")[0] for name in passed))
    order = sorted(passed, key=lambda name: (files.index(name.split("::")[0]) if cache else 0, passed[name]))
    return Tests({name: passed[name] for name in order}, cache)


def compiled_tests(files, longest, cache, passed):
    """Return the `Tests` that pass in a short time once all is compiled, but for those that mutants have passed."""
    cache.mkdir()
    once = passing(files, longest + _COMPILING, cache)
    return passing([name for name in once.seconds if name not in passed], longest, cache)


def importers(path):
    """Return the names of a module of the package and of all that import it, straight or by others."""
    imports = {other: _imported(other) for other in (ROOT / "roughxr").rglob("*.py")}
    found, new = set(), {path}
    while new:
        found |= new
        new = {other for other, names in imports.items() if names & {one.stem for one in new}} - found
    return {one.stem for one in found}


def _imported(path):
    """Return the last parts of the names of all modules that a module may import."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            names |= {(node.module or "").split(".")[-1], *(name.name for name in node.names)}
    return names


def survives(one, tests):
    """Return, in a child, 0 if all tests pass on a mutant."""
    import resource
    from importlib.machinery import SourceFileLoader

    if tests.cache:
        own = tests.cache.with_name(str(os.getpid()))
        stale = {f"{name}." for name in importers(one.path)}
        unlike = lambda _, names: [name for name in names if name.startswith(tuple(stale))]  # noqa: E731
        shutil.copytree(tests.cache, own, ignore=unlike)
        numba.config.CACHE_DIR = str(own)
    ordinary = SourceFileLoader.get_code

    def get_code(loader, name):
        return one.code if Path(loader.path) == one.path else ordinary(loader, name)

    SourceFileLoader.get_code = get_code
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    return int(run_tests(tests.seconds, "-x", plugin=Limits(tests)) != 0)


def survivors(every, tests, jobs):
    """Return the mutants that no test notices."""
    waiting, running, left = list(every), {}, []
    while tests.seconds and (waiting or running):
        while waiting and len(running) < jobs:
            one = waiting.pop(0)
            running[forked(lambda one=one: survives(one, tests), tests.cache)] = one
        child, status = os.wait()
        if tests.cache:
            shutil.rmtree(tests.cache.with_name(str(child)), ignore_errors=True)
        one = running.pop(child)
        left += [one] if status == 0 else []
        said = "survives" if status == 0 else "is killed"
        print(f"{one.path.name}:{one.line} {said}: {one.words}", file=sys.stderr, flush=True)
    return left if tests.seconds else list(every)


def main():
    """Print the share killed of each file and of each group."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help=f"groups ({', '.join(GROUPS)}) or parts of file names, with commas between")
    parser.add_argument("--sample", type=int, default=20, help="mutants of each file; default %(default)s")
    parser.add_argument("--seed", type=int, nargs="+", default=[0], help="of each a sample; default 0")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--longest", type=float, default=1.0, help="processor seconds of a test; default %(default)s")
    parser.add_argument("--longest-compiled", type=float, default=3.0, help="the same, compiled; default %(default)s")
    parser.add_argument("--survivors", action="store_true", help="print the mutants that no test noticed")
    options = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    wanted = options.only.split(",") if options.only else list(GROUPS)
    for name, parts in GROUPS.items():
        found = []
        for pattern, tests in parts.items():
            files = sorted(path for one in pattern.split() for path in ROOT.glob(one) if mutants(path, 1, 0)[1])
            files = [path for path in files if name in wanted or any(word in str(path) for word in wanted)]
            if files:
                found.append(part(files, [f"tests/test_{test}.py" for test in tests], name != "statistics", options))
        for k, seed in enumerate(options.seed if found else ()):
            killed, drawn = (sum(counts) for counts in zip(*(counts[k] for counts in found)))
            print(f"{name}, seed {seed}: {killed} of {drawn} killed, {killed / drawn:.0%}", flush=True)


def part(files, tests, kernels, options):
    """Print the results of the files of a group that share their tests; return killed and drawn by seed."""
    drawn = {(path, seed): mutants(path, options.sample, seed)[0] for path in files for seed in options.seed}
    left, passed = [one for some in drawn.values() for one in some], {}
    with tempfile.TemporaryDirectory(prefix="roughxr-mutants-") as folder:
        for compiled in (False, True) if kernels else (True,):
            if not left:
                break
            if compiled:
                chosen = compiled_tests(tests, options.longest_compiled, Path(folder, "cache"), passed)
            else:
                chosen = passing(tests, options.longest, None)
                passed = chosen.seconds
            how = "compiled" if compiled else "uncompiled"
            print(f"{len(chosen.seconds)} tests, {how}, {chosen.total:.1f} s, on {len(left)} mutants", flush=True)
            some, left = left, survivors(left, chosen, options.jobs)
            if not left and not survivors([without_fault(some[0].path)], chosen, options.jobs):
                raise SystemExit("a file without a fault is killed as well: its tests do not pass on their own")
    alive = {key: [one for one in some if one in left] for key, some in drawn.items()}
    for path in files:
        shares = [f"{len(drawn[path, k]) - len(alive[path, k])} of {len(drawn[path, k])}" for k in options.seed]
        total = mutants(path, 1, 0)[1]
        print(f"  {path.relative_to(ROOT)}: {', '.join(shares)} killed, of {total} possible", flush=True)
        for seed in options.seed if options.survivors else ():
            for one in alive[path, seed]:
                print(f"    seed {seed}, line {one.line}: {one.words}", flush=True)
    counts = [([len(some[path, k]) for path in files] for some in (alive, drawn)) for k in options.seed]
    return [(sum(whole) - sum(living), sum(whole)) for living, whole in counts]


if __name__ == "__main__":
    main()
