"""Convolution with an even kernel in a box, by fast Fourier transforms.

Given a kernel k at offsets (i, j) ≥ 0 and values f in a box, g(m) = Σ k(m − n) f(n) on the box follows from the
convolution theorem (Hockney & Eastwood 1981 for the padding; Stanley & Kato 1997, Liu, Wang & Liu 2000 for contacts).

The box is padded with zeros, so that the result is exact and not periodic. Only the rows with values are transformed
along y, both ways, which saves a quarter of the work. The kernel is even along both axes, so that its transform is
real, symmetric, and a cosine transform of one quadrant: an eighth of the work of a product. If the spectrum is larger
than the processor's cache, its columns are transformed, multiplied and transformed back strip by strip: 0.6 of the time
at 2048².

SciPy's transforms run inside compiled code through rocket-fft: no Python in the loop and no lock held, so that threads
scale. Without compilation (NUMBA_DISABLE_JIT) SciPy itself is used.
"""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import scipy.fft
from numba import config
from rocket_fft import lowlevel

from ..jit import kernel

_ALONG_ROWS, _ALONG_COLUMNS = np.array([1]), np.array([0])


def _scipy_transforms():
    """Return SciPy's equivalents of the functions of `lowlevel` in use, without scaling."""

    def r2c(values, out, axes, forward, factor, threads):
        out[:] = scipy.fft.rfft(values, axis=axes[0])

    def c2r(values, out, axes, forward, factor, threads):
        out[:] = scipy.fft.irfft(values, out.shape[axes[0]], axis=axes[0], norm="forward")

    def c2c(values, out, axes, forward, factor, threads):
        transform, norm = (scipy.fft.fft, "backward") if forward else (scipy.fft.ifft, "forward")
        out[:] = transform(values, axis=axes[0], norm=norm)

    return SimpleNamespace(r2c=r2c, c2r=c2r, c2c=c2c)


if config.DISABLE_JIT:
    lowlevel = _scipy_transforms()


class Convolution(NamedTuple):
    """The product with a kernel in one box, in the precision of its arrays; all but ``transfer`` are work arrays."""

    transfer: np.ndarray  # one quadrant of the transformed kernel, divided by the number of the padded box's cells
    box: np.ndarray  # (rows, padded columns): the values to convolve, then their convolution
    spectrum: np.ndarray  # (rows, padded columns // 2 + 1)
    strip: np.ndarray  # (padded rows, some or all columns of the spectrum)


def even_length(size):
    """Return the least even length of at least ``size`` with a fast transform."""
    return 2 * scipy.fft.next_fast_len((size + 1) // 2, True)


def kernel_transform(rows, columns, quadrant):
    """Return one quadrant of the transform of a kernel on a padded box (even lengths), over its number of cells."""
    return scipy.fft.dctn(quadrant[: rows // 2 + 1, : columns // 2 + 1] / (rows * columns), 1)


def convolution(rows, transfer, kind=np.float32):
    """Return the `Convolution` of a box of ``rows`` rows, in single or double precision."""
    high = 2 * (transfer.shape[0] - 1)
    wide = transfer.shape[1]
    whole = np.result_type(kind, np.complex64)
    # largest number of values of a spectrum transformed in one piece; number of columns of a strip of larger ones
    width = wide if high * wide <= 2**17 else 32
    box = np.empty((rows, 2 * (wide - 1)), kind)
    spectrum = np.empty((rows, wide), whole)
    return Convolution(transfer.astype(kind, copy=False), box, spectrum, np.empty((high, width), whole))


@kernel
def convolve(c):
    """Replace the values in ``c.box`` by their convolution; columns beyond the box's own are padding."""
    lowlevel.r2c(c.box, c.spectrum, _ALONG_ROWS, True, 1.0, 1)
    (rows, wide) = c.spectrum.shape
    high = c.strip.shape[0]
    for first in range(0, wide, c.strip.shape[1]):
        width = min(c.strip.shape[1], wide - first)
        for i in range(high):  # faster to compile than slices
            for j in range(width):
                c.strip[i, j] = c.spectrum[i, first + j] if i < rows else 0.0
        lowlevel.c2c(c.strip, c.strip, _ALONG_COLUMNS, True, 1.0, 1)
        for i in range(high):
            row = c.transfer[min(i, high - i)]
            for j in range(width):
                z = c.strip[i, j]
                factor = row[first + j]
                c.strip[i, j] = complex(z.real * factor, z.imag * factor)
        lowlevel.c2c(c.strip, c.strip, _ALONG_COLUMNS, False, 1.0, 1)
        for i in range(rows):
            for j in range(width):
                c.spectrum[i, first + j] = c.strip[i, j]
    lowlevel.c2r(c.spectrum, c.box, _ALONG_ROWS, False, 1.0, 1)


def convolved(values, transfer):
    """Return the convolution of a box in double precision."""
    columns = values.shape[1]
    c = convolution(len(values), transfer, np.float64)
    c.box[:, :columns] = values
    c.box[:, columns:] = 0.0
    convolve(c)
    return c.box[:, :columns]
