"""The scale of images that are no lengths, in vendors' files: their reader hands over what is stored, in no unit.

SurfaceTopography scales lengths alone; a Nanoscope image of forces would come as counts that are called nN. Here its
scale is read from the header: value = count × hard scale / 2^(8 × bytes) × sensitivity, the hard scale in V, or in
arbitrary units ("Arb") by instruments that map forces.
"""

from __future__ import annotations

import re
from pathlib import Path

from ..scans.channel import Channel, UnreadableScan
from .forces import converts

_NUMBER = r"([-+0-9.eE]+)"
_IMAGE = re.compile(r"^\\\*(?:Ciao|AFM) image list", re.IGNORECASE)
_TITLE = re.compile(r"^\\@\d+:Image Data: S \[([^\]]*)\]")
_SCALE = re.compile(rf"^\\@[24]:Z scale: V (?:\[(?P<quantity>[^\]]*)\] )?\([^)]*\) {_NUMBER} ?(?P<units>\w*)")
_BYTES = re.compile(r"^\\Bytes/pixel: (\d)")
_SENSITIVITY = re.compile(rf"^\\@(?P<quantity>Sens\.[^:]*): V {_NUMBER} ?(?P<units>[^\s/]*)(?:/(?P<per>\S*))?\s*$")


def in_true_units(path: Path, channels: list[Channel], chosen: Channel, family: str) -> Channel:
    """Return an image whose values are in the units that it names, or say that its scale is not known.

    Raises
    ------
    UnreadableScan
        If the format's scale of such images is not known here, or its header does not state it.
    """
    stored = family != "vendor" or converts(chosen.units, "nm") or chosen.header.get("format") == "ibw"
    if stored:  # as numbers in their units, or scaled by the reader
        return chosen
    if chosen.header.get("format") != "di":
        raise UnreadableScan(
            path,
            f"expected an image whose scale is known, found {chosen.name!r} in {chosen.header.get('format')!r}, of "
            "which heights alone are read in true units; write the image as .gwy, .gsf or text with the vendor's "
            "program or Gwyddion, and open that",
        )
    units, scale = nanoscope_scale(path, channels.index(chosen), chosen.name)
    return chosen._replace(units=units, read=lambda: chosen.read() * scale)


def nanoscope_scale(path: Path, index: int, name: str) -> tuple[str, float]:
    """Return the units of a Nanoscope image and what one count of it is worth in them.

    Parameters
    ----------
    path : Path
    index : int
        Of the image in the file.
    name : str
        Of the image, as the header must have it at that place.

    Returns
    -------
    units : str
        V where the header states no sensitivity for it.
    scale : float
    """
    header = path.read_bytes().partition(b"\x1a")[0].decode("latin-1").splitlines()
    starts = [k for k, line in enumerate(header) if _IMAGE.match(line)]
    block = header[starts[index] : [*starts, len(header)][index + 1]] if index < len(starts) else []
    title, scale, size = (_first(pattern, block) for pattern in (_TITLE, _SCALE, _BYTES))
    if not (title and scale) or title[1] != name or scale["units"] not in ("V", "mV", "Arb"):
        raise UnreadableScan(path, f"expected the scale of image {name!r} in V, found none that can be read")
    one_count = float(scale[2]) * (1e-3 if scale["units"] == "mV" else 1.0) / 256 ** int(size[1] if size else 2)
    matches = (_SENSITIVITY.match(line) for line in header)
    found = next((one for one in matches if one and one["quantity"] == scale["quantity"]), None)
    arbitrary = scale["units"] == "Arb"
    if found is None or not found["units"] or found["per"] is None or arbitrary != (found["per"] == "Arb"):
        if arbitrary:
            raise UnreadableScan(
                path,
                f"expected a calibrated image {name!r}, found arbitrary units without {scale['quantity']!r} for them: "
                "calibrate deflection and spring constant in the vendor's program, and save it there in nN",
            )
        return "V", one_count
    return found["units"], one_count * float(found[2]) * (1e3 if found["per"] == "mV" else 1.0)


def _first(pattern: re.Pattern, lines: list[str]) -> re.Match | None:
    return next((found for found in map(pattern.match, lines) if found), None)
