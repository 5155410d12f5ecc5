"""Moduli and works of adhesion fitted to curves of known spheres lie in their intervals, by every law."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.application.cli import main
from roughxr.mechanics.kernels.asperity import maugis

REACH = 0.3


def branch(modulus, work, radius):
    """Return the law that Tabor's parameter chooses, and force and indentation along its stable branch."""
    a_c = (9 * np.pi * work * radius**2 / (8 * modulus)) ** (1 / 3)
    pull = 1.5 * np.pi * work * radius
    tabor = (radius * work**2 / (modulus**2 * REACH**3)) ** (1 / 3)
    a = np.r_[np.linspace(0.481, 1, 4000), np.geomspace(1.0005, 200, 20000)]
    if tabor > 5:
        return "jkr", pull * (a**3 - 2 * a**1.5), a_c**2 / radius * (a**2 - 4 / 3 * np.sqrt(a))
    if tabor < 0.1:
        a = np.r_[0.0, np.geomspace(1e-4, 200, 20000)]
        return "dmt", np.pi * work * radius * (a**3 - 2), a_c**2 / radius * a**2 / 1.5 ** (2 / 3)
    force, _, indentation = maugis.contact_at(1.157 * tabor, 1 + np.geomspace(1e7, 1e-7, 40000))
    return "dugdale", pull * force, a_c**2 / radius * indentation


def measured(rng, modulus, work, radius, stiffness, errors, *, with_approach=True, drift=0.0):
    """Return a curve as recorded: with noise that is correlated, tilt, drift, and wrong calibrations."""
    _, force, indentation = branch(modulus, work, radius)
    travel = indentation + force / stiffness
    fold = int(np.argmin(travel))
    travel, force, pull = travel[fold:], force[fold:], -force[fold:].min()
    top = np.interp(rng.uniform(1, 5) * pull, force, travel)
    n = int(rng.choice([500, 1000, 2000]))
    span = (top - travel[0]) * rng.uniform(2.5, 5)
    piezo = top - np.linspace(0, span, n)
    noise = pull * 10 ** rng.uniform(-2.7, -1.5)
    stiffer, larger = np.array(errors) * rng.normal(size=2)
    recorded = []
    for end, z in ((travel[0], piezo), (max(travel[0], 0.0), piezo[::-1]))[
        : 1 + with_approach
    ]:  # on approach it snaps in
        recorded_force = np.where(z >= end, np.interp(z, travel, force), 0) * np.exp(-stiffer - larger)
        memory = np.exp(-np.arange(40) / rng.uniform(0.1, 6.0))
        recorded_force += noise * np.convolve(rng.normal(size=n + 39), memory / np.sqrt((memory**2).sum()), "valid")
        recorded_force += pull * (rng.normal() + 0.1 * rng.normal() * (z - top) / span) + drift * noise * np.linspace(
            0, 1, n
        )
        recorded.append((z + 1000 * rng.normal(), recorded_force))
    values = np.array(recorded).transpose(1, 0, 2)
    dims = ("branch", "sample")
    names = ["retraction", "loading"][: 1 + with_approach]
    made = {"piezo": (dims, values[0], {"units": "nm"}), "force": (dims, values[1], {"units": "nN"})}
    return xr.Dataset(made, {"branch": names}, {"spring_constant": stiffness * np.exp(-stiffer)})


def drawn(rng, soft):
    """Return modulus, work, radius and stiffness from wide ranges."""
    modulus = 10 ** (rng.uniform(-5, -3) if soft else rng.uniform(-1, 1))
    stiffness = 10 ** (rng.uniform(-1, 0.5) if soft else rng.uniform(-1, 1.6))
    return modulus, 10 ** rng.uniform(-2, -1), rng.uniform(500, 5000), stiffness


def covered(count, soft, errors, **options):
    """Return in how many curves modulus and work lie in their intervals, and half the logarithms of these."""
    inside = []
    width = []
    for seed in range(count):
        rng = np.random.default_rng(seed)
        modulus, work, radius, stiffness = drawn(rng, soft)
        curve = measured(rng, modulus, work, radius, stiffness, errors, **options)
        calibration = dict(zip(("spring_constant_std", "sensitivity_std"), errors))
        fit = roughxr.fit_curve(curve, sphere_radius=radius, **calibration).isel(subregion=0)
        if not fit.reason.item():
            ends = [
                (float(fit[f"fitted_{name}_low"]), float(fit[f"fitted_{name}_high"])) for name in ("modulus", "work")
            ]
            inside.append([low <= true <= high for (low, high), true in zip(ends, (modulus, work))])
            width.append([np.log(high / low) / 2 if low > 0 else np.inf for low, high in ends])
    return np.array(inside), np.array(width)


@pytest.mark.parametrize(
    ("soft", "errors"),
    [
        (False, (0.0, 0.0)),
        (True, (0.0, 0.0)),
        (True, (0.1, 0.03)),
        pytest.param(False, (0.1, 0.03), marks=pytest.mark.soak),
    ],
)
def test_intervals_contain_modulus_and_work(soft, errors):
    """Of 200 curves each, tests/benchmarks/fitted_curves.py."""
    inside, width = covered(16, soft, errors, drift=1.0)
    assert len(inside) >= 14 and inside.sum(axis=0).min() >= len(inside) - 2
    assert np.median(width[:, 1]) < (0.1 if errors == (0.0, 0.0) else 0.3)


@pytest.mark.parametrize(
    ("law", "modulus", "work"), [("jkr", 0.01, 0.05), ("dugdale", 2.0, 0.03), ("dmt", 400.0, 0.01)]
)
def test_the_law_is_tabors(law, modulus, work):
    exact = {"sphere_radius": 500, "spring_constant_std": 0.0, "sensitivity_std": 0.0}
    curves = [measured(np.random.default_rng(seed), modulus, work, 500.0, 400.0, (0.0, 0.0)) for seed in range(3)]
    fits = [roughxr.fit_curve(curve, **exact).isel(subregion=0) for curve in curves]
    assert branch(modulus, work, 500.0)[0] == law and {fit.law.item() for fit in fits} == {law}
    assert np.mean([fit.fitted_work_of_adhesion for fit in fits]) == pytest.approx(work, rel=0.03)
    with_law = roughxr.fit_curve(curves[1], law=law, **exact).isel(subregion=0)
    np.testing.assert_allclose(with_law.fitted_work_of_adhesion, fits[1].fitted_work_of_adhesion, rtol=1e-3)


def test_the_rms_of_the_residuals_is_the_noise_where_the_law_fits():
    rng = np.random.default_rng(3)
    curve = measured(rng, 1e-3, 0.05, 2000.0, 0.5, (0.0, 0.0))
    noise = 0.03 * np.pi * 1.5 * 0.05 * 2000.0
    curve["force"] = curve.force + noise * rng.normal(size=curve.force.shape)
    curve.force.attrs["units"] = "nN"
    fit = roughxr.fit_curve(curve, sphere_radius=2000).isel(subregion=0)
    assert float(fit.force_rms / fit.force_noise) == pytest.approx(1.0, abs=0.15) and fit.note.item() == ""


def test_a_map_is_its_curves_and_keeps_its_places():
    rng = np.random.default_rng(4)
    curves = [measured(rng, 1e-3, 0.05, 2000.0, 0.5, (0.0, 0.0)) for _ in range(3)]
    n = min(curve.sizes["sample"] for curve in curves)
    whole = xr.concat([curve.isel(sample=slice(0, n)) for curve in curves], "subregion", combine_attrs="override")
    whole = whole.assign_coords(subregion_x=("subregion", [0.0, 1.0, 2.0], {"units": "um"}))
    fit = whole.contact.fit_curve(sphere_radius="2 um")
    assert roughxr.schema.history(fit)[-1]["arguments"] == {"sphere_radius": "2 um"}
    np.testing.assert_allclose(fit.subregion_x, [0, 1000, 2000])
    for k in range(3):
        alone = roughxr.fit_curve(whole.isel(subregion=k), sphere_radius=2000)
        np.testing.assert_allclose(fit.fitted_contact_modulus[k], alone.fitted_contact_modulus[0], rtol=1e-6)
    assert set(fit.reason.values) == {""} and roughxr.schema.VARIABLES["fitted_contact_modulus"].units == "GPa"


def test_a_soft_cantilever_sets_no_upper_limit():
    curve = measured(np.random.default_rng(0), 50.0, 0.05, 2000.0, 0.1, (0.0, 0.0))
    fit = roughxr.fit_curve(curve, sphere_radius=2000).isel(subregion=0)
    assert np.isinf(fit.fitted_modulus_high) and 0 < float(fit.fitted_modulus_low) < 50
    assert "the modulus has no upper limit" in fit.note.item()


def test_curves_that_cannot_be_fitted_are_refused_or_say_why():
    curve = measured(np.random.default_rng(0), 1e-3, 0.05, 2000.0, 0.5, (0.0, 0.0))
    with pytest.raises(ValueError, match="spring_constant: expected it in N/m to subtract the bending"):
        roughxr.fit_curve(curve.assign_attrs(spring_constant=np.inf), sphere_radius=2000)
    with pytest.raises(ValueError, match="piezo: expected a 'units' attribute"):
        roughxr.fit_curve(curve.assign(piezo=curve.piezo.drop_attrs()), sphere_radius=2000)
    with pytest.raises(ValueError, match="law: expected"):
        roughxr.fit_curve(curve, sphere_radius=2000, law="hertz")
    with pytest.raises(ValueError, match="sensitivity_std: expected a relative error"):
        roughxr.fit_curve(curve, sphere_radius=2000, sensitivity_std=3)
    flat = curve.assign(force=xr.full_like(curve.force, 0.0) + np.random.default_rng(0).normal(size=curve.force.shape))
    flat.force.attrs = curve.force.attrs
    fit = roughxr.fit_curve(flat, sphere_radius=2000)
    assert fit.reason.item() == "no pull exceeds the noise" and np.isnan(fit.fitted_contact_modulus.item())


def test_the_shell_prints_modulus_and_work(tmp_path, capsys):
    curve = measured(np.random.default_rng(0), 1e-3, 0.05, 2000.0, 0.5, (0.0, 0.0), with_approach=False).isel(branch=0)
    rows = "".join(f"{z!r},{f!r}\n" for z, f in zip(curve.piezo.values.tolist(), curve.force.values.tolist()))
    (tmp_path / "curve.csv").write_text("piezo [nm],force [nN]\n" + rows)
    line = ["measured", str(tmp_path / "curve.csv"), "--sphere-radius", "2000"]
    assert main(line) == 1 and "--spring-constant: expected it in N/m" in capsys.readouterr().err
    assert main([*line, "--spring-constant", "0.5", "-o", str(tmp_path / "fit.csv")]) == 0
    printed = capsys.readouterr().out
    assert "curves: 1 fitted" in printed and "contact modulus: 0.00" in printed and "J/m² (95 % interval" in printed
    assert "fitted_contact_modulus" in (tmp_path / "fit.csv").read_text()
