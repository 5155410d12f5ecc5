"""The command line: ``roughxr paper``, ``run``, ``report``, ``explore``, ``detach``, ``info``, ``convert``, …

options       each command with its options and their help: all that ``--help`` reads
spelling      the parser, which asks back what a wrong word was meant to be
config        options of `run` in a file, and `config`, which writes them out
words         the words of an option as numbers, quantities or pairs; others' errors in words
running       `paper`, `run`
pages         `report`, `explore`
files         `info`, `convert`
measurements  `measured`, `compare`
detach        `detach`
citation      `cite`

A command is imported when it is called, so that help needs none of what solves and draws.
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout

from ..jobs.progress import progress
from .config import with_config
from .options import command_line
from .words import REFUSALS, Printable, in_words, tell


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 1 refused, 130 interrupted."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        options = command_line().parse_args(with_config(words))
        with warnings.catch_warnings(), redirect_stdout(Printable(sys.stdout)):
            said: set[str] = set()
            warnings.showwarning = lambda message, *_, **__: tell(message, said)
            with nullcontext() if getattr(options, "quiet", True) else progress():
                module, _, name = options.command.partition(":")
                getattr(importlib.import_module(f".{module}", __package__), name)(options)
            sys.stdout.flush()
    except (KeyboardInterrupt, SystemError) as error:
        from ..jobs.executor import is_interrupt

        if not is_interrupt(error):
            raise
        continues = words[:1] in (["paper"], ["run"])
        tell("interrupted" + "; finished places are kept, and the same command continues from there" * continues)
        return 130
    except BrokenPipeError:  # the reader, such as head, has had enough; nothing is left to write at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except REFUSALS as error:
        tell(in_words(error))
        return 1
    return 0
