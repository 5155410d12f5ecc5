"""The command line: ``roughxr paper``, ``run``, ``report``, ``explore``, ``detach``, ``info``, ``convert``, …

options        each command with its options and their help: all that ``--help`` reads
words          the words of an option as numbers, quantities or pairs; errors of other libraries in words
running        `paper`, `run`, `report`, `explore`
file_commands  `info`, `convert`
measurements   `measured`, `compare`
detach         `detach`

A command is imported when it is called, so that help needs no solver and no figures.
"""

from __future__ import annotations

import importlib
import os
import shlex
import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout

from ..jobs.progress import progress
from .options import command_line
from .words import Printable, in_shell, in_words, is_refusal, tell


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 1 refused, 130 interrupted.

    Refusals of roughxr and errors of the system are one line; any other error shows its traceback.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    _never_fail_to_print()
    try:
        options = command_line().parse_args(words)
        options.line = shlex.join(["roughxr", *words])
    except OSError as error:  # of a file of options, @FILE
        tell(in_words(error))
        return 1
    try:
        with warnings.catch_warnings(), redirect_stdout(Printable(sys.stdout)):
            printed: set[str] = set()
            warnings.showwarning = lambda message, *_, **__: tell(in_shell(str(message), options), printed)
            with nullcontext() if getattr(options, "quiet", True) else progress():
                module, _, name = options.command.partition(":")
                getattr(importlib.import_module(f".{module}", __package__), name)(options)
            sys.stdout.flush()
    except (KeyboardInterrupt, SystemError) as error:
        from ..jobs.spread import is_interrupt

        if not is_interrupt(error):
            raise
        continues = words[:1] in (["paper"], ["run"])
        tell("interrupted" + "; finished places are kept, and the same command continues from there" * continues)
        return 130
    except BrokenPipeError:  # the reader, such as head, has closed the pipe; there is no output left at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        if options.debug or not is_refusal(error):
            raise
        tell(in_shell(in_words(error), options))
        return 1
    return 0


def _never_fail_to_print() -> None:
    """Let standard output and errors replace the signs that their encoding lacks, such as "−" in cp1252."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
