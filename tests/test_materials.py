"""The pair of bodies, against the paper's numbers and limits."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from roughxr.application.reproduction.printed import PAIR
from roughxr.mechanics.bodies import substances
from roughxr.mechanics.bodies.pair import ImplausiblePair, assign_pair, contact_modulus, hamaker_constant, indenter_map
from roughxr.mechanics.bodies.substances import MATERIALS
from roughxr.mechanics.vocabulary.refusal import Refusal

from .surfaces import scan


def test_the_papers_pair():
    assert contact_modulus(75, 0.22) == pytest.approx(39.407, abs=5e-4)
    assert PAIR["surface_energy"] == pytest.approx(0.67478, abs=5e-6)
    assert 3 * np.pi * PAIR["surface_energy"] * 3000 == pytest.approx(19.08e3, rel=1e-3)  # the printed 19.1 µN


def test_a_rigid_body_adds_no_compliance():
    assert contact_modulus((75, np.inf), (0.22, 0.3)) == pytest.approx(2 * contact_modulus(75, 0.22))
    assert contact_modulus((75, 200), (0.22, 0.3)) == pytest.approx(1 / ((1 - 0.22**2) / 75 + (1 - 0.3**2) / 200))


def test_surface_energy_is_half_the_work_of_adhesion():
    ds = scan(np.zeros((4, 4)))
    by_energy, by_work = (
        assign_pair(ds, sphere_radius=3000, contact_modulus=40, **energy)
        for energy in ({"surface_energy": 0.5}, {"work_of_adhesion": 1.0})
    )
    assert float(by_energy.work_of_adhesion) == float(by_work.work_of_adhesion) == 1.0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "one of sphere_radius, indenter, found none"),
        ({"sphere_radius": 3000}, "one of materials, contact_modulus, young_modulus, found none"),
        ({"sphere_radius": -3, "contact_modulus": 1}, "positive"),
        ({"sphere_radius": "3 GPa", "contact_modulus": 1}, "nm"),
        ({"sphere_radius": "three", "contact_modulus": 1}, "sphere_radius"),
        ({"sphere_radius": [1, 2], "contact_modulus": 1}, "one positive number"),
        ({"sphere_radius": np.nan, "contact_modulus": 1}, "finite"),
        ({"sphere_radius": 3000, "young_modulus": 75}, "poisson_ratio"),
        (
            {"sphere_radius": 3000, "materials": "glass", "poisson_ratio": 0.2},
            "expected none without young_modulus",
        ),
        ({"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.7}, "poisson_ratio"),
        ({"sphere_radius": 3000, "young_modulus": (1, 2, 3), "poisson_ratio": 0.2}, "pair"),
        ({"sphere_radius": 3000, "young_modulus": np.inf, "poisson_ratio": 0.2}, "elastic"),
        ({"sphere_radius": 3000, "contact_modulus": 1, "young_modulus": 2}, "found contact_modulus and young_modulus"),
        ({"sphere_radius": 3000, "contact_modulus": 1, "surface_energy": -1}, ">= 0"),
        (
            {"sphere_radius": 3000, "contact_modulus": 1, "surface_energy": 1, "work_of_adhesion": 1},
            "found both",
        ),
    ],
)
def test_bad_pairs_are_refused_in_words(options, says):
    with pytest.raises(ValueError, match=says):
        assign_pair(scan(np.zeros((4, 4))), **options)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"sphere_radius": 3e-6}, "expected 0.2 to 1e.10 nm, as bodies have, found 3e-06 nm"),
        ({"sphere_radius": 3e12}, "as bodies have, found 3e.12 nm"),
        ({"sphere_radius": "um"}, "expected a number with its units such as '3 nm', found 'um'"),
        ({"sphere_radius": 9}, "expected more than one pixel, found 9 nm, 0.92 pixels of 9.77 nm"),
        ({"young_modulus": 70e9}, "young_modulus: .* as bodies have, found 7e.10 GPa by 7e.10"),
        ({"contact_modulus": 40e9}, "contact_modulus: .* as bodies have"),
        ({"work_of_adhesion": 100}, r"work_of_adhesion: .* as bodies have, found 100 J/m\^2"),
        ({"surface_energy": 50}, r"surface_energy: .* as bodies have, found 100 J/m\^2 by 50"),
        ({"materials": "glass/cheese"}, "one or two of glass, .* found 'glass/cheese'"),
        ({"materials": "glass/glass/glass"}, "one or two of"),
    ],
)
def test_what_no_body_has_is_refused(options, says):
    with pytest.raises(ValueError, match=says):
        _assigned(options)


@pytest.mark.parametrize(
    "options",
    [
        {"sphere_radius": 30},
        {"sphere_radius": "3 cm"},
        {"young_modulus": 2000},
        {"contact_modulus": 1e-8},
        {"work_of_adhesion": 10},
        {"work_of_adhesion": 1e-7},
    ],
)
def test_what_is_hardly_meant_is_questioned(options):
    with pytest.warns(ImplausiblePair) as warned:
        _assigned(options)
    assert warned[0].filename == __file__
    assert next(iter(options)) in str(warned[0].message)


@pytest.mark.parametrize(
    "options",
    [
        {"sphere_radius": 500},
        {"young_modulus": (np.inf, 1e-6)},
        {"work_of_adhesion": 0},
        {"work_of_adhesion": "50 mJ/m^2"},
        {"materials": "silicon"},
    ],
)
def test_what_is_plausible_is_taken_without_a_word(options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _assigned(options)


def _assigned(options):
    ways = {"young_modulus", "contact_modulus", "materials"} & set(options)
    modulus = {} if ways else {"contact_modulus": 40}
    poisson = {"poisson_ratio": 0.3} if "young_modulus" in options else {}
    return assign_pair(scan(np.zeros((4, 4))), **{"sphere_radius": 3000, **modulus, **poisson, **options})


def test_named_materials_are_those_of_their_sources():
    flat = scan(np.zeros((4, 4)))
    named = assign_pair(flat, sphere_radius=3000, materials=("Silicon", "polystyrene"), work_of_adhesion=0.1)
    by_hand = assign_pair(
        flat, sphere_radius=3000, young_modulus=(130, 2.8), poisson_ratio=(0.28, 0.33), work_of_adhesion=0.1
    )
    assert float(named.contact_modulus) == float(by_hand.contact_modulus)
    assert float(named.work_of_adhesion) == 0.1
    glass = assign_pair(flat, sphere_radius=3000, materials="silicon/glass")
    assert 0.03 < float(glass.work_of_adhesion) < 0.5


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_brings_what_its_example_needs_with_its_source(name):
    pair = assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials=f"glass/{name}")
    assert {"contact_modulus", "work_of_adhesion", "hamaker_constant", "hardness_estimate"} <= set(pair.coords)
    assert 0.01 < hamaker_constant(name) < 0.5
    material = MATERIALS[name]
    assert material.elastic_source and material.hardness_source and material.hamaker_source


#: Index of refraction, static permittivity (conductors: infinite), and main absorption frequency (10¹⁵ Hz).
OPTICAL = {
    "silica": (1.448, 3.8, 3.2),
    "alumina": (1.753, 11.6, 3.2),
    "polystyrene": (1.557, 2.55, 2.3),
    "ptfe": (1.359, 2.1, 2.9),
    "steel": (1.97, np.inf, 3.0),  # Fe3O4
    "calcite": (1.60, 8.0, 3.0),
    "mica": (1.60, 7.0, 3.0),
    "silicon_nitride": (1.98, 7.4, 2.45),
    "pmma": (1.49, 3.6, 3.0),
    "water": (1.333, 80.0, 3.0),
    "ethanol": (1.361, 26.0, 3.0),
    "hexadecane": (1.423, 2.05, 2.9),
}


@pytest.mark.parametrize("name", OPTICAL)
def test_hamaker_constants_follow_from_optical_constants(name):
    """By Tabor and Winterton's formula of Lifshitz's theory across vacuum, in zJ."""
    index, permittivity, frequency = OPTICAL[name]
    ratio = 1.0 if np.isinf(permittivity) else (permittivity - 1) / (permittivity + 1)
    static = 0.75 * 4.05 * ratio**2  # of k T at 293 K
    dispersion = 3 * 662.6 * frequency / (16 * np.sqrt(2)) * (index**2 - 1) ** 2 / (index**2 + 1) ** 1.5
    tabulated = hamaker_constant(name) if name in MATERIALS else substances.MEDIA[name]
    assert 1e3 * tabulated == pytest.approx(static + dispersion, rel=0.05)


def test_golds_hamaker_constant_is_one_of_a_metal_and_silicons_that_of_its_oxide():
    low, high = (3 * 662.6 * frequency / (16 * np.sqrt(2)) for frequency in (3.0, 5.0))
    assert low < 1e3 * hamaker_constant("gold") < high
    assert hamaker_constant("silicon") == hamaker_constant("silica") == hamaker_constant("glass")


@pytest.mark.parametrize("constant", [65, "6.5e-20", 6.5e-20])
def test_a_hamaker_constant_in_other_units_is_refused_with_its_own(constant):
    with pytest.raises(ValueError, match=r"(?s)hamaker_constant.*30 to 500 zJ"):
        assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, contact_modulus=40, hamaker_constant=constant)


@pytest.mark.parametrize(
    ("names", "twice_the_surface_energy"),
    [("polystyrene", 2 * 0.033), ("ptfe", 2 * 0.0183)],  # measured; Israelachvili, table 13.2
)
def test_van_der_waals_work_of_adhesion_is_near_twice_the_measured_surface_energy(names, twice_the_surface_energy):
    pair = assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials=names)
    assert float(pair.work_of_adhesion) == pytest.approx(twice_the_surface_energy, rel=0.05)


def _probe():
    """Return a scan of a probe's face as the microscope draws it, from its corner, lopsided."""
    x = np.arange(61) * 10.0 + 5
    y = np.arange(51) * 10.0 + 5
    height = 40.0 - (x[:, None] - 205) ** 2 / 2000 - (y - 285) ** 2 / 1000
    height[20, 28 + 10] += 3.0  # a bump 100 nm above the apex in the picture
    axes = {"x": ("x", x, {"units": "nm"}), "y": ("y", y, {"units": "nm"})}
    return xr.Dataset({"height": (("x", "y"), height, {"units": "nm"})}, axes)


def test_a_scan_of_a_probe_faces_the_surface_with_its_top_at_the_contact_centre():
    pair = assign_pair(scan(np.zeros((4, 4))), indenter=_probe(), contact_modulus=40)
    x, y, height = indenter_map(pair)
    assert height[np.ix_(x == 0, y == 0)].item() == height.max() == 40.0
    assert np.all(np.diff(x) > 0) and np.all(np.diff(y) > 0)
    across = height[x == 0].ravel()
    excess = across - (40.0 - y**2 / 1000)
    assert y[excess.argmax()] == -100.0  # turned over about the x axis
    assert (x[0], x[-1]) == (-200.0, 400.0)


def test_a_map_counted_from_its_corner_is_refused_with_what_to_do():
    with pytest.raises(
        ValueError, match=r"counted from the contact centre, found x from 5 to 605 nm; give the whole scan"
    ):
        assign_pair(scan(np.zeros((4, 4))), indenter=_probe().height, contact_modulus=40)


def test_named_bodies_adhere_across_a_medium_by_hamakers_rule():
    flat = scan(np.zeros((9, 9)))
    dry, immersed = (assign_pair(flat, sphere_radius=3000, materials="silica", medium=m) for m in ("air", "water"))
    assert float(immersed.hamaker_constant) == pytest.approx(hamaker_constant("silica", medium="water"))
    ratio = (1 - np.sqrt(substances.MEDIA["water"] / 0.065)) ** 2
    assert float(immersed.work_of_adhesion / dry.work_of_adhesion) == pytest.approx(ratio)
    assert float(immersed.contact_modulus) == float(dry.contact_modulus)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"materials": "ptfe/silica", "medium": "ethanol"}, "they do not adhere"),
        ({"materials": "silica", "medium": "water", "work_of_adhesion": 0.1}, "under the medium instead"),
        ({"materials": "silica", "medium": "water", "humidity": 0.5}, "found both; leave medium or humidity out"),
        ({"contact_modulus": 40, "medium": "water"}, "named materials alone"),
        ({"materials": "silica", "medium": "watr"}, "medium: .*water"),
    ],
)
def test_a_medium_of_unknown_or_repulsive_attraction_is_refused(options, says):
    with pytest.raises(ValueError, match=says):
        assign_pair(scan(np.zeros((9, 9))), sphere_radius=3000, **options)


def test_an_unlisted_material_is_no_misspelt_other():
    with pytest.raises(Refusal, match=r"found 'talc/glass'; for another material"):
        substances.named_pair("talc/glass")
    with pytest.raises(Refusal, match=r"found 'silica/silcon' \(did you mean silicon\?\)"):
        substances.named_pair("silica/silcon")


def test_moduli_of_crystals_follow_from_their_constants():
    """Calcite's by Hill's average; mica's pressed on its cleavage plane, of a transversely isotropic solid."""
    stiffness = np.diag([137.0, 137, 81.1, 35, 35, 44.4])
    stiffness[0, 1] = stiffness[1, 0] = 48.2
    stiffness[:2, 2] = stiffness[2, :2] = 56.8
    for i, j, constant in ((0, 3, -20.0), (1, 3, 20.0), (4, 5, -20.0)):
        stiffness[i, j] = stiffness[j, i] = constant
    bulk, shear = np.mean([_voigt(stiffness), _reuss(np.linalg.inv(stiffness))], axis=0)
    assert MATERIALS["calcite"].young_modulus == pytest.approx(9 * bulk * shear / (3 * bulk + shear), rel=0.01)
    ratio = (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
    assert MATERIALS["calcite"].poisson_ratio == pytest.approx(ratio, abs=0.01)
    along, across, mixed, sheared = 179.7, 58.6, 23.4, 18.0
    root = np.sqrt(along * across)
    pressed = 2 * np.sqrt((root**2 - mixed**2) / along / (1 / sheared + 2 / (root + mixed)))
    mica = MATERIALS["mica"]
    assert mica.young_modulus / (1 - mica.poisson_ratio**2) == pytest.approx(pressed, rel=0.01)


def _voigt(stiffness):
    """Return bulk and shear modulus at equal strain."""
    normal, mixed, sheared = (
        np.trace(stiffness[:3, :3]),
        np.triu(stiffness[:3, :3], 1).sum(),
        np.trace(stiffness[3:, 3:]),
    )
    return (normal + 2 * mixed) / 9, (normal - mixed + 3 * sheared) / 15


def _reuss(compliance):
    """Return bulk and shear modulus at equal stress."""
    normal, mixed = np.trace(compliance[:3, :3]), np.triu(compliance[:3, :3], 1).sum()
    return 1 / (normal + 2 * mixed), 15 / (4 * normal - 4 * mixed + 3 * np.trace(compliance[3:, 3:]))


def test_the_page_of_materials_has_their_numbers():
    page = (Path(__file__).parents[1] / "notebooks" / "site" / "materials.md").read_text(encoding="utf-8")
    for name, material in MATERIALS.items():
        start = f"| {name} | {material.young_modulus:g} | {material.poisson_ratio:g} | {material.elastic_source} |"
        assert f"{start} " in page and f"| {1e3 * material.hamaker_constant:g} |" in page


def test_materials_of_a_users_own_table_come_first(tmp_path, monkeypatch):
    table = tmp_path / "own.csv"
    table.write_text(
        "name,young_modulus,poisson_ratio,hamaker_constant\nPVA film,2000 MPa,0.4,70 zJ\nglass,70,0.2,0.06\n"
    )
    monkeypatch.setenv("ROUGHXR_MATERIALS", str(table))
    pair = assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials="glass/pva film")
    expected = 1 / ((1 - 0.2**2) / 70 + (1 - 0.4**2) / 2)
    assert float(pair.contact_modulus) == pytest.approx(expected)
    assert float(pair.hamaker_constant) == pytest.approx(np.sqrt(0.07 * 0.06))
    with pytest.raises(ValueError, match=r"for another material give young_modulus.* ROUGHXR_MATERIALS names"):
        assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials="cheese")
    with pytest.raises(ValueError, match=r"found 'limestone' \(did you mean calcite\?\)"):
        assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials="limestone")
    for value, fault in (("nan", "finite"), ("-0.07", "one positive"), ("70", "as bodies have, found 70 nN nm")):
        table.write_text(f"name,young_modulus,poisson_ratio,hamaker_constant\nPVA,2,0.4,{value}\n")
        with pytest.raises(ValueError, match=f"hamaker_constant.*{fault}"):
            assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials="pva")
    table.write_text("name,young_modulus,poisson_ratio\nPVA,2,0.4\n")
    with pytest.raises(ValueError, match=r"own.csv: expected hamaker_constant of pva \(nN nm\), found none"):
        assign_pair(scan(np.zeros((4, 4))), sphere_radius=3000, materials="pva")
