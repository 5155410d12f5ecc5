"""The parser: it suggests what an unknown option or choice may mean, and reads options from files."""

from __future__ import annotations

import argparse
import re
import shlex

from ..vocabulary.text import did_you_mean


class Parser(argparse.ArgumentParser):
    """A parser with suggestions for misspelt words, and with options in files, ``@FILE``."""

    def convert_arg_line_to_args(self, line: str) -> list[str]:
        """Return the words of a line of a file of options; a comment begins with #."""
        return shlex.split(line, comments=True)

    def parse_known_args(self, args=None, namespace=None):
        """Parse as argparse does, and keep what was given."""
        self.given = args
        return super().parse_known_args(args, namespace)

    def error(self, message: str):
        """End with the error and the question."""
        options = option_names(self)
        unknown = [word for word in self.given or () if word.startswith("--") and word.split("=")[0][2:] not in options]
        if "required" in message and unknown:  # what is required may be misspelt
            message = f"unrecognized arguments: {' '.join(unknown)}"
        if chosen := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message):
            message += did_you_mean(chosen[1], re.findall(r"[\w-]+", chosen[2]))
        typed = [word.split("=")[0] for word in message.split() if word.startswith("--")]
        if message.startswith("unrecognized") and typed:
            message += meant(typed[0].lstrip("-"), options)
        super().error(message)


def option_names(parser: argparse.ArgumentParser) -> set[str]:
    """Return the long options of a parser and of its commands."""
    known: set[str] = set()
    for action in parser._actions:
        known |= {option.removeprefix("--") for option in action.option_strings if option.startswith("--")}
        if isinstance(action, argparse._SubParsersAction):
            known |= set().union(*(option_names(option) for option in action.choices.values()))
    return known


def meant(word: str, known: set[str]) -> str:
    """Return the question after the option that holds a word, or is spelt like it."""
    options = [f"--{name}" for name in sorted(known)]
    holding = [option for option in options if word and word in option[2:].split("-")]
    return f"; did you mean {' or '.join(holding)}?" if holding else did_you_mean(f"--{word}", options)
