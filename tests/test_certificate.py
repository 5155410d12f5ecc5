"""The certificate tells by how much a solution misses its conditions, and no stagnation is called solved."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.kernels.adhesion import equilibrium as smooth_equilibrium
from roughxr.mechanics.kernels.adhesion import states as smooth_states
from roughxr.mechanics.kernels.adhesion.traction_laws import smooth_law
from roughxr.mechanics.kernels.halfspace import displacement_control, load_control, working_set

from . import half_space
from .contact_conditions import certificate_of_fields
from .surfaces import rough, scan, sphere_gap

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

PIXEL = 4.0
MODULUS = 40.0
WORK = 0.1
RANGE = 0.3


@pytest.fixture(scope="module")
def surface():
    pair = {"sphere_radius": 800.0, "contact_modulus": MODULUS, "work_of_adhesion": WORK, "adhesion_range": RANGE}
    return roughxr.assign_pair(scan(rough(64, rms=0.6, seed=2), pixel=PIXEL), **pair)


def rows(solution):
    """Return the violations by check, those of the fields included, and the checks that are not met."""
    certificate = certificate_of_fields(solution)
    return certificate.violation.to_series(), set(certificate.check.values[~certificate.met.values])


def displacement(pressure):
    """Return Love's displacement by a plain sum over all pairs of cells: none of the library's own operators."""
    x = np.arange(pressure.shape[0]) * PIXEL
    out = np.zeros_like(pressure)
    half = PIXEL / 2

    def corner(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    for i, j in np.argwhere(pressure != 0):
        a = (x - x[i])[:, None]
        b = (x - x[j])[None, :]
        whole = corner(a + half, b + half) - corner(a + half, b - half)
        whole += corner(a - half, b - half) - corner(a - half, b + half)
        out += pressure[i, j] * whole / (np.pi * MODULUS)
    return out


def separation(ds, solution):
    """Return the separation of the undeformed bodies, nm below the highest point, on the window of the first place."""
    x, y = np.meshgrid(solution.x, solution.y, indexing="ij")
    heights = ds.height.sel(
        x=solution.x + float(solution.subregion_x[0]), y=solution.y + float(solution.subregion_y[0]), method="nearest"
    )
    return float(ds.height.max()) - heights.values + 800.0 - np.sqrt(800.0**2 - x**2 - y**2)


def test_an_elastic_solution_is_as_good_as_direct_summation_says(surface):
    solution = roughxr.direct(surface, delta=[1.5], subregions=([0.0], [0.0]), fields=True)
    violation, lost = rows(solution)
    here = solution.isel(subregion=0, delta=0)
    gap = separation(surface, solution) - 1.5 + displacement(here.pressure.values)
    deepest = (1.5 - separation(surface, solution)).max()
    assert max(0.0, -gap.min()) / deepest == pytest.approx(violation["penetration"], abs=1e-10) and not lost
    product = (here.pressure * np.abs(gap)).sum() * PIXEL**2 / (here.force * deepest)
    assert float(product) == pytest.approx(violation["complementarity"], abs=1e-10)
    assert violation["penetration"] <= violation["residual"] * (1 + 1e-6) and violation["complementarity"] <= 1e-6


def test_an_adhesive_solution_is_in_equilibrium_by_direct_summation(surface):
    options = {"delta": [0.5, 2.0], "subregions": ([0.0], [0.0]), "law": "exponential", "mesh": 1, "fields": True}
    solution = roughxr.adhesive(surface, **options)
    violation, lost = rows(solution)
    assert lost == {"mesh"}  # one mesh states no error
    for branch in ("loading", "retraction"):
        state = solution.isel(subregion=0).sel(branch=branch, delta=2.0)
        pressure = state.pressure.values
        gap = separation(surface, solution) - 2.0 + displacement(pressure)
        pull = WORK / RANGE * np.exp(-np.maximum(gap, 0.0) / RANGE)
        touching = pressure + pull > 0.5 * gap * MODULUS / PIXEL
        largest = max(WORK / RANGE, 0.1 * pressure.max())
        near = gap < 8 * RANGE  # the law is cut further out
        missed = max(np.abs(gap[touching]).max() * MODULUS / PIXEL, np.abs(pressure + pull)[~touching & near].max())
        assert missed / largest <= 1.001e-5 and touching.any()
        assert missed / largest == pytest.approx(float(state.residual), rel=0.05, abs=1e-9)
        assert -gap.min() * MODULUS / PIXEL / np.abs(pressure).max() <= violation["penetration"] + 1e-10


def test_every_condition_that_is_broken_is_named(surface):
    surface = surface.assign_coords(hardness=1.0)
    solution = roughxr.direct(surface, delta=[1.5, 2.5], subregions=([0.0], [0.0]), fields=True)
    assert rows(solution)[1] == set() and float(solution.plastic_work.max()) > 0
    broken = {
        "penetration": {"gap": solution.gap - 1e-4},
        "complementarity": {"gap": np.abs(solution.gap) + 1e-4},
        "force_balance": {"force": solution.force * (1 + 1e-8)},
        "hardness": {"pressure": solution.pressure * (1 + 1e-8), "force": solution.force * (1 + 1e-8)},
        "truncated": {"truncated": solution.truncated | True},
        "unconverged": {"converged": solution.converged & False},
        "residual": {"residual": solution.residual + 1e-5},
    }
    for name, change in broken.items():
        violation, lost = rows(solution.assign(change))
        assert name in lost and violation.isnull().sum() == 0
    for name in ("gap", "pressure", "force", "residual"):  # what is not known is not kept
        assert rows(solution.assign({name: solution[name] * np.nan}))[1]


def tampered(solution):
    """Yield solutions whose sums agree, and which solve no contact."""
    more = {name: 1.5 * solution[name] for name in ("pressure", "force")}
    yield "elasticity", more
    yield "geometry", more | {"displacement": 1.5 * solution.displacement}
    yield "geometry", {"gap": solution.gap.where(~(solution.gap > 1e-3), solution.gap + 0.5)}


@pytest.mark.filterwarnings("ignore:.*cut off")
@pytest.mark.parametrize("law", ["direct", "exponential", "jkr", "dugdale", "lennard_jones"])
def test_a_solution_that_solves_nothing_is_refused(surface, law):
    at = {"delta": [1.5, 2.0], "subregions": ([0.0], [0.0]), "fields": True}
    if law == "direct":
        solution = roughxr.direct(surface, **at)
        allowed = set()
    else:
        surface = surface.assign_coords(adhesion_range=2.0)
        solution = roughxr.adhesive(surface, law=law, mesh=1, **at)
        allowed = {"mesh"}
    assert rows(solution)[1] <= allowed
    for name, change in tampered(solution):
        assert name in rows(solution.assign(change))[1]
        if law in ("exponential", "lennard_jones"):  # these pull across every gap
            assert name == "elasticity" or "traction" in rows(solution.assign(change).isel(delta=[1]))[1]


def test_a_load_is_carried_and_places_that_touch_nothing_break_nothing(surface):
    pressed = roughxr.direct(surface, load=[5.0, 50.0])
    assert rows(pressed)[1] == set() and "load" in rows(pressed)[0]
    assert "load" in rows(pressed.assign(force=pressed.force * 1.001))[1]
    untouched = roughxr.direct(surface, delta=[0.0, 1.0], datum="first_contact", fields=True)
    assert float(untouched.force[0, 0]) == 0 and rows(untouched)[1] == set()


def test_without_fields_and_without_deformation(surface):
    rigid = roughxr.rigid(surface, subregions=(2, 1), law="exponential")
    assert {"truncated", "mesh"} == set(rows(rigid)[0].index)
    settled = roughxr.adhesive(surface, law="exponential", mesh=roughxr.Mesh(accuracy=None))
    violation, lost = rows(settled)
    assert lost == {"mesh"} and 0 < violation["residual"] <= 1e-3
    with pytest.raises(ValueError, match="expected a solution of direct, adhesive, rigid"):
        roughxr.certificate(roughxr.superpose(surface, delta=[1.0]))


@pytest.mark.parametrize("cut", [{"max_iterations": 3}, {"tolerance": 0.0}])
def test_an_elastic_solve_that_stagnates_is_flagged_and_told_of(surface, monkeypatch, cut):
    for solve in (displacement_control.sweep_arrays, load_control.loaded_arrays):
        monkeypatch.setattr(solve, "__kwdefaults__", solve.__kwdefaults__ | cut)
    for asked in ({"delta": [1.5]}, {"load": [50.0]}):
        with pytest.warns(UserWarning, match="direct: 1 of 1 solutions have not converged"):
            solution = roughxr.direct(surface, subregions=([0.0], [0.0]), **asked)
        assert not solution.converged.any() and {"unconverged"} <= rows(solution)[1]


def test_numbers_that_are_none_do_not_pass_for_a_solution():
    """Every comparison with NaN is False: no violation would be found."""
    gap = sphere_gap(32, PIXEL)
    begin = working_set.Guess(np.full(gap.shape, np.nan), gap < 1, gap < 1)
    row = np.zeros(8)
    lost = working_set.solve_in_box(1.0 - gap, begin, 1e-6, 100, np.inf)
    displacement_control.describe(row, lost, 1.0 - gap, np.inf, np.inf)
    assert row[half_space.STATUS] != half_space.CONVERGED and np.isnan(row[displacement_control.RESIDUAL])
    law = smooth_law(exponential=(WORK * PIXEL / MODULUS, RANGE))
    solver = smooth_states.Solver(gap, law, np.inf, np.inf)
    nothing = solver.without_traction(1.0, np.zeros(gap.shape))
    spoiled = nothing._replace(state=nothing.state._replace(pressure=nothing.state.pressure * np.nan))
    assert solver.solve(1.0, nothing).converged and not solver.solve(1.0, spoiled).converged


@pytest.mark.parametrize(("rounds", "tolerance"), [(1, smooth_states.TOLERANCE), (20, 0.0)])
@pytest.mark.parametrize("asked", [{"delta": [2.0, 2.5]}, {"preload": 0.0}])
def test_an_adhesive_solve_that_stagnates_is_flagged_and_told_of(surface, monkeypatch, rounds, tolerance, asked):
    monkeypatch.setattr(smooth_equilibrium, "_MOST_ROUNDS", rounds)
    monkeypatch.setattr(smooth_states, "TOLERANCE", tolerance)
    monkeypatch.setattr(smooth_states, "INTERMEDIATE_TOLERANCE", 0.0)
    with pytest.warns(UserWarning, match=r"have not converged \(converged is False\)"):
        cycle = roughxr.adhesive(surface, law="exponential", mesh=1, subregions=([0.0], [0.0]), **asked)
    assert not cycle.converged.any() and np.isnan(cycle.pull_off_force).all()
    assert {"unconverged"} <= rows(cycle)[1]


def test_a_surface_that_does_not_give_way_enough_has_not_converged(surface, monkeypatch):
    hard = surface.assign_coords(hardness=1.0)
    good = roughxr.adhesive(hard, law="exponential", mesh=roughxr.Mesh(accuracy=None), preload=50.0)
    assert good.converged.all() and float(good.yielded_area.max()) > 0
    monkeypatch.setattr(smooth_states, "_MOST_DENTS", 0)
    with pytest.warns(UserWarning, match="have not converged"):
        stiff = roughxr.adhesive(hard, law="exponential", mesh=roughxr.Mesh(accuracy=None), preload=50.0)
    assert not stiff.converged.any() and "unconverged" in rows(stiff)[1]


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_pull_off_is_one_that_the_states_around_it_allow(surface, factor):
    options = {"subregions": ([0.0], [0.0]), "law": "exponential", "mesh": 2, "datum": "highest_peak"}
    near = float(roughxr.adhesive(surface, **options).pull_off_delta[0])
    solution = roughxr.adhesive(surface, delta=np.arange(near - 0.3, near + 1.0, 0.1), **options)
    violation, lost = rows(solution)
    assert violation["pull_off"] < 0.01 and "pull_off" not in lost
    violation, lost = rows(solution.assign(pull_off_force=factor * solution.pull_off_force))
    assert "pull_off" in lost and violation["pull_off"] > 0.3


def test_a_chunked_solution_has_the_same_certificate(surface):
    """Of each method, lazy as from an archive or in chunks of xarray's."""
    for solution in (
        roughxr.adhesive(surface, subregions=(2, 1), law="jkr", mesh=1),
        roughxr.direct(surface, delta=[1.5], subregions=(2, 1), fields=True),
    ):
        xr.testing.assert_identical(roughxr.certificate(solution.chunk(subregion=1)), roughxr.certificate(solution))
