"""Condensed water: against closed forms, exact menisci, an own double sum, and words where it is refused."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.special import ndtr, ndtri

import roughxr
from roughxr import reference
from roughxr.application import cli, report, sentences
from roughxr.application.cli.options import command_line
from roughxr.application.cli.running import paired
from roughxr.mechanics.bodies import liquid
from roughxr.mechanics.contact.adhesion import adhesive_and_moments
from roughxr.mechanics.kernels.adhesion import potentials
from roughxr.mechanics.kernels.adhesion import rigid as kernels
from roughxr.mechanics.kernels.asperity import maugis
from roughxr.mechanics.kernels.topography.interpolation import splined
from roughxr.mechanics.particles.resting_places import resting
from roughxr.mechanics.scans import regions

from .closed_forms import maugis_pull_off, sphere_attraction
from .surfaces import bare_runs, rigid_pull_off, rough, scan

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = [
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact"),
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult"),
]

GAMMA = 0.072
LEAST = 0.524253
OF_LIQUID = {"humidity", "kelvin_radius", "surface_tension", *liquid.ANGLES, "liquid_film", "liquid_molecule"}
OF_LIQUID |= {"share_under_liquid"}
FLAT = {3000.0: (10.0, 161), 100.0: (0.5, 281)}


def wet(ds, humidity=0.5, radius=3000.0, **options):
    """Return the scan with water alone between the bodies, or what else is given."""
    air_options = {name: options.pop(name) for name in ("contact_angle", "liquid", "film") if name in options}
    air = roughxr.HumidAir(humidity, **air_options)
    bodies = {"sphere_radius": radius, "contact_modulus": 40.0, "humidity": air}
    bodies |= {} if "materials" in options else {"work_of_adhesion": 0.0}
    return ds.contact.assign_pair(**(bodies | options))


def flat(radius):
    pixel, n = FLAT[radius]
    return scan(np.zeros((n, n)), pixel)


@pytest.mark.parametrize(
    ("bodies", "work"),
    [
        ({"contact_modulus": 40}, None),
        ({"young_modulus": (60, 72), "poisson_ratio": (0.3, 0.22)}, None),
        ({"contact_modulus": 40, "hamaker_constant": "65 zJ"}, 0.0633),
        ({"contact_modulus": 40, "surface_energy": 0.03}, 0.06),
        ({"contact_modulus": 40, "work_of_adhesion": 0}, 0.0),
        ({"materials": "glass"}, 0.0633),
    ],
)
def test_dry_adhesion_of_a_humid_pair_is_stated_or_refused(bodies, work):
    """Bodies whose adhesion is unknown were taken not to attract at all."""
    for air in (0.4, "40 %", roughxr.HumidAir(0.4)):
        options = {"sphere_radius": 3000, "humidity": air, **bodies}
        if work is None:
            with pytest.raises(ValueError, match=r"humidity: expected the dry adhesion .* work_of_adhesion=0"):
                flat(3000.0).contact.assign_pair(**options)
        else:
            pair = flat(3000.0).contact.assign_pair(**options)
            assert float(pair.work_of_adhesion) == pytest.approx(work, rel=1e-2)


def test_a_run_in_humid_air_without_adhesion_is_refused_in_options(tmp_path, capsys):
    scan_file = tmp_path / "scan.nc"
    scan(rough(32), 20.0).to_netcdf(scan_file)
    bodies = ["--sphere-radius", "500 nm", "--contact-modulus", "40 GPa", "--humidity", "40 %"]
    assert cli.main(["run", str(scan_file), *bodies, "-o", str(tmp_path / "run")]) != 0
    printed = capsys.readouterr().err
    assert "--humidity: expected the dry adhesion" in printed and "--work-of-adhesion 0" in printed
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(("humidity", "expected"), [(0.3, 0.4354), ("50 %", 0.7563), (0.9, 4.9758)])
def test_kelvin_radius_is_that_of_water_at_25_degrees(humidity, expected):
    assert liquid.kelvin_radius(humidity) == pytest.approx(expected, abs=5e-5)
    assert liquid.kelvin_radius(humidity, liquid=("72 mN/m", "18.05 cm3/mol")) == pytest.approx(expected, abs=5e-5)


def test_menisci_are_as_high_as_kelvin_radius_and_angles_say():
    ds = wet(flat(3000.0), 0.8, contact_angle=(20, 60))
    assert liquid.menisci_of(ds).height == pytest.approx(LEAST / -np.log(0.8) * (np.cos(np.pi / 9) + 0.5), rel=1e-5)
    assert {ds[name].units for name in ("contact_angle_1", "contact_angle_2")} == {"rad"}
    drier = ds.assign_coords(liquid.humidity_coordinates(ds, 0.5))
    assert float(drier.kelvin_radius) == pytest.approx(liquid.kelvin_radius(0.5))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"humidity": 60}, "0.6 or '60 %', found 60: 60 % is 0.6"),
        ({"humidity": "60"}, "found '60': 60 % is 0.6"),
        ({"humidity": 0.995}, "saturation"),
        ({"humidity": "99 %"}, "saturation"),
        ({"humidity": 0}, "between 0 and 1"),
        ({"contact_angle": 100}, "does not wet"),
        ({"contact_angle": (0, 91)}, "does not wet"),
        ({"contact_angle": -5}, "from 0 to 90"),
        ({"contact_angle": (1, 2, 3)}, "a pair"),
        ({"film": -0.1}, "at least 0 nm"),
        ({"humidity": 0.95, "sphere_radius": 60.0}, "small compared with the sphere's radius"),
        ({"liquid": "oil"}, "'water', 'ethanol'"),
        ({"liquid": 3}, "molar volume"),
        ({"work_of_adhesion": (0.1, 0.05, 0.01)}, "a pair"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(options, sentence):
    with pytest.raises(ValueError, match=next(iter(options)) if sentence != "a pair" else sentence) as refusal:
        wet(scan(np.zeros((9, 9))), **({"humidity": 0.5} | options))
    assert sentence in str(refusal.value)


def test_under_water_named_solids_attract_as_their_hamaker_constants_say():
    ds = scan(np.zeros((9, 9)))
    pair = ds.contact.assign_pair(sphere_radius=3000, materials="glass/alumina", humidity=0.6)
    across = roughxr.reference.hamaker_constant("glass", "alumina", medium="water")
    share = across / roughxr.reference.hamaker_constant("glass", "alumina")
    assert float(pair.share_under_liquid) == pytest.approx(share)
    stated = wet(ds, work_of_adhesion=(0.1, 0.03))
    assert (float(stated.work_of_adhesion), float(stated.share_under_liquid)) == pytest.approx((0.1, 0.3))


@pytest.mark.parametrize("law", ["hamaker", "lennard_jones", "exponential", "dugdale"])
def test_the_law_of_the_gap_is_the_sum_of_both_attractions(law):
    """Its integral from contact is the water's work, the solids' share under it, and theirs beyond it."""
    dry = potentials.potential(law, 0.06, 0.3)
    law_with_liquid = potentials.with_liquid(dry, 1.7, 0.05, 0.2)
    contact = law_with_liquid.filled - 1.7
    dry_energy = float(potentials.energy(law_with_liquid.filled, dry))

    def over(f, low, high):
        return quad(f, low, high, epsabs=1e-13, epsrel=1e-12, limit=400, points=[0.3] if low < 0.3 < high else None)[0]

    def traction(g):
        return potentials.traction(g, law_with_liquid)

    whole = over(traction, max(contact, 1e-9), law_with_liquid.filled) + dry_energy
    assert whole == pytest.approx(0.05 * 1.7 + 0.2 * (0.06 - dry_energy) + dry_energy, rel=1e-8)
    assert float(potentials.energy(contact, law_with_liquid)) == pytest.approx(whole, rel=1e-8)
    for z in (0.31, 1.0, 5.0):
        direct = over(lambda S, z=z: 2 * np.pi * (500 - S) * traction(z + S), 0, max(law_with_liquid.filled - z, 0))
        direct += over(lambda S, z=z: 2 * np.pi * (500 - S) * traction(z + S), max(law_with_liquid.filled - z, 0), 1000)
        assert float(sphere_attraction(z, 500.0, law_with_liquid)) == pytest.approx(direct, rel=1e-6)


@pytest.mark.parametrize("radius", FLAT)
@pytest.mark.parametrize(("humidity", "angles"), [(0.3, 0), (0.5, (20, 60)), (0.9, 30)])
def test_a_sphere_on_a_plane_is_pulled_by_the_law_of_thin_menisci(radius, humidity, angles):
    """On pixels of which a meniscus spans a few: its edge is found within them."""
    cosines = np.cos(np.radians(np.broadcast_to(angles, 2))).sum()
    kelvin = LEAST / abs(np.log(humidity))
    pair = wet(flat(radius), humidity, radius, contact_angle=angles)
    pulled = pair.contact.rigid(delta=[-0.3, 0.0], law="exponential")
    wetted = kelvin * cosines - np.array([0.3, 0.0])  # height of the sphere within the liquid
    expected = 2 * np.pi * (radius - wetted / 2) * GAMMA * wetted / kelvin
    np.testing.assert_allclose(-pulled.force.values[0], expected, rtol=2e-3)
    assert float(pulled.pull_off_force[0]) == pytest.approx(expected[1], rel=2e-3)


@pytest.fixture(scope="module")
def gaussian():
    """Heights on 900² cells whose distribution is exactly Gaussian, with the outlines of smooth roughness."""
    heights = rough(900, rms=1.0, smooth=12.0, seed=7)
    ranks = np.argsort(np.argsort(heights.ravel())).reshape(heights.shape)
    return ndtri((ranks + 0.5) / heights.size)


@pytest.mark.parametrize(
    ("height", "shares"),
    [(2.0, (0.80477, 0.5, 0.19523, 0.04147, 0.00424)), (10.0, (0.96011, 0.89167, 0.79915, 0.69996, 0.60000))],
)
def test_over_gaussian_heights_it_is_their_integral(gaussian, height, shares):
    """The wetted area as `rigid` sums it, and the work per area: by Derjaguin the share of a sphere's pull."""
    law = potentials.with_liquid(potentials.potential("dugdale", 0.0, 0.3), height, 1.0, 1.0)
    for distance, share in enumerate(shares):
        gap = distance - gaussian
        area = kernels.attractions(gap, kernels.cells(gap, law), np.zeros(1), law, 1e-12, 1.0)[0] / gap.size
        assert area == pytest.approx(ndtr(height - distance), rel=2e-3)
        work = float(np.mean(potentials.energy(np.maximum(gap, 0.0), law)))
        assert work / height == pytest.approx(share, rel=2e-3)


@pytest.mark.parametrize(
    ("radius", "angle", "distance", "expected"),
    [
        (100, 0, 0.0, (88.1125, 87.3567, 82.5283)),
        (100, 0, 0.3, (56.4353, 69.1245, 79.7755)),
        (100, 30, 0.0, (76.0033, 75.2681, 70.7372)),
        (3000, 0, 0.0, (2701.466, 2697.363, 2670.648)),
        (3000, 0, 0.3, (1763.452, 2157.144, 2588.259)),
    ],
)
def test_exact_menisci_and_the_error_stated_of_thin_ones(radius, angle, distance, expected):
    for humidity, force in zip((0.3, 0.5, 0.9), expected):
        kelvin = liquid.kelvin_radius(humidity)
        exact = reference.meniscus_sphere([distance], radius=radius, kelvin_radius=kelvin, contact_angle=angle)
        assert -float(exact.force[0]) == pytest.approx(force, rel=1e-5)
        pair = wet(flat(float(radius)), humidity, float(radius), contact_angle=angle)
        thin_menisci = pair.contact.rigid(delta=[-1.0], law="exponential")
        if distance == 0:
            off = 1 - force / -float(exact.thin_force[0])
            assert float(thin_menisci.meniscus_error[0]) == pytest.approx(off, rel=0.06)


def test_far_off_no_exact_meniscus_can_stand():
    menisci = reference.meniscus_sphere([0.0, 8.0, 12.0], radius=100, kelvin_radius=5.0)
    assert float(menisci.force[0]) < float(menisci.force[1]) <= 0 == float(menisci.force[2])


def test_the_slow_work_is_the_area_under_the_force():
    pair = wet(scan(rough(64, rms=0.5)), 0.8, materials="glass", contact_modulus=None)
    delta = np.linspace(-40, 0, 2001)
    pulled = pair.contact.rigid(delta=delta, datum="first_contact", law="exponential")
    area = np.trapezoid(np.nan_to_num(-pulled.force.values[0]), delta)
    assert area == pytest.approx(float(pulled.work_of_separation[0]), rel=3e-3)


def double_sum(ds, refine, humidities, radius, centres):
    """Return the pulls of water alone, cell by cell: splines on cells, each wet or not by the gap in its middle."""
    from scipy.interpolate import RectBivariateSpline

    kelvins = LEAST / np.abs(np.log(humidities))
    pull_offs = []
    spline = RectBivariateSpline(ds.x.values, ds.y.values, ds.height.values)
    cell = float(ds.x[1] - ds.x[0]) / refine
    n = int(np.sqrt(2 * radius * 40) / cell)
    for x, y in zip(*centres):
        along = cell * (np.arange(-n, n + 1))
        ground = spline(x + along, y + along)
        gap = along[:, None] ** 2 / (2 * radius) + along**2 / (2 * radius) - ground
        wetted = [np.count_nonzero(gap - gap.min() < 2 * kelvin) for kelvin in kelvins]
        pull_offs.append(GAMMA / kelvins * cell**2 * wetted)
    return np.array(pull_offs)


def test_the_twin_by_two_independent_sums():
    """Rigid bodies, R = 3 µm, 16 places: from the solids' own 30 nN to most of a smooth sphere's 2714 nN."""
    glass = roughxr.open_sample("glass")
    cell = float(glass.x[1] - glass.x[0]) / 2
    fine = scan(splined(glass.height.values, 2), cell)
    expected = {0.5: 68.0, 0.9: 1451.0, 0.95: 2111.0}
    places = regions.centres(fine, (4, 4))
    summed = double_sum(fine, 2, list(expected), 3000.0, (places.subregion_x.values, places.subregion_y.values))
    means = {}
    for humidity, sum_of_cells in zip(expected, summed.mean(axis=0)):
        pulled = wet(fine, humidity).contact.rigid(subregions=places, delta=[0.0])
        means[humidity] = float(pulled.pull_off_force.mean())
        assert means[humidity] == pytest.approx(sum_of_cells, rel=0.05 if humidity < 0.8 else 0.01)
    assert means == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("pixels", "rms"), [(9, 0.05), (33, 0.5)])
def test_on_a_scan_hardly_wider_than_the_meniscus_the_pull_is_truncated(pixels, rms):
    surface = scan(rough(pixels, rms=rms, smooth=1.0), 5.0)
    pair = wet(surface, 0.9, materials="glass", contact_modulus=None)
    rigid = pair.contact.rigid(delta=[-0.2])
    with pytest.warns(UserWarning, match=r"1 of 1 subregions .* edge of the scan .* do not include the surface beyond"):
        adhesive = pair.contact.adhesive(mesh=roughxr.Mesh(1, accuracy=None))
    for solved in (rigid, adhesive):
        assert bool(solved.truncated.all()) and np.isfinite(solved.pull_off_force).all()


def test_a_dry_pair_is_what_it_was():
    glass = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    assert not OF_LIQUID & set(glass.coords)
    pulled = glass.contact.rigid(subregions=(2, 2), delta=[0.0])
    assert "meniscus_error" not in pulled and sentences.liquid_words(glass) == ""
    rewetted = glass.contact.assign_pair(sphere_radius=3000, materials="glass", humidity=0.5)
    again = rewetted.contact.assign_pair(sphere_radius=3000, materials="glass")
    assert not OF_LIQUID & set(again.coords)


def test_few_molecules_are_said():
    ds = scan(np.zeros((9, 9)))
    assert "a few molecules" in sentences.liquid_words(wet(ds, 0.3))
    assert "molecules" not in sentences.liquid_words(wet(ds, 0.9))


def at_part(part):
    """Return the humidity at which a part of water's capillary pressure counts."""
    molecule = (18.05e21 / 6.02214076e23) ** (1 / 3)
    return float(np.exp(-LEAST / (0.5 * molecule * (1 + part))))


def test_menisci_thicker_than_two_molecules_count_in_full():
    ds = scan(np.zeros((9, 9)))
    assert [liquid.menisci_of(wet(ds, humidity)).part for humidity in (0.2, 0.3, 0.5, 0.9)] == [1.0] * 4
    thin = liquid.menisci_of(wet(ds, at_part(0.25), work_of_adhesion=(0.1, 0.02)))
    assert thin.capillary_pressure == pytest.approx(0.25 * GAMMA / thin.kelvin_radius, rel=1e-4)
    assert thin.share == pytest.approx(0.8, rel=1e-4)


@pytest.mark.parametrize("method", ["rigid", "adhesive", "map", "dugdale"])
def test_as_humidity_falls_every_pull_off_becomes_that_of_the_dry_pair(method):
    """Equal below a molecule; a 1e-4 part above it within 0.1 %; and in between without a step."""
    ds = scan(rough(32, rms=1.0, seed=2), pixel=5.0)
    solve = {
        "rigid": lambda pair: pair.contact.rigid(delta=[0.0]),
        "adhesive": lambda pair: pair.contact.adhesive(mesh=roughxr.Mesh(1, accuracy=None)),
        "map": lambda pair: pair.contact.pull_off_map(subregions=(1, 1)),
        "dugdale": lambda pair: pair.contact.pull_off_map(subregions=(1, 1), law="dugdale"),
    }[method]

    def pull_off(humidity, **air):
        air = None if humidity is None else roughxr.HumidAir(humidity, **air)
        pair = ds.contact.assign_pair(sphere_radius=300, materials="glass", humidity=air)
        return float(solve(pair).pull_off_force.squeeze())

    dry = pull_off(None)
    first = pull_off(at_part(1e-4))
    with pytest.warns(UserWarning, match="nothing condenses, and the pair counts as dry"):
        assert [pull_off(1e-9), pull_off(0.03), pull_off(0.01, liquid="ethanol")] == [dry] * 3
    # the sum of asperities by Maugis's law has other ellipses than that by JKR's
    assert first == pytest.approx(dry, rel=0.015 if method == "map" else 1e-3)
    parts = np.linspace(0, 1, 4 if method == "adhesive" else 13)[1:]
    forces = np.array([first, *(pull_off(at_part(part)) for part in parts)])
    assert np.abs(np.diff(np.log(forces))).max() < 2.4 / parts.size
    assert pull_off(0.2) == pytest.approx(forces[-1], rel=0.2)


def test_a_humidity_at_which_nothing_condenses_varies_as_others_do(humid):
    varied = humid.contact.vary(roughxr.rigid, humidity=[1e-6, 0.1, 0.5], delta=[0.0])
    dry = humid.contact.assign_pair(sphere_radius=3000, materials="glass")
    expected = dry.contact.rigid(delta=[0.0])
    assert float(varied.pull_off_force[0, 0]) == float(expected.pull_off_force[0])
    assert float(varied.meniscus_error[0, 0]) == 0 < float(varied.meniscus_error[1, 0])
    with pytest.warns(UserWarning, match="thinner than a molecule"):
        below = humid.contact.assign_pair(sphere_radius=3000, materials="glass", humidity=1e-3)
    xr.testing.assert_equal(
        *(pair.contact.rolling(directions=4).drop_vars(OF_LIQUID, errors="ignore") for pair in (below, dry))
    )
    assert "nothing condenses" in sentences.liquid_words(below)
    assert "thinner than two molecules" in sentences.liquid_words(wet(humid, 0.1))


@pytest.fixture(scope="module")
def humid():
    return wet(scan(rough(48, rms=1.0)), materials="glass", contact_modulus=None)


def summit(radius=200.0, humidity=0.5, *, n=65, pixel=2.0, **options):
    """Return one round summit under the sphere, with its pair."""
    x = (np.arange(n) - n // 2) * pixel
    return wet(scan(10.0 - (x[:, None] ** 2 + x**2) / (2 * radius), pixel=pixel), humidity, **options)


@pytest.mark.parametrize("modulus", [40.0, 1.0, 1e-3])
def test_asperities_that_bend_are_maugiss_of_the_liquids_law(modulus):
    """λ = σ₀ (9R/(2πwE*²))^⅓ with the pull γ/r_K for σ₀, from DMT's 2πwR to JKR's 3/2."""
    pair = summit(contact_modulus=modulus)
    menisci = liquid.menisci_of(pair)
    mean_radius = 1 / (1 / 200 + 1 / 3000)
    parameter = menisci.capillary_pressure * (9 * mean_radius / (2 * np.pi * menisci.work * modulus**2)) ** (1 / 3)
    pull_off = float(pair.contact.pull_off_map(subregions=(1, 1), law="dugdale").pull_off_force[0])
    assert pull_off == pytest.approx(maugis.pull_off(parameter) * np.pi * menisci.work * mean_radius, rel=2e-3)
    mu = float(roughxr.reference.tabor(pair.contact.asperities()).tabor_parameter.max())
    assert mu == pytest.approx(parameter / 1.157, rel=1e-3)
    if modulus < 1:
        soft = float(pair.contact.pull_off_map(subregions=(1, 1), law="jkr").pull_off_force[0])
        assert (
            soft
            == pytest.approx(1.5 * np.pi * menisci.work * mean_radius, rel=1e-4)
            == pytest.approx(pull_off, rel=5e-3)
        )


def solved_moments(ds, places, *, directions):
    """Return the resisting moments of a simulation at these places."""
    return adhesive_and_moments(ds, subregions=places, mesh=2, directions=directions)[1]


def test_a_wet_sphere_rolls_off_slides_or_lifts(humid):
    """From the contacts of the simulation and its own pressures; the moment grows with the humidity."""
    bodies = {"sphere_radius": 1000, "contact_modulus": 40, "work_of_adhesion": 0}
    dry = humid.contact.assign_pair(**bodies, humidity=0.3)
    more = humid.contact.assign_pair(**bodies, humidity=0.8)
    moments = [solved_moments(ds, (2, 2), directions=6) for ds in (dry, more)]
    assert float(moments[1].resisting_moment.mean()) > 1.2 * float(moments[0].resisting_moment.mean()) > 0
    assert (moments[0].contact.critical_load().critical_friction_velocity > 0).all()
    places = resting(more).isel(subregion=[0, 1])
    resuspended = solved_moments(more, places, directions=6).contact.resuspension(friction_velocity=[0.01, 1e3])
    assert resuspended.remaining.values[:, 0].tolist() == [1.0, 0.0]
    solved = summit(humidity=0.5, n=33, pixel=4.0, contact_modulus=4.0).contact.adhesive(
        delta=[-0.4, 0.0, 0.4, 0.8], fields=True, mesh=roughxr.Mesh(4, accuracy=None)
    )
    rolled = solved.contact.rolling(directions=4)
    state = solved.sel(branch="retraction").isel(subregion=0)
    radius = np.sqrt(state.contact_area / np.pi)
    expected = float((-state.force * radius).max())
    np.testing.assert_allclose(rolled.resisting_moment.values[0], expected, rtol=0.15)


def test_superposed_asperities_of_a_humid_pair_do_not_roll(humid):
    with pytest.raises(ValueError, match=r"humidity: expected a dry pair.*rigid"):
        humid.contact.rolling()


def test_the_budget_changes_humidity_and_contact_angles(humid):
    changed = {"humidity": [-0.1, 0.1], "contact angle": [30.0]}
    budget = humid.contact.error_budget(places=1, settings=changed, mesh=roughxr.Mesh(accuracy=None))
    rises = [humid.assign_coords(liquid.humidity_coordinates(humid, share)) for share in (0.5, 0.6)]
    options = {"subregions": regions.sample(regions.centres(humid), 1), "mesh": roughxr.Mesh(accuracy=None)}
    low, high = (float(pair_at_share.contact.adhesive(**options).pull_off_force[0]) for pair_at_share in rises)
    assert float(np.expm1(budget.relative_std.sel(entry="humidity"))) >= (high / low - 1) * 0.98
    thin = humid.contact.rigid(delta=[0.0]).meniscus_error
    assert float(budget.pull_off_change.sel(entry="thin menisci")) == pytest.approx(-float(thin[0]), rel=1e-6)
    half_of_bias = np.log1p(0.5 * float(thin[0]))
    assert float(budget.relative_std.sel(entry="thin menisci")) == pytest.approx(half_of_bias, rel=1e-6)
    assert float(budget.pull_off_corrected) == pytest.approx(float(budget.pull_off_mean * (1 - thin[0])), rel=1e-6)
    with pytest.raises(ValueError, match="settings: expected a humid pair for 'humidity'"):
        humid.contact.assign_pair(sphere_radius=3000, materials="glass").contact.error_budget(settings=changed)


def test_humidity_varies_as_other_parts_of_the_pair_do(humid):
    varied = humid.contact.vary(roughxr.rigid, humidity=[0.3, 0.5, 0.9], delta=[0.0])
    assert varied.kelvin_radius.values == pytest.approx([liquid.kelvin_radius(share) for share in (0.3, 0.5, 0.9)])
    alone = humid.contact.rigid(delta=[0.0])
    assert float(varied.pull_off_force.sel(humidity=0.5)[0]) == pytest.approx(float(alone.pull_off_force[0]), rel=1e-12)
    with pytest.raises(ValueError, match="humid pair"):
        humid.contact.assign_pair(sphere_radius=3000, materials="glass").contact.vary(roughxr.rigid, humidity=[0.5])
    with pytest.raises(ValueError, match="saturation"):
        humid.contact.vary(roughxr.rigid, humidity=[0.5, 0.995], delta=[0.0])


@pytest.mark.parametrize(("humidity", "expected"), [(0.3, 0.44), (0.5, 0.26), (0.9, 0.04)])
def test_the_regime_says_whether_bodies_bend_under_the_water(humidity, expected):
    """Glass, R = 3 µm: Maugis's parameter of the water's law."""
    pair = wet(scan(rough(48, rms=1.0)), humidity, materials="glass", contact_modulus=None)
    regime = pair.contact.regime(subregions=(1, 1), mesh=1)
    assert float(regime.sphere_maugis) == pytest.approx(expected, abs=6e-3)
    assert ("a few molecules" in sentences.recommendation(regime)) == (humidity < 0.5)
    soft = wet(scan(rough(48, rms=1.0)), humidity, contact_modulus=0.01)
    assert soft.contact.regime(subregions=(1, 1), mesh=1).recommended.item() == "adhesive"


def test_the_waves_that_a_scan_shows_matter_less_in_humid_air():
    """Dry, the shortest waves decide; menisci higher than they are do not see them."""
    scan_ = roughxr.scans.synthetic.self_affine((64, 64), 10, rms=1.5, hurst=0.8, rolloff=200, cutoff=40, seed=3)
    changes = []
    for humidity in (None, 0.9):
        pair = scan_.contact.assign_pair(sphere_radius=500, materials="glass", humidity=humidity)
        shown, smoothed = (rigid_pull_off(pair, wave, law="hamaker") for wave in (40, 160))
        changes.append(smoothed / shown)
    assert changes[0] - 1 > 2 * (changes[1] - 1) > 0


def test_a_run_takes_a_humid_pair_through_all_its_parts(tmp_path, capsys):
    ground = roughxr.scans.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    pair = wet(ground, 0.7, 500.0, work_of_adhesion=(0.06, 0.004))
    options = {"subregions": (2, 1), "particle": True, "delta": [1.0, 2.0], "mesh": 2, "budget": 0}
    with bare_runs():
        groups = roughxr.run(pair, tmp_path / "run.nc", **options)
    explored = report.write_explorer(tmp_path / "run.nc").read_text(encoding="utf-8")
    assert "for the synthetic surface at 70 % relative humidity" in explored
    assert {"solutions/adhesive", "solutions/rigid", "statistics/regime"} <= set(groups)
    assert {"solutions/rolling", "statistics/formulas", "statistics/detachment"} <= set(groups)
    assert not {"solutions/published", "solutions/energy"} & set(groups)
    places = report.by_place(groups)
    assert float(places.critical_friction_velocity.min()) > 0
    assert "simulation as scanned" in capsys.readouterr().out
    stiff, bent = (groups[f"statistics/{name}"].pull_off_force.mean() for name in ("rigid", "adhesive"))
    assert float(bent) == pytest.approx(float(stiff), rel=0.05)


def test_the_command_line_takes_the_humid_air(tmp_path):
    roughxr.open_sample("glass").isel(x=slice(32), y=slice(32)).to_netcdf(tmp_path / "scan.nc")
    arguments = ["--sphere-radius", "1 um", "--materials", "glass", "--contact-angle", "20", "60"]
    options = command_line().parse_args(["run", str(tmp_path / "scan.nc"), *arguments, "--humidity", "60 %"])
    pair = paired(roughxr.open_sample("glass"), options)
    assert float(pair.humidity) == 0.6 and float(pair.contact_angle_2) == pytest.approx(np.pi / 3)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
@pytest.mark.parametrize("humidity", [0.3, 0.5, 0.9])
def test_the_simulation_gives_the_anchors_of_stiff_bodies_and_maugis_of_others(humidity):
    """Dugdale's law is the liquid's: on stiff bodies 4πRγ, on glass the pull-off of Maugis's λ."""
    humid_pair = {"sphere_radius": 3000.0, "work_of_adhesion": 0.0, "humidity": humidity}
    stiff = scan(np.zeros((101, 101)), 5.0).contact.assign_pair(contact_modulus=1e4, **humid_pair)
    simulated = stiff.contact.adhesive(mesh=roughxr.Mesh(1, accuracy=None))
    assert float(simulated.pull_off_force[0]) == pytest.approx(4 * np.pi * 3000 * GAMMA, rel=0.01)
    if humidity == 0.9:
        return
    glass = scan(np.zeros((101, 101)), 5.0).contact.assign_pair(contact_modulus=39.4, **humid_pair)
    work = 2 * GAMMA
    pull = GAMMA / float(glass.kelvin_radius)
    maugis = pull * (9 * 3000 / (2 * np.pi * work * 39.4**2)) ** (1 / 3)
    length = 1.157 / maugis * (3000 * work**2 / 39.4**2) ** (1 / 3)
    expected = maugis_pull_off(radius=3000, contact_modulus=39.4, work_of_adhesion=work, adhesion_range=length)
    simulated = glass.contact.adhesive(mesh=roughxr.Mesh(1, accuracy=None))
    assert float(simulated.pull_off_force[0]) == pytest.approx(expected, rel=0.01)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")
def test_the_simulation_sums_the_works_of_liquid_and_solids():
    """The solids' part under the liquid and, beyond its edge, their whole: as between rigid bodies."""
    pair = wet(scan(np.zeros((101, 101)), 5.0), 0.3, contact_modulus=1e4, work_of_adhesion=(0.06, 0.02))
    rigid = pair.contact.rigid(delta=[0.0], law="exponential", mesh=2)
    simulated = pair.contact.adhesive(mesh=roughxr.Mesh(2, accuracy=None))
    assert float(simulated.pull_off_force[0]) == pytest.approx(float(rigid.pull_off_force[0]), rel=0.01)
    assert float(rigid.pull_off_force[0]) > 1.08 * 4 * np.pi * 3000 * GAMMA
    with pytest.raises(ValueError, match="humid pair"):
        pair.contact.adhesive(law="jkr")


def test_the_smooth_sphere_to_compare_with_is_wet_too():
    pair = wet(flat(3000.0), 0.9, materials="glass", contact_modulus=None)
    reduced = roughxr.statistics.reduction(pair.contact.rigid(law="exponential", delta=[0.0]))
    assert float(reduced.pull_off_ratio[0]) == pytest.approx(1.0, rel=5e-3)


def test_formulas_of_liquid_stand_beside_the_sum_over_the_scan():
    """A smooth sphere and one summit by 4πRγ cos θ, a plane below, and Gaussian heights by their closed form."""
    pair = wet(scan(rough(96, rms=1.5), pixel=8.0), 0.9, contact_angle=30)
    table = pair.contact.formulas(subregions=(2, 2), mesh=2)
    force = table.pull_off_force
    inputs = table.attrs
    menisci = liquid.menisci_of(pair)
    assert float(force.sel(formula="smooth")) == pytest.approx(4 * np.pi * 3000 * GAMMA * np.cos(np.pi / 6))
    share = inputs["asperity_radius"] / (inputs["asperity_radius"] + 3000)
    assert float(force.sel(formula="summit") / force.sel(formula="smooth")) == pytest.approx(share)
    below = 1 - 1.82 * inputs["rms"] / menisci.height
    assert float(force.sel(formula="plane_below") / force.sel(formula="smooth")) == pytest.approx(below)
    s = inputs["rms"]

    def integral(x):
        return x * ndtr(x) + np.exp(-0.5 * x * x) / np.sqrt(2 * np.pi)

    expected = s / menisci.height * (integral(menisci.height / s - 4) - integral(-4))
    assert float(force.sel(formula="gaussian_heights") / force.sel(formula="smooth")) == pytest.approx(
        expected, rel=5e-3
    )
    assert float(force.sel(formula="sum") / force.sel(formula="smooth")) == pytest.approx(1, abs=0.5)
    assert "Rabinovich 2002" in report.tables({"statistics/formulas": table})["Usual formulas"].index[3]


def test_what_menisci_hold_is_not_taken_under_water(humid, tmp_path, capsys):
    with pytest.raises(ValueError, match="flow: expected a dry pair in a liquid"):
        roughxr.run(humid, tmp_path / "refused.nc", flow="water")
    held = solved_moments(humid, (2, 1), directions=4)
    groups = dict.fromkeys(report.DETACHMENT, held) | {"scan": humid}
    groups["statistics/detachment"] = held.contact.critical_load()
    roughxr.archive.save(groups, tmp_path / "run.nc")
    assert cli.main(["detach", str(tmp_path / "run.nc"), "--method", "adhesive", "--fluid", "water"]) == 1
    assert "expected a dry pair" in capsys.readouterr().err
    assert cli.main(["detach", str(tmp_path / "run.nc"), "--method", "adhesive"]) == 0
    printed = capsys.readouterr().out
    assert "pull-off forces: simulation as scanned" in printed
    assert "with the run's dry work of adhesion" in printed and "relative humidity add to it" in printed


@pytest.mark.parametrize("work", [0.001, 0.0005])
def test_solids_that_would_attract_more_under_the_liquid_are_refused(work):
    with pytest.raises(ValueError, match="no less in air than under the liquid"):
        scan(np.zeros((9, 9))).contact.assign_pair(
            sphere_radius=1000, contact_modulus=40, work_of_adhesion=work, humidity="60 %"
        )


def test_varied_work_of_adhesion_derives_the_share_under_the_liquid_again():
    humid_pair = {"sphere_radius": 1000.0, "contact_modulus": 40.0, "humidity": 0.5}
    surface = scan(np.zeros((41, 41)), 10.0)
    works = [0.1, 0.2, 0.5]
    varied = surface.contact.assign_pair(work_of_adhesion=0.1, **humid_pair).contact.vary(
        roughxr.rigid, work_of_adhesion=works, delta=[-1.0]
    )
    alone = [
        float(
            surface.contact.assign_pair(work_of_adhesion=w, **humid_pair).contact.rigid(delta=[-1.0]).pull_off_force[0]
        )
        for w in works
    ]
    assert varied.pull_off_force.values.ravel() == pytest.approx(alone)
