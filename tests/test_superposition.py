"""Superposition against single asperities, the published formulas by hand, and itself under dask."""

import numpy as np
import pytest
import xarray as xr

from roughxr.application.report.caveats import superposition_notes
from roughxr.mechanics.asperity import expectation
from roughxr.mechanics.asperity.asperity_sum import FORMULATIONS
from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.bodies.pair import contact_modulus
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio, elliptic_integrals

from .surfaces import glass_pair, rough, scan

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")

E = contact_modulus(75, 0.22)
W = 2 * 0.6747
R = 3000.0


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(96, rms=1.5, seed=11)))


def one_asperity(curvature_x, curvature_y, height=10.0, at=(0.0, 0.0)):
    x = (np.arange(65) - 32) * 5.0
    z = height - curvature_x / 2 * (x[:, None] - at[0]) ** 2 - curvature_y / 2 * (x[None, :] - at[1]) ** 2
    return glass_pair(scan(z, pixel=5.0))


def test_a_spherical_asperity_is_jkr_of_the_composite_radius():
    """Pull-off of a cap of R = 200 nm under the sphere: 3/2 π w R' with 1/R' = 1/200 + 1/3000, at its displacement."""
    radius = 1 / (1 / 200 + 1 / 3000)
    deltas = np.arange(-3, 1, 0.001)
    for formulation in ("self_similar", "energy"):
        force = superpose(one_asperity(1 / 200, 1 / 200), delta=deltas, formulation=formulation).force[0]
        assert -force.min().item() == pytest.approx(1.5 * np.pi * W * radius, rel=1e-5)
        unit = (9 * np.pi * W * radius**2 / (8 * E)) ** (2 / 3) / radius
        assert float(force.delta[force.argmin("delta")]) == pytest.approx(-unit / 3, abs=2e-3)
        branch_end = float(force.delta[(force < 0).argmax("delta")])
        assert branch_end == pytest.approx(-(3 ** (-1 / 3)) * unit, abs=2e-3)


def published_by_hand(A, B, delta):
    """Eqs. 20–24 as printed, their cubic solved by NumPy."""
    lam = axis_ratio(B / A)
    K, _ = elliptic_integrals(lam)
    beta = A + lam**2 * B
    gamma = W / 2
    a_c = (9 * gamma * lam**2 * K / (2 * beta**2 * E)) ** (1 / 3)
    s = np.roots([1, 0, 0, -4 / 3, -delta / (beta * a_c**2)])  # a* = s², δ* = s⁴ − (4/3) s
    a = max(root.real for root in s if abs(root.imag) < 1e-9 and root.real > 0) ** 2
    return 3 * np.pi * gamma * lam**2 / beta * (a**3 - 2 * a**1.5)


@pytest.mark.parametrize("delta", [-0.5, 0.0, 1.0, 6.0])
def test_published_is_the_paper_to_the_letter(delta):
    force = superpose(one_asperity(1 / 300, 1 / 100), delta=[delta], formulation="published").force.item()
    assert force == pytest.approx(published_by_hand(1 / 600, 1 / 200, delta), rel=1e-9)


def test_displacement_follows_the_sign_of_equation_35():
    """An asperity off the axis, and below the highest point, is reached later by S₀ and by its depth."""
    r = 100.0
    depth = 4.0
    z = one_asperity(1 / 200, 1 / 200, at=(r, 0.0))
    z["height"][0, 0] = z.height.max() + depth  # a spike at the edge sets the datum and is no peak
    late = depth + r**2 / (R + np.sqrt(R**2 - r**2))
    options = {"formulation": "published", "law": "hertz"}
    shifted = superpose(z, delta=np.array([3.0, 5.0]) + late, subregions=([0.0], [0.0]), **options).force.values
    centred = superpose(one_asperity(1 / 200, 1 / 200), delta=[3.0, 5.0], **options).force.values
    np.testing.assert_allclose(shifted, centred, rtol=1e-9)


def test_hertz_agrees_with_the_direct_simulation_of_one_asperity():
    asperity = one_asperity(1 / 200, 1 / 200)
    summed = superpose(asperity, delta=[2.0, 4.0], law="hertz").force
    solved = direct(asperity, delta=[2.0, 4.0]).force
    np.testing.assert_allclose(summed, solved, rtol=2e-2)  # a contact of 20–28 nm on 5 nm pixels


def test_zero_adhesion_is_hertz(surface):
    dry = surface.assign_coords(work_of_adhesion=0.0)
    for formulation in FORMULATIONS:
        options = {"delta": [5.0, 10.0], "formulation": formulation}
        catalogue = asperities(dry)
        without = {"delta": [5.0, 10.0], "formulation": "published" if formulation == "published" else "energy"}
        np.testing.assert_allclose(
            superpose(catalogue, **options).force, superpose(catalogue, law="hertz", **without).force
        )


def test_the_sum_is_over_all_asperities(surface):
    catalogue = asperities(surface)
    whole = superpose(catalogue, delta=[8.0], subregions=(2, 2)).force
    halves = [
        superpose(catalogue.isel(asperity=slice(k, None, 2)), delta=[8.0], subregions=(2, 2)).force for k in (0, 1)
    ]
    np.testing.assert_allclose(halves[0] + halves[1], whole, rtol=1e-12)


def test_scan_and_catalogue_give_the_same(surface):
    options = {"delta": [2.0, 8.0], "subregions": (2, 3)}
    np.testing.assert_array_equal(superpose(surface, **options).force, superpose(asperities(surface), **options).force)


def test_the_default_displacements_of_a_place_show_its_pull_off():
    height = rough(96, rms=1.5, seed=11)
    height[4:7, 4:7] += 100.0  # all displacements count from a far peak
    swept = superpose(glass_pair(scan(height)))
    pull_off = float(swept["pull_off_force"][0])
    force = swept["force"].isel(subregion=0)
    assert float(force.min()) == pytest.approx(-pull_off, rel=0.01)
    assert 0 < float(force.max()) < 100 * pull_off
    assert float(force[0]) == 0.0


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_default_displacements_contain_the_pull_off_of_every_place(surface, formulation):
    swept = superpose(surface, subregions=(6, 6), formulation=formulation)
    np.testing.assert_allclose(-swept.force.min("delta"), swept.pull_off_force, rtol=1e-9)
    tension = (swept.force < -0.05 * swept.pull_off_force).sum("delta")
    assert int(tension.min()) >= 6  # enough points to draw a curve


def test_large_contacts_are_counted():
    summed = superpose(asperities(one_asperity(1 / 400, 1 / 400), patch=5), delta=[0.01, 1.0], law="hertz")
    assert summed.contacts.values.tolist() == [[1, 1]]
    assert summed.contacts_beyond_patch.values.tolist() == [[0, 1]]  # a = √(δR') = 2 and 19 nm; the patch has 12.5 nm
    two = scan(np.maximum(*(one_asperity(1 / 100, 1 / 100, at=(x, 0.0)).height.values for x in (-20, 20))), pixel=5.0)
    summed = superpose(asperities(glass_pair(two), patch=5), delta=[3.0, 30.0], law="hertz")
    assert summed.contacts_overlapping.values.tolist() == [[0, 2]]  # a = 17 nm and 53 nm, 40 nm apart


def test_saddles_are_left_out_and_counted(surface):
    catalogue = asperities(surface)
    assert int(superpose(catalogue, delta=[5.0], formulation="published").excluded_asperities) == int(
        catalogue.saddle.sum()
    )


def test_adhesion_must_be_assigned(surface):
    with pytest.raises(ValueError, match="work_of_adhesion"):
        superpose(surface.drop_vars("work_of_adhesion"), delta=[1.0])


def with_contacts(count, *, apart, curvatures=(0.004, 0.004), orientation=0.0, along=0.0):
    """Return a catalogue of equal asperities of one height on a line, and its pair."""
    x = np.arange(count) * apart
    properties = {
        "height": 10.0,
        "curvature_min": curvatures[0],
        "curvature_max": curvatures[1],
        "orientation": orientation,
        "axis_ratio": 1.0,
        "fit_rms": 0.0,
    }
    ds = xr.Dataset({name: ("asperity", np.full(count, size)) for name, size in properties.items()})
    edges = {f"scan_{axis}_{end}": sign * 1e4 for axis in "xy" for end, sign in (("min", -1), ("max", 1))}
    places = {"x": ("asperity", x * np.cos(along)), "y": ("asperity", x * np.sin(along))}
    ds = ds.assign_coords(datum_height=10.0, patch_radius=5.0, **places, **edges)
    return glass_pair(ds, sphere_radius=1e6)


@pytest.mark.parametrize("law", ["hertz", "jkr"])
def test_contacts_overlap_where_their_radii_add_up_to_the_distance(law):
    """Two of R = 250 nm, 40 nm apart: neither reaches the other's middle when they meet, at a = 20 nm."""
    deltas = np.linspace(-1, 4, 501)
    single = with_contacts(1, apart=40.0)
    two = with_contacts(2, apart=40.0)
    middle = ([20.0], [0.0])
    radius = np.sqrt(superpose(single, delta=deltas, subregions=middle, law=law).contact_area / np.pi)
    overlapping = superpose(two, delta=deltas, subregions=middle, law=law).contacts_overlapping[0]
    expected = np.where(radius[0] > 20.0, 2, 0)
    assert set(expected.tolist()) == {0, 2}
    np.testing.assert_array_equal(overlapping, expected)


def test_ellipses_overlap_by_the_radii_that_face_each_other():
    """B/A = 9: end to end they meet long before side by side; any turn of all together changes nothing."""
    deltas = np.linspace(0.01, 6, 300)

    def begins(orientation, along):
        two = with_contacts(2, apart=40.0, curvatures=(0.002, 0.018), orientation=orientation, along=along)
        middle = ([20.0 * np.cos(along)], [20.0 * np.sin(along)])
        summed = superpose(two, delta=deltas, subregions=middle, law="hertz")
        overlapping = summed.contacts_overlapping[0] > 0
        return float(summed.delta[int(np.argmax(overlapping.values))]) if overlapping.any() else np.inf

    end_to_end = begins(0.0, 0.0)
    side_by_side = begins(np.pi / 2 - 1e-12, 0.0)
    assert end_to_end < 0.2 * side_by_side
    assert begins(0.7, 0.7) == pytest.approx(end_to_end, abs=0.03)


def test_lone_and_far_contacts_never_overlap():
    for catalogue in (with_contacts(1, apart=1.0), with_contacts(5, apart=500.0)):
        assert not superpose(catalogue, delta=[1.0, 5.0], law="hertz").contacts_overlapping.any()


def test_published_takes_the_papers_own_asperities(surface):
    paper_asperities = asperities(surface, patch="paper")
    options = {"delta": [2.0, 8.0], "subregions": (2, 2), "formulation": "published"}
    expected = superpose(paper_asperities, **options).force
    np.testing.assert_array_equal(superpose(surface, **options).force, expected)
    np.testing.assert_array_equal(superpose(surface.chunk(x=30), **options).compute().force, expected)


def test_the_papers_sum_without_adhesion_is_over_its_own_asperities(surface):
    options = {"delta": [2.0, 8.0], "subregions": (2, 2), "formulation": "published"}
    dry = surface.assign_coords(work_of_adhesion=0.0)  # the paper's law without adhesion is Hertz's
    expected = superpose(dry, **options).force
    force = superpose(surface, law="hertz", **options).force
    np.testing.assert_allclose(force, expected, rtol=1e-12)
    assert not np.allclose(force, superpose(asperities(surface), law="hertz", **options).force, rtol=1e-3)


def test_asperities_stay_elastic_with_a_warning(surface):
    options = {"delta": [2.0, 8.0], "subregions": (2, 2)}
    with pytest.warns(UserWarning, match="hardness: superposed asperities stay elastic"):
        hard = superpose(surface.assign_coords(hardness=1.0), **options)
    np.testing.assert_array_equal(hard.force, superpose(surface, **options).force)


def test_what_is_expected_is_said_of_means_and_of_single_places(surface):
    for ds in (superpose(surface, delta=[2.0, 8.0]), pull_off_map(surface, subregions=(2, 2))):
        sentence = superposition_notes({"solutions/energy": ds})[0]
        assert f"{expectation.LOW:g} … {expectation.HIGH:g} in 19 of 20 means over four places" in sentence
        assert "9 of 10 single places" in sentence


@pytest.mark.parametrize(
    ("change", "options", "why"),
    [
        (lambda ds: asperities(ds, patch=5), {}, "use asperities(patch='auto')"),
        (lambda ds: ds, {"law": "dugdale"}, "not for 'dugdale'"),
        (lambda ds: ds, {"formulation": "published"}, "not for 'published'"),
        (lambda ds: ds.isel(x=slice(None, None, 6), y=slice(None, None, 6)), {}, "too few to resolve its summits"),
    ],
)
def test_nothing_is_expected_where_nothing_was_measured(surface, change, options, why):
    summed = superpose(change(surface), delta=[2.0], **options)
    assert why in superposition_notes({"solutions/energy": summed})[0]


def test_more_than_the_smooth_sphere_is_never_given_without_a_word():
    ground = glass_pair(scan(rough(96, rms=0.8, smooth=1.2, seed=3)), sphere_radius=3000)
    catalogue = asperities(ground, patch=9)
    with pytest.warns(UserWarning, match="exceed that of the sphere on a smooth flat.*take asperities.patch='auto'"):
        superpose(catalogue, delta=np.arange(-2, 3, 0.1))
    with pytest.warns(UserWarning, match="exceed that of the sphere"):
        pull_off_map(catalogue, subregions=(2, 2))


def test_a_formulation_of_adhesion_is_refused_without_adhesion():
    with pytest.raises(ValueError, match="expected none with law='hertz'"):
        superpose(one_asperity(1 / 300, 1 / 100), delta=[5.0], law="hertz", formulation="self_similar")
