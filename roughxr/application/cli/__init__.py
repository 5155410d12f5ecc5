"""The command line: ``roughxr paper``, ``run``, ``report``, ``explore``, ``detach``, ``info``, ``convert``, …

options        the parser: each command with its options and help
config         options in a file
checks         what the words of a command line alone decide
words          arguments as numbers, quantities or pairs; error messages
running        `paper`, `run`, `report`, `explore`
file_commands  `info`, `convert`
measurements   `measured`, `compare`, `fit`
detach         `detach`

The module of a command is imported when the command is called, so that ``--help`` is fast.
"""

from __future__ import annotations

import gc
import importlib
import os
import shlex
import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout

from ...mechanics.jobs.interrupts import delivered_interrupts, is_interrupt
from ...mechanics.jobs.progress import print_line, progress
from .options import command_line
from .words import (
    EXPECTED_ERRORS,
    Printable,
    error_in_shell,
    expand_wildcards,
    in_shell,
    print_error,
    refuse_inputs_as_outputs,
)

#: Exit status after Ctrl-C, as of a shell's commands.
_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 for success, 1 for invalid input, 130 for an interrupt.

    Errors that roughxr or the operating system raises are printed in one line, all others with their traceback.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    _never_fail_to_print()
    files = [word for word in words if word.startswith("-") and os.path.exists(word)]
    if files:  # of a folder with a file of this name, by a shell's *
        print_error(f"{files[0]}: an option and a file of this folder; name the file ./{files[0]}, all files ./*")
        return 1
    try:
        options = command_line().parse_args(words)
    finally:
        _flush()  # of --help
    options.line = shlex.join(["roughxr", *words])
    try:
        with warnings.catch_warnings(), redirect_stdout(Printable(sys.stdout)), delivered_interrupts():
            printed: set[str] = set()
            warnings.simplefilter("always", UserWarning)  # whatever the filters of Python: each is printed once
            warnings.showwarning = lambda message, *_, **__: print_error(in_shell(message.args[0], options), printed)
            with nullcontext() if getattr(options, "quiet", True) else progress():
                expand_wildcards(options)
                refuse_inputs_as_outputs(options)
                importlib.import_module(".checks", __package__).check(options)
                print_line("loading the package")
                module, _, name = options.command.partition(":")
                command = getattr(importlib.import_module(f".{module}", __package__), name)
                _collect_garbage_again()
                command(options)
    except BrokenPipeError:
        pass
    except (KeyboardInterrupt, Exception) as error:
        if is_interrupt(error):
            continues = words[:1] in (["paper"], ["run"])
            advice = "; finished places are kept, and the same command continues from there" * continues
            print_error(f"interrupted{advice}")
            return _INTERRUPTED
        if options.debug or not isinstance(error, EXPECTED_ERRORS):
            raise
        print_error(error_in_shell(error, options))
        return 1
    finally:
        _flush()
    return 0


def main_of_process() -> None:
    """Run the command line and end the process; after an interrupt at once, without the places being solved."""
    gc.disable()  # imports leave no garbage, and to search them all takes a twentieth of a run
    status = main()
    if status == _INTERRUPTED:
        sys.stderr.flush()
        os._exit(status)  # else it would wait for dask's threads
    sys.exit(status)


def _collect_garbage_again() -> None:
    """Collect garbage again if the process began without, except among what was imported."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


def _flush() -> None:
    """Write what is left of the output, unless its reader, such as head, has closed the pipe."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _never_fail_to_print() -> None:
    """Replace, in standard output and errors, characters that their encoding lacks, such as "−" in cp1252."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
