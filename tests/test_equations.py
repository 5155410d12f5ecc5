"""The paper's equations 1-45: the page that lists them, and the steps that no other test checks."""

import ast
import importlib
import re
from pathlib import Path

import numpy as np
import pytest
from scipy import special

from roughxr import asperities, reference
from roughxr.mechanics.kernels.asperity import elliptic_jkr
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio
from roughxr.mechanics.kernels.topography.paraboloid import principal

from .surfaces import rough, scan

PAGE = Path(__file__).parents[1] / "notebooks" / "site" / "equations.md"
TESTS = Path(__file__).parent

E_STAR = 39.4
GAMMA = 0.67


def integrals(lam):
    """Return K and E of the modulus √(1 − λ²)."""
    return special.ellipkm1(lam**2), special.ellipe(1 - lam**2)


# --- the page ---


def rows():
    """Return the cells of the page's rows that begin with numbers of equations."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    cells = [re.split(r"\s*\|\s*", line)[1:-1] for line in lines if line.startswith("| ")]
    return [row for row in cells if re.fullmatch(r"[\d, –]+", row[0])]


def resolved(name):
    """Return the object of a dotted name below the package."""
    names = name.removeprefix("roughxr.").split(".")
    for count in range(len(names), -1, -1):
        try:
            item = importlib.import_module(".".join(["roughxr", *names[:count]]))
        except ModuleNotFoundError:
            continue
        for attribute in names[count:]:
            item = getattr(item, attribute)
        return item
    raise AssertionError(name)


def test_the_page_names_each_equation_once():
    numbers = []
    for row in rows():
        for part in row[0].split(", "):
            first, _, last = part.partition("–")
            numbers += range(int(first), int(last or first) + 1)
    assert sorted(numbers) == list(range(1, 46))


def test_each_function_on_the_page_exists():
    text = PAGE.read_text(encoding="utf-8")
    names = re.findall(r"`~?((?:roughxr\.|mechanics\.kernels\.)[\w.]+)`", text)
    assert len(names) > 25
    assert all(callable(resolved(name)) for name in names)
    assert all(re.match(r"({py:func})?`[\w~.]+`<br>|a step to 15<br>", row[3]) for row in rows())


def test_each_test_on_the_page_exists():
    text = PAGE.read_text(encoding="utf-8")
    pairs = re.findall(r"`(test_\w+\.py)::(test_\w+)`", text)
    assert len(pairs) >= len(rows()) and all("::test_" in row[3] for row in rows())
    for file, name in set(pairs):
        tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
        assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, (file, name)


# --- one asperity ---


@pytest.mark.parametrize("lam", [0.95, 0.6, 0.1])
def test_displacement_under_the_papers_pressure_is_that_of_equations_2_to_6(lam):
    """On a = 1, b = λ with E* = 1; 1 is a case of the general pressure with c₀ = p₀ + p₁, c₁ = c₂ = −p₀."""
    p0 = 1.3
    p1 = -0.4
    K, E = integrals(lam)
    delta, A, B = elliptic_jkr.displacement(p0 + p1, -p0, -p0, lam)
    factor = p0 * lam / (1 - lam**2)
    assert pytest.approx(factor * (K - E)) == A
    assert pytest.approx(factor * (E / lam**2 - K)) == B
    assert delta == pytest.approx(lam * K * (p0 + 2 * p1))
    assert A + B * lam**2 == pytest.approx(p0 * lam * K)


def strain_energy(a, lam, beta, delta):
    """Return U_E by equation 8, corrected, with the pressures of equations 10 and 11."""
    K, _ = integrals(lam)
    b = lam * a
    p0 = beta * a**2 * E_STAR / (b * K)
    p1 = (delta - beta * a**2) * E_STAR / (2 * b * K)
    braces = b * K / E_STAR * (p0**2 / 3 + 5 / 3 * p0 * p1 + 2 * p1**2) - beta * a**2 * (p0 / 15 + p1 / 3)
    return np.pi * a * b * braces, p0, p1


@pytest.mark.parametrize("lam", [1.0, 0.6, 0.2])
def test_strain_energy_of_equations_8_9_12_and_13(lam):
    a = 80.0
    beta = 4e-4
    delta = 1.1
    step = 1e-3
    K, _ = integrals(lam)
    energy, p0, p1 = strain_energy(a, lam, beta, delta)
    bracket = beta**2 * a**4 / 5 - 2 / 3 * beta * delta * a**2 + delta**2
    assert energy == pytest.approx(np.pi * a * E_STAR / (2 * K) * bracket)
    above, below = (strain_energy(a + change, lam, beta, delta)[0] for change in (step, -step))
    slope = 2 * np.pi * lam**2 * a**2 * K * p1**2 / E_STAR
    assert (above - below) / (2 * step) == pytest.approx(slope, rel=1e-6)
    if lam == 1.0:
        sphere = np.pi**2 * a**3 / E_STAR * (2 / 15 * p0**2 + 2 / 3 * p0 * p1 + p1**2)
        assert energy == pytest.approx(sphere)


@pytest.mark.parametrize("formulation", ["self_similar", "published"])
def test_pressure_of_equations_10_11_16_carries_the_load_of_17(formulation):
    """The printed 16, with a for b, belongs to the printed 15."""
    A = 1 / 900
    B = 1 / 300
    lam = axis_ratio(B / A)
    K, _ = integrals(lam)
    shape = {"curvature_min": 2 * A, "curvature_max": 2 * B, "formulation": formulation}
    contact = reference.jkr_paraboloid([-0.05, 0.0, 1.0], **shape, contact_modulus=E_STAR, work_of_adhesion=2 * GAMMA)
    for branch, delta in (("stable", -0.05), ("stable", 1.0), ("unstable", -0.05)):
        state = contact.sel(branch=branch, delta=delta)
        a = float(state.semi_axis_a)
        b = float(state.semi_axis_b)
        p0 = (A * a**2 + B * b**2) * E_STAR / (b * K)
        p1 = (delta - A * a**2 - B * b**2) * E_STAR / (2 * b * K)
        edge = a if formulation == "published" else b
        assert p1 == pytest.approx(-np.sqrt(2 * GAMMA * E_STAR / (edge * K)))
        assert float(state.force) == pytest.approx(2 * np.pi * lam * a**2 * (p0 / 3 + p1))


def test_the_sphere_satisfies_equation_19():
    R = 3000.0
    contact = reference.jkr_sphere([-1.0, 0.0, 7.0], radius=R, contact_modulus=E_STAR, work_of_adhesion=2 * GAMMA)
    a = contact.semi_axis_a.values
    hertz = 4 * E_STAR * a**3 / (3 * R)
    assert (contact.force.values - hertz) ** 2 == pytest.approx(16 * np.pi * GAMMA * E_STAR * a**3)


# --- peaks and fit ---


def test_coefficients_of_counted_heights_are_scaled_by_equations_27_to_30():
    """Least squares of 26 on the 5 × 5 counts around each peak, by hand, against the catalogue of heights in nm."""
    pixel = 9.77
    step = 0.1
    counts = np.round(rough(48, rms=1.5, smooth=2.0, seed=4) / step)
    catalogue = asperities(scan(counts * step, pixel=pixel), patch="paper")
    whole = catalogue.isel(asperity=~(catalogue.edge | catalogue.saddle).values)
    assert whole.sizes["asperity"] > 10
    i, j = (array.ravel() for array in np.mgrid[-2:3, -2:3])
    terms = np.c_[i**2, j**2, i * j]
    surface = scan(counts * step, pixel=pixel)
    for k in range(whole.sizes["asperity"]):
        peak = whole.isel(asperity=k)
        row, column = (int(np.argmin(abs(surface[axis].values - float(peak[axis])))) for axis in ("x", "y"))
        depth = counts[row, column] - counts[row + i, column + j]
        A, B, C = np.linalg.lstsq(terms, depth, rcond=None)[0] * step / pixel**2
        expected = np.linalg.eigvalsh([[2 * A, C], [C, 2 * B]])
        assert [float(peak.curvature_min), float(peak.curvature_max)] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("coefficients", [(2.0, 1.0, 0.5), (1.0, 2.0, 0.5), (1.0, 1.5, -0.8), (1.0, 1.0, 0.3)])
def test_principal_axes_are_those_of_equations_32_to_34(coefficients):
    A, B, C = coefficients
    theta = 0.5 * np.arctan2(C, A - B)
    cosine = np.cos(theta)
    sine = np.sin(theta)
    first = A * cosine**2 + B * sine**2 + C * cosine * sine
    second = A * sine**2 + B * cosine**2 - C * cosine * sine
    flat, sharp, orientation = principal(A, B, C)
    assert (flat / 2, sharp / 2) == pytest.approx(sorted((first, second)))
    flattest = theta if first < second else theta + np.pi / 2
    assert np.sin(orientation - flattest) == pytest.approx(0, abs=1e-12)


# --- the half space ---


def test_compliances_of_equation_40_add_to_the_contact_modulus():
    """(1/2π) Σ (1 − μ)/G with G = E/(2 + 2μ) is 1/(πE*)."""
    bodies = ((75.0, 0.22), (160.0, 0.27))
    compliance = sum((1 - mu) * (2 + 2 * mu) / E for E, mu in bodies) / (2 * np.pi)
    modulus = reference.contact_modulus([75.0, 160.0], [0.22, 0.27])
    assert compliance == pytest.approx(1 / (np.pi * modulus))
