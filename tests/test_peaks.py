"""Peaks: every plateau once, and nothing that is not known to be a maximum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage
from scipy.interpolate import RectBivariateSpline

from roughxr.mechanics.kernels.topography.peaks import ascend, search

AROUND = np.ones((3, 3))

# Few levels, so that plateaus of all shapes abound; some pixels missing.
quantised = arrays(
    float,
    array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12),
    elements=st.sampled_from([0.0, 0.1, 0.2, 0.3, np.nan]),
    fill=st.nothing(),
)


def plateaus_that_are_peaks(z):
    """The definition, level by level and label by label: masks of the peaks' plateaus."""
    peaks = []
    for level in np.unique(z[np.isfinite(z)]):
        labels, count = ndimage.label(z == level, structure=AROUND)
        for plateau in (labels == n for n in range(1, count + 1)):
            ring = ndimage.binary_dilation(plateau, structure=AROUND) & ~plateau
            inner = plateau[1:-1, 1:-1].sum() == plateau.sum()
            if inner and (z[ring] < level).all():
                peaks.append(plateau)
    return peaks


def as_set(peaks):
    return set(zip(peaks.ix.tolist(), peaks.iy.tolist(), peaks.size.tolist()))


def picture(text):
    """Heights from a drawing: one digit for each pixel."""
    return np.array([[float(digit) for digit in line] for line in text.split()])


@given(quantised)
@settings(deadline=None, max_examples=200)
def test_agrees_with_labelling(z):
    peaks = search(z)
    plateaus = plateaus_that_are_peaks(z)
    assert len(peaks.ix) == len(plateaus)
    for plateau in plateaus:
        (n,) = np.flatnonzero(plateau[peaks.ix, peaks.iy])  # exactly one peak on each
        assert peaks.size[n] == plateau.sum()
        pixels = np.argwhere(plateau)
        distance = np.hypot(*(pixels - pixels.mean(axis=0)).T)
        at_peak = (pixels == (peaks.ix[n], peaks.iy[n])).all(axis=1)
        assert distance[at_peak][0] == pytest.approx(distance.min())


@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 2.0, 4.0]))
@settings(deadline=None, max_examples=50)
def test_smooth_surfaces_in_steps_agree_with_labelling(seed, levels):
    """Terraces, as on every quantised scan: shelves beside higher ones are what random pixels hardly hold."""
    z = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((24, 30)), 1.5)
    z = np.round(z / z.std() * levels)
    expected = sorted(int(plateau.sum()) for plateau in plateaus_that_are_peaks(z))
    assert sorted(search(z).size.tolist()) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        pytest.param("000 010 000", {(1, 1, 1)}, id="single pixel"),
        pytest.param("00000 01110 01110 01110 00000", {(2, 2, 9)}, id="square"),
        pytest.param("0000 0110 0110 0000", {(1, 1, 4)}, id="even square: the first of equals"),
        pytest.param("00000 01000 01000 01110 00000", {(2, 1, 5)}, id="L: the first of two as near"),
        pytest.param("00000 01110 01010 01110 00000", {(1, 2, 8)}, id="ring around a lower pixel"),
        pytest.param("00000 01110 01210 01110 00000", {(2, 2, 1)}, id="ring around a higher pixel"),
        pytest.param("0000 0100 0010 0000", {(1, 1, 2)}, id="diagonal contact is contact"),
        pytest.param("0000000 0220220 0221220 0000000", {(1, 1, 4), (1, 4, 4)}, id="saddle between plateaus"),
        pytest.param("00000 02200 01110 01110 01110 00000", {(1, 1, 2)}, id="shelf below a plateau met before"),
        pytest.param("0000 0110 0012 0000", set(), id="plateau below a border pixel"),
        pytest.param("0000 0111 0000", set(), id="plateau open to the outside"),
        pytest.param("1000 0000 0000", set(), id="border pixel"),
        pytest.param("1100 0110 0000 0000", set(), id="plateau from the border"),
        pytest.param("111 111 111", set(), id="constant"),
        pytest.param("01 10", set(), id="all border"),
    ],
)
def test_drawn(text, expected):
    assert as_set(search(picture(text))) == expected


@pytest.mark.parametrize("missing", [(1, 1), (2, 3), (4, 4)])
def test_nan_on_or_beside_a_plateau_forbids_it(missing):
    z = np.zeros((6, 6))
    z[2:4, 2:4] = 1
    assert len(search(z).ix) == 1
    z[missing] = np.nan
    assert len(search(z).ix) == 0


def test_large_plateau_of_a_quantised_dome():
    x = np.arange(-15, 16)
    dome = np.round(1 - np.add.outer(x**2, x**2) / 400, 0)
    assert as_set(search(dome)) == {(15, 15, (dome == 1).sum())}


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_invariance(seed):
    z = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((23, 31)), 1)
    peaks = as_set(search(z))
    last = z.shape[0] - 1
    assert as_set(search(z * 4 + 8)) == peaks
    assert {(j, i, n) for i, j, n in as_set(search(z.T))} == peaks
    assert {(last - i, j, n) for i, j, n in as_set(search(z[::-1]))} == peaks
    assert {(last - j, i, n) for i, j, n in as_set(search(np.rot90(z)[::-1, ::-1]))} == peaks


@pytest.mark.parametrize("shape", [(0, 0), (1, 5), (5, 2), (2, 2)])
def test_scans_too_small_for_a_peak(shape):
    assert len(search(np.zeros(shape)).ix) == 0


def test_an_ascent_ends_at_the_summit_of_a_ridge_from_wherever_it_begins():
    c = np.cos(0.4)
    s = np.sin(0.4)
    turn = np.array([[c, -s], [s, c]])
    bend = turn @ np.diag([-1.0, -100.0]) @ turn.T

    def surface(x, y, dx=0, dy=0):
        slope = np.stack([x - 3.0, y + 2.0], axis=-1) @ bend
        constant = {(2, 0): bend[0, 0], (1, 1): bend[0, 1], (0, 2): bend[1, 1]}
        return np.full(x.size, constant[dx, dy]) if dx + dy == 2 else slope[:, dy]

    starts = np.random.default_rng(0).uniform(-20, 20, (30, 2))
    np.testing.assert_allclose(ascend(surface, starts), np.broadcast_to([3.0, -2.0], (30, 2)), atol=1e-9)


def test_an_ascent_rises_through_a_valley_to_a_level_crest_and_stays_there():
    x = np.arange(40.0)
    y = np.arange(30.0)
    wave = RectBivariateSpline(x, y, np.broadcast_to(-np.cos(x / 5)[:, None], (40, 30)))
    crest = ascend(wave.ev, [[2.0, 20.0], [29.0, 11.3]])
    np.testing.assert_allclose(crest, [[5 * np.pi, 20.0], [5 * np.pi, 11.3]], atol=0.02)
