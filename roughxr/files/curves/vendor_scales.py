"""The scale of images other than heights in vendors' files: SurfaceTopography scales heights only.

NanoScope images: value = count × hard scale / 2^(8 × bytes) × sensitivity, with the hard scale in V, or in arbitrary
units ("Arb") by instruments that map forces.
"""

from __future__ import annotations

from pathlib import Path

from ...mechanics.vocabulary.units import converts
from ..images.channel import Channel, UnreadableScan, first_bytes
from ..images.nanoscope_header import LARGEST_HEADER, SCALED, SENSITIVITY, header_blocks

#: Size of the units of a hard scale, in V; of arbitrary units in themselves.
_HARD_UNITS = {"V": 1.0, "mV": 1e-3, "Arb": 1.0}


def with_vendor_scale(path: Path, channels: list[Channel], chosen: Channel, family: str) -> Channel:
    """Return an image with values in its stated units; raise if the scale is unknown."""
    stored = family != "vendor" or converts(chosen.units, "nm") or chosen.header.get("format") == "ibw"
    if stored:  # in the units, or scaled by the reader
        return chosen
    if chosen.header.get("format") != "di":
        fault = f"{chosen.name!r} in a format of which only heights are read in true units"
        advice = "save it as .gwy, .gsf or text with the vendor's program or Gwyddion, and open that file"
        raise UnreadableScan(path, "an image with a known scale", fault, advice)
    units, scale = nanoscope_scale(path, channels.index(chosen), chosen.name)
    return chosen._replace(units=units, read=lambda: chosen.read() * scale)


def nanoscope_scale(path: Path, index: int, name: str) -> tuple[str, float]:
    """Return the units of a Nanoscope image, and the value of one count in them."""
    blocks = header_blocks(first_bytes(path, LARGEST_HEADER))
    images = [block.values for block in blocks if block.title.lower() in ("ciao image list", "afm image list")]
    image = images[index] if index < len(images) else {}
    scale = SCALED.match(image.get("z scale", ""))
    if f"S [{name}]" not in image.get("image data", "") or scale is None or scale["units"] not in _HARD_UNITS:
        raise UnreadableScan(path, f"the scale of image {name!r} in V", "none that can be read")
    count = float(scale["value"]) * _HARD_UNITS[scale["units"]] / 256 ** int(image.get("bytes/pixel", 2))
    header = {key: value for block in blocks for key, value in block.values.items()}
    sensitivity = SENSITIVITY.match(header.get(str(scale["quantity"]).lower(), ""))
    units, _, per = sensitivity["units"].partition("/") if sensitivity else ("", "", "")
    is_arbitrary = scale["units"] == "Arb"
    if sensitivity and units and per and is_arbitrary == (per == "Arb"):
        return units.replace("~", "µ"), count * float(sensitivity["value"]) / _HARD_UNITS.get(per, 1.0)
    if is_arbitrary:
        fault = f"arbitrary units without their scale {scale['quantity']!r}"
        advice = "calibrate deflection and spring constant in the vendor's program, and save the image in nN"
        raise UnreadableScan(path, f"a calibrated image {name!r}", fault, advice)
    return "V", count
