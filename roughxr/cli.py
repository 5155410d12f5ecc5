"""The command line: ``roughxr paper``, ``run``, ``report``, ``explore``, ``detach``, ``info``, ``convert``, …"""

from __future__ import annotations

import argparse
import errno
import os
import re
import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout
from typing import TextIO

from ._version import __version__
from .bodies.substances import MATERIALS
from .jobs.progress import progress
from .vocabulary.numbers import number, percent
from .vocabulary.text import did_you_mean, printable

#: Laws of attraction, the same as in `adhesive`, repeated here so that help needs no import of the solver.
LAWS = ("auto", "exponential", "griffith", "dugdale", "lennard_jones")

#: Codes of `to_dem`, loads of `critical_load`, and its fluids.
PARTICLE_CODES = ("lammps", "4c", "liggghts", "mercurydpm", "yade", "rock_n_roll")
LOADS = ("wall_shear", "tilt", "centrifuge", "vibration")
FLUIDS = ("air", "water")

#: Endings of pictures.
_PICTURES = (".png", ".pdf", ".svg", ".jpg")

#: Control characters that may be printed.
_LINES = "\n\t"

#: Errors of the input, reported in one line; any other error is a bug and shows its traceback.
_REFUSALS = (ValueError, TypeError, OSError, ImportError, RuntimeError)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 1 refused, 130 interrupted."""
    try:
        words = _with_config(list(sys.argv[1:] if arguments is None else arguments))
    except _REFUSALS as error:
        _warn(_in_words(error))
        return 1
    options = _parser().parse_args(words)
    try:
        with warnings.catch_warnings(), redirect_stdout(_Printable(sys.stdout)):
            said: set[str] = set()
            warnings.showwarning = lambda message, *_, **__: _warn(message, said)
            with nullcontext() if getattr(options, "quiet", True) else progress():
                options.command(options)
            sys.stdout.flush()
    except (KeyboardInterrupt, SystemError) as error:
        from .jobs.executor import is_interrupt

        if not is_interrupt(error):
            raise
        kept = "; finished places are kept, and the same command continues from there"
        print(f"roughxr: interrupted{kept if options.command in (_paper, _run) else ''}", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader, such as head, has had enough; nothing is left to write at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except _REFUSALS as error:
        _warn(_in_words(error))
        return 1
    return 0


class _Printable:
    """A stream for others' text: nothing in it moves the terminal's cursor or changes its colours."""

    def __init__(self, stream: TextIO):
        self.stream = stream

    def write(self, text: str) -> int:
        return self.stream.write(printable(text, keep=_LINES))

    def __getattr__(self, name: str):
        return getattr(self.stream, name)


def _in_words(error: BaseException) -> str:
    """Return an error's text; the system's own errors in words, with the file's name first."""
    name = getattr(error, "filename", None)
    if not isinstance(error, OSError) or error.errno is None or name is None:
        return str(error)
    known = {
        errno.ENOENT: "expected a file or a folder, found none of this name",
        errno.EACCES: "you have no permission to read or write it",
        errno.EPERM: "you have no permission to read or write it",
        errno.EISDIR: "expected a file, found a folder",
        errno.ENOTDIR: "expected a folder, found a file of this name",
        errno.ENOSPC: "the disk is full: make room and call again; what was finished is kept",
        errno.EROFS: "is on a read-only disk: choose another place with -o",
    }
    return f"{name}: {known.get(error.errno, str(error.strerror).lower())}"


def _warn(message, said: set[str] | None = None) -> None:
    """Print the text of a warning without its place in the code, and only once."""
    if said is None or str(message) not in said:
        print(f"roughxr: {printable(str(message), keep=_LINES)}", file=sys.stderr)
    if said is not None:
        said.add(str(message))


def _with_config(words: list[str]) -> list[str]:
    """Return the words of a command with the options of its configuration file before them, so that theirs prevail."""
    import tomllib
    from pathlib import Path

    at = next((k for k, word in enumerate(words) if word.split("=")[0] == "--config"), None)
    if at is None or words[0] != "run":
        return words
    path = words[at].partition("=")[2] or (words[at + 1] if at + 1 < len(words) else "")
    try:
        stated = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(
            f'{path}: expected TOML with text in quotes, such as humidity = "50 %", found an error: {error}'
        ) from error
    if unknown := [name for name in stated if name.replace("_", "-") not in (known := _option_names(_parser_of_run()))]:
        raise ValueError(
            f"{path}: expected options of `roughxr run`, found {unknown[0]!r}{_meant(unknown[0], sorted(known))}"
        )
    given = []
    for name, value in stated.items():
        values = [str(one) for one in (value if isinstance(value, list) else [value])]
        flag = f"--{name.replace('_', '-')}"
        given += ([flag] if value else []) if isinstance(value, bool) else [f"{flag}={values[0]}"]
        given[-1:] = [flag, *values] if len(values) > 1 else given[-1:]
    rest = [
        word for k, word in enumerate(words[1:], start=1) if k != at and not (k == at + 1 and words[at] == "--config")
    ]
    scans = next((k for k, word in enumerate(rest) if word.startswith("-")), len(rest))
    return ["run", *rest[:scans], *given, *rest[scans:]]


def _add_config(commands) -> None:
    command = commands.add_parser("config", help="write the options of `run` as a file to edit, for run --config")
    command.add_argument("-o", "--output", default="roughxr.toml", metavar="TOML", help="default: %(default)s")
    command.set_defaults(command=_config)


def _config(options) -> None:
    """Write each option of `run` as a commented line of TOML, with its help."""
    import json
    import textwrap
    from pathlib import Path

    if Path(options.output).exists():
        raise ValueError(f"{options.output}: exists already, and may hold your options; give another name")
    lines = ['# Options of roughxr run. Remove the # before each option that you set. Text may have units: "3 um".']
    for action in _parser_of_run()._actions:
        name = max(action.option_strings, key=len, default="").removeprefix("--")
        if name in ("", "help", "config", "output", "quiet"):
            continue
        words = (action.help or "") % {"default": action.default}
        lines += ["", *textwrap.wrap(words, 100, initial_indent="# ", subsequent_indent="# ")]
        lines += [f"# {name} = {json.dumps('' if action.default is None else action.default)}"]
    Path(options.output).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"written to {options.output}")


def _parser_of_run() -> argparse.ArgumentParser:
    return next(one for one in _parser()._actions if isinstance(one, argparse._SubParsersAction)).choices["run"]


class _Parser(argparse.ArgumentParser):
    """A parser that asks back what an option that it does not know was meant to be."""

    def parse_known_args(self, args=None, namespace=None):
        self.given = args
        return super().parse_known_args(args, namespace)

    def error(self, message: str):
        options = _option_names(self)
        unknown = [word for word in self.given or () if word.startswith("--") and word.split("=")[0][2:] not in options]
        if "required" in message and unknown:  # what is required may be misspelt
            message = f"unrecognized arguments: {' '.join(unknown)}"
        if chosen := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            message += did_you_mean(chosen[1], re.findall(r"[\w-]+", chosen[2]))
        asked = [word.split("=")[0] for word in message.split() if word.startswith("--")]
        if message.startswith("unrecognized") and asked:
            message += _meant(asked[0].lstrip("-"), sorted(_option_names(self)))
        super().error(message)


def _option_names(parser: argparse.ArgumentParser) -> set[str]:
    """Return the long options of a parser and of its commands."""
    known: set[str] = set()
    for action in parser._actions:
        known |= {one.removeprefix("--") for one in action.option_strings if one.startswith("--")}
        if isinstance(action, argparse._SubParsersAction):
            known |= set().union(*(_option_names(one) for one in action.choices.values()))
    return known


def _meant(word: str, known: list[str]) -> str:
    """Return the question after the option that holds a word, or is spelt like it."""
    holding = [f"--{one}" for one in known if word and word in one.split("-")]
    return (
        f"; did you mean {' or '.join(holding)}?"
        if holding
        else did_you_mean(f"--{word}", [f"--{one}" for one in known])
    )


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="roughxr", description=_DESCRIPTION, epilog=_DOCUMENTATION)
    parser.add_argument("--version", action="version", version=f"roughxr {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_paper(commands)
    _add_run(commands)
    _add_config(commands)
    _add_report(commands)
    _add_explore(commands)
    _add_info(commands)
    _add_convert(commands)
    _add_measured(commands)
    _add_compare(commands)
    _add_detach(commands)
    _add_cite(commands)
    return parser


_DESCRIPTION = "How hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface."

#: The documentation is built from a clone, and is not hosted.
_DOCUMENTATION = (
    "Documentation: in a clone, `pip install '.[docs]'` and `sphinx-build -W notebooks build/site` make the pages, "
    "build/site/index.html the first of them; in Python, `help(roughxr)`."
)

#: What to cite in a paper that uses roughxr: the program, and the work whose method it implements.
_BIBTEX = f"""\
@software{{roughxr,
  author  = {{{{The roughxr developers}}}},
  title   = {{roughxr: contact and adhesion of a small sphere on AFM scans of rough surfaces}},
  version = {{{__version__}}},
  year    = {{2026}},
  license = {{BSD-3-Clause}},
}}

@article{{cheng_dunn_brach,
  author  = {{Cheng, W. and Dunn, P. F. and Brach, R. M.}},
  title   = {{Contact between a smooth microsphere and an anisotropic rough surface}},
  journal = {{The Journal of Adhesion}},
  volume  = {{79}},
  number  = {{8--9}},
  pages   = {{749--776}},
  year    = {{2003}},
}}"""


def _add_paper(commands) -> None:
    command = commands.add_parser(
        "paper", help="repeat the paper's analysis on the synthetic glass sample: archive, figures, tables"
    )
    command.add_argument("-o", "--output", default="paper-run", metavar="FOLDER", help="default: %(default)s")
    _add_budget(command)
    _add_quiet(command)
    command.set_defaults(command=_paper)


def _add_run(commands) -> None:
    command = commands.add_parser(
        "run", help="analyse a scan, or each of several: pull-off, forces, error budget, report"
    )
    command.add_argument("scan", metavar="SCAN", nargs="+", help="an AFM file, or a NetCDF file of a scan")
    command.add_argument("--config", metavar="TOML", help="file of options, as `roughxr config` writes it")
    command.add_argument(
        "-o",
        "--output",
        default="run",
        metavar="OUT",
        help="folder, or FILE.nc for the archive alone; default: %(default)s",
    )
    _add_reading(command)
    command.add_argument(
        "--level", default="plane", choices=("plane", "quadratic", "none"), help="default: %(default)s"
    )
    _add_pair(command)
    places = command.add_argument_group("where and how deep")
    places.add_argument(
        "--subregions",
        nargs="+",
        type=int,
        default=(8, 8),
        metavar="N",
        help="number of places along x and y, or one number for both; default: 8 8",
    )
    kind = places.add_mutually_exclusive_group()
    kind.add_argument(
        "--probe", action="store_true", help="the sphere is fixed in position, as a colloidal probe (default)"
    )
    kind.add_argument(
        "--particle",
        action="store_true",
        help="the sphere is free: it lands at each place, rolls to rest, and is analysed there",
    )
    places.add_argument(
        "--delta",
        nargs="+",
        type=float,
        metavar="D",
        help="displacements of the simulation without adhesion, nm; default: chosen from the heights",
    )
    _add_adhesion(command)
    command.add_argument(
        "--scheduler",
        metavar="NAME",
        help="threads, processes, synchronous, or the address of a dask scheduler; default: threads",
    )
    _add_budget(command)
    _add_quiet(command)
    command.set_defaults(command=_run)


def _add_pair(command) -> None:
    group = command.add_argument_group("the two bodies (plain numbers in nm, GPa, J/m², or text such as '3 um')")
    shape = group.add_mutually_exclusive_group(required=True)
    shape.add_argument("--sphere-radius", "--radius", metavar="R", help="radius of the sphere, nm")
    shape.add_argument("--indenter", metavar="FILE", help="a scan of the indenter, instead of a sphere")
    group.add_argument(
        "--materials",
        metavar="A/B",
        help=f"one or two of {', '.join(MATERIALS)}, as in glass/silicon: sets moduli, and van der Waals adhesion; "
        "the report estimates with their hardness what would yield",
    )
    group.add_argument(
        "--young-modulus",
        nargs="+",
        metavar="E",
        help="Young's modulus, one value for both bodies or one for each, GPa",
    )
    group.add_argument("--poisson-ratio", nargs="+", metavar="NU", help="one value for both bodies or one for each")
    group.add_argument("--contact-modulus", metavar="E*", help="instead of moduli and Poisson's ratios, GPa")
    group.add_argument(
        "--surface-energy", metavar="GAMMA", help="of two bodies of the same material, J/m²: half the work of adhesion"
    )
    group.add_argument(
        "--work-of-adhesion",
        nargs="+",
        metavar="W",
        help="J/m²; default: from --materials, for van der Waals forces between clean dry bodies; with --humidity two "
        "values may be given, dry and under the liquid",
    )
    group.add_argument(
        "--hardness",
        metavar="H",
        help="of the softer body, GPa: the contact pressure cannot exceed it; default: the bodies stay elastic, and "
        "the "
        "report tells how much of the contact exceeds the hardness estimated for --materials",
    )
    group.add_argument("--adhesion-range", metavar="RHO", help="how far the attraction reaches, nm; default: 0.3")
    group.add_argument(
        "--hamaker-constant", metavar="A", help="of the pair, such as '65 zJ', instead of --work-of-adhesion"
    )
    group.add_argument(
        "--retardation", metavar="L", help="retardation wavelength of van der Waals forces, nm; default: no retardation"
    )
    group.add_argument("--humidity", metavar="RH", help="relative humidity, such as '60 %%' or 0.6; default: dry")
    group.add_argument(
        "--contact-angle", nargs="+", metavar="DEG", help="of the liquid on both bodies or on each, degrees; default: 0"
    )
    group.add_argument("--temperature", metavar="T", help="of the humid air, K or as in '25 degC'; default: 298.15")
    group.add_argument(
        "--liquid",
        nargs="+",
        metavar="NAME",
        help="water, ethanol, or two numbers: surface tension (J/m²) and molar volume (cm³/mol); default: water",
    )
    group.add_argument("--film", metavar="F", help="thickness of a liquid film on each body, nm; default: none")


def _add_adhesion(command) -> None:
    group = command.add_argument_group("the simulation with adhesion")
    group.add_argument(
        "--preload",
        default=0.0,
        type=_number,
        metavar="P",
        help="force that presses the sphere on before it is pulled off, nN, or text such as '50 nN'; default: 0, only "
        "adhesion pulls the sphere on",
    )
    group.add_argument(
        "--law",
        default="auto",
        choices=LAWS,
        help="how the attraction falls with the gap; default: auto, exponential where its range matters, else griffith",
    )
    group.add_argument(
        "--mesh",
        default="auto",
        type=lambda text: text if text == "auto" else int(text),
        metavar="N",
        help="number of cells along a pixel; default: auto, from the range of the attraction",
    )


def _add_report(commands) -> None:
    command = commands.add_parser("report", help="write the report of a finished run, one HTML file")
    command.add_argument("run", metavar="RUN", help="the archive of a run, such as run.nc, or its folder")
    command.add_argument("-o", "--output", metavar="HTML", help="default: report.html beside the archive")
    _add_measurement(
        command, "--measured", help="measured pull-off forces to show with the prediction, as for `compare`"
    )
    command.set_defaults(command=_report)


def _add_explore(commands) -> None:
    command = commands.add_parser("explore", help="write an interactive page of a finished run")
    command.add_argument("run", metavar="RUN", help="the archive of a run, such as run.nc, or its folder")
    command.add_argument("-o", "--output", metavar="HTML", help="default: explore.html beside the archive")
    command.add_argument(
        "--loops",
        type=int,
        default=16,
        metavar="PLACES",
        help="number of places at which the simulation with adhesion is repeated for its force curve and contact maps, "
        "a "
        "second or more each; default: %(default)s",
    )
    command.add_argument("--open", action="store_true", help="show the page in the browser")
    _add_quiet(command)
    command.set_defaults(command=_explore)


def _add_info(commands) -> None:
    command = commands.add_parser("info", help="say what a file holds")
    command.add_argument("file", metavar="FILE", nargs="?")
    command.add_argument("--formats", action="store_true", help="list the formats of scans and of measured pull-offs")
    _add_reading(command)
    command.add_argument("--picture", metavar="PNG", help="draw the heights, levelled by a plane")
    command.set_defaults(command=_info)


def _add_convert(commands) -> None:
    command = commands.add_parser("convert", help="write a scan in another format")
    command.add_argument("file", metavar="FILE")
    command.add_argument("-o", "--output", required=True, metavar="OUT", help="OUT.nc or OUT.gsf")
    _add_reading(command)
    command.add_argument(
        "--surfacetopography", action="store_true", help="write the NetCDF-3 that SurfaceTopography reads"
    )
    command.set_defaults(command=_convert)


def _add_measured(commands) -> None:
    command = commands.add_parser("measured", help="say what a file of measured pull-off forces holds")
    _add_measurement(command)
    command.add_argument("-o", "--output", metavar="TABLE", help="write them as a table, OUT.csv or OUT.parquet")
    command.set_defaults(command=_measured)


def _add_compare(commands) -> None:
    command = commands.add_parser("compare", help="compare the pull-off forces of a run with measured ones")
    command.add_argument("run", metavar="RUN", help="the archive of a run, such as run.nc, or its folder")
    _add_measurement(command)
    command.add_argument(
        "--method",
        default="adhesive",
        help="method of the prediction: adhesive, energy, rigid, …; default: %(default)s",
    )
    command.add_argument("--picture", metavar="PNG", help="draw both distributions, and their quantiles")
    command.set_defaults(command=_compare)


_MEASURED = (
    "a table with named columns, an adhesion image of an AFM file, or force-distance curves; several files are pooled"
)


def _add_measurement(command, name: str = "file", *, help: str = _MEASURED) -> None:
    command.add_argument(name, metavar="FILE", nargs="+", help=help)
    group = command.add_argument_group("what to read from the file, and what the file does not state")
    group.add_argument("--channel", help="name of the column, name or number of the image")
    group.add_argument("--direction", choices=("trace", "retrace"), help="of an image; default: trace (forward)")
    group.add_argument("--size", nargs="+", metavar="L", help="of an image along x and y, nm")
    group.add_argument("--units", help="of what was measured, such as nN or V")
    group.add_argument("--place-units", metavar="UNITS", help="of the columns x and y, such as um")
    group.add_argument("--sensitivity", metavar="S", help="for values in V, such as '12 nN/V' or '50 nm/V'")
    group.add_argument("--spring-constant", metavar="K", help="for deflections, N/m")
    group.add_argument("--pulls", choices=("positive", "negative"), help="sign of a pulling force in the file")
    group.add_argument(
        "--baseline",
        type=float,
        metavar="PART",
        help="fraction of each curve, farthest from the surface, where no surface force acts; default: 0.3",
    )


def _add_detach(commands) -> None:
    command = commands.add_parser("detach", help="tell at what flow, vibration, tilt or rotation the sphere comes off")
    command.add_argument("run", metavar="RUN", help="the archive of a run, such as run.nc, or its folder")
    command.add_argument("--load", default="wall_shear", choices=LOADS, help="default: %(default)s")
    command.add_argument("--fluid", default="air", choices=FLUIDS, help="at 20 °C; the adhesion stays that of the run")
    command.add_argument(
        "--particle-density", metavar="RHO", help="kg/m³; default: weight is neglected, in a flow only"
    )
    slides = command.add_mutually_exclusive_group()
    slides.add_argument("--friction-coefficient", type=float, metavar="MU", help="default: the sphere cannot slide")
    slides.add_argument("--shear-strength", metavar="TAU", help="of the contact, GPa, or text such as '5 MPa'")
    command.add_argument(
        "--method",
        choices=("continued", "adhesive", "energy"),
        help="source of the pull-off forces: the simulation with the roughness continued below the scan (one row for "
        "each place and surface), the simulation on the scan as it is, or superposed asperities; default: the first of "
        "these that the run has",
    )
    command.add_argument("-o", "--output", metavar="TABLE", help="one row for each place, OUT.csv or OUT.parquet")
    command.add_argument(
        "--parameters",
        metavar="TABLE",
        help="input parameters for Rock'n'Roll, LAMMPS and code_saturne, OUT.csv or OUT.parquet",
    )
    command.add_argument(
        "--dem",
        nargs=2,
        action="append",
        default=[],
        metavar=("CODE", "FILE"),
        help=f"input lines for a particle code: {', '.join(PARTICLE_CODES)} (the distribution itself); may be repeated",
    )
    command.add_argument(
        "--picture",
        metavar="PNG",
        help="draw how the sphere comes off at each place (roll, slide or lift), or the critical load where all places "
        "agree, and the resisting moment over direction",
    )
    command.set_defaults(command=_detach)


def _add_cite(commands) -> None:
    command = commands.add_parser("cite", help="print what to cite, for BibTeX")
    command.set_defaults(command=lambda _: print(_BIBTEX))


def _add_reading(command) -> None:
    group = command.add_argument_group("what to read from the file")
    group.add_argument("--channel", help="name or number of the image; default: the first topography")
    group.add_argument("--direction", choices=("trace", "retrace"), help="default: trace (forward)")
    group.add_argument(
        "--size", nargs="+", metavar="L", help="size of the scan along x and y, nm, if the file does not state it"
    )
    group.add_argument(
        "--height-units", metavar="UNITS", help="units of the heights if the file does not state them, such as nm"
    )
    group.add_argument(
        "--fill",
        metavar="HOW",
        help="fill missing pixels: linear, nearest, or one height in nm; default: leave them missing",
    )


def _add_budget(command) -> None:
    command.add_argument(
        "--budget",
        type=int,
        default=8,
        metavar="PLACES",
        help="most places at which the simulation with adhesion is repeated under each change of the error budget; 0: "
        "no budget; default: %(default)s",
    )


def _add_quiet(command) -> None:
    command.add_argument("-q", "--quiet", action="store_true", help="show no progress")


def _paper(options) -> None:
    from .reproduction import paper

    _tell_answer(paper(options.output, budget=options.budget), options.output)


def _run(options) -> None:
    from pathlib import Path

    if Path(options.output).is_file() and Path(options.output).suffix != ".nc":
        raise ValueError(f"{options.output}: expected a folder or a file ending in .nc for -o, found another file")
    if len(options.scan) == 1:
        _tell_answer(_run_one(options, options.scan[0], options.output), options.output)
        return
    from . import scans as readers
    from .runs import several

    output = Path(options.output)
    for file in options.scan:  # before minutes are spent on those before it
        try:
            readers.describe(file)
        except _REFUSALS as error:
            _warn(f"{file}: cannot be read and is left out: {_in_words(error)}")
    scans = several.folders(options.scan, output)
    runs = several.run_each(scans, lambda scan, folder: _run_one(options, str(scan), folder))
    answer = several.together(*runs, output)
    print(f"written to {output}: index.html, places.csv, and a folder for each scan")
    for name, reason in runs[1].items():
        _warn(f"{name}: left out: {reason}")
    print(f"{answer} {len(runs[1])} of {len(options.scan)} files were left out." if runs[1] else answer)


def _run_one(options, file: str, output):
    from .jobs.schedulers import on
    from .runs import analysis

    scan = _paired(_opened(file, options), options)
    with on(options.scheduler):
        return analysis.run(
            scan,
            output,
            subregions=_both(options.subregions),
            particle=options.particle,
            delta=options.delta,
            preload=options.preload,
            law=options.law,
            mesh=options.mesh,
            levelling=options.level,
            budget=options.budget,
        )


def _tell_answer(groups, output: str) -> None:
    """Print where a run was written, and its answer on the last line."""
    from .presentation import report

    print(f"written to {output}")
    if answer := report.headline(groups):
        print(answer)


def _both(counts: Sequence[int]) -> tuple[int, int]:
    """Return the places along x and y: one number stands for both."""
    if len(counts) > 2:
        raise ValueError(f"--subregions: expected places along x and y, or one number for both, found {len(counts)}")
    return counts[0], counts[-1]


def _paired(scan, options):
    """Return the scan with the bodies that the options name; ask for what has no default."""
    from . import scans
    from .bodies import materials
    from .bodies.liquid import HumidAir

    pair = {
        "sphere_radius": options.sphere_radius,
        "indenter": options.indenter and scans.open_scan(options.indenter),
        "materials": options.materials,
        "young_modulus": options.young_modulus,
        "poisson_ratio": options.poisson_ratio,
        "contact_modulus": options.contact_modulus,
        "surface_energy": options.surface_energy,
        "work_of_adhesion": options.work_of_adhesion,
        "adhesion_range": options.adhesion_range,
        "hamaker_constant": options.hamaker_constant,
        "hardness": options.hardness,
        "retardation": options.retardation,
    }
    if not (options.materials or options.young_modulus or options.contact_modulus):
        raise ValueError(
            "expected the bodies' elastic constants, found none: give --materials A/B (one or two of "
            f"{', '.join(MATERIALS)}), or --young-modulus and --poisson-ratio, or --contact-modulus"
        )
    pair = {name: _numbers(value) for name, value in pair.items() if value is not None}
    wet = {name: getattr(options, name) for name in ("humidity", "contact_angle", "temperature", "liquid", "film")}
    wet = {name: _numbers(value) for name, value in wet.items() if value is not None}
    if "humidity" in wet:
        pair["humidity"] = HumidAir(**wet)
    elif wet:
        raise ValueError(f"--humidity: needed by {', '.join(wet)}, found none; give it, or leave these options out")
    scan = materials.assign_pair(scan, **pair)
    if "work_of_adhesion" not in scan.coords:
        raise ValueError(
            "expected the adhesion of the bodies, found none: give --work-of-adhesion (or --surface-energy) in J/m²; "
            "clean dry solids have about 0.05 to 0.1 by van der Waals forces alone, and more with water films or bonds"
        )
    return scan


def _numbers(value):
    """Return the value of a list of words: a number, a quantity, or a pair of them."""
    if not isinstance(value, (str, list)):
        return value
    numbers = [_number(one) for one in ([value] if isinstance(value, str) else value)]
    return numbers[0] if len(numbers) == 1 else tuple(numbers)


def _report(options) -> None:
    from .presentation.report import write_report

    options.file = options.measured
    measured = _measurement(options) if options.file else None
    print(f"written to {write_report(options.run, options.output, measured=measured)}")


def _explore(options) -> None:
    import webbrowser

    from .presentation.report import write_explorer

    page = write_explorer(options.run, options.output, loops=options.loops)
    print(f"written to {page}")
    if options.open:
        webbrowser.open(page.resolve().as_uri())


#: What `measured` reads besides adhesion images in the formats of scans.
_MEASURED_FORMATS = (
    ("table of pull-offs, any separator, names above", ".csv, .txt, .dat, .tsv", "roughxr measured"),
    ("workbook of pull-offs", ".xlsx", "roughxr measured (extra excel)"),
    (
        "force-distance curves and force volumes",
        ".jpk-force, .ibw, .h5, .tab, .csv",
        "roughxr measured (extra curves)",
    ),
    ("Bruker's force curves (NanoScope)", ".spm, .pfc", "not read; export as text"),
)


def _info(options) -> None:
    from . import scans
    from .presentation import figures

    if options.formats or options.file is None:
        for name, endings, through in [*scans.formats(), *_MEASURED_FORMATS]:
            print(f"{name:50s} {endings:36s} {through}")
        return
    channels = scans.describe(options.file)
    print(
        "\n".join(
            f"{key}: {printable(str(value or 'none'))}" for key, value in channels.attrs.items() if key != "history"
        )
    )
    print("sizes and heights in nm, s_q about the mean plane:")
    print(channels.rename(units="units in file").to_dataframe().to_string(float_format=lambda v: number(v, digits=6)))
    scan = _opened(options.file, options).load()
    channel = printable(str(scan.attrs.get("channel", "height")))
    print(f"\nroughness of {channel}, nm about its mean plane where not said otherwise:")
    for name, value in scans.roughness(scan, spectra=False).data_vars.items():
        if value.ndim == 0:
            print(f"  {name:10s} {float(value):12.6g} {value.attrs['units']:5s} {value.attrs['long_name']}")
    if options.picture:
        from matplotlib.figure import Figure

        axes = figures.scan_map(scans.level(scan), ax=Figure(figsize=(4, 3.4), layout="constrained").subplots())
        figures.save(axes.figure, options.picture, dpi=150)
        print(f"drawn in {options.picture}")


def _convert(options) -> None:
    from pathlib import Path

    from . import scans
    from .vocabulary.schema import one_of

    endings = (".nc",) if options.surfacetopography else (".nc", ".gsf")
    suffix = one_of(Path(options.output).suffix, endings, "output")
    scan = _opened(options.file, options)
    own = suffix == ".nc" and not options.surfacetopography
    (scans.to_netcdf if own else scans.to_file)(scan, options.output)
    print(f"written to {options.output}")


def _measured(options) -> None:
    from . import statistics
    from .presentation import exports

    ds = _measurement(options)
    told = {key: value for key, value in ds.attrs.items() if key != "history"}
    print("\n".join(f"{key}: {printable(str(value))}" for key, value in told.items()))
    print(f"places: {'known' if 'subregion_x' in ds.coords else 'not known'}")
    if "reason" in ds:
        left = ds["reason"].where(ds["reason"] != "", "used").to_series().value_counts()
        print("curves: " + ", ".join(f"{count} {reason}" for reason, count in left.items()))
    print("\npull-off force, nN:")
    intervals = statistics.bootstrap(ds, "pull_off_force").sel(resampling="block", drop=True)
    print(intervals[["estimate", "low", "high"]].to_dataframe().to_string(float_format=number))
    if options.output:
        print(f"written to {exports.to_table(ds, options.output)}")


def _compare(options) -> None:
    from pathlib import Path

    from . import measured
    from .files import archive
    from .presentation import figures
    from .vocabulary.schema import one_of

    groups = archive.load(archive.of_run(Path(options.run)))
    methods = [name.partition("/")[2] for name, ds in groups.items() if name.startswith("statistics/") and _pulls(ds)]
    predicted = groups[f"statistics/{one_of(options.method, methods, 'method')}"].load()
    own = _measurement(options)
    compared = measured.compare(predicted, own)
    print(f"measured over predicted ({options.method}) pull-off forces, nN:")
    columns = [f"{name}{end}" for name in ("predicted", "measured", "ratio") for end in ("", "_low", "_high")]
    print(compared[columns].to_dataframe().to_string(float_format=number))
    distance, p_value = float(compared.distribution_distance), float(compared.distribution_p_value)
    print(f"\nlargest difference of the cumulative distributions: {number(distance)}, p = {number(p_value)}")
    print(f"independent places: {float(compared.predicted_places):.0f} and {float(compared.measured_places):.0f}")
    print(f"places: {compared.attrs['places']}{_shift(compared)}")
    if options.picture:
        from matplotlib.figure import Figure

        axes = Figure(figsize=(6.9, 2.9), layout="constrained").subplots(1, 2)
        figures.predicted_and_measured(predicted, own, comparison=compared, ax=axes)
        figures.save(axes[0].figure, options.picture, dpi=150)
        print(f"drawn in {options.picture}")


def _detach(options) -> None:
    from pathlib import Path

    from . import detachment
    from .detachment.for_codes import by_place
    from .files import archive
    from .presentation import exports, report
    from .presentation.report.coming_off import leading
    from .vocabulary.schema import one_of

    for path in filter(None, (options.output, options.parameters)):  # before anything is computed
        one_of(Path(path).suffix, exports.FORMATS, f"{path}'s ending")
    if options.picture:
        one_of(Path(options.picture).suffix, _PICTURES, f"{options.picture}'s ending")
    for code, _ in options.dem:
        one_of(code, PARTICLE_CODES, "--dem")
    groups = archive.load(archive.of_run(Path(options.run)))
    if not set(report.COMING_OFF) <= set(groups):
        raise ValueError(
            f"{options.run}: expected a run with resisting moments, found none; a run has none without adhesion, with "
            "an indenter instead of a sphere, in very humid air, or if an older roughxr made it (then run it again)"
        )
    options.method = options.method or leading(groups)
    held = report.moments_of(groups, options.method)
    if options.fluid == "water" and held.attrs.get("law") == "menisci":
        raise ValueError(
            f"--fluid water: expected a dry run, found one at {percent(held['humidity'])} relative humidity; "
            "run again without --humidity, with the --work-of-adhesion under water"
        )
    density = options.particle_density and _number(options.particle_density)
    body = {"load": options.load, "particle_density": density, "flow": options.fluid}
    slides = {
        "friction_coefficient": options.friction_coefficient,
        "shear_strength": options.shear_strength and _number(options.shear_strength),
    }
    critical = detachment.critical_load(held, **body, **slides)
    _tell_critical(critical, held, options)
    if "statistics/rests" in groups:
        _tell_rests(groups, body, slides)
    if options.output:
        table = by_place(held).merge(critical, compat="override", combine_attrs="override")
        print(f"written to {exports.to_table(table, options.output)}")
    if options.parameters:
        numbers = detachment.parameters(held, catalogue=groups["asperities"])
        print(f"written to {exports.to_table(numbers, options.parameters)}")
    for code, path in options.dem:
        Path(path).write_text(detachment.to_dem(held, code=code), encoding="utf-8")
        print(f"written to {path}")
    if options.picture:
        _draw_coming_off(critical, held, options)


def _tell_critical(critical, held, options) -> None:
    """Print the critical strength of a load, and how the sphere comes off."""
    import numpy as np

    name, rests = next(iter(critical.data_vars)), "landing_share" in critical.coords
    values = critical[name].where(np.isfinite(critical[name]))
    words = f"{critical[name].attrs['long_name']}, {critical[name].attrs['units']}"
    method = "menisci" if options.method == "energy" and held.attrs.get("law") == "menisci" else options.method
    work = f"work of adhesion {number(held['work_of_adhesion'], 'J/m²')} as in the run"
    print(f"{options.load} in {options.fluid}, pull-off forces of {method!r}, {work}; {words}:")
    if bool(values.notnull().any()):
        least, middle, most = (number(_quantile(values, part)) for part in (0.05, 0.5, 0.95))
        of = "particles where they came to rest" if rests else "places"
        print(f"  5 % of {of} {least}, median {middle}, 95 % {most}")
    counts = ((mode, int((critical["mode"] == mode).sum())) for mode in np.unique(critical["mode"].values.astype(str)))
    print("how it comes off: " + ", ".join(f"{mode} at {count}" for mode, count in counts))
    inside = int(critical["in_range"].sum())
    of = "cases (places × surfaces)" if options.method == "continued" else "places"
    print(f"within the range of the drag formulas: {inside} of {critical.sizes['subregion']} {of}")


def _quantile(values, part: float) -> float:
    """Return a quantile over particles, where places hold shares of them, else over places."""
    from .statistics.sampling import shares

    return float(values.weighted(shares(values)).quantile(part))


def _tell_rests(groups, body, slides) -> None:
    """Print what half of the particles of a run stand at rest, where they landed, and up to the lowest pass."""
    from . import detachment

    at = {"at rest": "solutions/rolling", "where they landed": "solutions/rolling_landed"}
    critical = {words: detachment.critical_load(groups[name], **body, **slides) for words, name in at.items()}
    told = [(words, next(iter(ds.data_vars.values()))) for words, ds in critical.items()]
    rests = groups["statistics/rests"]
    if bool(rests["pass_x"].notnull().any()):
        leaves = detachment.leaving(groups["asperities"], rests, **body)
        told += [("to leave over the lowest pass", next(v for n, v in leaves.items() if str(n).startswith("leaving")))]
    medians = ", ".join(f"{words} {number(_quantile(values, 0.5))}" for words, values in told)
    print(f"the median by superposed asperities: {medians} {told[0][1].attrs['units']}")


def _draw_coming_off(critical, held, options) -> None:
    """Draw what goes first, or how much it takes where all go alike, beside the rose of resisting moments."""
    import numpy as np
    from matplotlib.figure import Figure

    from .presentation import figures

    figure = Figure(figsize=(6.9, 3.4), layout="constrained")
    left, strength = figure.add_subplot(1, 2, 1), next(iter(critical.data_vars))
    alike = np.unique(critical["mode"].values).size == 1 and bool(critical[strength].notnull().any())
    figures.subregion_map(critical, strength, ax=left) if alike else figures.mode_map(critical, ax=left)
    figures.moment_rose(held, ax=figure.add_subplot(1, 2, 2, projection="polar"))
    figure.suptitle(f"{options.load} in {options.fluid}, pull-off forces of {options.method!r}")
    figures.save(figure, options.picture, dpi=150)
    print(f"drawn in {options.picture}")


def _pulls(ds) -> bool:
    return "pull_off_force" in ds and ds["pull_off_force"].dims == ("subregion",)


def _shift(compared) -> str:
    if "measured_force" not in compared:
        return ""
    words = f"by {number(compared.shift_x)} and {number(compared.shift_y)} nm along x and y"
    return f", {words}; correlation {number(compared.place_correlation)}, p = {number(compared.place_p_value)}"


def _measurement(options):
    """Return the measured pull-offs in a file, read with the given options."""
    from .measured import curves_pull_off, open_curves, open_pull_off

    known = {"sensitivity": options.sensitivity}
    known |= {"spring_constant": options.spring_constant and _number(options.spring_constant)}
    if options.baseline is not None:
        if len(options.file) > 1:
            raise ValueError(f"--baseline: expected one file of curves, found {len(options.file)}")
        return curves_pull_off(open_curves(options.file[0], **known), baseline=options.baseline)
    return open_pull_off(
        options.file,
        channel=int(options.channel) if (options.channel or "").isdecimal() else options.channel,
        direction=options.direction,
        size=None if options.size is None else tuple(map(_number, options.size)),
        units=options.units,
        place_units=options.place_units,
        pulls=options.pulls,
        **known,
    )


def _opened(file: str, options):
    """Return the scan in a file, read with the given options."""
    from . import scans

    channel = int(options.channel) if (options.channel or "").isdecimal() else options.channel
    size = None if options.size is None else tuple(map(_number, options.size))
    scan = scans.open_scan(
        file, channel=channel, direction=options.direction, size=size, height_units=options.height_units
    )
    return scan if options.fill is None else scans.fill(scan, method=_number(options.fill))


def _number(text: str) -> float | str:
    """Return plain numbers as numbers; anything else is a quantity with its own units."""
    try:
        return float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    sys.exit(main())
