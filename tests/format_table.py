"""Write the site's table of formats: what ``roughxr info`` prints of a sample; python -m tests.format_table"""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path

from roughxr.application import cli
from roughxr.files.images import formats

from .afm_files import WRITERS, given, image_size, picture

PAGE = Path(__file__).parents[1] / "notebooks" / "site" / "how-to.md"

#: The lines around the table.
START = "<!-- formats: made by python -m tests.format_table -->\n"
END = "<!-- end of formats -->\n"


def printed(name: str, folder: Path) -> str:
    """Return what ``roughxr info`` prints of a sample."""
    rows = picture()
    arguments = ["info", str(WRITERS[name](folder, rows, image_size(rows)))]
    stated = given(name, image_size(rows))
    arguments += ["--size", *map(str, stated["size"]), "--height-units", "nm"] if stated else []
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        assert cli.main(arguments) == 0, name
    return out.getvalue()


def row(name: str, folder: Path) -> tuple[str, str]:
    """Return the format of a sample, and what is printed of its images."""
    text = printed(name, folder)
    code = next(line.partition(": ")[2] for line in text.splitlines() if line.startswith("source_format"))
    images = text.partition("about the mean plane:\n")[2].partition("\n\n")[0].splitlines()[2:]
    heights = [image for image in images if "NaN" not in image]
    columns, rows, x, y, _missing, low, high, _s_q = (heights or images)[0].split()[-8:]
    size_text = f"{x} × {y} nm, heights {low} … {high} nm" if heights else "size and units given as options"
    return code, f"{columns} × {rows} pixels, {size_text}" + f", {len(images)} images" * (len(images) > 1)


def table() -> str:
    """Return the table in Markdown, a row for each format."""
    notes: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in WRITERS:
            code, note = row(name, Path(folder))
            notes.setdefault(code, note)
    lines = ["| scans | endings | `roughxr info` of a sample | needs |", "|---|---|---|---|"]
    for code, format_read in formats.READ.items():
        needs = f"extra `{format_read.extra}`" if format_read.extra else "–"
        lines.append(f"| {format_read.name} | {', '.join(format_read.endings.split())} | {notes[code]} | {needs} |")
    note = f"{formats.BESIDES} | without a sample in the tests"
    lines.append(f"| others that SurfaceTopography reads | {note} | extra `afm` |")
    return "\n".join(lines) + "\n"


def page_with(rows_text: str) -> str:
    """Return the page with another table."""
    before, _, after = PAGE.read_text(encoding="utf-8").partition(START)
    return before + START + rows_text + END + after.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page_with(table()), encoding="utf-8")
