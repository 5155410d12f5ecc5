"""Convolution with an even kernel in a box, by transforms in arrays that are allocated beforehand.

Given a kernel k at offsets (i, j) ≥ 0 and values f in a box, sought is g(m) = Σ k(m − n) f(n) on the box: by the
convolution theorem (Hockney & Eastwood 1981 for the padding; Stanley & Kato 1997, Liu, Wang & Liu 2000 for contacts).

The box is padded with zeros until nothing wraps around: exact, not periodic. Only the rows that hold values are
transformed along y, both ways, which saves a quarter of the work. The kernel is even along both axes, so that its
transform is real, symmetric, and a cosine transform of one quadrant: an eighth of the work of a product. Where the
spectrum is larger than the cache its columns are transformed, multiplied and transformed back strip by strip: 0.6 of
the time at 2048².

SciPy's transforms run inside compiled code through rocket-fft: no Python in the loop and no lock held, so that
threads scale. Without compilation (NUMBA_DISABLE_JIT) SciPy itself is used. Kernels call rocket-fft's own functions,
which Numba writes where they are called: functions of ours between them took 0.06 s each to compile, and there are
eight.
"""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import scipy.fft
from numba import config
from rocket_fft import lowlevel

from ..arrays import unset
from ..jit import kernel

#: Spectra of up to so many values are transformed in one piece, larger ones in strips of so many columns.
_IN_ONE_PIECE, _STRIP = 2**17, 32

_ALONG_ROWS, _ALONG_COLUMNS = np.array([1]), np.array([0])


def _plain():
    """Return the transforms of `lowlevel` that are used here, by SciPy: none of them scales."""

    def r2c(values, out, axes, forward, factor, threads):
        out[:] = scipy.fft.rfft(values, axis=axes[0])

    def c2r(values, out, axes, forward, factor, threads):
        out[:] = scipy.fft.irfft(values, out.shape[axes[0]], axis=axes[0], norm="forward")

    def c2c(values, out, axes, forward, factor, threads):
        transform, norm = (scipy.fft.fft, "backward") if forward else (scipy.fft.ifft, "forward")
        out[:] = transform(values, axis=axes[0], norm=norm)

    return SimpleNamespace(r2c=r2c, c2r=c2r, c2c=c2c)


if config.DISABLE_JIT:
    lowlevel = _plain()


class Transfer(NamedTuple):
    """The transformed kernel of one padded box: one quadrant, divided by the number of the box's cells."""

    rows: int  # of the padded box, even
    columns: int
    double: np.ndarray  # (rows // 2 + 1, columns // 2 + 1)
    single: np.ndarray


class Convolution(NamedTuple):
    """The product with the kernel in one box, in the precision of its arrays; all but ``transfer`` are work arrays."""

    transfer: np.ndarray
    box: np.ndarray  # (rows, padded columns): the values to convolve, then their convolution
    spectrum: np.ndarray  # (rows, padded columns // 2 + 1)
    strip: np.ndarray  # (padded rows, some or all columns of the spectrum)


@kernel
def even_length(size):
    """Return an even length of quick transforms, at least ``size``."""
    return 2 * scipy.fft.next_fast_len((size + 1) // 2, True)


@kernel
def transfer_of(rows, columns, quadrant):
    """Return the `Transfer` of a padded box (even lengths) from the kernel at offsets (i, j) ≥ 0."""
    high, wide = rows // 2 + 1, columns // 2 + 1
    values, single = unset((high, wide), 0.0), unset((high, wide), np.float32(0))
    for i in range(high):  # NumPy's own quotients of arrays and ``astype`` take 0.2 s to compile
        for j in range(wide):
            values[i, j] = quadrant[i, j] / (rows * columns)
    double = scipy.fft.dctn(values, 1)
    for i in range(high):
        for j in range(wide):
            single[i, j] = double[i, j]
    return Transfer(rows, columns, double, single)


@kernel
def convolution(rows, columns, transfer, zero):
    """Return the `Convolution` of ``rows`` rows padded to ``columns`` columns, ``zero`` the complex number's type."""
    high, wide = 2 * (transfer.shape[0] - 1), transfer.shape[1]
    width = wide if high * wide <= _IN_ONE_PIECE else _STRIP
    box = unset((rows, columns), transfer[0, 0])
    spectrum, strip = unset((rows, wide), zero), unset((high, width), zero)
    return Convolution(transfer, box, spectrum, strip)


@kernel
def convolve(c):
    """Replace the values in ``c.box`` by their convolution; columns beyond the box's own are padding."""
    lowlevel.r2c(c.box, c.spectrum, _ALONG_ROWS, True, 1.0, 1)
    for first in range(0, c.spectrum.shape[1], c.strip.shape[1]):
        _convolve_columns(c, first)
    lowlevel.c2r(c.spectrum, c.box, _ALONG_ROWS, False, 1.0, 1)


@kernel
def _convolve_columns(c, first):
    """Transform as many columns of the spectrum as a strip holds, multiply them, and transform them back."""
    (rows, wide), (high, width) = c.spectrum.shape, c.strip.shape
    width = min(width, wide - first)
    for i in range(high):  # faster to compile than slices, as elsewhere in these kernels
        for j in range(width):
            c.strip[i, j] = c.spectrum[i, first + j] if i < rows else 0.0
    lowlevel.c2c(c.strip, c.strip, _ALONG_COLUMNS, True, 1.0, 1)
    for i in range(high):
        row = c.transfer[min(i, high - i)]
        for j in range(width):
            z, factor = c.strip[i, j], row[first + j]
            c.strip[i, j] = complex(z.real * factor, z.imag * factor)
    lowlevel.c2c(c.strip, c.strip, _ALONG_COLUMNS, False, 1.0, 1)
    for i in range(rows):
        for j in range(width):
            c.spectrum[i, first + j] = c.strip[i, j]
