"""A cycle with the exponential law on rough places, beside other solvers of adhesive contact.

    python tests/benchmarks/adhesive_peers.py [--peer NAME] [--peer-python PYTHON] [--places 20 …] [--rounds 1]

NAME is `adhesion`, the free-boundary solver of ContactMechanics and Adhesion, or `tamaas`, and PYTHON the interpreter
of an environment with it (`pip install ContactMechanics Adhesion` or `pip install tamaas`), by default this one. Either
side gets the same window of 192 × 192 cells, a quarter of the twin's pixel wide, and the same law: 1.35 J/m² over
0.3 nm. The sphere is pressed by 4 nm from first contact in steps of 0.25 nm and taken back until nothing touches. The
peer, with a hard wall, finds each state from the one before in a process of its own with one thread: Adhesion by
L-BFGS in the same steps; Tamaas, whose window is repeated periodically, at mean gaps, back in steps of a quarter of
that. Kernels are compiled before the series; libraries are loaded before a peer's time begins.

Printed are the processor times in an alternating series, their ratio, and the largest pull at Adhesion's displacements
by either side; ours also closes in on the largest pull between two of them, which is what it reports.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

SIDE = 192
REFINE = 4
DEPTH = 4.0
STEP = 0.25
MODULUS = 39.407
WORK = 1.35
RANGE = 0.3

#: Places of the 8 × 8, one in each row.
PLACES = (2, 9, 20, 27, 38, 45, 52, 61)

#: Gradient at which Adhesion's minimisation ends, over the largest traction; ours ends at 1e-5 of it, 1e-3 on the way.
PEER_TOLERANCE = 1e-4

#: Error at which an iteration of Tamaas ends, and their number where it has lost contact and does not converge.
TAMAAS_TOLERANCE, TAMAAS_ITERATIONS = 1e-4, 1000


def window(place):
    """Return the separation (nm) of a square of cells around a place's first contact, and the cells' side (nm)."""
    import roughxr
    from roughxr.mechanics.contact import problem
    from roughxr.mechanics.specimen import specimen_of

    scan = roughxr.open_sample("glass").contact.assign_pair(
        sphere_radius=3000, contact_modulus=MODULUS, work_of_adhesion=WORK
    )
    here = roughxr.scans.regions.centres(scan, (8, 8)).isel(subregion=[place])
    specimen = specimen_of(scan)
    asked = problem.read_problem(specimen, here, delta=[DEPTH], datum="first_contact", refine=REFINE)
    (where,), _ = problem.places(specimen, here, 1000.0)
    separation = problem.surface_at(where, asked).separation
    first = [min(max(k - SIDE // 2, 0), n - SIDE) for k, n in zip(_lowest(separation), separation.shape)]
    part = separation[first[0] : first[0] + SIDE, first[1] : first[1] + SIDE]
    return part - part.min(), asked.dx


def _lowest(separation):
    return np.unravel_index(np.argmin(separation), separation.shape)


def ours(separation, dx, deltas=(DEPTH,)):
    """Return our pull-off force (nN), at the displacements alone if there are several, and processor time (s)."""
    from roughxr.mechanics.kernels.adhesion import path, traction_laws

    began = time.process_time()
    per_unit = dx / MODULUS
    law = traction_laws.smooth_law(exponential=(WORK * per_unit, RANGE))
    (followed,) = path.follow_path(separation, np.array(deltas), STEP, law)
    back = followed.states[followed.first_retraction :]
    back = back[back["prescribed"] > 0] if len(deltas) > 1 else back
    return -back["force"].min() * MODULUS * dx, time.process_time() - began


def adhesion(separation, dx):
    """Return Adhesion's pull-off force (nN), processor time (s), and numbers of states and of those not converged."""
    from Adhesion.Interactions import Exponential
    from Adhesion.System import BoundedSmoothContactSystem, make_system
    from SurfaceTopography import Topography

    began = time.process_time()
    surface = Topography(-separation, physical_sizes=tuple(n * dx for n in separation.shape), periodic=False)
    law = Exponential(WORK, RANGE)
    system = make_system(
        surface=surface,
        interaction=law,
        substrate="free",
        young=MODULUS,
        system_class=BoundedSmoothContactSystem,
    )
    goal = PEER_TOLERANCE * abs(law.max_tensile) * surface.area_per_pt
    there = np.arange(-8 * RANGE, DEPTH, STEP)
    forces = []
    missed = 0
    u = None
    for delta in [*there, *np.arange(DEPTH, -60.0, -STEP)]:
        options = {"gtol": goal, "ftol": 0, "maxcor": 10, "maxiter": 3000}
        minimum = system.minimize_proxy(offset=delta, initial_displacements=u, options=options)
        missed = missed + (not minimum.success)
        u = system.disp
        forces.append(float(system.compute_normal_force()))
        if len(forces) > there.size + 1 and -forces[-1] < 1e-3 * -min(forces) and delta < 0:
            break
    return -min(forces[there.size :]), time.process_time() - began, len(forces), missed


def tamaas(separation, dx):
    """Return Tamaas' pull-off force (nN), processor time (s), and numbers of states and of those not converged."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    began = time.process_time()
    area = separation.size * dx**2
    sides = [n * dx for n in separation.shape]
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, sides, list(separation.shape))
    model.E, model.nu = MODULUS, 0.0
    surface = np.ascontiguousarray(-separation)
    law = tm.ExponentialAdhesionFunctional(surface)
    law.parameters = {"rho": RANGE, "surface_energy": WORK}
    gap = tm.PolonskyKeerRey.gap
    solver = tm.PolonskyKeerRey(model, surface, TAMAAS_TOLERANCE, gap, gap)
    solver.max_iter = TAMAAS_ITERATIONS
    solver.addFunctionalTerm(law)
    there = np.arange(0.0, DEPTH, STEP)
    forces = []
    missed = 0
    for delta in [*there, *np.arange(DEPTH, -60.0, -STEP / 4)]:
        converged = solver.solve(separation.mean() - delta) <= TAMAAS_TOLERANCE
        if delta < 0 and not converged:  # contact is lost
            break
        missed += not converged
        forces.append(float(model.traction.mean()) * area)
        seconds = time.process_time() - began  # without the last one
    return -min(forces[there.size :]), seconds, len(forces), missed


def asked_of(peer, python, separation, dx):
    """Run a peer with another interpreter; return what it prints."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "window.npz"
        np.savez(file, separation=separation, dx=dx)
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | threads
        command = [python, __file__, "--peer", peer, "--window", str(file)]
        out = subprocess.run(command, capture_output=True, text=True, env=environment)
    if out.returncode:
        raise SystemExit(f"the peer failed (pip install ContactMechanics Adhesion, or tamaas):\n{out.stderr[-2000:]}")
    return [float(value) for value in out.stdout.split()[-4:]]


PEERS = {"adhesion": adhesion, "tamaas": tamaas}


def main():
    """Print rows for each place, and the ratios of the processor times."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer", choices=PEERS, default="adhesion", help="default: %(default)s")
    parser.add_argument("--peer-python", default=sys.executable, help="default: this one")
    parser.add_argument("--places", type=int, nargs="+", default=PLACES, help="of the 8 × 8; default: %(default)s")
    parser.add_argument("--rounds", type=int, default=1, help="default: %(default)s")
    parser.add_argument("--window", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.window:
        with np.load(arguments.window) as file:
            print(*PEERS[arguments.peer](file["separation"], float(file["dx"])))
        return
    ours(*window(arguments.places[0]))  # compiles
    peer = arguments.peer, arguments.peer_python
    ratios = [ratio for place in arguments.places for ratio in beside(place, arguments.rounds, *peer)]
    ratio_text = f"from {min(ratios):.1f} to {max(ratios):.1f}, median {np.median(ratios):.1f}"
    print(f"{len(arguments.places)} places: ratio {ratio_text}")


def beside(place, rounds, peer, python):
    """Print a row for each round at a place; return the ratios of the processor times."""
    separation, dx = window(place)
    same, _ = ours(separation, dx, np.arange(-16.0, DEPTH + STEP, STEP))
    ratios = []
    for _ in range(rounds):
        pull, seconds = ours(separation, dx)
        other, peer_seconds, states, missed = asked_of(peer, python, separation, dx)
        ratios.append(peer_seconds / seconds)
        print(
            f"place {place}: ours {seconds:.2f} s, {peer} {peer_seconds:.1f} s ({states:.0f} states, "
            f"{missed:.0f} not converged), ratio {ratios[-1]:.1f}; "
            f"at its displacements ours {same:.1f} nN, its {other:.1f} nN; between them ours {pull:.1f} nN",
            flush=True,
        )
    return ratios


if __name__ == "__main__":
    main()
