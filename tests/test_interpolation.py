"""Heights between the pixels."""

import numpy as np
import pytest
import xarray as xr

from roughxr.mechanics.kernels.topography.interpolation import band_limited, heights_on_circles, splined

from .surfaces import unpressed


def waves_of(shortest, seed, *, noise=0.0, n=64):
    """Return, as a function of the place in pixels, a periodic surface of waves down to ``shortest`` pixels.

    Noise (nm, its standard deviation) is waves of one height down to two pixels.
    """
    rng = np.random.default_rng(seed)
    m = np.arange(-(n // 2) + 1, n // 2)
    q = np.hypot(*np.meshgrid(m, m, indexing="ij"))
    phases = np.exp(2j * np.pi * rng.random((2, *q.shape)))
    falling = np.where((q > 0) & (q <= n / shortest), np.maximum(q, 3.0) ** -1.8, 0.0)

    def of(amplitude, std):
        def at(x, y):
            along, across = (np.exp(2j * np.pi * np.multiply.outer(place, m) / n) for place in (x, y))
            return (along @ amplitude @ across.T).real

        scale = std / at(np.arange(n), np.arange(n)).std()
        return lambda x, y: scale * at(x, y)

    rough = of(phases[0] * falling, 1.5)
    white = of(phases[1], noise)
    return lambda x, y: rough(x, y) + white(x, y)


def centres(size, n):
    return (np.arange(size * n) + 0.5) / n - 0.5


@pytest.mark.parametrize(("shortest", "largest"), [(2.05, 2e-2), (3.0, 3e-3), (4.0, 2e-3)])
def test_a_band_limited_surface_comes_out_as_it_is(shortest, largest):
    surface = waves_of(shortest, 1)
    pixels = np.arange(64)
    fine = centres(64, 4)
    inside = slice(40, -40)  # ten pixels from the edges, whose kink falls off
    true = surface(fine, fine)[inside, inside]
    off = np.abs(band_limited(surface(pixels, pixels), 4)[inside, inside] - true).max()
    assert off < largest * 1.5
    assert off < 0.2 * np.abs(splined(surface(pixels, pixels), 4)[inside, inside] - true).max()


@pytest.mark.parametrize("n", [2, 3, 5])
def test_planes_are_kept_to_their_edges(n):
    x, y = np.meshgrid(centres(9, n), centres(7, n), indexing="ij")
    coarse = np.add.outer(0.3 * np.arange(9), -0.7 * np.arange(7)) + 4.0
    np.testing.assert_allclose(band_limited(coarse, n), 0.3 * x - 0.7 * y + 4.0, atol=1e-12)


@pytest.mark.parametrize("between", [band_limited, splined])
@pytest.mark.parametrize("n", [2, 3, 5])
def test_mirror_images_and_turns_are_kept(between, n):
    height = np.random.default_rng(0).normal(size=(9, 7))
    np.testing.assert_allclose(between(height[::-1], n), between(height, n)[::-1], atol=1e-12)
    np.testing.assert_allclose(between(height.T, n), between(height, n).T, atol=1e-12)


@pytest.mark.parametrize("between", [band_limited, splined])
def test_an_odd_division_keeps_the_pixels(between):
    height = np.random.default_rng(0).normal(size=(9, 7))
    np.testing.assert_allclose(between(height, 5)[2::5, 2::5], height, atol=1e-12)


def test_single_pixels_and_rows_stay_what_they_are():
    np.testing.assert_allclose(band_limited(np.array([[2.0]]), 3), 2.0)
    row = np.array([[0.0, 1.0, 0.5, 2.0]])
    np.testing.assert_allclose(band_limited(row, 3)[1, 1::3], row[0], atol=1e-12)


def test_heights_on_circles_and_their_slopes_are_those_of_the_surface():
    surface = waves_of(10.0, 1)
    pixels = np.arange(64)
    middle = 31.3, 32.6
    radii = np.linspace(0.0, 30.0, 7)
    angles = 2 * np.pi * np.arange(16) / 16
    axes = 5.0 * pixels - 40.0, 5.0 * pixels + 20.0
    heights, slopes = heights_on_circles(
        axes, surface(pixels, pixels), (5.0 * middle[0] - 40.0, 5.0 * middle[1] + 20.0), 5.0 * radii, angles
    )
    for k, (along_x, along_y) in enumerate(zip(np.cos(angles), np.sin(angles))):
        line = [np.diag(surface(middle[0] + r * along_x, middle[1] + r * along_y)) for r in (radii, radii + 1e-4)]
        np.testing.assert_allclose(heights[:, k], line[0], atol=0.01)
        np.testing.assert_allclose(slopes[:, k], (line[1] - line[0]) / 5e-4, atol=0.003)


def test_a_plane_is_kept_on_circles_that_end_at_the_outermost_pixels():
    x = np.arange(-8.0, 9.0)
    heights, slopes = heights_on_circles((x, x), np.add.outer(0.3 * x, -0.7 * x), (0, 0), np.array([8.0]), np.zeros(1))
    assert heights == pytest.approx(2.4, abs=1e-5) and slopes == pytest.approx(0.3, abs=1e-5)


def scan_of(height, pixel):
    nm = {"units": "nm"}
    axes = {name: (name, (np.arange(len(height)) + 0.5) * pixel, nm) for name in ("x", "y")}
    scan = xr.Dataset({"height": (("x", "y"), height, nm)}, axes)
    return scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1, adhesion_range=0.5)


@unpressed()
@pytest.mark.filterwarnings("ignore:.*miss accuracy")
@pytest.mark.parametrize(
    ("shortest", "noise"),
    [(2.05, 0.0), *(pytest.param(*case, marks=pytest.mark.soak) for case in ((4.0, 0.05), (3.0, 0.0), (4.0, 0.0)))],
)
def test_half_a_pixel_aside_a_pull_off_is_the_same_within_its_stated_error(shortest, noise):
    pixel = 6.0
    surface = waves_of(shortest, 2, noise=noise)
    n = np.arange(64)
    x, y = (c.ravel() for c in np.meshgrid([100.0, 280.0], [110.0, 290.0]))
    solved = []
    for aside in (0.0, 0.5):
        scan = scan_of(surface(n + aside, n + aside), pixel)
        places = (x - aside * pixel, y - aside * pixel)
        solved.append(scan.contact.adhesive(subregions=places, law="exponential"))
    at_pixel, half_a_pixel_aside = (solution.pull_off_force.values for solution in solved)
    stated = np.hypot(*(solution.pull_off_error.values for solution in solved))
    assert (np.abs(at_pixel - half_a_pixel_aside) <= stated * at_pixel).mean() >= 0.9
