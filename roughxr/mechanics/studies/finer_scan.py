"""A second, finer scan of a surface: without its noise, as it is and as the first scan would show it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from ..scans.editing import on_square_pixels
from ..scans.fine_scales import smooth
from ..scans.levelling import level
from ..scans.plausibility import ImplausibleScan
from ..scans.spectra import power_spectrum
from ..vocabulary import schema
from ..vocabulary.error_sources import SECOND_SCAN_WIDTH
from ..vocabulary.numbers import format_number
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import warn
from .assumptions import noise_limit

#: Places of the first pixels of a second scan as the first would show it, in pixels: results are means over both.
_PHASES = (0.25, 0.75)

#: Largest ratio of heights or slopes of the second scan to those of all parts of the first one as large.
_LARGEST_RATIO = 2.0

#: Ratios to the largest or least of all parts of the first scan from which a second scan is doubted.
_DOUBTFUL_RATIO = {"rms of heights": 1.5, "rms of slopes": 1.22, "rms of curvatures": 1.22, "tilt": 2.0}

#: Measures that change their sign with that of the heights.
_SKEWNESSES = ("skewness of heights", "skewness of curvatures")

#: Odds from which heights are doubted to be upside down.
_DOUBTFUL_ODDS = 10.0


class SecondScan(NamedTuple):
    """A second scan with the pair of the first."""

    finer: xr.Dataset  # without wavelengths at which noise exceeds roughness
    noisier: xr.Dataset  # the same with as much noise as its neighbouring lines allow
    as_shown: list[xr.Dataset]  # sampled on the pixels of the first scan
    shown_wavelength: float  # nm, the shortest that it shows


def second_scan(ds: xr.Dataset, finer: xr.Dataset) -> SecondScan:
    """Return a second, finer scan of the surface of the first.

    Raise where it is not finer, too small, or not of the same surface; warn where that is doubtful.
    """
    finer = on_square_pixels(schema.validate(finer, "scan"))[["height"]].reset_coords(drop=True)
    if missing := int(finer["height"].isnull().sum()):
        raise Refusal(
            "finer", "no missing pixels", f"{missing} of {finer['height'].size}", "fill them (fill), or crop the scan"
        )
    raw = finer.assign_coords(schema.pair_coordinates(ds))
    flat = level(raw)
    shown_wavelength = _wavelength_above_noise(flat)
    noise = np.random.default_rng(0).normal(0, noise_limit(flat), flat["height"].shape)
    finer, noisier = (_cut(scan, shown_wavelength) for scan in (flat, flat.assign(height=flat["height"] + noise)))
    shown = [_as_shown(finer, ds, phase) for phase in _PHASES]
    _compare(ds, shown[0], _as_shown(raw, ds, _PHASES[0]))
    if shown_wavelength > 2 * max(schema.pixel(ds)):
        limit = format_number(noise_limit(flat), "nm", 2)
        hidden = format_number(shown_wavelength, "nm", 2)
        sentence = f"its noise, up to {limit}, hides roughness below {hidden}: it shows no more than the first scan"
        warn(sentence, what="finer")
    return SecondScan(finer, noisier, shown, shown_wavelength)


def _wavelength_above_noise(ds: xr.Dataset) -> float:
    """Return the shortest wavelength (nm) above which roughness exceeds the limit of noise, two pixels or more."""
    step = schema.square_pixel(ds)
    spectrum = power_spectrum(ds, window="hann")
    noise = noise_limit(ds) ** 2 * step**2  # nm⁴
    resolved = spectrum.where((spectrum["wavevector"] > 0) & (spectrum["wavevector"] < np.pi / step), drop=True)
    hidden = resolved["wavevector"].where(resolved["psd"] < 2 * noise).min()
    return float(2 * np.pi / hidden.fillna(np.pi / step))


def _cut(ds: xr.Dataset, shortest: float) -> xr.Dataset:
    """Return a scan without wavelengths below the shortest (nm), unchanged if its pixels show none."""
    return smooth(ds, shortest=shortest) if shortest > 2 * schema.square_pixel(ds) * (1 + 1e-9) else ds


def _as_shown(finer: xr.Dataset, ds: xr.Dataset, phase: float) -> xr.Dataset:
    """Return a finer scan sampled on pixels as large as those of a coarser one, from a part of a pixel on."""
    step = schema.square_pixel(ds)
    fine = schema.square_pixel(finer)
    if not fine < step:
        raise Refusal("finer", f"pixels smaller than {step:.3g} nm", f"{fine:.3g} nm")
    axes = {}
    for axis in "xy":
        low = float(finer[axis][0])
        high = float(finer[axis][-1])
        count = int((high - low) / step)
        if count < SECOND_SCAN_WIDTH:
            raise Refusal(
                "finer",
                f"a side of {SECOND_SCAN_WIDTH * step:.3g} nm or more, ten pixels of the first scan",
                f"{high - low:.3g} nm",
            )
        axes[axis] = low + step * (phase + np.arange(count))
    return schema.label(finer.interp(axes, assume_sorted=True).assign_attrs(finer.attrs))


def _compare(ds: xr.Dataset, shown: xr.Dataset, raw: xr.Dataset) -> None:
    """Raise if a second scan cannot be of the first one's surface, and warn if it differs from all parts as large.

    ``shown`` is the second scan on the pixels of the first, ``raw`` the same with its noise and its plane.
    """
    sides = [min(shown.sizes[axis], ds.sizes[axis]) for axis in "xy"]
    parts = _measures_of_parts(ds, sides)
    low = parts.min()
    high = parts.max()
    second = pd.Series(_measures(shown) | {"tilt": _measures(raw)["tilt"]})
    _refuse_other_surface(second, low, high)
    ratio = pd.Series(_DOUBTFUL_RATIO).reindex(second.index, fill_value=1.0)
    is_doubtful = (second > high * ratio) | ((second < low / ratio) & (second.index != "tilt"))
    count = ds.sizes["x"] * ds.sizes["y"] / (sides[0] * sides[1])
    is_upside_down = _upside_down_log_odds(parts, count, second, sides[0] * sides[1]) > np.log(_DOUBTFUL_ODDS)
    for name in _SKEWNESSES:
        is_doubtful[name] = is_upside_down and second[name] * parts[name].mean() < 0
    doubts = [
        f"{name} {_words(name, second[name])} instead of {_words(name, low[name])} to {_words(name, high[name])}"
        for name in second.index[is_doubtful]
    ]
    if doubts:
        warn(
            f"on the pixels of the first scan it has {'; '.join(doubts)} of the parts as large of the first scan: "
            "check that it is the same surface, in the same units and orientation",
            ImplausibleScan,
            what="finer",
        )


def _measures_of_parts(ds: xr.Dataset, sides: list[int]) -> pd.DataFrame:
    """Return the measures of all parts of a scan with these sides (pixels), which overlap by half, a row each."""
    starts = [range(0, ds.sizes[axis] - side + 1, max(side // 2, 1)) for axis, side in zip("xy", sides)]
    return pd.DataFrame(
        [_measures(ds.isel(x=slice(i, i + sides[0]), y=slice(j, j + sides[1]))) for i in starts[0] for j in starts[1]]
    )


def _refuse_other_surface(second: pd.Series, low: pd.Series, high: pd.Series) -> None:
    """Raise if heights or slopes of the second scan are far from those of all parts of the first one."""
    for name in ("rms of heights", "rms of slopes"):
        if not low[name] / _LARGEST_RATIO <= second[name] <= high[name] * _LARGEST_RATIO:
            raise Refusal(
                "finer",
                f"a scan of the same surface, whose parts as large as this have {name.removeprefix('rms of ')} of rms "
                f"{_words(name, low[name])} to {_words(name, high[name])} at equal pixels",
                _words(name, second[name]),
            )


def _upside_down_log_odds(parts: pd.DataFrame, count: float, second: pd.Series, pixels: int) -> float:
    """Return ln of the odds that a second scan is upside down, by Student's t of a count of independent parts."""
    if count < 2:
        return 0.0
    log = 0.0
    least = 6 / pixels  # variance of the skewness of as many normally distributed heights
    for name in _SKEWNESSES:
        mean = parts[name].mean()
        scale = max(float(parts[name].var()), least) * (1 + 1 / count) * (count - 1)
        upright, inverted = (np.log1p((sign * second[name] - mean) ** 2 / scale) for sign in (1, -1))
        log += float(0.5 * count * (upright - inverted))
    return log


def _words(name: str, value: float) -> str:
    """Return a measure with its unit."""
    return format_number(value, {"rms of heights": "nm", "rms of curvatures": "1/nm"}.get(name, ""), 2)


def _skewness(values: np.ndarray) -> float:
    """Return the skewness of values."""
    off_mean = values - values.mean()
    return float(np.mean(off_mean**3) / np.mean(off_mean**2) ** 1.5)


def _measures(scan: xr.Dataset) -> dict[str, float]:
    """Return measures of a scan's heights: all but the tilt without its plane."""
    steps = schema.pixel(scan)
    heights = level(scan)["height"].values
    slopes = np.concatenate([np.diff(heights, axis=axis).ravel() / step for axis, step in enumerate(steps)])
    curvatures = np.concatenate([np.diff(heights, 2, axis=axis).ravel() / step**2 for axis, step in enumerate(steps)])
    tilts = [np.diff(scan["height"].values, axis=axis).mean() / step for axis, step in enumerate(steps)]
    return {
        "rms of heights": float(heights.std()),
        "rms of slopes": float(np.sqrt(np.mean(slopes**2))),
        "rms of curvatures": float(curvatures.std()),
        "skewness of heights": _skewness(heights),
        "skewness of curvatures": _skewness(curvatures),
        "tilt": float(np.hypot(*tilts)),
    }
