"""The options of each command, with their help; imports nothing but the parser.

Most options are one row: flags, what stands for its value ("E..." for one or more) and help. A command names the
function that does it, ``module:function`` of this package.
"""

from __future__ import annotations

import argparse
from typing import Any

from .._version import __version__
from ..bodies.substances import MATERIALS
from .spelling import Parser
from .words import number

#: Laws of attraction, the same as in `adhesive`, repeated here so that help needs no import of the solver.
LAWS = ("auto", "exponential", "griffith", "dugdale", "lennard_jones")

#: Codes of `to_dem`, loads of `critical_load`, and its fluids.
PARTICLE_CODES = ("lammps", "rock_n_roll")
LOADS = ("wall_shear", "tilt", "centrifuge", "vibration")
FLUIDS = ("air", "water")

_DESCRIPTION = "How hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface."

#: The documentation is built from a clone, and is not hosted.
_DOCUMENTATION = (
    "Documentation: in a clone, `pip install '.[docs]'` and `sphinx-build -W notebooks build/site` make the pages, "
    "build/site/index.html the first of them; in Python, `help(roughxr)`."
)

_VERSION = f"roughxr {__version__}; cite the program, and Cheng, Dunn and Brach, J. Adhesion 79 (2003) 749-776"

_RUN = ("run", "RUN", "the archive of a run, such as run.nc, or its folder")
_DEFAULT = "default: %(default)s"
_DIRECTIONS = ("trace", "retrace")

_BODIES = (
    ("--materials", "A/B", f"one or two of {', '.join(MATERIALS)}: moduli, van der Waals adhesion, estimated hardness"),
    ("--young-modulus", "E...", "Young's modulus, one value for both bodies or one for each, GPa"),
    ("--poisson-ratio", "NU...", "one value for both bodies or one for each"),
    ("--contact-modulus", "E*", "instead of moduli and Poisson's ratios, GPa"),
    ("--surface-energy", "GAMMA", "of two bodies of the same material, J/m²: half the work of adhesion"),
    ("--work-of-adhesion", "W...", "J/m²; default: from --materials; with --humidity also two, dry and under liquid"),
    ("--hardness", "H", "largest contact pressure that the softer body bears, GPa; default: the bodies stay elastic"),
    ("--adhesion-range", "RHO", "how far the attraction reaches, nm; default: 0.3"),
    ("--hamaker-constant", "A", "of the pair, such as '65 zJ', instead of --work-of-adhesion"),
    ("--retardation", "L", "retardation wavelength of van der Waals forces, nm; default: no retardation"),
)

_AIR = (
    ("--humidity", "RH", "relative humidity, such as '60 %%' or 0.6; default: dry"),
    ("--contact-angle", "DEG...", "of the liquid on both bodies or on each, degrees; default: 0"),
    ("--temperature", "T", "of the humid air, K or as in '25 degC'; default: 298.15"),
    ("--liquid", "NAME...", "water, ethanol, or surface tension (J/m²) and molar volume (cm³/mol); default: water"),
    ("--film", "F", "thickness of a liquid film on each body, nm; default: none"),
)

#: Names of the options of the bodies, without their shape, and of the humid air between them.
BODIES, AIR = ([flag.removeprefix("--").replace("-", "_") for flag, *_ in rows] for rows in (_BODIES, _AIR))


def command_line() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = Parser(prog="roughxr", description=_DESCRIPTION, epilog=_DOCUMENTATION)
    parser.add_argument("--version", action="version", version=_VERSION)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in (_paper, _run, _pages, _files, _measurements, _detach):
        add(commands)
    return parser


def _command(commands: Any, name: str, does: str, help: str) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=help, fromfile_prefix_chars="@")
    command.add_argument("--debug", action="store_true", help="show the traceback of every error")
    command.set_defaults(command=does)
    return command


def _add(to: Any, *rows: tuple[str, str, str]) -> None:
    """Add options whose values are read later, each from flag, metavar and help."""
    for flag, metavar, words in rows:
        several = "+" if metavar.endswith("...") else None
        to.add_argument(*flag.split(), metavar=metavar.removesuffix("..."), nargs=several, help=words)


def _paper(commands: Any) -> None:
    does = "repeat the paper's analysis on the synthetic glass sample: archive, figures, tables"
    command = _command(commands, "paper", "running:paper", does)
    command.add_argument("-o", "--output", default="paper-run", metavar="FOLDER", help=_DEFAULT)
    _add(command, ("--materials", "A/B", f"bodies in place of the paper's glass: one or two of {', '.join(MATERIALS)}"))
    words = "GPa, for finer roughness only: all else is elastic; default: that of the materials, or of glass"
    _add(command, ("--hardness", "H", words))
    _add_budget(command)
    _add_quiet(command)


def _run(commands: Any) -> None:
    does = "analyse a scan, or each of several: pull-off, forces, error budget, report"
    command = _command(commands, "run", "running:run", does)
    _add(command, ("scan", "SCAN...", "an AFM file, or a NetCDF file of a scan; @FILE reads options from a file"))
    words = "folder, or FILE.nc for the archive alone; default: %(default)s"
    command.add_argument("-o", "--output", default="run", metavar="OUT", help=words)
    _add_reading(command)
    command.add_argument("--level", default="plane", choices=("plane", "quadratic", "none"), help=_DEFAULT)
    group = command.add_argument_group("the two bodies (plain numbers in nm, GPa, J/m², or text such as '3 um')")
    shape = group.add_mutually_exclusive_group(required=True)
    shape.add_argument("--sphere-radius", "--radius", metavar="R", help="radius of the sphere, nm")
    _add(shape, ("--indenter", "FILE", "a scan of the indenter, instead of a sphere"))
    _add(group, *_BODIES, *_AIR)
    _add_places(command.add_argument_group("where and how deep"))
    _add_adhesion(command.add_argument_group("the simulation with adhesion"))
    words = "threads, processes, synchronous, or the address of a dask scheduler; default: threads"
    _add(command, ("--scheduler", "NAME", words))
    _add_budget(command)
    _add_quiet(command)


def _add_places(group: Any) -> None:
    words = "number of places along x and y, or one number for both; default: 8 8"
    group.add_argument("--subregions", nargs="+", type=int, default=(8, 8), metavar="N", help=words)
    kind = group.add_mutually_exclusive_group()
    words = "the sphere is fixed in position, as a colloidal probe (default)"
    kind.add_argument("--probe", action="store_true", help=words)
    words = "the sphere is free: it lands at each place, rolls to rest, and is analysed there"
    kind.add_argument("--particle", action="store_true", help=words)
    words = "displacements of the simulation without adhesion, nm; default: chosen from the heights"
    group.add_argument("--delta", nargs="+", type=float, metavar="D", help=words)


def _add_adhesion(group: Any) -> None:
    words = "force that presses the sphere on before it is pulled off, nN or as '50 nN'; default: 0"
    group.add_argument("--preload", default=0.0, type=number, metavar="P", help=words)
    words = "how the attraction falls with the gap; default: auto, exponential where its range matters, else griffith"
    group.add_argument("--law", default="auto", choices=LAWS, help=words)
    words = "number of cells along a pixel; default: auto, from the range of the attraction"
    group.add_argument("--mesh", default="auto", type=_cells, metavar="N", help=words)


def _cells(text: str) -> int | str:
    if text != "auto" and not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected auto or a number of cells, found {text!r}")
    return text if text == "auto" else int(text)


def _pages(commands: Any) -> None:
    command = _command(commands, "report", "pages:report", "write the report of a finished run, one HTML file")
    _add(command, _RUN, ("-o --output", "HTML", "default: report.html beside the archive"))
    command = _command(commands, "explore", "pages:explore", "write an interactive page of a finished run")
    _add(command, _RUN, ("-o --output", "HTML", "default: explore.html beside the archive"))
    command.add_argument("--open", action="store_true", help="show the page in the browser")
    _add_quiet(command)


def _files(commands: Any) -> None:
    command = _command(commands, "info", "files:info", "print the channels of a file, and the roughness of a scan")
    command.add_argument("file", metavar="FILE", nargs="?")
    words = "list the formats of scans and of measured pull-offs"
    command.add_argument("--formats", action="store_true", help=words)
    _add_reading(command)
    _add(command, ("--picture", "PNG", "draw the heights, levelled by a plane"))
    command = _command(commands, "convert", "files:convert", "write a scan in another format")
    command.add_argument("file", metavar="FILE")
    command.add_argument("-o", "--output", required=True, metavar="OUT", help="OUT.nc or OUT.gsf")
    _add_reading(command)


def _measurements(commands: Any) -> None:
    does = "print what a file of measured pull-off forces contains"
    command = _command(commands, "measured", "measurements:describe", does)
    _add_measurement(command)
    _add(command, ("-o --output", "TABLE", "write them as a table, OUT.csv or OUT.parquet"))
    does = "compare the pull-off forces of a run with measured ones"
    command = _command(commands, "compare", "measurements:compare_with_run", does)
    _add(command, _RUN)
    _add_measurement(command)
    words = "method of the prediction: adhesive, energy, rigid, …; default: %(default)s"
    command.add_argument("--method", default="adhesive", help=words)
    _add(command, ("--picture", "PNG", "draw both distributions, and their quantiles"))


def _detach(commands: Any) -> None:
    does = "print the flow, vibration, tilt or rotation that detaches the sphere"
    command = _command(commands, "detach", "detach:detach", does)
    _add(command, ("run", "RUN", f"{_RUN[2]}, or the folder of several scans"))
    command.add_argument("--load", default="wall_shear", choices=LOADS, help=_DEFAULT)
    words = "at 20 °C; the adhesion stays that of the run"
    command.add_argument("--fluid", default="air", choices=FLUIDS, help=words)
    _add(command, ("--particle-density", "RHO", "kg/m³; default: weight is neglected, in a flow only"))
    slides = command.add_mutually_exclusive_group()
    slides.add_argument("--friction-coefficient", type=float, metavar="MU", help="default: the sphere cannot slide")
    _add(slides, ("--shear-strength", "TAU", "of the contact, GPa, or text such as '5 MPa'"))
    words = (
        "source of the pull-off forces: the simulation with roughness extrapolated below the scan, that on the scan "
        "as it is, or superposed asperities; default: the first of these that the run has"
    )
    command.add_argument("--method", choices=("extrapolated", "adhesive", "energy"), help=words)
    words = "input parameters for Rock'n'Roll, LAMMPS and code_saturne, OUT.csv or OUT.parquet"
    _add(command, ("-o --output", "TABLE", "one row for each place, OUT.csv or OUT.parquet"))
    _add(command, ("--parameters", "TABLE", words))
    words = f"input lines for a particle code: {', '.join(PARTICLE_CODES)} (the distribution itself); may be repeated"
    command.add_argument("--dem", nargs=2, action="append", default=[], metavar=("CODE", "FILE"), help=words)
    words = "draw how the sphere comes off at each place, or the critical load where all agree, and resisting moments"
    _add(command, ("--picture", "PNG", words))


_MEASURED = "a table with named columns, an adhesion image, or force-distance curves; several files are pooled"


def _add_measurement(command: Any) -> None:
    _add(command, ("file", "FILE...", _MEASURED))
    group = command.add_argument_group("what to read from the file, and what the file does not state")
    group.add_argument("--channel", help="name of the column, name or number of the image")
    group.add_argument("--direction", choices=_DIRECTIONS, help="of an image; default: trace (forward)")
    _add(group, ("--size", "L...", "of an image along x and y, nm"))
    group.add_argument("--units", help="of what was measured, such as nN or V")
    _add(
        group,
        ("--place-units", "UNITS", "of the columns x and y, such as um"),
        ("--sensitivity", "S", "for values in V, such as '12 nN/V' or '50 nm/V'"),
        ("--spring-constant", "K", "for deflections, N/m"),
    )
    group.add_argument("--pulls", choices=("positive", "negative"), help="sign of a pulling force in the file")
    words = "a table of force curves; fraction of each, farthest from the surface, with the baseline: 1 is all of it"
    group.add_argument("--baseline", type=float, metavar="PART", help=words)


def _add_reading(command: Any) -> None:
    group = command.add_argument_group("what to read from the file")
    group.add_argument("--channel", help="name or number of the image; default: the first topography")
    group.add_argument("--direction", choices=_DIRECTIONS, help="default: trace (forward)")
    _add(
        group,
        ("--size", "L...", "size of the scan along x and y, nm, if the file does not state it"),
        ("--height-units", "UNITS", "units of the heights if the file does not state them, such as nm"),
        ("--fill", "HOW", "fill missing pixels: linear, nearest, or one height in nm; default: leave them missing"),
    )


def _add_budget(command: Any) -> None:
    words = "places at which each change of the error budget is simulated; 0: no budget; default: %(default)s"
    command.add_argument("--budget", type=int, default=8, metavar="PLACES", help=words)


def _add_quiet(command: Any) -> None:
    command.add_argument("-q", "--quiet", action="store_true", help="show no progress")
