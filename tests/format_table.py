"""Write the site's table of formats: python -m tests.format_table.

It shows what ``roughxr info`` prints of a microscope's file where a public one was read (``REAL``), else of a sample
that the tests make. ``python -m tests.format_table FILE...`` prints the rows of ``REAL`` anew; the files are those of
SurfaceTopography (test/file_format_examples) and of SciFiDatasets (data/microscopy/spm).
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
from pathlib import Path

from roughxr.application import cli
from roughxr.files.images import formats

from .afm_files import WRITERS, given, image_size, picture

PAGE = Path(__file__).parents[1] / "notebooks" / "site" / "formats.md"

#: The lines around the table.
START = "<!-- formats: made by python -m tests.format_table -->\n"
END = "<!-- end of formats -->\n"

#: What is printed of public files of microscopes, by their format; all others are made by the tests.
REAL = {
    "di": "`di-6.di`: 512 × 512 pixels, 10000 × 10000 nm, heights 74.98 … 198.9 nm, 4 images",
    "ps": "`example_ps.tiff`: 512 × 512 pixels, 1000 × 1000 nm, heights −14.98 … 21.71 nm",
    "ibw": "`spot_1-1000nm.ibw`: 256 × 256 pixels, 20078 × 20078 nm, heights −704.6 … −331.2 nm, 8 images",
    "ezd": "`nid-1.nid`: 256 × 256 pixels, 20000 × 20000 nm, heights −1983 … −925.4 nm, 4 images",
    "mi": "`mi-1.mi`: 256 × 256 pixels, 20000 × 20000 nm, heights −630 … −464.3 nm, 4 images",
    "sur": "`sur-2.sur`: 563 × 484 pixels, 1961492 × 1686256 nm, heights 8912 … 10388 nm",
    "gsf": "`GwiddionReader_chip.gsf`: 300 × 300 pixels, 80000 × 80000 nm, heights 12515 … 19495 nm",
    "gwy": "`PTO_110_Virgin0001.gwy`: 256 × 256 pixels, 10039 × 10039 nm, heights −15.46 … 109.6 nm, 4 images",
    "text": "`matrix-3.txt`: 256 × 256 pixels, 10000 × 10000 nm, heights −168.6 … 240.2 nm",
    "wsxm": "`stp-1.stp`: 256 × 256 pixels, 600 × 600 nm, heights −0.8629 … 12.84 nm",
}


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


def row(text: str) -> tuple[str, str]:
    """Return the format of a file, and what ``roughxr info`` printed of its images."""
    code = next(line.partition(": ")[2] for line in text.splitlines() if line.startswith("source_format"))
    images = text.partition("about the mean plane:\n")[2].partition("\n\n")[0].splitlines()[2:]
    heights = [image for image in images if "NaN" not in image]
    columns, rows, x, y, _missing, low, high, _s_q = (heights or images)[0].split()[-8:]
    size_text = f"{x} × {y} nm, heights {low} … {high} nm" if heights else "size and units given as options"
    return code, f"{columns} × {rows} pixels, {size_text}" + f", {len(images)} images" * (len(images) > 1)


def rows_of(files: list[str]) -> dict[str, str]:
    """Return the rows of files of microscopes, by their format."""
    notes = {}
    for file in files:
        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
            assert cli.main(["info", file]) == 0, file
        code, note = row(out.getvalue())
        notes[code] = f"`{Path(file).name}`: {note}"
    return notes


def table() -> str:
    """Return the table in Markdown, a row for each format."""
    notes = dict(REAL)
    with tempfile.TemporaryDirectory() as folder:
        for name in WRITERS:
            code, note = row(printed(name, Path(folder)))
            notes.setdefault(code, f"made: {note}")
    lines = ["| scans | endings | `roughxr info` of a file | needs |", "|---|---|---|---|"]
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
    if len(sys.argv) > 1:
        print(rows_of(sys.argv[1:]))
    else:
        PAGE.write_text(page_with(table()), encoding="utf-8")
