"""The parser: it suggests what an unknown option may mean, and reads options from files."""

from __future__ import annotations

import argparse
import shlex

from ..vocabulary.text import did_you_mean


class Parser(argparse.ArgumentParser):
    """A parser with suggestions for misspelt options, and with options in files, ``@FILE``."""

    def convert_arg_line_to_args(self, line: str) -> list[str]:
        """Return the words of a line of a file of options; a comment begins with #."""
        return shlex.split(line, comments=True)

    def error(self, message: str):
        """End with the error, and the option that holds the unknown word or is spelt like it."""
        unknown = next((word for word in message.split() if word.startswith("--")), "").split("=")[0]
        if message.startswith("unrecognized") and unknown:
            options = sorted(option_names(self))
            holding = [option for option in options if unknown.lstrip("-") in option.lstrip("-").split("-")]
            message += f"; did you mean {' or '.join(holding)}?" if holding else did_you_mean(unknown, options)
        super().error(message)


def option_names(parser: argparse.ArgumentParser) -> set[str]:
    """Return the long options of a parser and of its commands."""
    known: set[str] = set()
    for action in parser._actions:
        known |= {option for option in action.option_strings if option.startswith("--")}
        if isinstance(action, argparse._SubParsersAction):
            known |= set().union(*(option_names(command) for command in action.choices.values()))
    return known
