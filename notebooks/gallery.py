"""Draw one picture for each kind of result, for the page of the gallery: python notebooks/gallery.py FOLDER."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
from matplotlib import pyplot

#: What each picture needs.
BEGIN = """\
import roughxr

scan = roughxr.open_sample("rough").contact.level()
scan = scan.contact.assign_pair(sphere_radius="500 nm", materials="glass/silicon")
solved = scan.contact.adhesive(subregions=(5, 5), mesh=4)
"""

#: Title and code of each picture, in the order of a study; the last line draws.
PICTURES = {
    "Heights of a scan": "scan.contact.plot()",
    "Spectrum and its self-affine fit": (
        "spectrum = roughxr.scans.power_spectrum(scan)\nfitted = roughxr.scans.self_affine_fit(scan)\n"
        'spectrum.merge(fitted, combine_attrs="override").contact.plot()'
    ),
    "Statistics of asperities": "scan.contact.asperities().contact.plot()",
    "Force over displacement": "scan.contact.direct(subregions=(5, 5)).contact.plot()",
    "Superposed asperities": "scan.contact.superpose(subregions=(5, 5)).contact.plot()",
    "Contact area over load": "scan.contact.direct(load=[10, 100, 1000], subregions=(4, 4)).contact.plot()",
    "Pressure of one contact": (
        "contact = scan.contact.direct(load=[1000], fields=True)\nroughxr.figures.field_map(contact, scan=scan)"
    ),
    "Tension of one contact at pull-off": (
        "place = solved.isel(subregion=[7])\n"
        'how = {"subregions": place, "datum": "first_contact", "mesh": 4}\n'
        "pulled = scan.contact.adhesive(delta=place.pull_off_delta.values, fields=True, **how)\n"
        "roughxr.figures.field_map(pulled, scan=scan)"
    ),
    "Approach and retraction": (
        "# nm from first contact, densest around the pull-off; loops narrower than a step are not seen\n"
        "displacements = [-1, -0.5, -0.3, -0.2, -0.15, -0.1, -0.05, 0, 0.1, 0.2]\n"
        'scan.contact.adhesive(delta=displacements, datum="first_contact", subregions=(3, 3)).contact.plot()'
    ),
    "Distribution of pull-off forces": "solved.contact.plot()",
    "Pull-off forces by place": 'solved.contact.plot("pull_off_force", on="map")',
    "Cumulative probability": "roughxr.statistics.cdf(solved).contact.plot()",
    "Summary of pull-off forces": "solved.contact.summary().contact.plot()",
    "Answer with its interval": "solved.contact.answer().contact.plot()",
    "Intervals of the statistics": "solved.contact.bootstrap().contact.plot()",
    "Fitted laws": "solved.contact.fit().contact.plot()",
    "Pull-off over the radius": (
        "radii = [125, 250, 500, 1000]\n"
        "scan.contact.vary(roughxr.pull_off_map, sphere_radius=radii, subregions=(5, 5)).contact.plot()"
    ),
    "Pull-off over the pixel": (
        "real = scan.contact.extrapolated(subregions=(4, 4), mesh=4, places=1)\nroughxr.figures.force_over_pixel(real)"
    ),
    "Usual formulas": "scan.contact.formulas().contact.plot()",
    "Conditions of a solution": "scan.contact.direct(load=[1000], fields=True).contact.certificate().contact.plot()",
    "Predicted and measured quantiles": (
        "measured = solved.assign(pull_off_force=1.3 * solved.pull_off_force).contact.pull_off()\n"
        "solved.contact.compare(measured).contact.plot()"
    ),
    "Error budget": "scan.contact.error_budget(subregions=(3, 3), places=3).contact.plot()",
    "Resisting moments by direction": "scan.contact.rolling(subregions=(5, 5)).contact.plot()",
    "Fraction that remains in a flow": (
        "moments = scan.contact.rolling(subregions=(5, 5))\n"
        "speeds = [1, 2, 3, 4, 5, 6, 8, 10, 15, 20]\n"
        "moments.contact.resuspension(friction_velocity=speeds).contact.plot()"
    ),
}


def write_gallery(folder: Path) -> str:
    """Write the pictures to a folder, and return the page's text in Markdown."""
    names: dict = {}
    parts = [f"All pictures need these lines first:\n\n```python\n{BEGIN}```\n"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(BEGIN, names)
        for number, (title, code) in enumerate(PICTURES.items(), 1):
            *statements, last = code.splitlines()
            exec("\n".join(statements), names)
            drawn = np.ravel(eval(last, names))[0]
            file = f"gallery-{number:02d}.png"
            drawn.figure.savefig(folder / file, dpi=160)
            pyplot.close("all")
            parts.append(f"## {title}\n\n```python\n{code}\n```\n\n![{title}](generated/{file})\n")
    return "\n".join(parts)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    print(write_gallery(folder))
