"""The scale of images other than heights in vendors' files: SurfaceTopography scales heights only.

NanoScope images: value = count × hard scale / 2^(8 × bytes) × sensitivity, with the hard scale in V, or in arbitrary
units ("Arb") by instruments that map forces.
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


def with_vendor_scale(path: Path, channels: list[Channel], chosen: Channel, family: str) -> Channel:
    """Return an image with values in its stated units; raise if the scale is unknown."""
    stored = family != "vendor" or converts(chosen.units, "nm") or chosen.header.get("format") == "ibw"
    if stored:  # in the units, or scaled by the reader
        return chosen
    if chosen.header.get("format") != "di":
        raise UnreadableScan(
            path,
            f"expected an image with a known scale, found {chosen.name!r} in {chosen.header.get('format')!r}, a "
            "format of which only heights are read in true units; save the image as .gwy, .gsf or text with the "
            "vendor's program or Gwyddion, and open that file",
        )
    units, scale = nanoscope_scale(path, channels.index(chosen), chosen.name)
    return chosen._replace(units=units, read=lambda: chosen.read() * scale)


def nanoscope_scale(path: Path, index: int, name: str) -> tuple[str, float]:
    """Return the units of a Nanoscope image, and the value of one count in them."""
    header = path.read_bytes().partition(b"\x1a")[0].decode("latin-1").splitlines()
    scale, one_count = _hard_scale(path, _block(header, index), name)
    sensitivity = next(
        (match for match in map(_SENSITIVITY.match, header) if match and match["quantity"] == scale["quantity"]), None
    )
    arbitrary = scale["units"] == "Arb"
    if (
        sensitivity
        and sensitivity["units"]
        and sensitivity["per"] is not None
        and arbitrary == (sensitivity["per"] == "Arb")
    ):
        return sensitivity["units"].replace("~", "µ"), one_count * float(sensitivity[2]) * (
            1e3 if sensitivity["per"] == "mV" else 1.0
        )
    if arbitrary:
        raise UnreadableScan(
            path,
            f"expected a calibrated image {name!r}, found arbitrary units without their scale {scale['quantity']!r}: "
            "calibrate deflection and spring constant in the vendor's program, and save the image in nN",
        )
    return "V", one_count


def _block(header: list[str], index: int) -> list[str]:
    """Return a header's lines on the image of this number, none if there is no such image."""
    starts = [k for k, line in enumerate(header) if _IMAGE.match(line)]
    return header[starts[index] : [*starts, len(header)][index + 1]] if index < len(starts) else []


def _hard_scale(path: Path, block: list[str], name: str) -> tuple[re.Match, float]:
    """Return the hard scale of the image of this name, and one count in V or in arbitrary units."""
    title, scale, size = (_first(pattern, block) for pattern in (_TITLE, _SCALE, _BYTES))
    if not (title and scale) or title[1] != name or scale["units"] not in ("V", "mV", "Arb"):
        raise UnreadableScan(path, f"expected the scale of image {name!r} in V, found none that can be read")
    return scale, float(scale[2]) * (1e-3 if scale["units"] == "mV" else 1.0) / 256 ** int(size[1] if size else 2)


def _first(pattern: re.Pattern, lines: list[str]) -> re.Match | None:
    return next((match for match in map(pattern.match, lines) if match), None)
