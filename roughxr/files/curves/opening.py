"""`open_pull_off`: measured pull-off forces from tables, images of adhesion or force-distance curves."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from numbers import Real
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.jobs.progress import subregion_bar
from ...mechanics.statistics.sampling import AT_LEAST, AT_MOST, CONDITION, DETECTION, map_samples, sample_bounds
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal, WrongCall
from ...mechanics.vocabulary.text import Argument, Phrase, warn
from ...mechanics.vocabulary.units import Quantities, Quantity, converts, factor
from ..images import recognition as files
from ..images.channel import (
    Channel,
    UnreadableScan,
    channels_in_direction,
    channels_named,
    first_bytes,
    listing,
    naming_file,
    only_one,
)
from ..images.force_curve_formats import without_second_waves
from ..images.plain import decoded, gwyddion_header, text_without_numbers
from .curve_files import calibration, curve_kind, open_curve_file, read_curves
from .curves import read_curve_table
from .force_curves import curves_pull_off
from .force_tables import (
    Column,
    force_column,
    is_spreadsheet,
    lengths,
    place_columns,
    read_table,
    refuse_distribution,
    swept_column,
)
from .forces import Calibration, forces, magnitudes
from .vendor_scales import with_vendor_scale

#: Number of curves in memory at a time.
_CURVES_IN_MEMORY = 64


def open_pull_off(
    path: str | os.PathLike | Sequence[str | os.PathLike],
    *,
    channel: str | int | None = None,
    scan_direction: str | None = None,
    size: Quantities | None = None,
    units: str | None = None,
    place_units: str | None = None,
    sensitivity: Quantity | None = None,
    spring_constant: Quantity | None = None,
    pulls: str | None = None,
    baseline: float | tuple[float, float] | None = None,
) -> xr.Dataset:
    """Open measured pull-off forces: a table, an adhesion image of an AFM file, or force-distance curves.

    Parameters
    ----------
    path : str, path or sequence of them
        A table (CSV and similar, .xlsx) with names above its columns, such as ``x [um], y [um], force [nN]``, or of one
        force curve, with a column ``piezo``; any AFM
        file that `open_scan` reads with an image of adhesion; or a file of curves, see `open_curves`. The content
        decides, not the extension. Several files are read with the same options and concatenated.
    channel : str or int, optional
        Name of the column, or name or number of the image; needed if there is more than one candidate.
    scan_direction : {"trace", "retrace"}, optional
        For an image; by default the forward image if there are both.
    size : length or pair of lengths, optional
        For an image whose file does not state it; with it, a text file of bare numbers is read as an image.
    units : str, optional
        Units of the measured values, only if the file does not state them: those of a force, of a deflection, or V.
    place_units : str, optional
        Units of the columns x and y, if the file does not state them.
    sensitivity : quantity, optional
        For values in V: force per volt, "12 nN/V", or deflection per volt, "50 nm/V"; for curves the latter.
    spring_constant : number or quantity, optional
        For deflections, and with a sensitivity in nm/V: N/m.
    pulls : {"positive", "negative"}, optional
        The sign of adhesion in the file; needed if there are values of both signs.
    baseline : float or pair of floats, optional
        For curves, as in `curves_pull_off`: the share of the travel that may contain the baseline, or its two ends.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) along ``subregion``, NaN where nothing was measured, or only a
        limit, ``pull_off_at_most``; coordinates ``subregion_x``, ``subregion_y`` (nm) if places are known, for an image
        as in a scan of that file, and ``file`` if there are several; ``condition``, the values of a load, humidity,
        diameter or the like that a table sweeps: pull-offs of one condition are comparable. For curves also the other
        variables of `curves_pull_off`. Attributes: ``measured`` ("table", "adhesion image" or "force-distance curves"),
        file name, SHA-256, channel, and the conversion to forces.

    Raises
    ------
    UnreadableScan
        If a file contains no pull-off forces, or if the image or column, units or calibration are ambiguous or missing.
        See `open_scan` for other reasons.

    Examples
    --------
    >>> from pathlib import Path
    >>> import roughxr
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "curves.csv"
    >>> _ = path.write_text("x [um],y [um],adhesion [nN]\\n0,0,12.5\\n1,0,\\n0,1,9.5\\n")
    >>> pull = roughxr.measured.open_pull_off(path)
    >>> pull.pull_off_force.values, pull.subregion_x.values
    (array([12.5,  nan,  9.5]), array([   0., 1000.,    0.]))
    """
    calibration = Calibration(units, sensitivity, spring_constant, pulls)
    image = _Selection(channel, scan_direction, size)
    given = [path] if isinstance(path, (str, os.PathLike)) else path
    _refuse_values(given)
    paths = without_second_waves([files.regular_file(file) for file in given])
    resolved = [file.resolve() for file in paths]
    if doubled := [file for k, file in enumerate(paths) if resolved[k] in resolved[:k]]:
        raise Refusal("path", "each file once", f"{doubled[0]} twice", "leave it out")
    datasets = []
    for file in paths:
        with naming_file(file):
            datasets.append(_read_file(file, image, place_units, calibration, baseline))
    ds = _concatenated(paths, datasets)
    options = {**image._asdict(), **calibration._asdict(), "place_units": place_units, "baseline": baseline}
    return schema.record(schema.label(ds), "open_pull_off", file=ds.attrs["source_file"], **options)


def _refuse_values(given: Any) -> None:
    """Raise for forces in place of the files that contain them."""
    is_table = not isinstance(given, (list, tuple, set, map, filter)) and hasattr(given, "__array__")
    if is_table or any(isinstance(value, Real) for value in given):
        made = "xr.Dataset({'pull_off_force': ('subregion', forces, {'units': 'nN'})})"
        raise WrongCall("path", "a file, or several", f"values in a {type(given).__name__}", f"for forces make {made}")


def _concatenated(paths: Sequence[Path], datasets: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the pull-offs of several files along one ``subregion``."""
    if len(datasets) == 1:
        return datasets[0]
    kinds = sorted({ds.attrs["measured"] for ds in datasets})
    if len(kinds) != 1:
        raise Refusal("path", "files of one kind", ", ".join(kinds) or "no file")
    common = set.intersection(*(set(map(str, ds.variables)) for ds in datasets))
    named = [
        ds.drop_vars(set(ds.variables) - common).assign_coords(file=("subregion", [path.name] * ds.sizes["subregion"]))
        for path, ds in zip(paths, datasets)
    ]
    parts = [ds.drop_vars("subregion", errors="ignore") for ds in named]
    how: dict[str, Any] = {"data_vars": "minimal", "coords": "minimal", "compat": "override", "join": "outer"}
    out = xr.concat(parts, "subregion", combine_attrs="drop_conflicts", **how)
    out = out.assign_coords(subregion=range(out.sizes["subregion"]))
    hashes = "".join(ds.attrs["source_sha256"] for ds in datasets)
    out.attrs["source_file"] = f"{paths[0].name} and {len(paths) - 1} more"
    out.attrs["source_sha256"] = hashlib.sha256(hashes.encode()).hexdigest()
    return out


class _Selection(NamedTuple):
    """Which image or column of a file to read."""

    channel: str | int | None
    scan_direction: str | None
    size: Any


def _read_file(
    path: Path, image: _Selection, place_units: str | None, calibration: Calibration, baseline: Any
) -> xr.Dataset:
    """Return the pull-off forces of one file."""
    if is_spreadsheet(path):
        return _with_source(path, _read_force_table(path, image, place_units, calibration, baseline))
    family, read = files.reader_of(path)
    if family == "vendor" and (line := text_without_numbers(path)):
        expected = "a table of forces with names above its columns, an adhesion image, or force curves"
        raise UnreadableScan(path, expected, f"a text without numbers, {line!r}")
    kind = None if image.size is not None else files.call_naming_file(path, curve_kind, path, family, calibration)
    if family == "netcdf" and kind is None:
        raise UnreadableScan(path, "a table or an AFM file", "NetCDF", "write its pull-off forces as a table, .csv")
    if kind is not None:
        schema.refuse_unused("force-distance curves", **{**image._asdict(), "place_units": place_units})
        ds = _read_curve_file(path, kind, calibration, baseline)
    elif family == "text" and image.size is None and not _is_matrix(path):
        ds = _read_force_table(path, image, place_units, calibration, baseline)
    else:
        schema.refuse_unused("an adhesion image", place_units=place_units, baseline=baseline)
        code, channels = files.images(path, family, read)
        with files.naming_format(path, code):
            fitting = _adhesion(channels, image.channel, image.scan_direction, path)
            chosen = with_vendor_scale(path, channels, fitting, family)
            ds = _read_image(path, chosen, image.size, calibration).assign_attrs(channels=listing(channels))
    return _with_source(path, ds)


def _with_source(path: Path, ds: xr.Dataset) -> xr.Dataset:
    """Add the file's name and checksum; raise if every value is missing, and no limit is known."""
    if np.isnan(sample_bounds(ds, "pull_off_force")).all():
        reasons = np.unique(ds["reason"].values, return_counts=True) if "reason" in ds else ((), ())
        counts = ", ".join(f"{reason} ({count})" for reason, count in zip(*reasons))
        raise UnreadableScan(path, "pull-off forces", "missing values only" + f": {counts}" * bool(counts))
    source = {"source_file": path.name, "source_sha256": files.file_hash(path)}
    missing = "NaN where nothing was measured" + ", or a limit, pull_off_at_most" * (AT_MOST in ds)
    return ds.assign_attrs(missing=missing, **source)


def _read_curve_file(path: Path, kind: str, given: Calibration, baseline: Any) -> xr.Dataset:
    """Return the pull-off forces of a file's curves, read in parts to save memory."""
    file = open_curve_file(path, kind, given)
    parts = []
    with subregion_bar(len(file.curves), label=path.name) as bar:
        for first in range(0, len(file.curves), _CURVES_IN_MEMORY):
            curves = schema.label(read_curves(file, first, first + _CURVES_IN_MEMORY))
            parts.append(curves_pull_off(curves, baseline=_default_share(baseline)))
            bar.update(parts[-1].sizes["subregion"])
    ds = xr.concat(parts, "subregion", coords="minimal", compat="override", join="override", combine_attrs="override")
    ds.attrs.pop("history")  # of one part
    return ds.assign_attrs(source_format=file.format, **calibration(file))


def _default_share(baseline: Any) -> Any:
    """Return the stated baseline, by default the whole travel, which may contain it."""
    return 1.0 if baseline is None else baseline


def _is_matrix(path: Path) -> bool:
    """Return whether a text states the size of an image above the numbers, as Gwyddion's."""
    head = decoded(first_bytes(path, 2000))
    comments = [line for line in head.splitlines() if line.lstrip().startswith("#")]
    stated = all(any(side in line for line in comments) for side in ("Width:", "Height:"))
    return stated or bool(gwyddion_header(comments))


def _read_force_table(
    path: Path, image: _Selection, place_units: str | None, calibration: Calibration, baseline: Any
) -> xr.Dataset:
    schema.refuse_unused("a table", scan_direction=image.scan_direction, size=image.size)
    columns = files.call_naming_file(path, read_table, path, pull_offs=True)
    if image.channel is None and any(column.name.lower() == "piezo" for column in columns):
        schema.refuse_unused("a force-distance curve", place_units=place_units, pulls=calibration.pulls)
        curve = schema.label(read_curve_table(path, None, calibration))
        return curves_pull_off(curve, baseline=_default_share(baseline))
    schema.refuse_unused("a table of forces", baseline=baseline)
    column = force_column(path, columns, image.channel)
    values, how = _pull_off_magnitudes(path, column.values, column.units, calibration)
    ds = xr.Dataset({"pull_off_force": ("subregion", values)})
    for limit in columns:
        if limit.name in (AT_MOST, AT_LEAST, DETECTION) and converts(limit.units, "nN"):
            ds[limit.name] = ("subregion", limit.values * factor(str(limit.units), "nN"))
    ds = ds.assign_coords(_table_places(path, place_columns(path, columns, column), place_units))
    refuse_distribution(path, columns, column)
    swept = swept_column(columns, column)
    if swept is not None:
        ds.coords[CONDITION] = ("subregion", swept.values)
        ds.attrs[CONDITION] = f"{swept.name} [{swept.units}]" if swept.units else swept.name
    ds = ds.assign_coords(subregion=np.arange(ds.sizes["subregion"]))
    return ds.assign_attrs(measured="table", channel=column.name, **how)


def _table_places(path: Path, places: dict[str, Column], place_units: str | None) -> dict[str, Any]:
    """Return the coordinates of places; without units none, with a warning."""
    if places and place_units is None and not any(place.units for place in places.values()):
        named = ", ".join(repr(place.name) for place in places.values())
        left_out = f"{path.name}: the places {named} are left out: the file states no units; give them, "
        warn(Phrase(left_out, Argument("place_units", "um")))
        return {}
    return {
        f"subregion_{axis}": ("subregion", lengths(path, place, "place_units", place_units))
        for axis, place in places.items()
    }


def _pull_off_magnitudes(path: Path, values: np.ndarray, units: str | None, calibration: Calibration):
    if np.isinf(values).any():
        raise UnreadableScan(path, "finite values", "infinite ones: damaged")
    recorded, how = forces(values, units, calibration)
    turned, pulls = magnitudes(recorded, calibration.pulls)
    return turned, {**how, "pulls": pulls}


def _adhesion(channels: list[Channel], channel: Any, direction: str | None, path: Path) -> Channel:
    """Return the requested image, by default the only image of adhesion."""
    if channel is None:
        fitting = [candidate for candidate in channels if "adhes" in candidate.name.lower()]
        fitting = fitting or [candidate for candidate in channels if converts(candidate.units, "nN")]
        fitting = fitting or [candidate for candidate in channels if len(channels) == 1 and candidate.units is None]
    else:
        fitting = channels_named(channels, channel)
    wanted = "an image of adhesion" if channel is None else f"channel {channel!r}"
    advice = Phrase("give its name or number, ", Argument("channel", ...))
    return only_one(path, channels_in_direction(fitting, direction), wanted, listing(channels), advice)


def _read_image(path: Path, channel: Channel, size: Any, calibration: Calibration) -> xr.Dataset:
    """Return an image's pixels as places, as in a scan."""
    image = files.picture(files.with_size(channel, size, path), path)
    values, how = _pull_off_magnitudes(path, image.values, channel.units, calibration)
    ds = map_samples(image.copy(data=values).to_dataset(name="pull_off_force"))
    ds = ds.assign_coords(subregion=np.arange(values.size))
    return ds.assign_attrs(
        measured="adhesion image", channel=channel.name, scan_direction=channel.direction or "not stated", **how
    )
