"""Draw one picture for each kind of result, for the page of the gallery: python notebooks/gallery.py FOLDER."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import pyplot

#: What each picture needs.
BEGIN = """\
import roughxr

scan = roughxr.open_sample("rough").contact.level()
scan = scan.contact.assign_pair(sphere_radius="500 nm", materials="glass/silicon")
solved = scan.contact.adhesive(subregions=(5, 5), mesh=4)
"""


class Picture(NamedTuple):
    """The code of a picture, whose last line draws; a sentence on what it shows, and one on when it misleads."""

    code: str
    shows: str
    misleads: str


#: Pictures by their title, in the order of a study.
PICTURES = {
    "Heights of a scan": Picture(
        "scan.contact.plot()",
        "Heights of the scan after levelling, x to the right.",
        "One scratch or grain of debris takes the whole colour scale: state `limits=`.",
    ),
    "Spectrum and its self-affine fit": Picture(
        "spectrum = roughxr.scans.power_spectrum(scan)\nfitted = roughxr.scans.self_affine_fit(scan)\n"
        'spectrum.merge(fitted, combine_attrs="override").contact.plot()',
        "Power spectrum of the scan, and the self-affine spectrum fitted to it.",
        "Right of the dashed line the probe's tip and noise decide, not the surface.",
    ),
    "Statistics of asperities": Picture(
        "scan.contact.asperities().contact.plot()",
        "Heights, curvatures, axis ratios and orientations of all asperities.",
        "Curvatures depend on the pixel: compare only scans with equal pixels.",
    ),
    "Force over displacement": Picture(
        "scan.contact.direct(subregions=(5, 5)).contact.plot()",
        "Force without adhesion at each place, with its median and the bands of half and 90 % of the places.",
        "Displacements begin at each place's first contact, so that the curves hide how high the places are.",
    ),
    "Superposed asperities": Picture(
        "scan.contact.superpose(subregions=(5, 5)).contact.plot()",
        "Force of independent asperities on retraction, with the pull-off of each place.",
        "Neighbouring contacts do not share their load here: at large displacements the force is too large.",
    ),
    "Map of superposed pull-offs": Picture(
        "scan.contact.pull_off_map(subregions=(16, 16)).contact.plot()",
        "Pull-off force of superposed asperities by place, computed in milliseconds.",
        "It ranks places; single forces differ from the simulation, as its `expected_ratio` states.",
    ),
    "Contact area over load": Picture(
        "scan.contact.direct(load=[10, 100, 1000], subregions=(4, 4)).contact.plot()",
        "Real contact area at each place over the load, and its mean.",
        "A contact of few pixels has an area in steps of one pixel: use a finer mesh.",
    ),
    "Pressure of one contact": Picture(
        "contact = scan.contact.direct(load=[1000], fields=True)\nroughxr.figures.field_map(contact, scan=scan)",
        "Pressure of one contact over the heights of the scan, with the outline of the contact.",
        "The peak pressure grows with each finer pixel; the picture states the number of cells if there are few.",
    ),
    "Tension of one contact at pull-off": Picture(
        "place = solved.isel(subregion=[7])\n"
        'how = {"subregions": place, "datum": "first_contact", "mesh": 4}\n'
        "pulled = scan.contact.adhesive(delta=place.pull_off_delta.values, fields=True, **how)\n"
        "roughxr.figures.field_map(pulled, scan=scan)",
        "Pressure (red) and tension (blue) of one contact at its pull-off.",
        "Red and blue have scales of their own: equal darkness is no equal pressure.",
    ),
    "Approach and retraction": Picture(
        "# nm from first contact, densest around the pull-off; loops narrower than a step are not seen\n"
        "displacements = [-1, -0.5, -0.3, -0.2, -0.15, -0.1, -0.05, 0, 0.1, 0.2]\n"
        'scan.contact.adhesive(delta=displacements, datum="first_contact", subregions=(3, 3)).contact.plot()',
        "Mean force on approach and on retraction; the area between them is the work lost.",
        "A mean over places smooths jumps: draw one place to see them.",
    ),
    "Distribution of pull-off forces": Picture(
        "solved.contact.plot()",
        "Histogram of the pull-off force at all places, with the interval of the mean.",
        "Neighbouring places are not independent: 25 places of one scan may hold fewer independent values.",
    ),
    "Pull-off forces by place": Picture(
        'solved.contact.plot("pull_off_force", on="map")',
        "Pull-off force at each place of the simulation.",
        "A tile is one contact, not the mean of its area.",
    ),
    "Cumulative probability": Picture(
        "roughxr.statistics.cdf(solved).contact.plot()",
        "Share of places with a pull-off force below each force.",
        "The steps at both ends are single places: quantiles there have wide intervals.",
    ),
    "Summary of pull-off forces": Picture(
        "solved.contact.summary().contact.plot()",
        "Quartiles, 5 and 95 %, extremes and mean of the pull-off force.",
        "Two separate groups of places, such as debris and surface, look like one here.",
    ),
    "Answer with its interval": Picture(
        "solved.contact.answer().contact.plot()",
        "Mean pull-off as scanned, and that of the real surface, with their 95 % intervals.",
        "The interval as scanned is narrow because it omits the roughness that the scan does not show.",
    ),
    "Intervals of the statistics": Picture(
        "solved.contact.bootstrap().contact.plot()",
        "Statistics of the pull-off force with their 95 % intervals by bootstrap.",
        "They contain the choice of places alone, not the errors of bodies and scan.",
    ),
    "Fitted laws": Picture(
        "solved.contact.fit().contact.plot()",
        "Laws fitted to the pull-off forces, in the order of their AIC, over the histogram of the forces.",
        "Of 25 places several laws fit: differences of AIC below 2 decide nothing.",
    ),
    "Pull-off over the radius": Picture(
        "radii = [125, 250, 500, 1000]\n"
        "scan.contact.vary(roughxr.pull_off_map, sphere_radius=radii, subregions=(5, 5)).contact.plot()",
        "Pull-off force over the radius of the sphere at each place, and its mean.",
        "All radii share their places, so that their intervals are not independent.",
    ),
    "Pull-off over the pixel": Picture(
        "real = scan.contact.extrapolated(subregions=(4, 4), mesh=4, places=1)\nroughxr.figures.force_over_pixel(real)",
        "Pull-off force over the pixel of the scan, and its extrapolation to the real surface.",
        "Below the scan's pixel the curve assumes that the spectrum continues.",
    ),
    "Usual formulas": Picture(
        "scan.contact.formulas().contact.plot()",
        "Pull-off force by the usual formulas, beside the attraction of rigid bodies summed over the scan.",
        "Formulas take one or two numbers of the roughness, and differ by orders of magnitude on one surface.",
    ),
    "Conditions of a solution": Picture(
        "scan.contact.direct(load=[1000]).contact.certificate().contact.plot()",
        "Largest violation of each condition of a contact, over its limit.",
        "Met conditions show that the equations are solved, not that they describe the bodies.",
    ),
    "Predicted and measured quantiles": Picture(
        "measured = solved.assign(pull_off_force=1.3 * solved.pull_off_force).contact.pull_off()\n"
        "solved.contact.compare(measured).contact.plot()",
        "Measured over predicted quantiles: a common factor is a line through the origin.",
        "A wrong spring constant and a wrong work of adhesion look alike: both are factors.",
    ),
    "Error budget": Picture(
        "scan.contact.error_budget(subregions=(3, 3), places=3).contact.plot()",
        "Change of the pull-off force by each known source of error, with the error of the change.",
        "Entries marked as not computed are no small errors.",
    ),
    "Resisting moments by direction": Picture(
        "scan.contact.rolling(subregions=(5, 5)).contact.plot()",
        "Moment that resists rolling, by the direction of the flow.",
        "The median over places hides that a single place has strong and weak directions.",
    ),
    "Fraction that remains in a flow": Picture(
        "moments = scan.contact.rolling(subregions=(5, 5))\n"
        "speeds = [1, 2, 3, 4, 5, 6, 8, 10, 15, 20]\n"
        "moments.contact.resuspension(friction_velocity=speeds).contact.plot()",
        "Fraction of particles that remain over the friction velocity.",
        "All particles have one radius here, and the surface as scanned: real curves are flatter.",
    ),
}

#: Lines that store the picture of a script.
END = "numpy.ravel(drawn)[0].figure.savefig({file!r}, dpi=160)\n"


def write_gallery(folder: Path) -> str:
    """Write the pictures and their scripts to a folder, and return the page's text in Markdown."""
    names: dict = {}
    thumbnails = []
    parts = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(BEGIN, names)
        for number, (title, picture) in enumerate(PICTURES.items(), 1):
            *statements, last = picture.code.splitlines()
            exec("\n".join(statements), names)
            drawn = np.ravel(eval(last, names))[0]
            name = f"gallery-{number:02d}"
            drawn.figure.savefig(folder / f"{name}.png", dpi=160)
            pyplot.close("all")
            script = "\n".join(
                [f"import numpy\n{BEGIN}", *statements, f"drawn = {last}", END.format(file=f"{name}.png")]
            )
            (folder / f"{name}.py").write_text(script, encoding="utf-8")
            anchor = title.lower().replace(" ", "-")
            small = f'<img src="../_images/{name}.png" alt="" loading="lazy">'
            thumbnails.append(f'<a href="#{anchor}">{small}{title}</a>')
            words = f"{picture.shows} *When it misleads:* {picture.misleads}"
            parts.append(f"## {title}\n\n{words}\n\n```python\n{picture.code}\n```\n")
            parts.append(f"![{title}](generated/{name}.png)\n\n{{download}}`Whole script <generated/{name}.py>`\n")
    index = '<div id="thumbnails">\n' + "\n".join(thumbnails) + "\n</div>\n"
    begin = f"All pictures need these lines first:\n\n```python\n{BEGIN}```\n"
    return "\n".join([index, begin, *parts])


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    print(write_gallery(folder))
