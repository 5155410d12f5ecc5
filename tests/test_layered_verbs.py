"""What the verbs make of a layer: read, or refused with the reason."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import Layer, report
from roughxr.application.report.report_page import methods, pair_facts
from roughxr.mechanics.asperity.catalogue import DoubtfulAsperities
from roughxr.mechanics.bodies.layer import film_of, stiffened
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.studies.assumptions import pair_factors

from . import bonded_layer
from .contact_conditions import certificate_of_fields
from .surfaces import unpressed

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

#: Glass pressed on silica on silicon: of two bodies the scan's is the second.
OXIDE = {"sphere_radius": 500, "materials": "glass/silicon", "layer": Layer("20 nm", "silica")}


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with unpressed():
        yield


@pytest.fixture(scope="module")
def scan():
    return self_affine((48, 48), 4.0, rms=1.0, hurst=0.8, rolloff=100, cutoff=24, seed=3)


def _flat(cells=96, pixel=4.0):
    axis = pixel * np.arange(cells)
    flat = xr.Dataset({"height": (("x", "y"), np.zeros((cells, cells)))}, {"x": axis, "y": axis})
    for name in flat.variables:
        flat[name].attrs["units"] = "nm"
    return flat


def test_a_layer_is_assigned_in_any_units_and_travels(scan, tmp_path):
    ds = scan.contact.assign_pair(**OXIDE)
    assert float(ds.layer_thickness) == 20 and ds.layer_thickness.units == "nm"
    assert (float(ds.layer_modulus), float(ds.base_modulus)) == (73.0, 130.0)
    assert float(ds.contact_modulus) == pytest.approx(
        roughxr.mechanics.bodies.pair.contact_modulus((75, 73), (0.22, 0.17))
    )
    silica = scan.contact.assign_pair(sphere_radius=500, materials="glass/silica")  # what touches
    assert float(ds.work_of_adhesion) == float(silica.work_of_adhesion)
    assert float(ds.hardness_estimate) == float(silica.hardness_estimate)
    solved = ds.contact.direct(load=[100.0])
    solved.to_netcdf(tmp_path / "solved.nc")
    with xr.open_dataset(tmp_path / "solved.nc") as read:
        assert film_of(read) == film_of(ds)
    (last,) = [step["arguments"] for step in roughxr.schema.history(solved) if step["operation"] == "assign_pair"]
    assert last["layer.thickness"] == "20 nm" and last["layer.material"] == "silica"
    again = solved.contact.assign_pair(sphere_radius=500, materials="glass/silicon")
    assert "layer_thickness" not in again.coords


def test_a_rigid_base_and_indenter(scan, tmp_path):
    rubber = Layer(30, young_modulus="2 MPa", poisson_ratio=0.5)
    pair = {"sphere_radius": 500, "young_modulus": (np.inf, np.inf), "poisson_ratio": 0.3, "work_of_adhesion": 0.05}
    ds = scan.contact.assign_pair(**pair, layer=rubber)
    assert film_of(ds).share == pytest.approx(1.0) and film_of(ds).mismatch == 0
    ds.to_netcdf(tmp_path / "rigid.nc")
    with xr.open_dataset(tmp_path / "rigid.nc") as read:
        assert film_of(read) == film_of(ds)
    with pytest.raises(ValueError, match="found two rigid ones"):
        scan.contact.assign_pair(**pair)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"contact_modulus": 40}, "found their contact_modulus; give young_modulus"),
        ({"young_modulus": 40}, "found no poisson_ratio"),
        ({"young_modulus": (75, 0.01), "poisson_ratio": 0.3}, "at most 1000 times the modulus of its base"),
        ({"materials": "glass/silicon", "layer": Layer(20)}, "expected one of material, young_modulus"),
        (
            {"materials": "glass/silicon", "layer": Layer(20, young_modulus=1)},
            "of material, poisson_ratio",
        ),
        ({"materials": "glass/silicon", "layer": Layer(-1, "silica")}, "layer_thickness"),
        ({"materials": "glass/silicon", "layer": Layer(20, "quartz")}, "layer: expected a layer of .*, found 'quartz'"),
    ],
)
def test_a_layer_that_is_not_known_is_refused(scan, options, message):
    with pytest.raises(ValueError, match=message):
        scan.contact.assign_pair(**({"sphere_radius": 500, "layer": Layer(20, "silica")} | options))


def test_an_unnamed_layer_has_no_adhesion_or_hardness_of_its_base(scan):
    ds = scan.contact.assign_pair(
        sphere_radius=500, materials="glass/silicon", layer=Layer(20, young_modulus=200, poisson_ratio=0.25)
    )
    assert not {"work_of_adhesion", "hardness_estimate"} & set(ds.coords)


def test_a_layer_of_the_base_is_none(scan):
    """Forces, pull-off and fields of silicon on silicon are those of silicon."""
    pair = {"sphere_radius": 500, "materials": "glass/silicon"}
    bare, coated = (scan.contact.assign_pair(**pair, **more) for more in ({}, {"layer": Layer(10, "silicon")}))
    for solve in (
        lambda ds: ds.contact.direct(delta=[3.0, 5.0], fields=True)[["force", "pressure", "gap"]],
        lambda ds: ds.contact.direct(load=[50.0, 500.0])[["delta", "contact_area"]],
        lambda ds: ds.contact.adhesive(mesh=1, law="jkr")[["pull_off_force", "snap_in_delta"]],
    ):
        xr.testing.assert_allclose(
            solve(coated).reset_coords(drop=True), solve(bare).reset_coords(drop=True), rtol=1e-4, atol=1e-5
        )


@pytest.mark.parametrize(
    "layer",
    [Layer(20, "silica"), Layer(5, young_modulus=0.5, poisson_ratio=0.49), Layer(5, "alumina")],
    ids=["oxide", "polymer", "stiff"],
)
def test_solutions_meet_the_certificate_with_the_layer(scan, layer):
    ds = scan.contact.assign_pair(
        sphere_radius=500, young_modulus=(75.0, 20.0), poisson_ratio=0.3, work_of_adhesion=0.05, layer=layer
    )
    for solved in (
        ds.contact.direct(delta=[2.0, 4.0], fields=True),
        ds.contact.direct(load=[20.0, 200.0], fields=True),
        ds.contact.adhesive(delta=[2.0, 3.0], mesh=2, law="jkr", fields=True),
    ):
        proof = certificate_of_fields(solved)
        assert proof.met.sel(check="elasticity")
        assert set(proof.check.values[~proof.met.values]) <= {"mesh"}, proof.violation.to_series()
        other = solved.assign_coords(layer_thickness=1.5 * solved.layer_thickness)
        assert not certificate_of_fields(other).met.sel(check="elasticity")


def test_a_layer_that_yields_meets_the_certificate(scan):
    ds = scan.contact.assign_pair(**OXIDE, hardness=3.0)
    solved = ds.contact.direct(delta=[2.0, 5.0], fields=True)
    assert float(solved.yielded_area.max()) > 0
    assert certificate_of_fields(solved).met.all()
    rubber = Layer(5, young_modulus=0.5, poisson_ratio=0.5)
    with pytest.raises(ValueError, match="which bulges beside the contact"):
        scan.contact.assign_pair(**(OXIDE | {"layer": rubber}), work_of_adhesion=0.05, hardness=1.0).contact.direct()


def test_forces_fall_from_the_base_to_the_layer_with_thickness(scan):
    forces = []
    for h in (0.3, 3.0, 30.0, 300.0):
        ds = scan.contact.assign_pair(sphere_radius=500, materials="glass/silicon", layer=Layer(h, "silica"))
        forces.append(float(ds.contact.direct(delta=[5.0]).force[0, 0]))
    ends = [
        float(scan.contact.assign_pair(sphere_radius=500, materials=name).contact.direct(delta=[5.0]).force[0, 0])
        for name in ("glass/silicon", "glass/silica")
    ]
    assert ends[0] > forces[0] > forces[1] > forces[2] > forces[3] > ends[1]
    assert forces[0] == pytest.approx(ends[0], rel=0.02) and forces[3] == pytest.approx(ends[1], rel=0.02)


@pytest.mark.parametrize(
    ("thickness", "ratio", "base", "mesh"),
    [(60.0, 0.3, np.inf, 1), (12.0, 0.3, np.inf, 2), (12.0, 0.5, np.inf, 2), (12.0, 0.3, 0.5, 1)],
)
def test_pull_off_of_a_smooth_sphere(thickness, ratio, base, mesh):
    """Griffith's limit by dual integral equations: 1.5 πwR on half spaces, up to 2 πwR and 3 πwR on thin layers.

    Layers are at least six cells thick: with three, the pull-off is off by up to 3 %.
    """
    modulus = 1.64
    w = 0.1
    radius = 1000.0
    young = modulus * (1 - ratio**2)
    mismatch = 0.0 if np.isinf(base) else young / (1 + ratio) * (1 + 0.3) / base
    expected, _ = bonded_layer.pull_off(w / (modulus * radius), thickness / radius, mismatch, ratio, 0.3)
    ds = _flat(64).contact.assign_pair(
        sphere_radius=radius,
        young_modulus=(np.inf, base),
        poisson_ratio=0.3,
        work_of_adhesion=w,
        layer=Layer(thickness, young_modulus=young, poisson_ratio=ratio),
    )
    solved = ds.contact.adhesive(law="jkr", mesh=mesh)
    assert float(solved.pull_off_force[0]) / (np.pi * w * radius) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("ratio", "limit"), [(0.3, 2.0), (0.5, 3.0)])
def test_pull_off_on_thin_layers_has_a_limit(ratio, limit):
    """2 πwR on a thin compressible layer and 3 πwR on an incompressible one, whatever their stiffness."""
    pulls = [bonded_layer.pull_off(w, 0.1, 0.0, ratio, 0.3)[0] for w in (1e-6, 1e-2, 1.0)]
    assert pulls[0] == pytest.approx(1.5, rel=0.01)
    assert (np.diff([*pulls, limit]) > 0).all()


@pytest.mark.filterwarnings("ignore:delta. 400 nm")  # so deep on purpose
def test_sums_over_asperities_need_contacts_far_smaller_than_the_layer(scan):
    thick, thin = (
        scan.contact.assign_pair(sphere_radius=500, materials="glass/silicon", layer=Layer(h, "silica"))
        for h in (1000, 20)
    )
    bare = scan.contact.assign_pair(sphere_radius=500, materials="glass/silica")
    delta = np.linspace(0, 3, 7)
    np.testing.assert_allclose(thick.contact.superpose(delta=delta).force, bare.contact.superpose(delta=delta).force)
    with pytest.raises(ValueError, match=r"counts as a half space, found .* nm \(JKR's at pull-off"):
        thin.contact.superpose(delta=delta)
    sweeps = [thick.contact.superpose(delta=np.linspace(0, end, 7)) for end in (3, 400)]
    assert bool(sweeps[0].force.notnull().all()) and "wider than 100 nm" in sweeps[1].attrs["missing"]
    deep = sweeps[1].force.isel(subregion=0)
    assert bool(deep[0].notnull()) and bool(deep[-1].isnull())
    np.testing.assert_array_equal(sweeps[1].pull_off_force, bare.contact.superpose(delta=delta).pull_off_force)
    for refused in ("pull_off_map", "regime"):
        with pytest.raises(ValueError, match="layer: expected a half space, found a layer of 20 nm"):
            getattr(thin.contact, refused)()
    with pytest.raises(ValueError, match="found a layer with its own moduli"):
        thin.contact.vary(roughxr.direct, contact_modulus=[30, 40])


def test_a_run_on_a_layer_does_all_but_the_sums_over_half_spaces(scan, tmp_path, capsys):
    ds = scan.contact.assign_pair(sphere_radius=30, materials="silica/silicon", layer="5 nm silica")
    groups = roughxr.run(ds, tmp_path / "run.nc", subregions=(2, 1), budget=0, mesh=1)
    assert not {"statistics/energy", "solutions/hertz", "statistics/regime"} & set(groups)
    assert float(groups["statistics/formulas"].pull_off_force.sel(formula="bradley")) > 0  # of rigid bodies
    moments = groups["solutions/rolling"]
    assert (moments.resisting_moment > 0).any() and (groups["solutions/direct"].force > 0).any()
    facts = dict(pair_facts(groups["scan"]))
    assert facts["layer thickness"] == "5 nm"
    assert any(caution.startswith("Left out, since they hold for half spaces") for caution in report.cautions(groups))
    assert "half space below a layer of 5 nm was solved with adhesion (" in methods(groups)
    with pytest.raises(ValueError, match="expected 'lammps' for bodies without a layer"):
        roughxr.particles.to_dem(moments, code="lammps")
    assert "resisting moment" in capsys.readouterr().out


def test_text_is_a_layer_of_a_thickness_and_a_material(scan):
    pair = {"sphere_radius": 500, "materials": "glass/silicon"}
    as_text = scan.contact.assign_pair(**pair, layer="20 nm silica")
    assert film_of(as_text) == film_of(scan.contact.assign_pair(**pair, layer=Layer("20 nm", "Silica")))
    for wrong in ("20 nm", "silica", 20, "20 nm sillica"):
        with pytest.raises(ValueError, match=r"layer: expected thickness and one of .*, such as '5 nm silica', found"):
            scan.contact.assign_pair(**pair, layer=wrong)


def test_rigid_bodies_do_not_depend_on_a_layer(scan):
    coated = scan.contact.assign_pair(**OXIDE)
    bare = scan.contact.assign_pair(sphere_radius=500, materials="glass/silica")
    assert float(coated.contact.rigid(delta=[0.0]).force[0, 0]) == float(bare.contact.rigid(delta=[0.0]).force[0, 0])


def test_the_budget_changes_the_thickness_and_all_moduli_together(scan):
    ds = scan.contact.assign_pair(**OXIDE)
    assert "layer thickness" in pair_factors(ds)
    assert "layer thickness" not in pair_factors(ds.drop_vars("layer_thickness"))
    stiffer = ds.assign_coords(stiffened(ds, 1.1))
    assert film_of(stiffer) == pytest.approx(film_of(ds))
    with pytest.raises(ValueError, match="assign the pair with its layer anew"):
        film_of(ds.assign_coords(contact_modulus=200.0))
    budget = ds.contact.error_budget(places=1, law="jkr", mesh=2, settings={"layer thickness": [0.5]})
    entry = budget.sel(entry="layer thickness")
    assert 0 < float(entry.relative_std) < 0.2 and np.isfinite(entry.slope)


def test_a_layer_does_not_end_the_quick_recipe_of_detachment(scan):
    """A thick layer is a half space of its own; of a thin one a warning states that the base is neglected."""
    pair = {"sphere_radius": 500, "materials": "glass/silicon", "work_of_adhesion": 0.1}
    thick, thin = (scan.contact.assign_pair(**pair, layer=Layer(depth, "silica")) for depth in ("1 um", "2 nm"))
    own_body = scan.contact.assign_pair(sphere_radius=500, materials="glass/silica", work_of_adhesion=0.1)
    moments, of_silica = (ds.contact.rolling(directions=6).resisting_moment for ds in (thick, own_body))
    np.testing.assert_allclose(moments, of_silica, rtol=1e-6)
    with pytest.warns(DoubtfulAsperities, match="layer: taken as a thick one"):
        thin.contact.rolling(directions=6)
