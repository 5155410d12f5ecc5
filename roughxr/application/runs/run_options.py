"""The options of a run that are read without its scan."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...mechanics.vocabulary.adhesion_laws import read_law
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import Quantities, single, whole_number


def check_output(output: Path) -> None:
    """Raise where a run cannot be written since another file has the name of its output."""
    if output.is_file() and output.suffix != ".nc":
        raise Refusal("output", "a folder or a file ending in .nc", f"another file, {output}")


def read_adhesion(preload: Quantities, law: str, budget: int) -> dict[str, Any]:
    """Return the options of the simulation with adhesion; raise where one is wrong by itself."""
    expected = "one force of at least 0 nN"
    return {
        "preload": single(preload, "nN", "preload", expected, lambda force: force >= 0),
        "law": read_law(law, "adhesive"),
        "budget": whole_number(budget, "budget", least=0),
    }
