"""Superposition between JKR and DMT: both limits, published pull-off, Maugis's equations solved here anew."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

from roughxr.mechanics.asperity.catalogue import asperities
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.estimates import tabor
from roughxr.mechanics.kernels.asperity import branches, maugis
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio
from roughxr.mechanics.kernels.asperity.elliptic_table import mark_at_row
from roughxr.mechanics.kernels.asperity.pull_off_search import _TABLE_ERROR
from roughxr.statistics import pull_off

from .surfaces import glass_pair, rough, scan
from .test_superposition import E, W, one_asperity

RADIUS = 1 / (1 / 200 + 1 / 3000)
PARAMETERS = np.geomspace(maugis.SMALLEST, maugis.LARGEST, 60)


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(128, rms=1.5, seed=11)))


def distance_of(parameter):
    """Return z₀ (nm) at which a cap of 200 nm under the sphere has Maugis's λ."""
    return (RADIUS * W**2 / E**2) ** (1 / 3) / (parameter / 1.157)


def reaching(ds, length):
    """Return a pair whose adhesion has a range (nm)."""
    return ds.assign_coords(adhesion_range=length)


def a_line(parameter):
    line = np.empty(branches.LENGTH)
    branches.collapse(maugis.table().spline, maugis.table_row(parameter), branches.P, line)
    return line


@pytest.mark.parametrize("parameter, pull", [(0.1, 1.95059), (0.5, 1.71825), (1, 1.60073), (2, 1.53460), (5, 1.50635)])
def test_one_sphere_pulls_off_as_published(parameter, pull):
    mapped = pull_off_map(
        reaching(one_asperity(1 / 200, 1 / 200), distance_of(parameter)), subregions=(1, 1), law="dugdale"
    )
    assert mapped.pull_off_force.item() == pytest.approx(pull * np.pi * W * RADIUS, rel=1e-5)


@pytest.mark.parametrize("shape", [(1 / 200, 1 / 200), (1 / 400, 1 / 150)])
def test_short_range_is_jkr(shape):
    asperity = one_asperity(*shape)
    deltas = np.arange(-0.8, 4, 0.05)
    close = superpose(reaching(asperity, 1e-3), delta=deltas, law="dugdale").force
    limit = superpose(asperity, delta=deltas, formulation="self_similar").force
    np.testing.assert_allclose(close, limit, atol=1e-3 * 1.5 * np.pi * W * RADIUS)


def test_long_range_is_dmt():
    """Lets go at 2πwR with a contact that has shrunk to a point; loaded, Hertz's load on that contact less 2πwR."""
    asperity = reaching(one_asperity(1 / 200, 1 / 200), distance_of(0.02))
    far = {"law": "dugdale"}
    dmt = 2 * np.pi * W * RADIUS
    mapped = pull_off_map(asperity, subregions=(1, 1), **far)
    assert mapped.pull_off_force.item() == pytest.approx(dmt, rel=3e-3)
    at_pull_off = superpose(asperity, delta=mapped.pull_off_delta.values, **far)
    assert at_pull_off.contact_area.item() < 0.01 * np.pi * (9 * np.pi * W * RADIUS**2 / (8 * E)) ** (2 / 3)
    loaded = superpose(asperity, delta=[0.0, 0.5, 1.0], **far)
    radius = np.sqrt(loaded.contact_area / np.pi)
    np.testing.assert_allclose(loaded.force, 4 * E * radius**3 / (3 * RADIUS) - dmt, atol=0.06 * dmt)


@pytest.mark.parametrize("ratio, part", [(1.5, 0.99773), (5, 0.96796), (10, 0.94088)])
def test_an_ellipse_is_as_far_from_its_equivalent_sphere_as_self_similar_jkr(ratio, part):
    """The rigid paraboloid's pull is 2πwR at any B/A (Derjaguin): what Hertz's shape misses of it at long range."""
    # with the sphere's own curvature
    sharp = 1 / 150
    flat = 1 / (150 * ratio)
    asperity = one_asperity(flat - 1 / 3000, sharp - 1 / 3000)
    R = 1 / np.sqrt(sharp * flat)
    far = (R * W**2 / E**2) ** (1 / 3) / (0.02 / 1.157)
    mapped = pull_off_map(reaching(asperity, far), subregions=(1, 1), law="dugdale")
    assert mapped.pull_off_force.item() / (2 * np.pi * W * R) == pytest.approx(part, rel=3e-3)


def test_beyond_the_table_it_stays_at_its_ends():
    asperity = one_asperity(1 / 200, 1 / 200)

    def force(parameter):
        return superpose(reaching(asperity, distance_of(parameter)), delta=[-0.1, 0.5, 3.0], law="dugdale").force

    for end, beyond in ((maugis.SMALLEST, maugis.SMALLEST / 100), (maugis.LARGEST, maugis.LARGEST * 100)):
        np.testing.assert_allclose(force(end), force(beyond), rtol=1e-9)


def gap_where_the_pull_ends(a, c, R, traction):
    """Return the gap at r = c of a sphere in contact up to a, pulled by the traction from a to c (K = 1, E* = 3/4)."""
    s = np.sqrt(c**2 - a**2)
    angle = np.arccos(a / c)
    return (a * s + (c**2 - 2 * a**2) * angle) / (np.pi * R) + 16 * traction / (3 * np.pi) * (s * angle - c + a)


def sphere_by_hand(a, R, w, traction):
    """Return load and displacement at contact radius a: the pull ends where the gap is w over the traction."""
    c = brentq(lambda c: gap_where_the_pull_ends(a, c, R, traction) * traction - w, a, a + 1e3, xtol=1e-14)
    s = np.sqrt(c**2 - a**2)
    angle = np.arccos(a / c)
    return a**3 / R - 2 * traction * (c**2 * angle + a * s), a**2 / R - 8 / 3 * traction * s


def load_by_hand(A, B, delta, z0):
    """Solve Maugis's equations for the load at δ, nN; 0 where nothing is held.

    On a sphere of the same λ with R = w = K = 1; an ellipse has the sphere's law in units of its own JKR P_c and δ_c.
    """
    lam = axis_ratio(B / A)
    traction = 0.5 * np.pi ** (1 / 3) * 1.157 * (W**2 / (2 * np.sqrt(A * B) * E**2 * z0**3)) ** (1 / 3)
    beta = A + lam**2 * B
    a_c = (9 * W * lam * ellipk(1 - lam**2) / (4 * beta**2 * E)) ** (1 / 3)
    unit = np.array([1.5 * np.pi, (1.5 * np.pi) ** (2 / 3)])  # the sphere's P_c and δ_c
    depth = delta / (beta * a_c**2) * unit[1]
    radii = np.geomspace(1e-4, 30, 400)
    depths = np.array([sphere_by_hand(a, 1, 1, traction)[1] for a in radii])
    end = int(depths.argmin())
    if depth < depths[end]:
        return 0.0
    a = brentq(lambda a: sphere_by_hand(a, 1, 1, traction)[1] - depth, radii[end], radii[-1], xtol=1e-14)
    return 1.5 * np.pi * W * lam / beta * sphere_by_hand(a, 1, 1, traction)[0] / unit[0]


@pytest.mark.parametrize("z0", [0.3, 1.2])
def test_the_sum_is_that_of_the_equations_solved_directly(surface, z0):
    """On many elliptic asperities, in JKR-like and in DMT-like contact."""
    catalogue = reaching(asperities(surface), z0)
    deltas = np.array([0.5, 2.0, 4.0])
    summed = superpose(catalogue, delta=deltas, subregions=([0.0], [0.0]), law="dugdale")
    r2 = (catalogue.x**2 + catalogue.y**2).values
    touch = float(catalogue.datum_height) - catalogue.height.values + r2 / (3000 + np.sqrt(3000**2 - r2))
    A, B = (0.5 * catalogue[name].values + 0.5 / 3000 for name in ("curvature_min", "curvature_max"))
    peaks = np.flatnonzero(A > 0)
    for delta, force in zip(deltas, summed.force.values[0]):
        loads = [load_by_hand(A[i], B[i], delta - touch[i], z0) for i in peaks if delta - touch[i] > -3]
        assert force == pytest.approx(sum(loads), abs=3e-4 * np.abs(loads).sum())


def test_every_branch_is_convex_and_begins_with_a_pull():
    """On this the proof of the exact pull-off rests: to a millionth of P_c."""
    q = np.concatenate([np.geomspace(1e-5, 1e-2, 200)[:-1], np.linspace(1e-2, 8, 2001)])
    for parameter in PARAMETERS:
        line = a_line(parameter)
        force = np.array([branches.line_force(line, at)[0] for at in q**2])
        assert force[0] < -0.5
        hull = [0]
        for k in range(1, q.size):  # the lower convex hull, from left to right
            while len(hull) > 1:
                i, j = hull[-2:]
                if (force[j] - force[i]) * (q[k] ** 2 - q[i] ** 2) < (force[k] - force[i]) * (q[j] ** 2 - q[i] ** 2):
                    break
                hull.pop()
            hull.append(k)
        assert (force - np.interp(q**2, q[hull] ** 2, force[hull])).max() < 1e-6


def test_no_branch_falls_below_its_mark():
    for parameter in PARAMETERS:
        line = a_line(parameter)
        least = min(branches.line_force(line, at)[0] for at in np.linspace(1e-5, 1.5, 3001) ** 2)
        assert least >= mark_at_row(maugis.table().marks, maugis.table_row(parameter), 1) * (1 + _TABLE_ERROR)


@pytest.mark.parametrize("work, z0", [(1.35, 0.3), (1.35, 1.5), (0.1, 0.3), (0.1, 1.0), (0.02, 3.0)])
def test_no_fine_sweep_finds_a_larger_pull(surface, work, z0):
    """From λ = 3 to beyond the table's end; at the displacement found `superpose` gives that very force."""
    sticky = reaching(surface.assign_coords(work_of_adhesion=work), z0)
    options = {"law": "dugdale"}
    rng = np.random.default_rng(0)
    places = rng.uniform(float(surface.x[0]), float(surface.x[-1]), (2, 6))
    mapped = pull_off_map(sticky, subregions=tuple(places), **options)
    swept = pull_off(superpose(sticky, delta=np.arange(-4, 20, 0.002), subregions=tuple(places), **options))
    assert (mapped.pull_off_force >= swept.pull_off_force * (1 - 1e-6)).all()
    assert (mapped.pull_off_force < swept.pull_off_force * 1.02).all()
    for k in range(places.shape[1]):
        summed = superpose(sticky, delta=[mapped.pull_off_delta.item(k)], subregions=tuple(places[:, [k]]), **options)
        assert -summed.force.item() == pytest.approx(mapped.pull_off_force.item(k), rel=1e-10)
        assert summed.contacts.item() == mapped.contacts.item(k)


def test_without_adhesion_it_is_hertz(surface):
    dry = surface.assign_coords(work_of_adhesion=0.0)
    np.testing.assert_array_equal(
        superpose(dry, delta=[5.0], law="dugdale").force, superpose(dry, delta=[5.0], law="hertz").force
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"law": "dugdale", "formulation": "published"}, "expected none with law='dugdale', found 'published'"),
        ({"law": "dmt"}, "law: expected one of 'jkr', 'dugdale', 'hertz'"),
        ({"law": "energy"}, "law: expected one of 'jkr', 'dugdale', 'hertz', found 'energy'"),
        ({"formulation": "dugdale"}, "formulation: expected one of 'published', .* found 'dugdale'"),
    ],
)
def test_bad_options_are_refused_in_words(surface, options, says):
    with pytest.raises(ValueError, match=says):
        superpose(surface, delta=[1.0], **options)


def test_a_map_needs_a_law_that_adheres(surface):
    with pytest.raises(ValueError, match="law: expected one of 'jkr', 'dugdale', found 'hertz'"):
        pull_off_map(surface, law="hertz")


def test_the_range_matters_where_tabor_says_so(surface):
    """Asperities of λ above 3 pull off as without range, to a few percent."""
    catalogue = tabor(asperities(surface))
    assert float(catalogue.tabor_parameter.min()) > 2
    ranged = pull_off_map(catalogue, subregions=(3, 3), law="dugdale").pull_off_force
    limit = superpose(catalogue, delta=[0.0], subregions=(3, 3), formulation="self_similar").pull_off_force
    np.testing.assert_allclose(ranged, limit, rtol=0.05)
    far = pull_off_map(reaching(catalogue, 3.0), subregions=(3, 3), law="dugdale").pull_off_force
    assert (far > 1.1 * limit).all()
