"""Maps as images inside the page: PNG files of at most 256 colours, one byte per pixel."""

from __future__ import annotations

import io

import numpy as np

from ...figures.images import colour_map
from ..template import as_uri

#: Colours of tractions: index 0 is none, the first half is for pulls, strongest first, the second half for pushes.
_PULLS, _PUSHES = np.arange(1, 128), np.arange(128, 256)


def picture(indices: np.ndarray, colours: np.ndarray) -> str:
    """Return an image with a palette (colour, RGBA) as a data URI."""
    from PIL import Image

    image, file = Image.fromarray(indices), io.BytesIO()
    image.putpalette(np.ascontiguousarray(colours).tobytes(), "RGBA")
    image.save(file, "PNG", compress_level=9)
    return as_uri(file.getvalue())


def heights_palette() -> np.ndarray:
    """Return the colours of heights, dark to light; the last one, for missing values, is transparent."""
    colours = _of_map("mako", np.linspace(0.0, 1.0, 256))
    colours[255] = 0
    return colours


def tractions_palette() -> np.ndarray:
    """Return the colours of pulls and pushes, darker for stronger ones; the first one is transparent."""
    colours = np.zeros((256, 4), np.uint8)
    colours[_PULLS] = _of_map("Blues_r", np.linspace(0.05, 0.75, _PULLS.size))
    colours[_PUSHES] = _of_map("rocket_r", np.linspace(0.12, 0.95, _PUSHES.size))
    return colours


def _of_map(name: str, values: np.ndarray) -> np.ndarray:
    return (colour_map(name)(values) * 255).round().astype(np.uint8)


def heights_indices(heights: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return the index of each height's colour, and the heights at both ends of the scale."""
    known = heights[np.isfinite(heights)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    shares = (heights - low) / ((high - low) or 1.0)
    return np.where(np.isfinite(shares), np.round(254 * np.nan_to_num(shares)), 255).astype(np.uint8), low, high


def tractions_indices(tractions: np.ndarray, pull: float, push: float) -> np.ndarray:
    """Return the index of each traction's colour, between the largest pull and push; 0 where it is nearly 0 or NaN."""
    pulls = np.clip(-np.nan_to_num(tractions) / (pull or 1.0), 0.0, 1.0)
    pushes = np.clip(np.nan_to_num(tractions) / (push or 1.0), 0.0, 1.0)
    indices = np.zeros(tractions.shape, np.uint8)
    pulling, pushing = (pulls > 0.02) & (pull > 0), pushes > 0
    indices[pulling] = (_PULLS[-1] - np.round(pulls[pulling] * (_PULLS.size - 1))).astype(np.uint8)
    indices[pushing] = (_PUSHES[0] + np.round(pushes[pushing] * (_PUSHES.size - 1))).astype(np.uint8)
    return indices


def heights_legend() -> str:
    """Return the colour bar from the lowest height to the highest."""
    return picture(np.arange(255, dtype=np.uint8)[None, :], heights_palette())


def tractions_legend(pull: float, push: float) -> str:
    """Return the colour bar from the largest pull, where there is any, to the largest push."""
    bar = np.concatenate([_PULLS if pull > 0 else _PULLS[:0], _PUSHES]).astype(np.uint8)
    return picture(bar[None, :], tractions_palette())


def thinned(values: np.ndarray, most: int) -> np.ndarray:
    """Return averages over blocks, so that neither of the last two axes exceeds ``most``; a remainder is cut off."""
    rows, columns = (_block(n, most) for n in values.shape[-2:])
    whole = values[..., : values.shape[-2] // rows * rows, : values.shape[-1] // columns * columns]
    shape = (*values.shape[:-2], whole.shape[-2] // rows, rows, whole.shape[-1] // columns, columns)
    return whole.reshape(shape).mean(axis=(-3, -1))


def edges(axis: np.ndarray, most: int) -> tuple[float, float]:
    """Return the outer edges of a uniform axis' cells that `thinned` keeps."""
    cell, block = (axis[1] - axis[0] if axis.size > 1 else 1.0), _block(axis.size, most)
    return float(axis[0] - cell / 2), float(axis[axis.size // block * block - 1] + cell / 2)


def _block(count: int, most: int) -> int:
    return max(1, -(-count // most))
