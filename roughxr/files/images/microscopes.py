"""Images of JPK (TIFF), Nanonis (.sxm) and high-speed microscopes (.asd), which nothing else reads in all channels.

Facts from Gwyddion's descriptions of formats and the public readers libasd and AFMReader. JPK and high-speed movies
have their lowest line first, unless a JPK grid is reflected; Nanonis stores lines in the order of time.
"""

from __future__ import annotations

import re
import struct
import warnings
from collections.abc import Iterator
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .channel import Channel, UnreadableScan, first_bytes, refuse_other_size

#: First bytes of TIFF and Nanonis files.
TIFF, SXM = (b"II*\0", b"MM\0*"), b":NANONIS_VERSION:"

#: Tags of a JPK page: names, direction, default slot; sizes and reflection of the grid may stand on page 0 alone.
_NAME, _RETRACE, _TITLE, _SLOT, _WIDTH, _HEIGHT, _REFLECTED = 0x8050, 0x8051, 0x8052, 0x8081, 0x8042, 0x8043, 0x8045

#: Tag of Park's magic number.
_PARK = 0xC502

#: Tag of the first JPK slot's name, distance between slots, and where others of a slot follow its name.
_FIRST, _STRIDE, _UNITS, _SCALING, _FACTOR, _OFFSET = 0x8090, 0x30, 0x12, 0x13, 0x14, 0x15

#: First letter by which a Nanonis header states that a channel was recorded in one direction only.
_DIRECTIONS = {"trace": "f", "retrace": "b"}

#: Headers of high-speed movies of version 0, and of 1 and 2, up to the last value that is used.
_VERSION_0 = struct.Struct("<4x2s2s2i12x4h4x2fIi39xi")
_VERSION_1 = struct.Struct("<4x2i12x2s2x2s2x4xi8x4i69xIi16x2f")

#: TIFF's tag of the kind of its numbers, and the kind of one floating-point number for each pixel.
_SAMPLE_FORMAT = 339
_FLOAT = 3

#: Names of what a movie holds, and lowest and highest voltage of its converter by a code.
_KINDS = {b"TP": "Topography", b"ER": "Error", b"PH": "Phase"}
_VOLTS = {1: (0, 1), 2: (0, 2.5), 4: (0, 5), 1 << 16: (-1, 1), 1 << 17: (-2.5, 2.5), 1 << 18: (-5, 5)}


def is_jpk(path: Path) -> bool:
    """Return whether one of the first pages of a TIFF file has the name of a JPK channel."""
    return _has_tag(path, _NAME)


def is_park(path: Path) -> bool:
    """Return whether a TIFF file has the magic number of Park Systems."""
    return _has_tag(path, _PARK)


def is_float_matrix(path: Path) -> bool:
    """Return whether a TIFF file has one page, of one floating-point number for each pixel."""
    try:
        (page,) = _pages(path, 2)
        return np.ravel(page[_SAMPLE_FORMAT]).tolist() == [_FLOAT]
    except Exception:  # several pages, integers, or any TIFF that Pillow cannot read
        return False


def float_channels(path: Path) -> list[Channel]:
    """Return the one image of a TIFF file without a microscope's tags; its size and units must be given."""
    (page,) = _pages(path)
    return [Channel(path.stem, None, (page[257], page[256]), None, None, partial(_float_rows, path))]


def _float_rows(path: Path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as image:
        return np.asarray(image, dtype=float)


def _has_tag(path: Path, tag: int) -> bool:
    """Return whether one of the first pages of a TIFF file has a tag."""
    try:
        return any(tag in page for page in _pages(path, 2))
    except Exception:  # any other TIFF that Pillow cannot read
        return False


def _pages(path: Path, most_pages: int | None = None) -> list[dict[int, Any]]:
    """Return the tags of a TIFF file's pages."""
    from PIL import Image, ImageSequence

    with warnings.catch_warnings(action="ignore"), Image.open(path) as image:
        return [dict(page.tag_v2) for page in islice(ImageSequence.Iterator(image), most_pages)]  # type: ignore[attr-defined]


def jpk_channels(path: Path) -> list[Channel]:
    """Return the images of a JPK file; values are physical by the scaling of a page's default slot."""
    pages = _pages(path)
    end = max(int(np.max(np.add(page[273], page[279]))) for page in pages)
    refuse_other_size(path, end, may_be_longer=True)
    return [_jpk_channel(path, k, {**pages[0], **page}) for k, page in enumerate(pages) if _NAME in page]


def _jpk_channel(path: Path, number: int, tags: dict[int, Any]) -> Channel:
    slots = {tags[tag]: tag for tag in range(_FIRST, 0xFFFF, _STRIDE) if tag in tags}
    slot = slots.get(tags.get(_SLOT), 0)
    linear = tags.get(slot + _SCALING) == "LinearScaling"
    scale = (float(tags[slot + _FACTOR]), float(tags[slot + _OFFSET])) if linear else (1.0, 0.0)
    size = (tags[_WIDTH], tags[_HEIGHT]) if {_WIDTH, _HEIGHT} <= set(tags) else None
    read = partial(_jpk_rows, path, number, *scale, 1 if tags.get(_REFLECTED) else -1)
    direction = "retrace" if tags.get(_RETRACE) else "trace"
    header = {hex(tag): value for tag, value in tags.items() if tag >= 0x8000}
    name = str(tags.get(_TITLE) or tags[_NAME])
    units = tags.get(slot + _UNITS) or None
    return Channel(name, units, (tags[257], tags[256]), size, "m", read, direction, header)


def _jpk_rows(path: Path, number: int, factor: float, offset: float, step: int) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as image:
        image.seek(number)
        return np.asarray(image, dtype=float)[::step] * factor + offset


def sxm_channels(path: Path) -> list[Channel]:
    """Return the images of a Nanonis file; lines that were not scanned are missing."""
    text, _, data = path.read_bytes().partition(b"\x1a\x04")
    tags = re.split(r"^:([^\r\n]+):\s*$", text.decode("latin-1"), flags=re.MULTILINE)[1:]
    header = {name: value.strip() for name, value in zip(tags[::2], tags[1::2])}
    columns, rows = map(int, header["SCAN_PIXELS"].split()[:2])
    width, height = map(float, header["SCAN_RANGE"].split()[:2])
    images = list(_sxm_images(header["DATA_INFO"]))
    refuse_other_size(path, 4 * columns * rows * len(images), len(data))
    values = np.frombuffer(data, ">f4").reshape(len(images), rows, columns)
    vertical = -1 if header.get("SCAN_DIR") == "up" else 1
    channels = []
    for (name, units, direction), image in zip(images, values):
        turned = image[::vertical, :: -1 if direction == "retrace" else 1]
        read = partial(turned.astype, float)
        channels.append(Channel(name, units, (rows, columns), (width, height), "m", read, direction, header))
    return channels


def _sxm_images(table: str) -> Iterator[tuple[str, str, str]]:
    """Yield name, units and direction of the images in the order of their data, from a table of channels."""
    for line in table.splitlines()[1:]:
        _, name, units, recorded = line.strip().split("\t" if "\t" in line.strip() else None)[:4]
        for direction, letter in _DIRECTIONS.items():
            if recorded == "both" or recorded.startswith(letter):
                yield name, units, direction


def is_asd(head: bytes) -> bool:
    """Return whether bytes begin a high-speed movie: a version, and a kind of image where that version has it."""
    version = head[:4]
    place = 4 if head[:4] == bytes(4) else 24
    return version in (bytes(4), b"\1\0\0\0", b"\2\0\0\0") and head[place : place + 2] in _KINDS


class _Movie(NamedTuple):
    """What the header of a high-speed movie states."""

    kinds: list[bytes]
    start: int  # of the first frame, bytes; in some files less than the header
    before: int  # bytes before the heights of a frame
    columns: int
    rows: int
    size: tuple[float, float]  # nm
    per_volt: float  # nm
    code: int  # of the converter's range
    bits: int
    frame_count: int

    @property
    def frame_size(self) -> int:
        """The bytes of a frame."""
        return self.before + 2 * self.columns * self.rows


def _asd_movie(head: bytes) -> _Movie:
    """Return what a header of version 0, or of 1 and 2, states."""
    if head[:4] == bytes(4):
        *kinds, start, before, columns, rows, width, height, extension, amplification, code, bits, count = (
            _VERSION_0.unpack_from(head)
        )
    else:
        start, before, *kinds, count, columns, rows, width, height, code, bits, extension, amplification = (
            _VERSION_1.unpack_from(head)
        )
    size = (width, height)
    return _Movie(kinds, start, before, columns, rows, size, extension * amplification, code, bits, count)


def asd_channels(path: Path) -> list[Channel]:
    """Return the frames of a high-speed movie in the order of time, all of one kind before those of the other."""
    movie = _asd_movie(first_bytes(path, 512))
    shape = (movie.rows, movie.columns)
    names = [_KINDS[kind] for kind in movie.kinds if kind in _KINDS]
    if min(*shape, movie.frame_count) < 1 or movie.before < 0:
        raise UnreadableScan(
            path, "frames with pixels", f"{movie.frame_count} of {shape[1]} x {shape[0]} pixels: damaged"
        )
    frames = movie.frame_size * movie.frame_count * len(names)
    start = movie.start if movie.start >= _VERSION_0.size else path.stat().st_size - frames
    refuse_other_size(path, max(start, _VERSION_0.size) + frames)
    if movie.code not in _VOLTS or not 0 < movie.bits <= 32:
        raise UnreadableScan(path, "a known range of voltages", f"code {movie.code:#x} of {movie.bits} bits")
    low, high = _VOLTS[movie.code]
    header = {"nm per V": movie.per_volt, "volts": [low, high], "bits": movie.bits}
    images: list[Channel] = []
    for name, number in product(names, range(1, movie.frame_count + 1)):
        units, scale = ("nm", -movie.per_volt) if name == "Topography" else ("V", 1.0)
        offset = start + len(images) * movie.frame_size + movie.before
        read = partial(_asd_rows, path, offset, shape, (high - low) / 2**movie.bits * scale, low * scale)
        title = f"{name} {number}" if movie.frame_count > 1 else name
        images.append(Channel(title, units, shape, movie.size, "nm", read, "", {"frame": number, **header}))
    return images


def _asd_rows(path: Path, at: int, shape: tuple[int, int], factor: float, offset: float) -> np.ndarray:
    return np.fromfile(path, "<i2", shape[0] * shape[1], offset=at).reshape(shape)[::-1] * factor + offset
