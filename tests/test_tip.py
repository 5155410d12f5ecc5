"""The tip: a known surface dilated by a tip of known radius, what comes back, and what is flagged."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.scans.tip import dilate, erode, impossible_share, tip_flags
from roughxr.mechanics.vocabulary import schema

TIP = 20.0
RADII = (5.0, 10.0, 15.0, 18.0, 23.0, 30.0, 60.0, 120.0)


def bumps(pixel=0.5, cell=40.0):
    """Return round summits of known radii side by side in a row, 4 nm high at most, on a flat."""
    x = (np.arange(int(cell * len(RADII) / pixel)) + 0.5) * pixel
    y = (np.arange(int(cell / pixel)) + 0.5) * pixel
    k = (x // cell).astype(int)
    r2 = (x % cell - cell / 2)[:, None] ** 2 + (y - cell / 2) ** 2
    height = np.maximum(4.0 - r2 / (2 * np.asarray(RADII)[k][:, None]), 0.0)
    return schema.label(xr.Dataset({"height": (("x", "y"), height)}, coords={"x": x, "y": y}))


def summits(ds):
    """Return the asperity at each bump's middle, fitted over 10 nm: a sweep over pixels is a polygon, seen closer."""
    catalogue = roughxr.asperities(ds, patch=21)
    middles = (np.arange(len(RADII)) + 0.5) * 40.0
    return catalogue.isel(
        asperity=[int(np.hypot(catalogue.x - m, catalogue.y - 20).argmin("asperity")) for m in middles]
    )


def test_the_image_of_a_summit_has_both_radii_together():
    image = summits(dilate(bumps(), tip_radius=TIP))
    np.testing.assert_allclose(1 / image.curvature_max, np.asarray(RADII) + TIP, rtol=0.03)


def test_asperities_sharper_than_the_tip_are_flagged_and_no_others():
    flagged = tip_flags(summits(dilate(bumps(), tip_radius=TIP)), tip_radius=TIP)
    assert flagged.sharper_than_tip.values.tolist() == [radius < TIP for radius in RADII]
    assert not flagged.beyond_tip.any()
    np.testing.assert_allclose(1 / flagged.curvature_recovered, RADII, rtol=0.15)
    assert flagged.tip_radius.units == "nm"


def test_no_image_is_sharper_than_the_tip():
    spike = bumps()
    spike["height"][:] = 0.0
    spike["height"][100, 40] = 6.0
    image = roughxr.asperities(dilate(spike, tip_radius=TIP))
    assert float(image.curvature_max.max()) == pytest.approx(1 / TIP, rel=1e-6)
    assert tip_flags(image, tip_radius=TIP * 1.01).beyond_tip.any()
    assert tip_flags(image, tip_radius=TIP).sharper_than_tip.all()


def test_erosion_gives_back_what_the_tip_touched():
    surface = bumps()
    image = dilate(surface, tip_radius=TIP)
    back = erode(image, tip_radius=TIP)
    assert float((back.height - surface.height).min()) > -1e-12
    np.testing.assert_allclose(dilate(back, tip_radius=TIP).height, image.height, atol=1e-12)
    top = surface.height > 3.5
    np.testing.assert_allclose(back.height.where(top), surface.height.where(top), atol=1e-9)


@pytest.mark.parametrize("radius", [8.0, 25.0])
def test_an_image_by_the_tip_has_no_impossible_part_and_noise_is_one(radius):
    surface = roughxr.scans.synthetic.self_affine((64, 64), 2, rms=2, hurst=0.8, rolloff=40, seed=13)
    image = dilate(surface, tip_radius=radius)
    assert impossible_share(image, tip_radius=radius) < 1e-9
    bumps_with_noise = bumps()
    bumps_with_noise["height"] += np.random.default_rng(1).normal(0.0, 0.3, bumps_with_noise.height.shape)
    assert impossible_share(bumps_with_noise, tip_radius=radius) > 0.5


def test_a_blunter_tip_sees_less():
    scan = roughxr.scans.synthetic.self_affine((64, 64), 2, rms=1, hurst=0.8, rolloff=40, seed=3)
    images = [dilate(scan, tip_radius=radius).height for radius in (2, 10, 50)]
    assert (images[0] >= scan.height - 1e-12).all()
    assert (images[1] >= images[0] - 1e-12).all() and (images[2] >= images[1] - 1e-12).all()
    assert images[2].std() < images[0].std()


def test_bad_input_is_refused_in_words():
    with pytest.raises(ValueError, match="tip_radius"):
        dilate(bumps(), tip_radius=-1)
    with pytest.raises(ValueError, match="missing pixels"):
        erode(bumps().where(bumps().x > 10), tip_radius=5)
