"""Read force-distance curves through afmformats in `images.reader_process`; imports nothing of roughxr.

The content of a file decides its format, not its name. Two formats are read here: JPK's archives, of which afmformats
searches all names for each curve; and Asylum's waves, of which it requires notes that no curve needs.
"""

from __future__ import annotations

import os
import re
import tempfile
import zipfile
import zlib
from collections import defaultdict
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

#: afmformats' readers by the kind of file that the caller found.
_MODULES = {
    "hdf5": "fmt_hdf5",
    "afmformats": "fmt_tab",
    "workshop": "fmt_workshop.ws_single",
    "chiaro": "fmt_chiaro_txt",
    "nt-mdt": "fmt_ntmdt_txt",
}

#: Columns of the travel, the sensor's first. In Chiaro's files "height (measured)" is an indentation.
_TRAVELS = {"chiaro": ("height (piezo)",)}
_TRAVEL = ("height (measured)", "height (piezo)")

#: Values of each curve's header that are returned.
_HEADER_VALUES = ("spring constant", "sensitivity", "position x", "position y")

#: JPK's conversions of the deflection, V → m → N: the value of each, its name, the one before, and its unit.
_JPK_SLOTS = {"spring constant": ("force", "distance", "N"), "sensitivity": ("distance", "volts", "m")}
#: Beginnings of the properties that are used: of a curve (also in quantitative imaging), and of a segment.
_JPK_POSITION = tuple(
    f"{kind}-{of}.header.position." for kind in ("force-scan", "quantitative-imaging") for of in ("series", "map")
)
_JPK_SEGMENT = ("channel.", "force-segment-header.settings.", "force-segment-header.force-segment-header-info.")
_JPK_DEFLECTION = "channel.vDeflection.conversion-set.conversion."

#: Names of an Asylum wave's columns.
_ASYLUM = {"height (measured)": ("ZSnsr", "ZSensor", "LVDT"), "height (piezo)": ("Raw", "Height")}

#: Ends of the names of two Asylum waves that are one curve; values of its note: the calibration, and the place.
_ASYLUM_PAIR = ("Defl", "ZSnsr")
_ASYLUM_VALUES = {"spring constant": "SpringConstant", "sensitivity": "InvOLS"}
_ASYLUM_VALUES |= {f"position {axis.lower()}": f"{axis}LVDT" for axis in "XY"}


class Unusable(ValueError):
    """A file that cannot be read: expected, found, advice."""


def read(
    path: str, kind: str, known: dict[str, float], texts: dict[str, bytes], first: int = 0, last: int | None = None
) -> dict[str, Any]:
    """Return the headers of a file of curves, or its curves from ``first`` to before ``last``.

    ``texts`` are the words that distinguish the texts in an archive, by their kind.
    """
    from afmformats import errors

    stat, given = os.stat(path), (tuple(known.items()), tuple(texts.items()))
    try:
        name, curves = _opened(path, kind, *given, stat.st_mtime_ns, stat.st_size)
        return answer(name, curves, kind, first, last)
    except errors.MissingMetaDataError as error:
        return {"missing": list(error.meta_keys)}
    except errors.AFMFileFormatError as error:  # not a subclass of Exception
        raise ValueError(str(error)) from None
    except (zipfile.BadZipFile, zlib.error) as error:
        return {
            "refused": ("an intact archive", f"a damaged one: {error}", "copy the whole file again from its source")
        }
    except Unusable as unusable:
        return {"refused": unusable.args}


def answer(name: str, curves: list[dict[str, Any]], kind: str, first: int, last: int | None) -> dict[str, Any]:
    """Return the name of a format with the headers of its curves, or the samples of some curves."""
    if last is None:
        return {"format": name, "curves": [_stated_values(curve["metadata"]) for curve in curves]}
    return {"samples": [_samples(curve, curve.get("kind", kind)) for curve in curves[first:last]]}


@lru_cache(maxsize=1)
def _opened(path: str, kind: str, known: tuple, texts: tuple, *_state: int) -> tuple[str, list[dict[str, Any]]]:
    """Return the name of a file's format and its curves, with samples not read yet if the format allows."""
    if kind == "igor":
        return "Asylum Research (binarywave)", [_asylum(path, dict(known))]
    if kind != "zip":
        return _read_with_afmformats(Path(path), kind, dict(known))
    archive = zipfile.ZipFile(path)
    if "header.properties" in archive.namelist():
        return "JPK Instruments (binary data)", _Jpk(archive, dict(known)).curves()
    return _read_texts(archive, dict(known), dict(texts))


def _read_with_afmformats(path: Path, kind: str, known: dict[str, float]) -> tuple[str, list[dict[str, Any]]]:
    from afmformats.formats import formats_available

    module = f"afmformats.formats.{_MODULES[kind]}"
    recipe = next(recipe for recipe in formats_available if recipe.loader.__module__ == module)
    if recipe.recipe.get("detect", lambda _: True)(path):
        return f"{recipe.maker} ({recipe.descr})", recipe.loader(path, meta_override=known)
    raise Unusable("force-distance curves", "none that afmformats can read")


def _read_texts(archive: zipfile.ZipFile, known: dict[str, float], texts: dict[str, bytes]) -> tuple[str, list]:
    """Return the curves of all texts in an archive, in the order of their names."""
    name, curves = "", []
    with tempfile.TemporaryDirectory() as folder:
        for member in sorted(archive.namelist(), key=_natural):
            with archive.open(member) as packed:
                head = packed.read(4096)
                kind = next((kind for kind, words in texts.items() if words in head), None)
                if kind is not None:
                    file = Path(folder) / "text"
                    # largest size of a text in an archive, bytes
                    file.write_bytes(head + packed.read(2**28))
                    name, own = _read_with_afmformats(file, kind, known)
                    curves += [{**curve, "kind": kind} for curve in own]
    if not curves:
        raise Unusable("force-distance curves", "an archive with none that afmformats reads", "unpack tables")
    return f"{name} in an archive", curves


def _natural(name: str) -> list[tuple[int, str]]:
    """Return a key that sorts the numbers in names by their values."""
    return [(int(part) if part.isdigit() else -1, part) for part in re.split(r"(\d+)", name)]


class _Jpk:
    """A JPK archive, whose names are searched once."""

    def __init__(self, archive: zipfile.ZipFile, known: dict[str, float]):
        self.archive, self.known = archive, known
        self.segments: dict[str, dict[int, list[str]]] = defaultdict(lambda: defaultdict(list))  # of each curve
        for name in archive.namelist():
            if match := re.match(r"((?:index/\d+/)?)segments/(\d+)/.", name):
                self.segments[match[1]][int(match[2])].append(name)
        self.common, self.shared = self.properties("header.properties"), defaultdict[str, dict[str, Any]](dict)
        shared = "shared-data/header.properties"
        for key, value in (self.properties(shared) if shared in archive.namelist() else {}).items():
            kind, number, rest = [*key.split(".", 2), "", ""][:3]
            self.shared[f"{kind}.{number}"][rest] = value
        self.shared_of: dict[tuple[str, Any], dict[str, Any]] = {}

    def properties(self, name: str, begins: str | tuple[str, ...] = "") -> dict[str, Any]:
        """Return the properties in a member whose names begin with a text, numbers as such."""
        text = self.archive.read(name).decode("latin-1")
        lines = (line.partition("=") for line in text.splitlines() if line.startswith(begins))
        return {key.strip(): _number(value.strip()) for key, equals, value in lines if equals}

    def shared_properties(self, key: str, number: Any) -> dict[str, Any]:
        """Return the properties that a segment shares with others, by their name ("channel.height.lcd-info.*")."""
        if (key, number) not in self.shared_of:
            parent, kind, _ = key.rsplit(".", 2)
            shared = self.shared[f"{kind}.{number:g}"]
            self.shared_of[key, number] = {f"{parent}.{rest}": value for rest, value in shared.items()}
        return self.shared_of[key, number]

    def stated(self, folder: str, number: int) -> dict[str, Any]:
        """Return the properties of a segment of a curve."""
        own = self.properties(f"{folder}segments/{number}/segment-header.properties", _JPK_SEGMENT)
        stated = dict(own)
        for key, value in own.items():
            if key.endswith(".*"):
                stated |= self.shared_properties(key, value)
        stated |= self.common
        for name, value in self.known.items():
            slot, base, unit = _JPK_SLOTS[name]
            scaling = {"multiplier": value, "offset": 0.0, "unit": unit}
            stated |= {f"{_JPK_DEFLECTION}{slot}.scaling.{part}": own for part, own in scaling.items()}
            stated[f"{_JPK_DEFLECTION}{slot}.base-calibration-slot"] = base
        return stated

    def curves(self) -> list[dict[str, Any]]:
        """Return all curves, of which only the headers are read yet."""
        from afmformats import errors

        curves = []
        for folder in sorted(self.segments, key=_natural):
            stated = self.stated(folder, min(self.segments[folder]))
            places = self.properties(f"{folder}header.properties", _JPK_POSITION) if folder else stated
            header = {f"position {key[-1]}": place for key, place in places.items() if key.startswith(_JPK_POSITION)}
            values = {name: f"{_JPK_DEFLECTION}{slot}.scaling.multiplier" for name, (slot, *_) in _JPK_SLOTS.items()}
            if missing := [name for name, key in values.items() if key not in stated]:
                raise errors.MissingMetaDataError(missing)
            header |= {name: stated[key] for name, key in values.items()}
            curves.append({"metadata": header, "data": partial(self.columns, folder)})
        return curves

    def columns(self, folder: str) -> dict[str, np.ndarray]:
        """Return force and travel of a curve that all its segments have, these in a row."""
        from afmformats.formats.fmt_jpk import jpk_data

        segments = sorted(self.segments[folder].items())
        members = [{Path(name).stem: name for name in names if name.endswith(".dat")} for _, names in segments]
        channels = {
            column: [next((name for name in names if name in stored), None) for stored in members]
            for column, names in jpk_data.JPK_COLUMNS.items()
        }
        whole = [column for column, names in channels.items() if None not in names]
        travel = [column for column in _TRAVEL if column in whole][:1]
        parts = defaultdict(list)
        for position, (number, _) in enumerate(segments):
            stated = self.stated(folder, number)
            for column in [*travel, *(column for column in whole if column not in _TRAVEL)]:
                name = str(channels[column][position])
                with self.archive.open(members[position][name]) as file:
                    values, unit, _ = jpk_data.load_dat_unit(file, name, stated, jpk_data.JPK_SLOTS[column])
                if unit != jpk_data.JPK_UNITS[column]:
                    raise Unusable(f"{column} in {jpk_data.JPK_UNITS[column]}", unit)
                parts[column].append(values)
            samples = parts["force"][-1].size if parts["force"] else 0
            parts["segment"].append(np.full(samples, number))
            parts["paused"].append(np.full(samples, _is_pause(stated)))
        return {column: np.concatenate(values) for column, values in parts.items()}


def _is_pause(stated: dict[str, Any]) -> bool:
    """Return whether the settings of a JPK segment name it a pause."""
    settings = "force-segment-header.settings."
    return "pause" in (stated.get(f"{settings}style"), stated.get(f"{settings}segment-settings.style"))


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _asylum(path: str, known: dict[str, float]) -> dict[str, Any]:
    """Return the curve in an Igor wave of Asylum's, or in two."""
    from afmformats import errors

    values, notes = _asylum_columns(path)
    header = {name: float(notes[key]) for name, key in _ASYLUM_VALUES.items() if notes.get(key, "").strip()} | known
    if "spring constant" not in header:
        raise errors.MissingMetaDataError(["spring constant"])
    data = {column: -values[name] for column, names in _ASYLUM.items() for name in names if name in values}
    bent = next((values[name] for name in ("Defl", "Deflection") if name in values), None)
    if bent is not None:
        data |= {"force": bent * header["spring constant"], **_asylum_segments(notes, bent.size)}
    return {"metadata": header, "data": data}


def _asylum_columns(path: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Return the columns of an Igor wave by their names, or those of two waves of one each; and the note."""
    from igor2 import binarywave

    wave = binarywave.load(path)["wave"]
    notes = dict(line.split(":", 1) for line in wave["note"].decode("latin-1").split("\r") if ":" in line)
    if wave["wData"].ndim > 1:
        labels = [label.decode("latin-1") for label in wave["labels"][1]][1:]
        return dict(zip(labels, wave["wData"].T.astype(float))), notes
    file = Path(path)
    own = next(name for name in _ASYLUM_PAIR if file.stem.endswith(name))
    values = {}
    for name in _ASYLUM_PAIR:
        member = file.with_stem(file.stem.removesuffix(own) + name)
        if not member.is_file():
            raise Unusable("waves of deflection and sensor in one folder", f"no {member.name}")
        values[name] = binarywave.load(member)["wave"]["wData"].astype(float)
    return values, notes


def _asylum_segments(notes: dict[str, str], size: int) -> dict[str, np.ndarray]:
    """Return the segment of each sample between the turning points of a note, and whether it is a pause."""
    turns = [int(number) for number in re.findall(r"\d+", notes.get("Indexes", ""))]
    directions = re.findall(r"[-\w]+", notes.get("Direction", ""))
    if len(turns) < 2 or len(directions) != len(turns):
        return {}
    segment = np.searchsorted(turns[1:-1], np.arange(size))  # a turning point is the last sample before it
    return {"segment": segment, "paused": np.array(directions[1:])[segment] == "0"}


def _stated_values(metadata: Any) -> dict[str, float]:
    """Return the values of a curve's header that are known."""
    return {name: float(metadata[name]) for name in _HEADER_VALUES if name in metadata and np.isfinite(metadata[name])}


def _samples(curve: dict[str, Any], kind: str) -> dict[str, np.ndarray]:
    """Return the piezo's travel towards the surface, the force, and the file's segments of a curve."""
    data = curve["data"]() if callable(curve["data"]) else curve["data"]
    names = list(data.keys())
    travel = next((name for name in _TRAVELS.get(kind, _TRAVEL) if name in names), None)
    if travel is None or "force" not in names:
        raise Unusable("a force and a height of the piezo", f"columns {', '.join(sorted(names))}")
    piezo, force = (np.asarray(values, dtype=float) for values in (-np.asarray(data[travel]), data["force"]))
    if piezo.shape != force.shape:
        raise Unusable("as many heights as forces", f"{piezo.size} and {force.size}")
    both = {"piezo": piezo, "force": force}
    return both | {name: np.asarray(data[name]) for name in ("segment", "paused") if name in names}
