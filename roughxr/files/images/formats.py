"""Names of formats: what an error says that it naming_format, and what ``roughxr info --formats`` lists.

The tests open a sample of each format in `READ`. SurfaceTopography reads more, of optical profilers.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from .channel import UnreadableScan, first_bytes


class Format(NamedTuple):
    """A format that is read: the program or instrument that writes it, its usual endings, the extra it needs."""

    name: str
    endings: str
    extra: str = ""


#: Formats by the word that a scan's attribute ``source_format`` states.
READ = {
    "netcdf": Format("NetCDF: roughxr, SurfaceTopography, CF", ".nc"),
    "gwy": Format("Gwyddion", ".gwy"),
    "gsf": Format("Gwyddion Simple Field", ".gsf", "afm"),
    "text": Format("text: a matrix, or points x, y, z of a grid", ".txt .csv .dat .asc .xyz"),
    "npy": Format("NumPy array", ".npy"),
    "tiff": Format("TIFF of floating-point numbers", ".tif"),
    "hdf5": Format("HDF5: any matrix; TopoStats, JPK, Nanosurf, NeXus", ".h5 .topostats .h5-jpk .nhf .nxs"),
    "di": Format("Bruker/Veeco/DI NanoScope", ".spm .000 .001", "afm"),
    "ibw": Format("Asylum, Igor wave", ".ibw", "afm"),
    "jpk": Format("JPK image", ".jpk .jpk-qi-image"),
    "ps": Format("Park Systems", ".tiff", "afm"),
    "sxm": Format("Nanonis", ".sxm"),
    "asd": Format("high-speed AFM, a frame", ".asd"),
    "ezd": Format("Nanosurf easyScan", ".nid .ezd", "afm"),
    "mi": Format("Agilent, Molecular Imaging", ".mi", "afm"),
    "sdf": Format("ISO 25178-71", ".sdf", "afm"),
    "mdt": Format("NT-MDT", ".mdt", "afm"),
    "wsxm": Format("WSxM", ".stp .top", "afm"),
    "bcr": Format("BCR-STM", ".bcr .bcrf", "afm"),
    "x3p": Format("X3P", ".x3p", "afm"),
    "sur": Format("Digital Surf", ".sur", "afm"),
}

#: Endings of further formats that SurfaceTopography reads; no sample of them is opened in the tests.
BESIDES = ".al3d, .opdx, .mnt, .frt, .vk4, .zon, .zmg, .qep, .lext, .oir, .poir, .os3d, .plu, .plux, .tmd, .opd, .datx"

#: First bytes of files that are not read, and their names; those of SurfaceTopography's formats are in `vendors`.
_NOT_READ = {
    b"S\0T\0i\0M\0a\0g\0e\0": "RHK (.sm4)",
    b"[Param": "Createc (.dat)",
    b"ONTMATRX": "Omicron MATRIX (.mtrx)",
    b"Grid dim=": "Nanonis grid spectroscopy (.3ds)",
    b"Experiment\t": "Nanonis spectroscopy (.dat)",
    b"MATLAB 5.0": "MATLAB (.mat)",
    b"\x0e\x03\x13\x01": "HDF4 (.hdf)",
    b"CPYA ": "Origin project (.opj)",
    b"PK\x03\x04": "zip archive",
    b"\x89PNG": "picture (.png), which has no heights",
    b"\xff\xd8\xff": "picture (.jpg), which has no heights",
    b"%PDF": "document (.pdf)",
    b"II*\0": "TIFF of no known microscope",
}


def name_of(code: str) -> str:
    """Return the name of a format that is read, with its usual ending, for an error."""
    row = READ.get(code)
    return f"{row.name.partition(':')[0]} ({row.endings.split()[0]})" if row else code


def refuse_not_read(path: Path) -> None:
    """Raise for a file of a known format that is not read, by its first bytes."""
    head = first_bytes(path, 64)
    names = ["Asylum force map (.ARDF)"] if head[8:12] == b"ARDF" else []
    names += [name for start, name in _NOT_READ.items() if head.startswith(start)]
    if names:
        advice = "save it as .gwy, .gsf or text in Gwyddion or in the program that wrote it"
        raise UnreadableScan(path, "an AFM image", f"a file that is not read, {names[0]}", advice)
