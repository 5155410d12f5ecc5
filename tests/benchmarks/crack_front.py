"""Soft contacts by the front that bounds them: beside exact solutions, beside `adhesive` on cells, and its cost.

    python tests/benchmarks/crack_front.py [exact] [energy] [rough] [limits] [sample] [cost] [--references FILE]

exact    JKR's sphere, three rippled spheres (Sneddon 1965, Griffith) and ellipses (the ellipse of least energy)
energy   work of adhesion that an approach shows, over fine roughness: w − U, U = (E*/4) Σ q |h_q|²
rough    16 places of four soft rough surfaces beside `adhesive` on cells, 10 to 50 s of processor time each
limits   30 places of five further surfaces, at U/w = 0.15, 0.3 and 0.45; three of them set the limits, two score them
sample   eight places of the sample "rough" nearest to the limits, E* 30 MPa, 10 to 25 s of processor time each on cells
cost     processor time of a place from E* = 0.5 MPa to 1 GPa, with 17 to 200 pixels to the contact's radius

Without a name: all of them. ``--references`` names a file in which the results on cells are stored; what it does not
contain is solved. ``--budget`` ends each solution on cells after so many seconds of processor time, ``--accuracy``
is that of its mesh.
"""

import argparse
import json
import multiprocessing
import resource
import sys
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr.mechanics.contact.adhesive_options import read_adhesion, read_preloads, settling_depth, window_half_width
from roughxr.mechanics.contact.edge_front import Unfollowed, front_cycles
from roughxr.mechanics.contact.mesh import Mesh
from roughxr.mechanics.contact.problem import places as windows
from roughxr.mechanics.contact.problem import read_problem
from roughxr.mechanics.kernels.adhesion import front
from roughxr.mechanics.specimen import specimen_of
from roughxr.mechanics.vocabulary.adhesion_laws import JKR


class Surface(NamedTuple):
    """A self-affine surface and its pair."""

    modulus: float  # GPa
    radius: float  # nm
    work: float  # J/m²
    hurst: float
    rolloff: float  # nm
    cutoff: float  # nm
    pixel: float  # nm
    count: int  # pixels along a side
    seed: int
    rms: float = 1.0  # nm


SURFACES = {
    "A": Surface(0.1, 5000, 0.05, 0.8, 600, 120, 20, 128, 31, rms=1.5),
    "B": Surface(0.03, 2000, 0.05, 0.8, 500, 100, 20, 96, 32, rms=3.0),
    "C": Surface(0.3, 5000, 0.1, 0.6, 500, 100, 16, 128, 33, rms=1.0),
    "D": Surface(0.01, 1000, 0.03, 0.8, 400, 120, 20, 96, 34, rms=4.0),
}

#: Surfaces whose roughness is scaled to a stated U/w: the first three set the limits, the others score them.
ROUGHER = {
    "E": Surface(0.01, 1000, 0.03, 0.7, 400, 120, 20, 96, 41),
    "F": Surface(0.005, 1500, 0.03, 0.9, 600, 160, 30, 96, 42),
    "G": Surface(0.02, 2000, 0.05, 0.5, 500, 120, 24, 96, 43),
    "H": Surface(0.03, 1000, 0.1, 0.8, 350, 100, 16, 96, 44),
    "I": Surface(0.015, 1500, 0.04, 0.6, 450, 110, 20, 96, 45),
}
SHARES = (0.15, 0.3, 0.45)


def scan_of(surface):
    """Return the scan of a surface with its pair."""
    shape = (surface.count, surface.count)
    options = {"rms": surface.rms, "hurst": surface.hurst, "rolloff": surface.rolloff, "cutoff": surface.cutoff}
    scan = roughxr.scans.synthetic.self_affine(shape, surface.pixel, seed=surface.seed, **options)
    pair = {"sphere_radius": surface.radius, "contact_modulus": surface.modulus, "work_of_adhesion": surface.work}
    return scan.contact.assign_pair(**pair, adhesion_range=0.3)


def flattening_energy(surface):
    """Return U = (E*/4) Σ q |h_q|², J/m², the energy by area that flattens a periodic surface."""
    height = scan_of(surface)["height"].values
    q = 2 * np.pi * np.fft.fftfreq(surface.count, surface.pixel)
    amplitudes = np.abs(np.fft.fft2(height)) / height.size
    return surface.modulus / 4 * float(np.sum(np.hypot(q[:, None], q) * amplitudes**2))


def with_share(surface, share):
    """Return a surface with its roughness scaled to a share U/w."""
    return surface._replace(rms=surface.rms * np.sqrt(share * surface.work / flattening_energy(surface)))


def places(surface):
    """Return four contact centres (nm) about the middle."""
    side = surface.count * surface.pixel
    return [(x, y) for x in (0.42 * side, 0.58 * side) for y in (0.42 * side, 0.58 * side)]


class References:
    """Results of `adhesive` on cells, stored in a file."""

    def __init__(self, file, budget, accuracy):
        self.file = file and Path(file)
        self.budget = budget  # processor time (s) of a place
        self.accuracy = accuracy  # largest relative change by finer cells
        self.stored = json.loads(self.file.read_text()) if file and self.file.exists() else {}

    def at(self, name, surface, place):
        """Return the pull-off (nN), its relative error and the processor time (s) at a place; NaN beyond the budget."""
        if name not in self.stored:
            self.stored[name] = within_budget(self.budget, on_cells, surface, place, self.accuracy)
            if self.file:
                self.file.write_text(json.dumps(self.stored, indent=1))
        return self.stored[name]


def on_cells(surface, place, accuracy):
    """Return the pull-off (nN), its relative error and the processor time (s) of a place on cells."""
    began = time.process_time()
    mesh = roughxr.Mesh("auto", accuracy)
    solution = scan_of(surface).contact.adhesive(subregions=([place[0]], [place[1]]), law="jkr", mesh=mesh)
    values = {key: float(solution[f"pull_off_{key}"][0]) for key in ("force", "error")}
    values["pressed"] = float(solution["pressed_pull_off_force"][0])
    return values | {"seconds": time.process_time() - began}


def within_budget(budget, solve, *arguments):
    """Return the result of a function in a process of its own; NaN where it takes more than so much processor time."""

    def send(pipe):
        resource.setrlimit(resource.RLIMIT_CPU, (budget, budget))
        pipe.send(solve(*arguments))

    fork = multiprocessing.get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)
    process = fork.Process(target=send, args=(sender,))
    process.start()
    sender.close()
    try:
        return receiver.recv()
    except EOFError:
        return {"force": np.nan, "error": np.nan, "pressed": np.nan, "seconds": float(budget)}
    finally:
        process.join()


def rough_cases():
    """Return name, surface and place of all places of the four surfaces."""
    return [(f"{name}{k}", row, at) for name, row in SURFACES.items() for k, at in enumerate(places(row))]


def rougher_cases():
    """Return name, surface and place of two places of each rougher surface."""
    cases = []
    for share in SHARES:
        for name, row in ROUGHER.items():
            scaled = with_share(row, share)
            cases += [(f"{name}{k}, U/w {share}", scaled, places(scaled)[k]) for k in (0, 3)]
    return cases


def followed(surface, place, preload=0.0):
    """Return the cycles of a place by its front, and the processor time (s)."""
    return followed_on(scan_of(surface), place, preload)


def followed_on(scan, place, preload=0.0):
    """Return the cycles of a place of a scan by its front, and the processor time (s)."""
    specimen = specimen_of(scan)
    adhesion = read_adhesion(specimen, JKR, preloads=read_preloads(preload), mesh=Mesh(), cycles=1)
    centre = specimen.centres(([place[0]], [place[1]]))
    depth = [settling_depth(specimen, adhesion)]
    problem = read_problem(specimen, centre, delta=depth, datum="first_contact", refine=1)
    (window,), _ = windows(specimen, centre, window_half_width(specimen, problem, adhesion))
    began = time.process_time()
    return front_cycles(window, problem, adhesion), time.process_time() - began


def axisymmetric_front(slope, modulus, work, preload, spacing=2.0, largest=900.0, step=0.02):
    """Return the states of approach and retraction of a body of revolution by its slope s′(r), in steps of nm."""
    r = np.arange(0.0, largest, spacing)
    s = np.concatenate([[0.0], np.cumsum(0.5 * spacing * (slope(r)[1:] + slope(r)[:-1]))])
    columns = np.ones(8)
    edge = front.Front(front.landscape(r, s[:, None] * columns, slope(r)[:, None] * columns), modulus, work)
    loading, _ = front.approach(edge, 0.0, step, preload)
    retraction, _ = front.retraction(edge, loading[-1].delta, step)
    for _ in range(3):  # to the end of the branch
        step *= 0.1
        retraction += front.retraction(edge, retraction[-1].delta, step)[0]
    return loading, retraction


def exact_states(slope, modulus, work, radii):
    """Return force (nN) and displacement (nm) of bodies of revolution by Sneddon's solution and Griffith's balance."""
    node, weight = np.polynomial.legendre.leggauss(600)
    sine = np.sin(0.25 * np.pi * (node + 1))
    weight = 0.25 * np.pi * weight
    slopes = slope(sine * radii[:, None])
    delta = radii * (slopes @ weight) - np.sqrt(2 * np.pi * radii * work / modulus)
    punch = np.sqrt(8 * np.pi * modulus * work * radii**3)
    return 2 * modulus * radii**2 * (slopes * sine**2 @ weight) - punch, delta


def exact_pull_off(slope, modulus, work, preload, largest=900.0):
    """Return the largest tension (nN) on retraction from a preload, where the contact jumps past folds."""
    radii = np.linspace(0.5, largest, 8000)
    force, delta = exact_states(slope, modulus, work, radii)
    is_stable = delta >= np.maximum.accumulate(delta)  # on approach
    turn = int(np.argmax(is_stable & (force >= preload)))
    force = force[: turn + 1][::-1]
    delta = delta[: turn + 1][::-1]
    is_stable = delta <= np.minimum.accumulate(delta)
    return float(-force[is_stable].min())


#: Rippled spheres: radius (nm), modulus (GPa), work (J/m²), amplitude and wavelength (nm), preload (nN).
RIPPLES = (
    (5000, 0.1, 0.05, 1.5, 150, 1500.0),
    (2000, 0.05, 0.03, 2.0, 120, 500.0),
    (10000, 0.3, 0.1, 0.8, 150, 2000.0),
)

#: Ratio of curvatures, pull-off over that of a sphere by the least energy, and axis ratio at pull-off.
ELLIPSES = ((1.5, 0.99871, 0.817), (2.0, 0.99630, 0.707), (5.0, 0.98130, 0.448))


def rippled(radius, amplitude, wavelength):
    """Return the slope s′(r) of a sphere with ripples."""
    q = 2 * np.pi / wavelength
    return lambda r: r / np.sqrt(radius**2 - r**2) + q * amplitude * np.sin(q * r)


def print_exact():
    """Print JKR's sphere, rippled spheres and ellipses."""
    R, E, w = 5000.0, 0.1, 0.05
    force = 1.5 * np.pi * w * R
    radius = np.cbrt(9 * np.pi * w * R**2 / (8 * E))
    depth = radius**2 / R
    _, retraction = axisymmetric_front(lambda r: r / R, E, w, 0.0)
    pull_off = min(retraction, key=lambda state: state.force)
    for name, state, exact in (
        ("under load control", pull_off, (-1.0, 1.0, -1 / 3)),
        ("under displacement control", retraction[-1], (-5 / 9, 3 ** (-2 / 3), -(3 ** (-1 / 3)))),
    ):
        values = state.force / force, state.radius.mean() / radius, state.delta / depth
        figures = ", ".join(f"{value:.4f} ({expected:.4f})" for value, expected in zip(values, exact))
        print(f"JKR's end {name}: force, radius, displacement {figures}")
    for R, E, w, amplitude, wavelength, preload in RIPPLES:
        slope = rippled(R, amplitude, wavelength)
        jkr = 1.5 * np.pi * w * R
        _, retraction = axisymmetric_front(slope, E, w, preload, step=0.05)
        pull_off = -min(state.force for state in retraction) / jkr
        exact = exact_pull_off(slope, E, w, preload) / jkr
        print(f"ripples of {amplitude} nm at {wavelength} nm, R {R}, E* {E}, w {w}: {pull_off:.4f} ({exact:.4f})")
    for ratio, exact, axes in ELLIPSES:
        pull_off, axis_ratio = elliptic_pull_off(ratio)
        print(f"ellipse of B/A {ratio}: {pull_off:.4f} ({exact}), axis ratio {axis_ratio:.3f} ({axes})")


def elliptic_pull_off(ratio, angles=128, turned=0.0):
    """Return the pull-off of a paraboloid over that of a sphere of the radius 1/(2√(AB)), and the axis ratio."""
    R, E, w = 5000.0, 0.1, 0.05
    r = np.arange(0.0, 1100.0, 4.0)
    angle = 2 * np.pi * np.arange(angles) / angles - turned
    A = 0.5 / R / np.sqrt(ratio)
    curvature = A * np.cos(angle) ** 2 + A * ratio * np.sin(angle) ** 2
    edge = front.Front(front.landscape(r, r[:, None] ** 2 * curvature, 2 * r[:, None] * curvature), E, w)
    loading, _ = front.approach(edge, 0.0, 0.25, 0.0)
    pull_off = min(front.retraction(edge, loading[-1].delta, 0.25)[0], key=lambda state: state.force)
    return -pull_off.force / (1.5 * np.pi * w * R), pull_off.radius.min() / pull_off.radius.max()


def print_energy():
    """Print the work of adhesion that approach and retraction show over roughness of ever shorter wavelengths."""
    for rolloff, cutoff, pixel in ((300, 200, 20), (160, 100, 16), (100, 60, 10), (60, 40, 8)):
        for share in (0.002, 0.02, 0.05):
            fine = Surface(0.02, 5000, 0.05, 0.8, rolloff, cutoff, pixel, 3000 // pixel, 1)
            surface = with_share(fine, share)
            middle = 0.5 * surface.count * surface.pixel
            cycles, _ = followed(surface, (middle, middle))
            (cycle,) = cycles.cycles
            approach, retraction = (1 - mean_work(part, surface) for part in (cycle.loading, cycle.retraction))
            print(
                f"wavelengths {cutoff} … {rolloff} nm, U/w {share}: lost on approach {approach / share:.2f} U, "
                f"on retraction {retraction / share:.2f} U, ⟨S²⟩/2E* {second_order(cycle) / share:.2f} U",
                flush=True,
            )


def second_order(cycle):
    """Return the mean second order of the states of a cycle, over w."""
    return float(np.mean([state.second_order for state in cycle.loading + cycle.retraction]))


def mean_work(states, surface):
    """Return the mean work of adhesion over w of states with radii beyond 400 nm, as those of a smooth sphere."""
    height = scan_of(surface)["height"].values
    works = []
    for state in states:
        a = np.sqrt(np.mean(state.radius**2))
        if a > 400:
            uplift = 0.5 * a * np.log((surface.radius + a) / (surface.radius - a)) - (
                state.delta - height.max() + height.mean()
            )
            works.append(surface.modulus * uplift**2 / (2 * np.pi * a) / surface.work)
    return float(np.mean(works))


class Row(NamedTuple):
    """One place by the front and on cells."""

    difference: float  # of the front from the cells, relative
    stated: float  # relative error of the front
    on_cells: float  # relative error of the cells
    is_valid: bool

    @property
    def agrees(self):
        """Whether the difference is within both errors."""
        return abs(self.difference) <= self.stated + self.on_cells


def compared(cases, references):
    """Print each case by its front beside the cells; return the rows that the cells resolve within 25 %."""
    rows = []
    for name, surface, place in cases:
        on_cells = references.at(name, surface, place)
        try:
            cycles, seconds = followed(surface, place)
        except Unfollowed:
            print(f"{name}: not followed as one region; on cells ± {on_cells['error']:.1%}", flush=True)
            continue
        if np.isnan(on_cells["force"]):
            print(f"{name}: on cells more than {on_cells['seconds']:.0f} s", flush=True)
            continue
        pull_off = float(cycles.pull_offs[0])
        row = Row(
            pull_off / on_cells["force"] - 1, float(cycles.pull_off_errors[0]), on_cells["error"], cycles.is_valid
        )
        state = cycles.cycles[0].pull_off
        print(
            f"{name}: {pull_off:.1f} nN ± {row.stated:.1%}, on cells {on_cells['force']:.1f} ± {row.on_cells:.1%}: "
            f"{row.difference:+.1%}; second order {state.second_order:.3f}, spread "
            f"{state.radius.std() / state.radius.mean():.2f}; {seconds:.2f} s for {on_cells['seconds']:.0f} s"
            f"{'' if row.is_valid else '; NOT VALID'}",
            flush=True,
        )
        if row.on_cells <= 0.25:
            rows.append(row)
    return rows


def print_coverage(name, rows):
    """Print how many valid rows agree, alone and within the front's own error."""
    valid = [row for row in rows if row.is_valid]
    agree = sum(row.agrees for row in valid)
    widest = max((row.stated for row in valid), default=np.nan)
    largest = max((abs(row.difference) for row in valid), default=np.nan)
    print(
        f"{name}: {len(valid)} of {len(rows)} places valid, {agree} agree within both errors; "
        f"largest stated error {widest:.1%}, largest difference {largest:.1%}"
    )


def print_rough(references):
    """Print the places of the four surfaces."""
    print_coverage("four surfaces", compared(rough_cases(), references))


def print_limits(references):
    """Print the places of the rougher surfaces, those that set the limits and those that score them."""
    cases = rougher_cases()
    for name, letters in (("that set the limits", "EFG"), ("that score them", "HI")):
        print_coverage(f"surfaces {name}", compared([case for case in cases if case[0][0] in letters], references))


def print_sample():
    """Print the valid places of a grid on a sample that are nearest to the limits, on which nothing was set."""
    pair = {"sphere_radius": 500, "contact_modulus": 0.03, "work_of_adhesion": 0.03, "adhesion_range": 0.3}
    scan = roughxr.open_sample("rough").contact.assign_pair(**pair)
    fronts = scan.contact.adhesive(subregions=(6, 6), mesh="front")
    valid = fronts.isel(subregion=fronts["complete"].values)
    print(f"{valid.sizes['subregion']} of {fronts.sizes['subregion']} places have a valid front")
    for _, front_place in valid.sortby("pull_off_error", ascending=False).isel(subregion=slice(8)).groupby("subregion"):
        place = front_place["subregion_x"].values, front_place["subregion_y"].values
        on_cells = scan.contact.adhesive(subregions=place, law="jkr")
        values = [
            solved[f"pull_off_{name}"].item() for solved in (front_place, on_cells) for name in ("force", "error")
        ]
        force, stated, force_on_cells, stated_on_cells = values
        print(
            f"{force:.1f} nN ± {stated:.1%}, on cells {force_on_cells:.1f} ± {stated_on_cells:.1%}: "
            f"{force / force_on_cells - 1:+.1%}",
            flush=True,
        )


def print_cost():
    """Print the processor time of a place over the moduli and over the pixels of a contact, and on a sample."""
    longest = 0.0
    for modulus in (5e-4, 2e-3, 1e-2, 0.03, 0.1, 0.3, 1.0):
        contact = np.cbrt(9 * np.pi * 0.05 * 5000**2 / (8 * modulus))
        for pixels in (17, 60, 200):  # along the contact's radius
            finest = contact / max(3, pixels / 10)
            surface = Surface(modulus, 5000, 0.05, 0.8, 1.5 * contact, finest, contact / pixels, int(6.6 * pixels), 5)
            surface = with_share(surface, 0.05)
            middle = 0.5 * surface.count * surface.pixel
            cycles, seconds = followed(surface, (middle, middle))
            longest = max(longest, seconds)
            print(
                f"E* {1e3 * modulus:g} MPa, contact {contact:.0f} nm, {pixels} pixels: "
                f"± {float(cycles.pull_off_errors[0]):.1%}, {seconds:.2f} s",
                flush=True,
            )
    pair = {"sphere_radius": 5000, "contact_modulus": 0.03, "work_of_adhesion": 0.05, "adhesion_range": 0.3}
    scan = roughxr.open_sample("glass").contact.assign_pair(**pair)
    for centre in (1250.0, 2500.0, 3750.0):
        cycles, seconds = followed_on(scan, (centre, centre))
        longest = max(longest, seconds)
        print(f"sample 'glass': ± {float(cycles.pull_off_errors[0]):.1%}, {seconds:.2f} s", flush=True)
    print(f"longest: {longest:.2f} s")


def main():
    """Print the tables."""
    warnings.simplefilter("ignore")
    parts = {"exact": print_exact, "energy": print_energy, "rough": print_rough, "limits": print_limits}
    parts |= {"sample": print_sample, "cost": print_cost}
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", choices=list(parts), help="default: all")
    parser.add_argument("--references", help="file of the results on cells")
    parser.add_argument("--budget", type=int, default=600, help="processor time (s) of a place on cells (default 600)")
    parser.add_argument("--accuracy", type=float, default=0.05, help="of the mesh of cells (default 0.05)")
    options = parser.parse_args()
    references = References(options.references, options.budget, options.accuracy)
    for name in options.parts or parts:
        parts[name](*([references] if name in ("rough", "limits") else []))


if __name__ == "__main__":
    main()
