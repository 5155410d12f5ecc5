"""Adhesion of what yields: the capped loading branch, the shape that it leaves, and what that does to the pull-off."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import ellipe, ellipk

from roughxr.mechanics.bodies.pair import assign_pair
from roughxr.mechanics.contact.adhesion import adhesive
from roughxr.mechanics.contact.cycle import edge_extrapolation
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.contact.mesh import Mesh
from roughxr.mechanics.kernels.adhesion import states as smooth_states
from roughxr.mechanics.kernels.adhesion import traction_laws as smooth_laws
from roughxr.mechanics.kernels.adhesion.path import follow_path
from roughxr.mechanics.kernels.halfspace import displacement_control
from roughxr.mechanics.kernels.halfspace.yielding import residual_heights

from .closed_forms import flattened_pull_off, punch_pull_off
from .surfaces import rough, scan

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

E = 39.4
W = 0.1


def pair(height, pixel=5.0, **options):
    body = {"sphere_radius": 500.0, "contact_modulus": E, "work_of_adhesion": W}
    return assign_pair(scan(height, pixel=pixel), **(body | options))


@pytest.fixture(scope="module")
def heights():
    return rough(64, smooth=1.2, seed=11)


LAWS = ("exponential", "jkr")


@pytest.fixture(scope="module", params=LAWS)
def cycle(heights, request):
    return adhesive(
        pair(heights, hardness=2.0), delta=[4, 6, 8.0], mesh=Mesh(1, step=0.2), fields=True, law=request.param
    )


def test_fields_meet_the_conditions(cycle):
    assert cycle.residual_height.dims == ("subregion", "delta", "x", "y")
    pressing = cycle.pressure.sel(branch="loading")
    assert float(cycle.pressure.max()) <= 2.0 * (1 + 2e-3)
    assert float(cycle.gap.min()) >= -1e-5
    dents = [cycle.residual_height.isel(delta=k) for k in range(3)]
    for k in range(3):
        before = dents[k - 1] if k else 0.0 * dents[0]
        newly = (dents[k] < before - 1e-3).values
        assert newly.any()
        assert (pressing.isel(delta=k).values[newly] >= 2.0 * (1 - 5e-3)).all()
    volume = -cycle.residual_height.sum(("x", "y")) * 25.0
    np.testing.assert_allclose(cycle.plastic_work.sel(branch="loading"), 2.0 * volume, rtol=1e-9)
    np.testing.assert_allclose(cycle.pressure.sum(("x", "y")) * 25.0, cycle.force, rtol=1e-6, atol=1e-3)


def test_the_energy_balance_holds_the_plastic_work(cycle, heights):
    """The loop's work is what yielded and what adhesion freed in jumps, some percent of it here."""
    lost = float(cycle.hysteresis[0])
    plastic = float(cycle.plastic_work[0, 0, -1])
    dissipated = float(cycle.dissipated.sel(branch="retraction")[0, 0])
    assert plastic > 1000.0
    assert lost == pytest.approx(plastic, rel=0.01) and dissipated == pytest.approx(plastic, rel=0.01)


@pytest.mark.parametrize("law", [*LAWS, "dugdale"])
def test_weak_adhesion_loads_as_the_direct_simulation(heights, law):
    """With a thousandth of the work of adhesion both branches are those of `direct`, another solver's."""
    weak = adhesive(
        pair(heights, hardness=2.0, work_of_adhesion=1e-4),
        delta=[4, 6, 8.0],
        mesh=Mesh(1, step=0.5),
        fields=True,
        law=law,
    )
    bare = direct(pair(heights, hardness=2.0), delta=[4, 6, 8.0], fields=True)
    np.testing.assert_allclose(weak.force, bare.force, rtol=2e-3, atol=0.5)
    np.testing.assert_allclose(weak.plastic_work, bare.plastic_work, rtol=5e-3)
    np.testing.assert_allclose(weak.yielded_fraction.sel(branch="loading"), bare.yielded_fraction[:, 0], atol=0.02)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
@pytest.mark.parametrize("law", LAWS)
def test_a_hardness_that_is_never_reached_changes_nothing(heights, law):
    elastic, hard = (
        adhesive(pair(heights, hardness=hardness), delta=[2, 4.0], mesh=1, law=law) for hardness in (None, 500.0)
    )
    np.testing.assert_array_equal(hard.force, elastic.force)
    assert (hard.plastic_work == 0).all() and (hard.yielded_area == 0).all()


@pytest.mark.filterwarnings("ignore:.*have a range")
@pytest.mark.parametrize("law", LAWS)
def test_flattened_asperities_stick_harder_the_harder_they_were_pressed(heights, law):
    loads = [0, 100.0, 1000.0, 5000.0]
    bodies = pair(heights, hardness=2.0)
    elastic, hard = (
        adhesive(body, preload=loads, mesh=Mesh(1, step=0.2), law=law)
        for body in (bodies.rename(hardness="hardness_estimate"), bodies)
    )
    assert (elastic.pull_off_force.max() < 16.0).all() and elastic.yielded_fraction.dims == ("subregion", "preload")
    assert elastic.yielded_fraction[0, 0] == 0 and elastic.yielded_fraction[0, -1] > 0.9
    assert (np.diff(hard.pull_off_force[0]) > 0).all()
    assert float(hard.pull_off_force[0, -1]) > 10 * float(elastic.pull_off_force[0, -1])


@pytest.mark.filterwarnings("ignore:.*have a range")
@pytest.mark.parametrize("law", LAWS)
def test_shakedown(heights, law):
    """The second cycle finds the shape that bears its preload: it yields no more and pulls off alike."""
    cycles = adhesive(pair(heights, hardness=2.0), preload=[100.0, 5000.0], mesh=Mesh(1, step=0.1), cycles=2, law=law)
    assert cycles.pull_off_force.dims == ("subregion", "cycle", "preload")
    work = cycles.plastic_work[0]
    assert (work.sel(cycle=1) > 20).all()
    np.testing.assert_allclose(work.sel(cycle=2), work.sel(cycle=1), rtol=5e-3)
    assert (cycles.hysteresis[0].sel(cycle=2) < 0.2 * cycles.hysteresis[0].sel(cycle=1)).all()
    np.testing.assert_allclose(cycles.pull_off_force[0].sel(cycle=2), cycles.pull_off_force[0].sel(cycle=1), rtol=0.02)


@pytest.mark.parametrize("deep", [10.0, 20.0])
def test_a_sphere_that_yields_pulls_as_its_flattened_curvature_says(deep):
    """Under uniform pressure H a disc of radius a recovers by curvature H/(E* a): a sphere of E* a/H, drawn off.

    As the law's range is not short beside that shape the pull lies between JKR's 3/2 and Bradley's 2 times π w R.
    """
    H = 6.0
    radius = 100.0
    dx = 2.0
    x = (np.arange(65) - 32) * dx
    separation = (x[:, None] ** 2 + x**2) / (2 * radius)
    law = smooth_laws.smooth_law(exponential=(0.05 * dx / E, 0.3))
    options = {"cap": H * dx / E, "limit": H * dx / E}
    (path,) = follow_path(separation, np.array([deep]), 0.2, law, **options)
    pull = -path.states["force"].min() * E * dx
    contact = path.states["contact_area"][path.first_retraction - 1] * dx**2
    flattened = E * np.sqrt(contact / np.pi) / H
    assert flattened > 1.2 * radius
    assert 1.3 * np.pi * 0.05 * flattened < pull < 2.0 * np.pi * 0.05 * flattened


@pytest.mark.parametrize("step", [2.0, 0.3])
def test_what_gave_way_while_the_contact_was_small_is_taken_back(step, monkeypatch):
    """Steps that multiply the contact leave what the adhesionless solver finds at once."""
    monkeypatch.setattr(smooth_states, "TOLERANCE", 1e-7)
    x = np.arange(41) - 20.0
    separation = (x[:, None] ** 2 + x**2) / 60.0
    deltas = np.array([2.0])
    w = 1e-5
    law = smooth_laws.without_range(w, 0.25)
    (path,) = follow_path(separation, deltas, step, law, cap=0.05, limit=0.05)
    limits = {"hardness": displacement_control.Hardness(0.05), "tolerance": 1e-10, "keep": 1}
    records, *fields = displacement_control.sweep_arrays(separation, deltas, 1.0, 1.0, **limits)
    residual = residual_heights(*fields, separation, deltas, 0.05)[0]
    np.testing.assert_allclose(path.residual_heights[-1], residual, atol=1e-6 * np.ptp(residual))
    assert path.states["force"][path.first_retraction - 1] == pytest.approx(
        records[0, displacement_control.FORCE], rel=1e-6
    )


#: Radius of a flat punch, nm.
PUNCH = 10.0


def punch(cells):
    """Return separation and cell (nm) of a flat disc: the cells whose middles lie on it have its area."""
    x = np.arange(-cells - 3, cells + 4)
    disc = np.hypot(x[:, None], x) <= cells
    return np.where(disc, 0.0, np.inf), PUNCH / np.sqrt(disc.sum() / np.pi)


def exponential_pull(cells, length):
    """Return a flat punch's pull-off force (nN) under the law that yielding bodies take."""
    separation, dx = punch(cells)
    law = smooth_laws.smooth_law(exponential=(W * dx / E, length))
    (path,) = follow_path(separation, np.array([0.2]), 0.02, law)
    return -path.states["force"].min() * E * dx


def edged_pull(separation, dx, law_of, delta=0.2):
    """Return a pull-off force (nN) by edges as steep as the mesh bears, and half as steep, by ``law_of(w, fall)``."""
    pulls = []
    for fall in (0.25, 0.125):
        law = law_of(W * dx / E, fall)
        (path,) = follow_path(separation, np.array([delta]), 0.02, law)
        pulls.append(-path.states["force"].min() * E * dx)
    return pulls


def pull_of_rings(length, count=40):
    """Return the same from rings of uniform traction on a half space: another discretisation, and another minimiser.

    A disc of radius b under unit pressure sinks by 4b/(πE*) E(r/b) within, and beyond by
    4r/(πE*) [E(b/r) − (1 − b²/r²) K(b/r)].
    """
    edges = PUNCH * np.sin(np.linspace(0, np.pi / 2, count + 1))
    middle = 0.5 * (edges[1:] + edges[:-1])[:, None]
    area = np.pi * np.diff(edges**2)
    inner = np.minimum(middle / np.maximum(edges, 1e-9), 1) ** 2
    outer = np.minimum(edges / middle, 1) ** 2
    beyond = middle * (ellipe(outer) - (1 - outer) * ellipk(np.minimum(outer, 1 - 1e-15)))
    sinks = np.where(middle < edges, edges * ellipe(inner), beyond) * 4 / (np.pi * E)
    stiffness = area[:, None] * np.linalg.inv(np.diff(sinks, axis=1))
    stiffness = 0.5 * (stiffness + stiffness.T)

    def energy(gap, raised):
        held = stiffness @ (raised - gap)
        attraction = area * W * np.exp(-gap / length)
        return 0.5 * (raised - gap) @ held - attraction.sum(), attraction / length - held

    gap = np.zeros(count)
    pulls = [0.0]
    for raised in np.arange(0.005, 2.0, 0.005):
        options = {"ftol": 1e-14, "gtol": 1e-9, "maxiter": 5000}
        bounds = [(0, None)] * count
        gap = minimize(energy, gap, (raised,), jac=True, method="L-BFGS-B", bounds=bounds, options=options).x
        pulls.append((stiffness @ (raised - gap)).sum())
        if pulls[-1] < 0.7 * max(pulls):
            break
    return max(pulls)


@pytest.mark.parametrize("length", [0.3, 0.1, 0.05])
def test_a_flat_punch_of_ten_cells_pulls_as_rings_of_the_same_law_do(length):
    """Within half a percent, and two where less than one cell spans the law's zone at the edge (0.05 nm)."""
    griffith = punch_pull_off(radius=PUNCH, contact_modulus=E, work_of_adhesion=W)
    rings = pull_of_rings(length)
    assert exponential_pull(10, length) == pytest.approx(rings, rel=0.02 if length < 0.1 else 0.005)
    assert rings < 0.85 * griffith


def test_its_pull_grows_to_griffith_s_as_the_law_s_range_shrinks():
    griffith = punch_pull_off(radius=PUNCH, contact_modulus=E, work_of_adhesion=W)
    wanting = [1 - exponential_pull(20, length) / griffith for length in (0.2, 0.1, 0.05)]
    assert 0.0 < wanting[2] < 0.6 * wanting[1] < 0.6 * 0.7 * wanting[0]


def test_without_range_a_flat_punch_wants_what_its_edge_gives():
    """25 % at ten and 16 % at twenty cells, for beyond its edge nothing could pull: the stated error covers it."""
    griffith = punch_pull_off(radius=PUNCH, contact_modulus=E, work_of_adhesion=W)
    pulls = np.array([edged_pull(*punch(cells), smooth_laws.without_range) for cells in (10, 20)]) / griffith
    ten, twenty = pulls[:, 0]
    assert 0.5 < (1 - twenty) / (1 - ten) < 0.71  # it falls as the root of the cell
    for pull, wide in pulls:
        assert abs(pull - 1) < edge_extrapolation("jkr", 10.0, 1 - wide / pull).error


@pytest.mark.parametrize(("strength", "cells", "within"), [(0.5, (5, 10), 1e-6), (1.0, (10, 20), 0.03)])
def test_dugdale_s_law_on_a_flat_punch_is_the_closed_form(strength, cells, within):
    """The whole punch pulls at 0.5 GPa; at 1 GPa a zone of 3 nm does, and is spread over more by the mesh."""
    flat = {"radius": PUNCH, "contact_modulus": E, "work_of_adhesion": W}
    expected = punch_pull_off(adhesion_range=W / strength, **flat)
    edge = lambda w, fall: smooth_laws.dugdale(w, W / strength, fall)  # noqa: E731
    coarse, fine = (pull + 0.5 * (pull - wide) for pull, wide in (edged_pull(*punch(n), edge) for n in cells))
    assert fine == pytest.approx(expected, rel=within)
    assert abs(fine - expected) < 0.5 * abs(coarse - expected) + 1e-5 * expected


def test_the_closed_form_of_a_flat_punch_has_both_limits():
    flat = {"radius": PUNCH, "contact_modulus": E, "work_of_adhesion": W}
    griffith = punch_pull_off(**flat)
    assert griffith == pytest.approx(314.7, abs=0.05)
    assert punch_pull_off(adhesion_range=W / 1e3, **flat) == pytest.approx(griffith, rel=1e-6)
    assert punch_pull_off(adhesion_range=W / 0.01, **flat) == pytest.approx(np.pi * PUNCH**2 * 0.01)
    forces = [punch_pull_off(adhesion_range=W / strength, **flat) for strength in np.geomspace(0.1, 100, 40)]
    assert (np.diff(forces) > 0).all() and max(forces) < griffith


def flattened(hard, cells=10):
    """Return the separation that a paraboloid was left with, its displacement, cell and contact's radius, nm.

    ``hard`` is H over √(w E*/a); the sphere is so small that all of its contact, of ``cells`` in radius, bears H.
    """
    H = hard * np.sqrt(W * E / PUNCH)
    dx = PUNCH / cells
    radius = min(6 * PUNCH, 0.05 * E * PUNCH / H)
    delta = PUNCH**2 / (2 * radius) + 4 * H * PUNCH / (np.pi * E)
    half = int(np.sqrt(2 * radius * delta) / dx) + 4
    x = np.arange(-half, half + 1) * dx
    separation = (x[:, None] ** 2 + x**2) / (2 * radius)
    deltas = np.array([delta])
    limits = {"hardness": displacement_control.Hardness(H), "tolerance": 1e-9, "keep": 1}
    records, pressure, sinks = displacement_control.sweep_arrays(separation, deltas, dx, E, **limits)
    assert records[0, displacement_control.FORCE] > 0.98 * H * records[0, displacement_control.AREA]
    residual = residual_heights(pressure, sinks, separation, deltas, H)[0]
    return separation - residual, delta, dx, np.sqrt(records[0, displacement_control.AREA] / np.pi)


@pytest.mark.parametrize("hard", [1.0, 3.0])
def test_an_asperity_pressed_flat_pulls_as_its_closed_form(hard):
    """At twenty cells within 0.5 % where it recovers to nearly a punch, and is not extrapolated, else within 2 %."""
    separation, delta, dx, radius = flattened(hard, cells=20)
    H = hard * np.sqrt(W * E / PUNCH)
    pull, wide = edged_pull(separation, dx, smooth_laws.without_range, delta)
    expected = flattened_pull_off(radius=radius, contact_modulus=E, work_of_adhesion=W, hardness=H)
    assert (pull > wide) == (hard == 1.0)
    to_edge = edge_extrapolation("jkr", 20.0, 1 - wide / pull)
    result = to_edge.apply(pull, wide)
    stated = to_edge.error * pull if pull > wide else pull - result
    assert result == pytest.approx(expected, abs=stated, rel=0)
    assert result == pytest.approx(expected, rel={1.0: 0.005, 3.0: 0.02}[hard])


def test_the_closed_form_of_a_flattened_asperity_leads_from_a_punch_to_jkr():
    flat = {"radius": PUNCH, "contact_modulus": E, "work_of_adhesion": W}
    punch = punch_pull_off(**flat)
    unit = np.sqrt(W * E / PUNCH)
    pull_offs = np.array(
        [flattened_pull_off(hardness=hard * unit, **flat) for hard in (1e-4, 0.03, 0.5, 2.0, 100.0, 1e4)]
    )
    assert (np.diff(pull_offs) < 0).all()
    assert pull_offs[0] == pytest.approx(punch, rel=1e-4) and 0.98 * punch < pull_offs[1] < 0.99 * punch
    jkr = [1.5 * np.pi * W * E * PUNCH / (hard * unit) for hard in (100.0, 1e4)]
    assert pull_offs[4] == pytest.approx(jkr[0], rel=2e-3) and pull_offs[5] == pytest.approx(jkr[1], rel=1e-5)


def test_a_flattened_asperity_is_made_of_punches():
    """Its largest pull is that of a contact held together by punches: P = 2E* ∫ (δ − g) da, δ − g(a) = −√(2πaw/E*)."""
    H = 0.5
    parts = np.linspace(0.5, 0.95, 4001)
    a = parts * PUNCH
    shape = 2 * H / E * (PUNCH - np.sqrt(PUNCH**2 - a**2))  # of the contact, as punches add up to it
    delta = shape - np.sqrt(2 * np.pi * a * W / E)
    force = 2 * H * PUNCH**2 * (np.arcsin(parts) - parts * np.sqrt(1 - parts**2)) - np.sqrt(8 * np.pi * W * E * a**3)
    slope = np.gradient(force, a) - 2 * E * a * np.gradient(delta, a)  # of the force at fixed displacement
    expected = -2 * E * np.sqrt(2 * np.pi * a * W / E)
    np.testing.assert_allclose(slope[5:-5], expected[5:-5], rtol=1e-4)
    flat = {"radius": PUNCH, "contact_modulus": E, "work_of_adhesion": W}
    assert -force.min() == pytest.approx(flattened_pull_off(hardness=H, **flat), rel=1e-6)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
@pytest.mark.parametrize(
    ("assigned", "options", "says"),
    [
        ({"hardness": 0.3}, {"law": "dugdale"}, "hardness: expected more than the adhesive traction, 0.333 GPa"),
        ({"hardness": 2.0, "work_of_adhesion": 0}, {}, "work_of_adhesion: expected more than 0 for bodies that yield"),
        ({"hardness": 2.0}, {"cycles": 0}, "cycles: expected a whole number of at least 1"),
        ({"hardness": 2.0}, {"cycles": 2, "delta": [1.0]}, r"cycles: expected one with displacements \(delta\)"),
    ],
)
def test_what_does_not_go_together_is_refused(heights, assigned, options, says):
    with pytest.raises(ValueError, match=says):
        adhesive(pair(heights, **assigned), **options)
