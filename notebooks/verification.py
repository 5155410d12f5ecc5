"""Compare solvers with closed forms and print the table, as on the page: python notebooks/verification.py."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import roughxr
from roughxr.mechanics.kernels.asperity import maugis


class Row(NamedTuple):
    """One comparison."""

    case: str
    call: str
    value: float
    closed_form: float
    formula: str
    unit: str = "nN"


#: Sphere of all comparisons, nm, GPa, J/m².
SPHERE = {"sphere_radius": 1000.0, "contact_modulus": 40.0}
WORK = 0.05


def flat(pixels: int, pixel: float, height: Any = 0.0) -> xr.Dataset:
    """Return a scan in nm, flat by default."""
    x = (np.arange(pixels) + 0.5) * pixel
    heights = np.zeros((pixels, pixels)) + height
    return roughxr.schema.label(xr.Dataset({"height": (("x", "y"), heights)}, {"x": x, "y": x}))


def rows() -> Iterator[Row]:
    """Yield the comparisons, from the one without adhesion to rough bodies."""
    sphere = flat(96, 1.0).contact.assign_pair(**SPHERE)
    pressed = sphere.contact.direct(delta=[1.0])
    hertz = roughxr.reference.hertz([1.0], radius=1000, contact_modulus=40)
    yield Row("Hertz", "direct(delta=[1])", pressed.force.item(), hertz.force.item(), "4/3 E* √(R δ³)")

    layer = roughxr.Layer(1e4, young_modulus=10, poisson_ratio=0.3)
    moduli = {"young_modulus": [1000, 100], "poisson_ratio": 0.3}
    coated = flat(96, 1.0).contact.assign_pair(sphere_radius=1000, layer=layer, **moduli)
    thick = coated.contact.direct(delta=[1.0])
    compliance = (1 - 0.3**2) * (1 / 10 + 1 / 1000)
    film = roughxr.reference.hertz([1.0], radius=1000, contact_modulus=1 / compliance)
    yield Row("thick film", "direct(delta=[1])", thick.force.item(), film.force.item(), "Hertz with the film's modulus")

    adheres = flat(96, 1.0).contact.assign_pair(**SPHERE, work_of_adhesion=WORK)
    jkr = adheres.contact.adhesive(law="jkr", mesh=2)
    yield Row("JKR", 'adhesive(law="jkr")', jkr.pull_off_force.item(), 1.5 * np.pi * WORK * 1000, "3/2 π w R")

    soft = {"sphere_radius": 5000, "contact_modulus": 0.1, "work_of_adhesion": WORK}
    front = flat(96, 20.0).contact.assign_pair(**soft).contact.adhesive(mesh="front", law="jkr")
    yield Row(
        "JKR, soft", 'adhesive(mesh="front")', front.pull_off_force.item(), 1.5 * np.pi * WORK * 5000, "3/2 π w R"
    )

    for name, length, pixel in (("Maugis, transition", 0.5, 1.5), ("Maugis, near DMT", 3.0, 4.0)):
        ranged = flat(96, pixel).contact.assign_pair(**SPHERE, work_of_adhesion=WORK, adhesion_range=length)
        solved = ranged.contact.adhesive(law="dugdale", mesh=2)
        parameter = roughxr.reference.tabor_parameter(
            radius=1000, contact_modulus=40, work_of_adhesion=WORK, adhesion_range=length
        )
        closed = np.pi * WORK * 1000 * maugis.pull_off(maugis.parameter(parameter))
        yield Row(
            name, 'adhesive(law="dugdale")', solved.pull_off_force.item(), closed, f"Maugis at µ = {parameter:.2g}"
        )

    rigid = flat(200, 1.0).contact.assign_pair(sphere_radius=1000, contact_modulus=40, work_of_adhesion=WORK)
    summed = rigid.contact.rigid(law="exponential", mesh=1)
    yield Row("Bradley", 'rigid(law="exponential")', summed.pull_off_force.item(), 2 * np.pi * WORK * 1000, "2π w R")

    x = 0.25 * (np.arange(240) + 0.5 - 120)
    square = np.add.outer(x**2, x**2)
    hemisphere = np.sqrt(np.maximum(20.0**2 - square, 0.0))
    pair = {"sphere_radius": 1000, "contact_modulus": 40, "hamaker_constant": "65 zJ"}
    bump = flat(240, 0.25, hemisphere).contact.assign_pair(**pair)
    summed = bump.contact.rigid(law="hamaker", mesh=1)
    closed = roughxr.reference.rumpf(radius=1000, asperity_radius=20, hamaker_constant="65 zJ")
    yield Row(
        "Rumpf", 'rigid(law="hamaker")', summed.pull_off_force.item(), closed, "A/6z₀² [rR/(r + R) + R/(1 + r/z₀)²]"
    )


def table() -> str:
    """Return the comparisons as a table in Markdown."""
    lines = ["| case | value | closed form | difference | formula |", "|---|---|---|---|---|"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for row in rows():
            difference = 100 * (row.value / row.closed_form - 1)
            numbers = f"{row.value:.4g} {row.unit} | {row.closed_form:.4g} {row.unit} | {difference:+.2g} %"
            unbroken = numbers.replace("-", "−").replace(" nN", "\u00a0nN").replace(" %", "\u00a0%")
            lines.append(f"| {row.case}: `{row.call}` | {unbroken} | {row.formula} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(table())
