"""The options of each command, with their help, without the import of any solver.

Most options are one row: flags, metavar ("E..." for one or more values) and help. A command names its function as
``module:function`` of this package.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any

from ..._version import __version__
from ...mechanics.bodies.substances import MATERIALS
from ...mechanics.vocabulary.adhesion_laws import AUTO, laws_of
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import did_you_mean
from . import config
from .words import number, share

#: Codes of `to_dem`, loads of `critical_load`, and its fluids.
PARTICLE_CODES = ("lammps", "liggghts", "rock_n_roll")
CAUSES = ("wall_shear", "tilt", "centrifuge", "vibration")
FLUIDS = ("air", "water")

_DESCRIPTION = (
    "The force that detaches a small sphere from a rough surface, at many places of an AFM scan, with its uncertainty."
)

#: The documentation is built from a clone, and is not hosted.
_DOCUMENTATION = (
    "Documentation: in a clone, run `pip install '.[docs]'` and `sphinx-build -W notebooks build/site`, and open "
    "build/site/index.html; in Python, `help(roughxr)`."
)

_VERSION = f"roughxr {__version__}; cite the program, and Cheng, Dunn and Brach, J. Adhesion 79 (2003) 749-776"

_RUN = ("run", "RUN", "the archive of a run, such as run.nc, or its folder")
_DEFAULT = "default: %(default)s"

_HALF = "the radius is half of the diameter: give --sphere-radius half of this value"

#: Names that people give to options, with the option and what to do.
_OTHER_NAMES = {
    "--diameter": ("--sphere-radius", _HALF),
    "--sphere-diameter": ("--sphere-radius", _HALF),
    "--load": ("--cause", f"what detaches the sphere is --cause: {', '.join(CAUSES)}"),
}

_FORCE_STD = (
    "relative standard deviation that all measured forces share, such as 10%% by the spring constant; default: 0"
)

_DIRECTIONS, _QUIET = ("trace", "retrace"), "show no progress"

_BODIES = (
    ("--materials", "A/B", f"one or two of {', '.join(MATERIALS)}: moduli, van der Waals adhesion, estimated hardness"),
    ("--young-modulus", "E...", "Young's modulus, one value for both bodies or one for each, GPa"),
    ("--poisson-ratio", "NU...", "Poisson's ratio, one value for both bodies or one for each"),
    ("--contact-modulus", "E*", "contact modulus E* of the pair, GPa; replaces moduli and Poisson's ratios"),
    ("--surface-energy", "GAMMA", "surface energy of two bodies of one material, J/m²: half the work of adhesion"),
    (
        "--work-of-adhesion",
        "W...",
        "J/m²; default: that of --materials; with --humidity also two values: dry, under liquid",
    ),
    ("--layer", "LAYER", "a layer bonded to the scan's body: thickness and material, such as '5 nm silica'"),
    ("--hardness", "H", "hardness of the softer body, GPa: the upper limit of pressure; default: elastic bodies"),
    ("--adhesion-range", "RHO", "interaction range of the attraction, nm; default: 0.3"),
    ("--hamaker-constant", "A", "Hamaker constant of the pair, such as '65 zJ', instead of --work-of-adhesion"),
    ("--medium", "NAME", "what is between --materials when they meet, such as water; default: air"),
    ("--retardation", "L", "retardation wavelength of van der Waals forces, nm; default: no retardation"),
)

_AIR = (
    ("--humidity", "RH", "relative humidity, such as '60 %%' or 0.6; default: dry"),
    (
        "--contact-angle",
        "DEG...",
        "contact angle of the liquid, one value for both bodies or one for each, degrees; default: 0",
    ),
    ("--liquid", "NAME...", "water, ethanol, or surface tension (J/m²) and molar volume (cm³/mol); default: water"),
    ("--film", "F", "thickness of a liquid film on each body, nm; default: none"),
)

#: Names of the options of the bodies, without their shape, and of the humid air between them.
BODIES, AIR = ([flag.removeprefix("--").replace("-", "_") for flag, *_ in rows] for rows in (_BODIES, _AIR))


class Parser(argparse.ArgumentParser):
    """A parser whose options may also stand in a file, ``--config``; it names the option nearest to a misspelt one."""

    commands: argparse._SubParsersAction | None = None  # of a parser that has them

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as argparse does, after a search for misspelt options of a command."""
        args = _with_negative_values(args)
        self._refuse_misspelt(args or ())
        in_file = config.namespace_of_file(args or (), self)
        parsed, surplus = super().parse_known_args(args, in_file or namespace)
        if surplus:
            self._refuse_surplus(args, surplus[0])
        return parsed, surplus

    def _refuse_misspelt(self, args: Sequence[str]) -> None:
        """End for a command or an option that does not exist, with the nearest that does."""
        options = {flag for action in self._actions for flag in action.option_strings if flag.startswith("--")}
        for word in args:
            option = word.partition("=")[0]
            if self.commands is not None and not option.startswith("-"):
                if option not in (names := self.commands.choices):
                    self.error(f"unknown command {option}{did_you_mean(option, names)}: {', '.join(names)}")
                break  # the options after the command are its own
            if word.startswith("@"):
                self.error(
                    f"{word}: options in a file are read by --config {word[1:]}; a file of this name is ./{word}"
                )
            (usual, advice) = _OTHER_NAMES.get(option, ("", ""))
            if usual in options and option not in options:
                self.error(f"unknown option {option}: {advice}")
            if option.startswith("--") and not any(name.startswith(option) for name in options):
                self.error(f"unknown option {option}{did_you_mean(option, options)}")

    def _refuse_surplus(self, args: Sequence[str], word: str) -> None:
        """End for a word that belongs to no option, with a reason."""
        if word.startswith("-"):
            self.error(f"unknown option {word}")
        before = args[: args.index(word)][-2:]
        if not any(previous.startswith("-") for previous in before):
            taken = [action.metavar or action.dest for action in self._actions if not action.option_strings]
            self.error(f"unexpected {word}: expected {' and '.join(map(str, taken)) or 'options'} alone")
        self.error(
            f"unexpected {word} after {' '.join(before)}: quote values that contain spaces, such as '3 um', "
            "and join two bodies, as glass/silicon"
        )

    def _match_argument(self, action: argparse.Action, arg_strings_pattern: str) -> int:
        """Count the values of an option as argparse does; of an option that lacks one, name its values."""
        try:
            return super()._match_argument(action, arg_strings_pattern)  # type: ignore[misc]
        except argparse.ArgumentError as error:
            if not isinstance(action.nargs, int):
                raise
            names = action.metavar if isinstance(action.metavar, tuple) else (action.metavar,) * action.nargs
            raise argparse.ArgumentError(action, f"{error.message}, {' '.join(map(str, names))}") from error

    def error(self, message: str) -> Any:
        """Print one line, and end."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def _with_negative_values(args: Any) -> Any:
    """Return a command line where values such as -3um, which look like options, are joined to their options."""
    if args is None:
        return None
    joined: list[str] = []
    for word in args:
        is_negative = re.match(r"-\.?\d[^=]*[^\d.]", word) and joined and re.fullmatch(r"--[a-z-]+", joined[-1])
        if is_negative:
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def command_line() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = Parser(prog="roughxr", description=_DESCRIPTION, epilog=_DOCUMENTATION)
    parser.add_argument("--version", action="version", version=_VERSION)
    parser.commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in (_paper, _run, _pages, _files, _measurements, _detach):
        add(parser.commands)
    return parser


def _command(commands: Any, name: str, does: str, help: str) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=help)
    command.add_argument("--debug", action="store_true", help="show the traceback of every error")
    command.set_defaults(command=does)
    return command


def _add(to: Any, *rows: tuple[str, str | None, str], **more: Any) -> list[argparse.Action]:
    """Add options, each from flags, metavar ("E..." for several values) and help; ``more`` applies to all of them."""
    added = []
    for flags, metavar, help in rows:
        several = {"nargs": "+"} if metavar and metavar.endswith("...") else {}
        named = {"metavar": metavar.removesuffix("...")} if metavar else {}
        added.append(to.add_argument(*flags.split(), help=help, **named, **several, **more))
    return added


def _flag(to: Any, flags: str, help: str) -> argparse.Action:
    return to.add_argument(*flags.split(), action="store_true", help=help)


def _paper(commands: Any) -> None:
    does = "repeat the paper on the synthetic glass sample: table, figures, comparison with a simulation"
    command = _command(commands, "paper", "running:paper", does)
    _add(command, ("-o --output", "FOLDER", _DEFAULT), default="paper-run")
    _flag(command, "-q --quiet", _QUIET)


def _run(commands: Any) -> None:
    does = "analyse a scan, or each of several: pull-off, forces, error budget, report"
    command = _command(commands, "run", "running:run", does)
    _add(command, ("scan", "SCAN...", "an AFM file, or a NetCDF file of a scan"))
    _add(command, ("-o --output", "OUT", f"folder, or FILE.nc for the archive alone; {_DEFAULT}"), default="run")
    options = _add_reading_options(command)
    options += _add(
        command,
        ("--level", None, f"background to subtract; {_DEFAULT}"),
        default="plane",
        choices=("plane", "quadratic", "none"),
    )
    options += [*_add_bodies(command), *_add_places(command), *_add_simulation(command)]
    help = "threads, processes, synchronous, or the address of a dask scheduler; default: threads"
    _add(command, ("--scheduler", "NAME", help))
    help = f"number of places for each entry of the error budget; 0: no error budget; {_DEFAULT}"
    options += _add(command, ("--budget", "PLACES", help), type=_count, default=8)
    _flag(command, "-q --quiet", _QUIET)
    config.add_options(command, options)


def _add_bodies(command: Any) -> list[argparse.Action]:
    """Add the options of the two bodies and of the air between them."""
    group = command.add_argument_group("the two bodies (plain numbers in nm, GPa, J/m², or text such as '3 um')")
    shape = group.add_mutually_exclusive_group(required=True)
    sphere = ("--sphere-radius --radius", "R", "radius of the sphere, nm")
    indenter = ("--indenter", "FILE", "a scan of the indenter, instead of a sphere")
    return _add(shape, sphere, indenter) + _add(group, *_BODIES, *_AIR)


def _add_places(command: Any) -> list[argparse.Action]:
    """Add the options of places, displacements, finer roughness and flow."""
    group = command.add_argument_group("places and displacements")
    help = "number of places along x and y, or one number for both; default: 8 8"
    options = _add(group, ("--subregions", "N...", help), type=_counts, default=(8, 8))
    help = "a second scan of the surface on finer pixels, 0.8 to 1.6 radii wide, for the best estimate"
    options += _add(group, ("--finer", "FILE", help))
    help = "shortest wavelength of the surface, nm, where it is known, for the best estimate; default: 0.5"
    options += _add(group, ("--shortest", "L", help), type=number)
    help = "a free particle, which rolls from each place to rest and is analysed there; default: a fixed probe"
    options.append(_flag(group, "--particle", help))
    help = "displacements of the simulation without adhesion, nm; default: chosen from the heights"
    options += _add(group, ("--delta", "D...", help), type=_nanometres)
    help = f"fluid whose flow detaches the sphere, {' or '.join(FLUIDS)}, at 20 °C; default: the medium, else air"
    return options + _add(group, ("--fluid", None, help), choices=FLUIDS)


def _add_simulation(command: Any) -> list[argparse.Action]:
    """Add the options of the simulation with adhesion."""
    group = command.add_argument_group("the simulation with adhesion")
    help = "compressive force before retraction, nN or as '50 nN'; default: 0"
    options = _add(group, ("--preload", "P", help), default=0.0, type=number)
    help = (
        f"law of adhesion: {', '.join(laws_of('adhesive'))}; {_DEFAULT}, exponential where its range matters, else jkr"
    )
    options += _add(group, ("--law", "LAW", help), default=AUTO)
    help = (
        "cells along the side of a pixel; default: auto, refined until the pull-off changes little; a number is quick, "
        "but the errors leave out what finer cells would change; front: the edge of a soft sphere's one contact is "
        "followed, as by auto where cells would be too many"
    )
    return options + _add(group, ("--mesh", "N", help), default="auto", type=_cells)


def _cells(text: str) -> int | str:
    if text not in ("auto", "front") and not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected auto, front or a number of cells, found {text!r}")
    return int(text) if text.isdecimal() else text


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number, found {text!r}")
    return int(text)


def _counts(text: str) -> tuple[int, ...]:
    """Return the numbers of places in "8", "8x8" or "8,8"."""
    parts = re.split("[x×,]", text)
    if not all(part.isdecimal() for part in parts):
        raise argparse.ArgumentTypeError(f"expected numbers of places, such as 8 8 or 8x8, found {text!r}")
    return tuple(map(int, parts))


def _nanometres(text: str) -> float:
    """Return a length as a number or text with units in nm."""
    from ...mechanics.vocabulary.units import magnitude

    try:
        return float(magnitude(number(text), "nm", "length"))
    except Refusal as refusal:
        raise argparse.ArgumentTypeError(str(refusal)) from refusal


def _pages(commands: Any) -> None:
    command = _command(commands, "report", "running:write_report", "write the report of a finished run, one HTML file")
    _add(command, _RUN, ("-o --output", "HTML", "page to write; default: report.html beside the archive"))
    command = _command(commands, "explore", "running:explore", "write an interactive page of a finished run")
    _add(command, _RUN, ("-o --output", "HTML", "page to write; default: explore.html beside the archive"))
    _flag(command, "--open", "show the page in the browser")
    _flag(command, "-q --quiet", _QUIET)


def _files(commands: Any) -> None:
    command = _command(commands, "info", "file_commands:info", "print a file's channels, and a scan's roughness")
    command.add_argument("file", metavar="FILE", nargs="?", help="an AFM file, or a NetCDF file of a scan")
    _flag(command, "--formats", "print the formats that are read, instead")
    _add_reading_options(command)
    _add(command, ("--picture", "PNG", "draw the heights, levelled by a plane"))
    command = _command(commands, "convert", "file_commands:convert", "write a scan in another format")
    _add(command, ("file", "FILE", "an AFM file, or a NetCDF file of a scan"))
    _add(command, ("-o --output", "OUT", "OUT.nc or OUT.gsf"), required=True)
    _add_reading_options(command)


def _measurements(commands: Any) -> None:
    does = "print what a file of measured pull-off forces contains"
    command = _command(commands, "measured", "measurements:describe", does)
    _add_measurement(command)
    help = "of curves on a flat, nm: fit modulus and work of adhesion, which are then printed and written"
    _add(command, ("--sphere-radius", "R", help))
    _add(command, ("-o --output", "TABLE", "write the forces as a table, OUT.csv or OUT.xlsx"))
    _add(command, ("--picture", "PNG", "draw the twelve most doubtful curves, with the reasons for the doubts"))
    _flag(command, "-q --quiet", _QUIET)
    does = "compare the pull-off forces of a run with measured ones"
    command = _command(commands, "compare", "measurements:compare_with_run", does)
    _add(command, _RUN)
    _add_measurement(command)
    _add(
        command,
        ("--method", None, f"prediction: adhesive (simulation), energy (superposed asperities) or rigid; {_DEFAULT}"),
        default="adhesive",
    )
    _add(command, ("--picture", "PNG", "draw both distributions, and their quantiles"))
    _add(command, ("--force-std", "PART", _FORCE_STD), type=share, default=0.0)
    does = "fit the work of adhesion of a run's pair to measured pull-off forces"
    command = _command(commands, "fit", "measurements:fit_to_run", does)
    _add(command, _RUN)
    _add_measurement(command)
    help = f"prediction: adhesive (simulation at 16 of the run's places, minutes) or superposed (seconds); {_DEFAULT}"
    _add(command, ("--method", None, help), default="adhesive", choices=("adhesive", "superposed"))
    _add(command, ("--force-std", "PART", _FORCE_STD), type=share, default=0.0)
    _add(command, ("--picture", "PNG", "draw the distance of prediction and measurement over the work of adhesion"))
    _flag(command, "-q --quiet", _QUIET)


def _detach(commands: Any) -> None:
    does = "print the flow, vibration, tilt or rotation that detaches the sphere"
    command = _command(commands, "detach", "detach:detach", does)
    _add(command, ("run", "RUN", f"{_RUN[2]}, or the folder of several scans"))
    _add(command, ("--cause", None, f"what detaches the sphere; {_DEFAULT}"), default="wall_shear", choices=CAUSES)
    _add(
        command,
        ("--fluid", None, "fluid of the flow, at 20 °C; does not change the adhesion; default: the run's"),
        choices=FLUIDS,
    )
    _add(
        command,
        (
            "--particle-density",
            "RHO",
            "density of the sphere, kg/m³; required, except by a flow, which then neglects the weight",
        ),
    )
    slides = command.add_mutually_exclusive_group()
    help = "friction coefficient (PTFE 0.05, glass 0.5, gold on gold 1); without it the sphere does not slide"
    _add(slides, ("--friction-coefficient", "MU", help), type=share)
    help = "shear strength of the contact, GPa, or text such as '5 MPa' (polymers 10 MPa, mica and metals 20 to 1000)"
    _add(slides, ("--shear-strength", "TAU", help))
    help = "share of the particles, such as 90%%: print the strength that removes it; in turbulence, too"
    _add(command, ("--remove", "SHARE", help), type=share)
    help = (
        "pull-off forces of the simulation, with finer roughness (extrapolated) or as scanned (adhesive); default: "
        "extrapolated if the run contains it"
    )
    _add(command, ("--method", None, help), choices=("extrapolated", "adhesive"))
    _add(command, ("-o --output", "TABLE", "write one row for each place, OUT.csv or OUT.xlsx"))
    help = "write input parameters for Rock'n'Roll and LAMMPS, OUT.csv or OUT.xlsx"
    _add(command, ("--parameters", "TABLE", help))
    help = (
        f"write input for a particle code: {', '.join(PARTICLE_CODES)} (a table of the distribution); may be repeated"
    )
    command.add_argument("--dem", nargs=2, action="append", default=[], metavar=("CODE", "FILE"), help=help)
    help = (
        "draw a map of the mode of detachment, or of the critical load, and the resisting moments; of several scans "
        "the share that is removed over the strength"
    )
    _add(command, ("--picture", "PNG", help))


def _add_measurement(command: Any) -> None:
    help = "a table with named columns, an adhesion image, or force-distance curves; several files are pooled"
    _add(command, ("file", "FILE...", help))
    group = command.add_argument_group("what to read from the file, and what the file does not state")
    _add(group, ("--channel", None, "name of the column, or name or number of the image"))
    _add(group, ("--scan-direction", None, "scan direction of an image; default: trace (forward)"), choices=_DIRECTIONS)
    _add(
        group,
        ("--size", "L...", "size of an image along x and y, nm"),
        ("--units", None, "units of the measured values, such as nN or V"),
        ("--place-units", "UNITS", "units of the columns x and y, such as um"),
        ("--sensitivity", "S", "sensitivity, for values in V, such as '12 nN/V' or '50 nm/V'"),
        ("--spring-constant", "K", "spring constant, for deflections, N/m"),
    )
    _add(group, ("--pulls", None, "sign of pull-off forces in the file"), choices=("positive", "negative"))
    help = (
        "for force curves: part of the travel, from its far end, that may contain the baseline; default: 1, all of it; "
        "or its two ends, such as 0 0.4"
    )
    group.add_argument("--baseline", nargs="+", type=share, metavar="PART", help=help)


def _add_reading_options(command: Any) -> list[argparse.Action]:
    group = command.add_argument_group("what to read from the file")
    options = _add(group, ("--channel", None, "name or number of the image; default: the first topography"))
    help = "scan direction to read; default: trace (forward)"
    options += _add(group, ("--scan-direction", None, help), choices=_DIRECTIONS)
    return options + _add(
        group,
        ("--size", "L...", "size of the scan along x and y, nm, if the file does not state it"),
        ("--height-units", "UNITS", "units of the heights if the file does not state them, such as nm"),
        ("--fill", "HOW", "fill missing pixels: linear, nearest, or one height in nm; default: leave them missing"),
    )
