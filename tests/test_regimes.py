"""Which model, what formulas are off by, and what finer scales do."""

import numpy as np
import pytest

import roughxr
from roughxr import reference
from roughxr.mechanics.contact.adhesive_options import chosen_law
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.specimen import specimen_of

from .surfaces import scan, unpressed
from .verb_calls import surface, unlabelled


@pytest.fixture(scope="module")
def rough():
    surface = self_affine((128, 128), 9.77, rms=2, hurst=0.6, rolloff=300, cutoff=30, seed=4)
    return surface.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0.06)


def bumps(radius, distance, n=96, pixel=2.0):
    """A plane with hemispheres on a square lattice, one of them in the middle."""
    x = (np.arange(n) - n / 2) * pixel
    near = (x + distance / 2) % distance - distance / 2
    r2 = near[:, None] ** 2 + near**2
    return scan(np.sqrt(np.clip(radius**2 - r2, 0, None)), pixel)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
def test_stiff_is_rigid_soft_is_summed_between_is_adhesive(rough):
    def of(modulus, work):
        pair = {"sphere_radius": 500, "contact_modulus": modulus, "work_of_adhesion": work}
        return rough.contact.assign_pair(**pair).contact.regime(subregions=(2, 2))

    regimes = [of(*pair) for pair in ((4000.0, 0.06), (40.0, 0.3), (0.05, 0.06))]
    assert [regime.recommended.item() for regime in regimes][:2] == ["rigid", "adhesive"]
    assert regimes[2].recommended.item() == ("superpose" if regimes[2].share_beyond_contact < 0.5 else "adhesive")
    for regime in regimes:
        assert roughxr.answer(regime).sentence.startswith("The quickest valid method is `")
        assert float(regime.sphere_tabor) > float(regime.asperity_tabor) > 0


def test_yield_is_told_where_a_hardness_is_given(rough):
    soft, hard = (rough.assign_coords(hardness=H).contact.regime(subregions=(1, 1)) for H in (0.01, 1e3))
    assert bool(soft["yields"]) and not bool(hard["yields"]) and unlabelled(soft) == []
    assert "yield" in roughxr.answer(soft).sentence and "yield" not in roughxr.answer(hard).sentence
    radius = 100.0
    load = np.pi**3 * radius**2 * 6**3 / (6 * 40**2)  # Hertz's largest pressure is the hardness
    from roughxr.mechanics.contact.regimes import _peak_pressure

    work = load / (2 * np.pi * radius)
    assert _peak_pressure(radius, 40.0, work) == pytest.approx(6.0)
    named = rough.contact.assign_pair(hardness=2.0, **{name: float(rough[name]) for name in roughxr.schema.PAIR})
    assert "yields" in named.contact.regime(subregions=(1, 1)) and "yields" not in rough.contact.regime(
        subregions=(1, 1)
    )


def test_rumpf_is_right_on_the_surface_that_it_is_made_for():
    """One hemisphere on a plane under a large sphere, both rigid: Derjaguin's pull of each, within a few percent."""
    single = bumps(12.0, 1e4, n=128, pixel=1.0)
    pair = {"sphere_radius": 2000, "contact_modulus": 40, "work_of_adhesion": 0.06, "hamaker_constant": 0.0615}
    single = single.contact.assign_pair(**pair)
    z0 = float(np.sqrt(0.0615 / (12 * np.pi * 0.06)))
    top = [float(single.x[64])], [float(single.y[64])]
    pull_off = float(single.contact.rigid(subregions=top, delta=[0.0], mesh=4).pull_off_force[0])
    formula = reference.rumpf(radius=2000, asperity_radius=12, hamaker_constant=0.0615, closest_approach=z0)
    assert pull_off / formula == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize(("radius", "rms", "wavelength"), [(200, 1, 60), (200, 5, 100), (1000, 3, 200), (5000, 1, 200)])
def test_rabinovich_is_right_on_the_surface_that_he_draws(radius, rms, wavelength):
    """Caps 1.817 rms high and half a wavelength wide on a plane, one of them under the sphere: within 5 %."""
    pixel = wavelength / 40
    z0 = 0.3
    near = (np.arange(160) * pixel) % wavelength - wavelength / 2
    r2 = near[:, None] ** 2 + near**2
    caps = scan(1.817 * rms * np.clip(1 - r2 / (wavelength / 4) ** 2, 0, None), pixel)
    constant = 12 * np.pi * z0**2 * 0.06
    caps = caps.contact.assign_pair(
        sphere_radius=radius, contact_modulus=40, work_of_adhesion=0.06, hamaker_constant=constant
    )
    top = [float(caps.x[60])], [float(caps.y[60])]
    pull_off = float(caps.contact.rigid(subregions=top, delta=[0.0], mesh=8).pull_off_force[0])
    formula = reference.rabinovich(
        radius=radius, rms=rms, wavelength=wavelength, hamaker_constant=constant, closest_approach=z0
    )
    assert pull_off / formula == pytest.approx(1, abs=0.05)


@unpressed()
def by_each_model(ground, place, refine):
    """Return the recommended model, and the pull-off by rigid bodies and by superposition over the simulation."""
    simulated = ground.contact.adhesive(subregions=place, mesh=roughxr.Mesh(refine, step=0.2)).pull_off_force
    stiff = ground.contact.rigid(law="exponential", subregions=place, mesh=refine, delta=[0.0]).pull_off_force
    summed = roughxr.pull_off_map(ground, subregions=place).pull_off_force
    recommended = ground.contact.regime(subregions=place).recommended.item()
    return recommended, *(float((pull_off / simulated).mean()) for pull_off in (stiff, summed))


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
def test_what_is_recommended_is_near_the_simulation_and_the_rest_is_not(rough):
    """All three are computed: on stiff ground, on one soft cap, and between."""
    place = ([600.0], [600.0])
    pair = {"sphere_radius": 500, "work_of_adhesion": 0.06, "adhesion_range": 0.3}
    verb, rigid, summed = by_each_model(rough.contact.assign_pair(contact_modulus=4000, **pair), place, 4)
    assert verb == "rigid" and rigid == pytest.approx(1, abs=0.02) and abs(summed - 1) > 0.1
    verb, rigid, summed = by_each_model(rough.contact.assign_pair(contact_modulus=40, **pair), place, 4)
    assert verb == "adhesive" and abs(rigid - 1) > 0.02 and abs(summed - 1) > 0.1
    x = (np.arange(72) - 36) * 3.0
    cap = scan(np.clip(30 - (x[:, None] ** 2 + x**2) / 120, 0, None), 3.0)
    cap = cap.contact.assign_pair(contact_modulus=0.5, sphere_radius=500, work_of_adhesion=0.2, adhesion_range=0.3)
    verb, rigid, summed = by_each_model(cap, ([float(cap.x[36])], [float(cap.y[36])]), 2)
    assert verb == "superpose" and summed == pytest.approx(1, abs=0.05) and rigid > 1.2


def test_the_table_holds_the_formulas_at_the_scans_own_numbers(rough):
    table = rough.contact.formulas(subregions=(2, 2))
    force = table.pull_off_force
    inputs = table.attrs
    assert float(force.sel(formula="bradley")) == pytest.approx(2 * np.pi * 0.06 * 500)
    expected = reference.rabinovich(
        radius=500,
        rms=inputs["rms"],
        wavelength=inputs["wavelength"],
        hamaker_constant=inputs["hamaker_constant"],
        closest_approach=inputs["closest_approach"],
    )
    assert float(force.sel(formula="rabinovich")) == pytest.approx(expected)
    assert inputs["short_rms"] ** 2 + inputs["long_rms"] ** 2 == pytest.approx(inputs["rms"] ** 2, rel=0.02)
    np.testing.assert_allclose(table.formula_ratio * float(force.sel(formula="sum")), force)


def test_a_scan_too_small_for_two_scales_leaves_that_formula_out():
    table = surface(21).contact.formulas(subregions=(1, 1), mesh=2)
    missing = table.pull_off_force.isnull()
    assert table.formula[missing].values.tolist() == ["rabinovich_two_scales"] and "too small" in table.attrs["missing"]


def test_what_is_wrong_is_said(rough):
    with pytest.raises(ValueError, match="sphere_radius"):
        roughxr.regime(rough.drop_vars("sphere_radius"))


def rubber(modulus, work=0.05, **assigned):
    """Low summits, all alike (radius 13 nm), across whose gaps much of the pull acts: no sum over contacts suffices."""
    x = (np.arange(72) - 36) * 2.0
    waves = scan(0.5 * np.cos(2 * np.pi * x / 16)[:, None] * np.cos(2 * np.pi * x / 16), 2.0)
    pair = {"sphere_radius": 500, "contact_modulus": modulus, "work_of_adhesion": work, "adhesion_range": 0.3}
    return waves.contact.assign_pair(**pair | assigned)


@pytest.mark.parametrize(
    ("modulus", "assigned", "law", "reason"),
    [
        (2e-3, {}, "jkr", "range of adhesion is negligible"),  # rubber
        (30.0, {}, "exponential", "as the range of adhesion"),
        (2e-3, {"hardness": 20.0}, "exponential", "traction must be finite"),
        (
            2e-3,
            {"humidity": roughxr.HumidAir("60 %", contact_angle=10)},
            "exponential",
            "the liquid attracts across gaps",
        ),
        (30.0, {"hardness": 20.0}, "exponential", "as the range of adhesion"),
    ],
)
def test_the_law_that_is_recommended_is_the_one_that_the_simulation_chooses(modulus, assigned, law, reason):
    ds = rubber(modulus, **assigned)
    regime = ds.contact.regime(subregions=(1, 1), mesh=2)
    assert regime.attrs["law"] == law
    assert regime.recommended.item() == "adhesive"
    assert reason in roughxr.answer(regime).sentence and f"'{law}'" in roughxr.answer(regime).sentence
    assert chosen_law(specimen_of(ds), "auto")[0] == law
    assert ("as the range of adhesion" in roughxr.answer(regime).sentence) <= (float(regime.asperity_tabor) < 5)


def test_both_change_their_law_at_the_same_modulus():
    """Tabor's parameter of 5, just above and just below, by its own power −2/3 of E*."""
    at_one = float(rubber(1.0).contact.regime(subregions=(1, 1), mesh=2).asperity_tabor)
    edge = (at_one / 5) ** 1.5
    for factor, law in ((0.999, "jkr"), (1.001, "exponential")):
        ds = rubber(edge * factor)
        assert ds.contact.regime(subregions=(1, 1), mesh=2).attrs["law"] == law
        assert chosen_law(specimen_of(ds), "auto")[0] == law
