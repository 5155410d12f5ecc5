"""Tiles joined at their seams give what the whole gives, to the last bit and in the same order."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from roughxr.kernels.topography.peaks import search
from roughxr.kernels.topography.tile_stitching import Frame, join_tiles, search_tile

from .surfaces import rough
from .test_peaks import plateaus_that_are_peaks


def frame_of(z, patch=3, vertex="fitted"):
    return Frame(z.shape, (1.3, 2.1), patch, vertex)


def tiles(z, frame, *sizes):
    """Search each tile of a grid of these sizes along x and y, apart from all others."""
    ends = [np.cumsum([0, *n]).tolist() for n in sizes]
    rows, columns = (list(itertools.pairwise(e)) for e in ends)
    return [[search_tile(z[a:b, c:d].copy(), (a, c), frame) for c, d in columns] for a, b in rows]


def assert_joined(z, frame, *sizes):
    """Compare with the scan in one piece, and that with the search that knows no tiles; return what is found."""
    whole = join_tiles([[search_tile(z, (0, 0), frame)]], frame)
    for column, direct in zip(whole.peaks, search(z).peaks):
        np.testing.assert_array_equal(column, direct)
    found = join_tiles(tiles(z, frame, *sizes), frame)
    assert (found.missing, found.highest) == (whole.missing, whole.highest)
    for name, column in {**whole.peaks._asdict(), **whole.fit._asdict()}.items():
        other = getattr(found.peaks if name in whole.peaks._fields else found.fit, name)
        assert other.dtype == column.dtype
        np.testing.assert_array_equal(other, column, err_msg=name)
    return found


@st.composite
def cut(draw, n, least):
    """Sizes that add up to n, none below the least."""
    sizes = []
    while n - sum(sizes) >= 2 * least:
        sizes.append(draw(st.integers(least, n - sum(sizes) - least)))
    return [*sizes, n - sum(sizes)]


@st.composite
def cases(draw):
    """A surface, smooth or not, in steps or not, and how to cut it into tiles."""
    shape, patch = (draw(st.integers(5, 40)), draw(st.integers(5, 40))), draw(st.sampled_from([3, 5]))
    z = np.random.default_rng(draw(st.integers(0, 2**32 - 1))).standard_normal(shape)
    smooth, levels = draw(st.sampled_from([0.0, 0.7, 2.0, 5.0])), draw(st.sampled_from([0.5, 1.0, 3.0, np.inf]))
    z = ndimage.gaussian_filter(z, smooth)
    z = z / z.std() if np.isinf(levels) else np.round(z / z.std() * levels)
    sizes = [draw(cut(n, patch - 1)) for n in shape]
    return z, frame_of(z, patch, draw(st.sampled_from(["fitted", "pixel"]))), *sizes


@given(cases())
@settings(deadline=None, max_examples=300)
def test_any_tiles_of_any_surface(case):
    assert_joined(*case)


@given(cases())
@settings(deadline=None, max_examples=50)
def test_joined_plateaus_agree_with_labelling(case):
    z, frame, *sizes = case
    found = join_tiles(tiles(z, frame, *sizes), frame)
    expected = sorted(int(plateau.sum()) for plateau in plateaus_that_are_peaks(z))
    assert sorted(found.peaks.size.tolist()) == expected


def spiral(turns=4, pitch=4):
    """A ridge of one height, one pixel wide, that winds outwards over lower ground; its inner and outer end."""
    side = 2 * pitch * turns + 5
    z = np.zeros((side, side))
    i = j = side // 2
    start, z[i, j] = (i, j), 1.0
    for leg in range(2 * turns):
        di, dj = ((0, 1), (1, 0), (0, -1), (-1, 0))[leg % 4]
        for _ in range(pitch * (leg // 2 + 1)):
            i, j = i + di, j + dj
            z[i, j] = 1.0
    return z, start, (i, j)


@pytest.mark.parametrize("sizes", [(6, 31), (12, 25), (18, 19), (9, 9, 9, 10), (2, 3, 4, 5, 6, 7, 8, 2)])
def test_a_spiral_through_many_tiles_is_one_peak_or_none(sizes):
    z, inner, outer = spiral()
    frame = frame_of(z)
    found = assert_joined(z, frame, sizes, sizes)
    assert found.peaks.size.tolist() == [z.sum()]
    for end in (inner, outer):  # one higher pixel at either end, tiles away, forbids all of it
        higher = z.copy()
        higher[end] = 2.0
        assert assert_joined(higher, frame, sizes, sizes).peaks.size.tolist() == [1]
    z[outer[0] :, outer[1]] = z[: outer[0] + 1, outer[1]] = 1.0  # and so does leading to the scan's edge
    assert assert_joined(z, frame, sizes, sizes).peaks.size.size == 0


@pytest.mark.parametrize("patch", [3, 5, 9])
def test_the_middle_of_a_large_plateau_is_fitted_to_what_is_around_it(patch):
    """A mesa over many tiles, whose middle lies in a narrow part of it, far from all seams."""
    z = np.zeros((60, 60))
    z[20:41, 3:57] = 1.0
    z[22:41, 18:29], z[20:39, 31:43] = rough(60)[22:41, 18:29] - 20, rough(60)[20:39, 31:43] - 20
    found = assert_joined(z, frame_of(z, patch), (20, 20, 20), (15, 30, 15))
    (n,) = np.flatnonzero(found.peaks.size > 100)
    assert found.peaks.ix[n] == 30 and abs(found.peaks.iy[n] - 30) <= 1
    assert found.fit.curvature_max[n] > 0


def test_pixels_in_a_chessboard_touch_by_corners_across_the_corners_of_tiles():
    z = np.zeros((24, 24))
    z[3:21, 3:21] = np.indices((18, 18)).sum(axis=0) % 2
    found = assert_joined(z, frame_of(z), (12, 12), (12, 12))
    assert found.peaks.size.tolist() == [162]


@pytest.mark.parametrize("patch", [3, 5])
def test_heights_of_one_value_have_no_peak_and_leave_little_behind(patch):
    """Nothing in an inner tile says that its plateau, all of it, is no peak: it is carried as a bit per pixel."""
    z = np.full((768, 768), 7.0)
    frame = frame_of(z, patch)
    grid = tiles(z, frame, (256,) * 3, (256,) * 3)
    assert join_tiles(grid, frame).peaks.size.size == 0
    middle = grid[1][1]
    kept = sum(part.nbytes for pair in (*middle.rims, *middle.numbers) for part in pair)
    kept += sum(part.nbytes for part in middle.open)
    assert kept < 0.1 * 256**2 * 8
    owners = [part.base for pair in middle.rims for part in pair]
    assert all(owner is None or owner.nbytes < 0.1 * 256**2 * 8 for owner in owners)  # no view of a whole tile


def test_missing_pixels_are_counted_and_nothing_else():
    z = rough(30)
    z[3, 4], z[20:22, 25] = np.nan, np.inf
    found = join_tiles(tiles(z, frame_of(z), (15, 15), (10, 20)), frame_of(z))
    assert found.missing == 3
