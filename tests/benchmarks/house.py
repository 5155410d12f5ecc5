"""What the package's code is like to live in: its size, its longest parts, its docstrings, its complexity.

    python tests/benchmarks/house.py [PACKAGE]
    python tests/benchmarks/house.py --rooms

Reads the source alone, so that it works on any tree: PACKAGE is the folder of a package, by default the one beside.
Public are the functions that `roughxr.__all__` names, or that a module named there shows. A docstring is complete with
Parameters where there are any, Returns or Yields where something is returned, Raises where the function or a helper in
its file raises, and Examples. Complexity is McCabe's: one, and one more for every branch.
"""

import argparse
import ast
import io
import tokenize
from pathlib import Path
from typing import NamedTuple

import numpy as np

PACKAGE = Path(__file__).resolve().parents[2] / "roughxr"
SECTIONS = ("Parameters", "Returns", "Raises", "Examples")

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_BRANCHES = (ast.If, ast.IfExp, ast.For, ast.While, ast.ExceptHandler, ast.comprehension, ast.match_case, ast.Assert)


class Function(NamedTuple):
    """A function where it stands."""

    module: str
    name: str
    node: ast.FunctionDef

    @property
    def words(self):
        """Return its full name."""
        return f"{self.module}.{self.name}"


# ---------------------------------------------------------------- reading


def modules(package):
    """Return the source of every module by its dotted name."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = [package.name, *path.relative_to(package).with_suffix("").parts]
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text(encoding="utf-8")
    return found


def functions(module, tree):
    """Yield all functions of a module, nested ones and methods among them."""

    def below(node, prefix):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, FUNCTIONS):
                yield Function(module, prefix + child.name, child)
            named = isinstance(child, (*FUNCTIONS, ast.ClassDef))
            yield from below(child, f"{prefix}{child.name}." if named else prefix)

    return below(tree, "")


def lines(source):
    """Return how many lines are code, docstring, comment and blank."""
    rows = source.splitlines()
    kinds = np.full(len(rows) + 1, "blank", dtype="<U9")
    skipped = {tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER, tokenize.COMMENT}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT and kinds[token.start[0]] == "blank":
            kinds[token.start[0]] = "comment"
        elif token.type not in skipped:
            kinds[token.start[0] : token.end[0] + 1] = "code"
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Module, ast.ClassDef, *FUNCTIONS)) and ast.get_docstring(node) is not None:
            kinds[node.body[0].lineno : node.body[0].end_lineno + 1] = "docstring"
    return {kind: int((kinds[1:] == kind).sum()) for kind in ("code", "docstring", "comment", "blank")}


# ---------------------------------------------------------------- one function


def length(node):
    """Return its lines without the docstring."""
    whole = node.end_lineno - node.lineno + 1
    if ast.get_docstring(node) is None:
        return whole
    return whole - (node.body[0].end_lineno - node.body[0].lineno + 1)


def parameters(node):
    """Return the names of its parameters, self left out."""
    spec = node.args
    every = [*spec.posonlyargs, *spec.args, *spec.kwonlyargs, *filter(None, (spec.vararg, spec.kwarg))]
    return [argument.arg for argument in every if argument.arg not in ("self", "cls")]


def own(node):
    """Yield the nodes of a function that belong to no function inside it."""
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, (*FUNCTIONS, ast.Lambda, ast.ClassDef)):
            yield from own(child)


def complexity(node):
    """Return McCabe's number."""
    found = 1
    for child in own(node):
        found += isinstance(child, _BRANCHES)
        found += len(child.values) - 1 if isinstance(child, ast.BoolOp) else 0
        found += len(child.ifs) if isinstance(child, ast.comprehension) else 0
    return found


def lacking(function, helpers):
    """Return the sections that its docstring should have and has not."""
    node, text = function.node, ast.get_docstring(function.node) or ""
    returns = any(isinstance(child, ast.Return) and child.value is not None for child in own(node))
    yields = any(isinstance(child, (ast.Yield, ast.YieldFrom)) for child in own(node))
    wanted = {
        "Parameters": bool(parameters(node)),
        "Returns": returns or yields,
        "Raises": _raises(node, helpers, set()),
        "Examples": True,
    }
    heads = {name: f"{name}\n{'-' * len(name)}" for name in (*SECTIONS, "Yields")}
    has = {name: head in text for name, head in heads.items()}
    has["Returns"] |= has["Yields"]
    return [name for name, needed in wanted.items() if needed and not has[name]]


def _raises(node, helpers, seen):
    """Return whether a function raises, by itself or by a function of its file."""
    for child in own(node):
        if isinstance(child, ast.Raise) and child.exc is not None:
            return True
        name = child.func.id if isinstance(child, ast.Call) and isinstance(child.func, ast.Name) else None
        if name in helpers and name not in seen and _raises(helpers[name], helpers, seen | {name}):
            return True
    return False


# ---------------------------------------------------------------- the public surface


class Surface:
    """Names, as they are bound in modules, followed to the functions that they mean."""

    def __init__(self, sources):
        self._trees = {name: ast.parse(source) for name, source in sources.items()}
        self._packages = {name.rpartition(".")[0] for name in sources} | {min(sources, key=len)}

    def functions(self):
        """Return the public functions, each once."""
        package = min(self._trees, key=len)
        root = next((name for name in self._trees if name == f"{package}._public"), package)
        found = {}
        for name in self._shown(root):
            module = self._module(root, name)
            meant = [(module, shown) for shown in self._shown(module)] if module else [(root, name)]
            for function in filter(None, (self._meant(*pair) for pair in meant)):
                found[function.words] = function
        return list(found.values())

    def helpers(self, module):
        """Return the functions at the top of a module by their names."""
        return {node.name: node for node in self._trees[module].body if isinstance(node, FUNCTIONS)}

    def _shown(self, module):
        for node in self._trees[module].body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
                return ast.literal_eval(node.value)
        return [name for name in self.helpers(module) if not name.startswith("_")]

    def _module(self, module, name):
        """Return the module that a name is imported as, None for anything else."""
        for node in ast.walk(self._trees[module]):
            if isinstance(node, ast.ImportFrom) and name in (alias.asname or alias.name for alias in node.names):
                inside = f"{self._absolute(module, node)}.{name}"
                return inside if inside in self._trees else None
        return None

    def _meant(self, module, name, seen=()):
        if module not in self._trees or (module, name) in seen:
            return None
        if name in self.helpers(module):
            return Function(module, name, self.helpers(module)[name])
        for node in ast.walk(self._trees[module]):
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                if (alias.asname or alias.name) == name:
                    return self._meant(self._absolute(module, node), alias.name, (*seen, (module, name)))
        return None

    def _absolute(self, module, node):
        if not node.level:
            return node.module
        parts = module.split(".")
        parts = parts[: len(parts) - node.level + (module in self._packages)]
        return ".".join([*parts, *filter(None, [node.module])])


# ---------------------------------------------------------------- what is printed


def print_lines(sources):
    """Print lines in all, and the longest files."""
    counts = {name: lines(source) for name, source in sources.items()}
    total = {kind: sum(count[kind] for count in counts.values()) for kind in ("code", "docstring", "comment", "blank")}
    print(f"modules: {len(sources)}; lines: {sum(total.values())}, " + ", ".join(f"{k} {n}" for k, n in total.items()))
    whole = {name: sum(count.values()) for name, count in counts.items()}
    print(f"longest files, lines: {_largest(whole)}")
    print(f"longest files, code: {_largest({name: count['code'] for name, count in counts.items()})}")


def print_functions(every):
    """Print how long and how complex functions are."""
    lengths = {f.words: length(f.node) for f in every}
    some = np.array(list(lengths.values()))
    print(f"functions: {some.size}; lines: median {np.median(some):g}, 90 % {np.quantile(some, 0.9):g}", end="; ")
    print(f"under 35: {np.mean(some < 35):.1%}")
    print(f"longest functions: {_largest(lengths)}")
    branches = {f.words: complexity(f.node) for f in every}
    some = np.array(list(branches.values()))
    print(f"complexity: mean {some.mean():.2f}, 90 % {np.quantile(some, 0.9):g}, above 10: {(some > 10).sum()}")
    print(f"most complex: {_largest(branches)}")
    print(f"most parameters: {_largest({f.words: len(parameters(f.node)) for f in every})}")


def print_public(surface):
    """Print the public functions' signatures and how many docstrings are complete."""
    public = surface.functions()
    print(f"public functions: {len(public)}")
    print(f"longest public signatures, parameters: {_largest({f.words: len(parameters(f.node)) for f in public})}")
    missing = {f.words: lacking(f, surface.helpers(f.module)) for f in public}
    whole = sum(not names for names in missing.values())
    parts = ", ".join(f"{name} {sum(name in names for names in missing.values())}" for name in SECTIONS)
    print(f"complete docstrings: {whole} of {len(public)}, {whole / len(public):.1%}; lacking {parts}")
    for name, sections in sorted(missing.items()):
        if sections:
            print(f"  {name}: {', '.join(sections)}")


def _largest(values, count=5):
    ordered = sorted(values, key=values.get, reverse=True)[:count]
    return ", ".join(f"{name.partition('.')[2] or name} {values[name]}" for name in ordered)


def passed(work):
    """Return the functions of the package that receive a scan while a call is made, and how often each was called.

    First those that receive its Dataset, then those that receive it or the specimen read from it.
    """
    import sys
    from collections import Counter

    import xarray as xr

    from roughxr.specimen import Specimen

    calls, wider = Counter(), Counter()

    def watch(frame, event, _):
        code = frame.f_code
        if event != "call" or not code.co_filename.startswith(str(PACKAGE)):
            return
        given = [frame.f_locals.get(name) for name in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]]
        name = f"{Path(code.co_filename).stem}.{code.co_qualname}"
        if any(isinstance(one, xr.Dataset) and "height" in one and "x" in one.dims for one in given):
            calls[name] += 1
            wider[name] += 1
        elif any(isinstance(one, Specimen) for one in given) and not code.co_qualname.startswith("Specimen."):
            wider[name] += 1

    sys.setprofile(watch)
    try:
        work()
    finally:
        sys.setprofile(None)
    return calls, wider


def print_rooms():
    """Print how many functions a scan passes under `adhesive` and `run`, and how often its asperities are searched."""
    import contextlib
    import tempfile
    import warnings

    import roughxr
    from roughxr.asperity import catalogue

    warnings.simplefilter("ignore")
    ground = roughxr.scans.synthetic.self_affine((64, 64), 4.0, rms=0.5, hurst=0.8, rolloff=100, cutoff=30, seed=1)
    scan = roughxr.assign_pair(ground, sphere_radius=200, contact_modulus=40, work_of_adhesion=0.05)
    searched, tiles = [0], catalogue.join_tiles

    def counted(*arguments):
        searched[0] += 1
        return tiles(*arguments)

    catalogue.join_tiles = counted
    adhesive, wider = passed(lambda: roughxr.adhesive(scan, subregions=(2, 1), mesh=roughxr.Mesh(1, step=1.0)))
    print(f"adhesive: a scan passes {len(adhesive)} functions, with the specimen read from it {len(wider)}")
    searched[0] = 0
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        run, wider = passed(lambda: roughxr.run(scan, Path(folder) / "run.nc", subregions=(2, 1), mesh=1, budget=1))
    asked = sum(count for name, count in run.items() if name == "catalogue.asperities")
    print(f"run: a scan passes {len(run)} functions, with the specimen {len(wider)}")
    print(f"run: asperities asked for {asked} times, searched {searched[0]} times")


def main():
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", nargs="?", type=Path, default=PACKAGE)
    parser.add_argument(
        "--rooms", action="store_true", help="how many functions a scan passes, solved or run (minutes)"
    )
    if parser.parse_args().rooms:
        print_rooms()
        return
    sources = modules(parser.parse_args().package.resolve())
    every = [function for name, source in sources.items() for function in functions(name, ast.parse(source))]
    print_lines(sources)
    print_functions(every)
    print_public(Surface(sources))


if __name__ == "__main__":
    main()
