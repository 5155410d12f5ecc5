"""A cycle with the exponential law on rough places, beside ContactMechanics' and Adhesion's free-boundary solver.

    python tests/benchmarks/adhesive_peers.py [--peer-python PYTHON] [--places 20 …] [--rounds 1]

PYTHON is that of an environment with both (`pip install ContactMechanics Adhesion`), by default this one. Either side
gets the same window of 192 × 192 cells, a quarter of the twin's pixel wide, and the same law: 1.35 J/m² over 0.3 nm.
The sphere is pressed by 4 nm from first contact in steps of 0.25 nm and taken back until nothing touches. The peer,
with a hard wall, finds each state from the one before by L-BFGS, in a process of its own with one thread.

Printed are the processor times in an alternating series, their ratio, and the largest pull at the peer's displacements
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

#: Gradient at which the peer's minimisation ends, over the largest traction; ours ends at 1e-5 of it, 1e-3 on the way.
PEER_TOLERANCE = 1e-4


def window(place):
    """Return the separation (nm) of a square of cells around a place's first contact, and the cells' side (nm)."""
    import roughxr
    from roughxr.contact import problem
    from roughxr.specimen import specimen_of

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
    from roughxr.kernels.adhesion import path, traction_laws

    began = time.process_time()
    per_unit = dx / MODULUS
    law = traction_laws.smooth_law(exponential=(WORK * per_unit, RANGE))
    (followed,) = path.follow_path(separation, np.array(deltas), STEP, law)
    back = followed.states[followed.turn :]
    back = back[back["prescribed"] > 0] if len(deltas) > 1 else back
    return -back["force"].min() * MODULUS * dx, time.process_time() - began


def peers(separation, dx):
    """Return the peer's pull-off force (nN), processor time (s), and numbers of states and of those not converged."""
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


def asked_of(python, separation, dx):
    """Run the peer with another interpreter; return what it prints."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "window.npz"
        np.savez(file, separation=separation, dx=dx)
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | threads
        command = [python, __file__, "--peer", str(file)]
        out = subprocess.run(command, capture_output=True, text=True, env=environment)
    if out.returncode:
        raise SystemExit(f"the peer failed (pip install ContactMechanics Adhesion):\n{out.stderr[-2000:]}")
    return [float(value) for value in out.stdout.split()[-4:]]


def main():
    """Print rows for each place, and the ratios of the processor times."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer-python", default=sys.executable, help="default: this one")
    parser.add_argument("--places", type=int, nargs="+", default=PLACES, help="of the 8 × 8; default: %(default)s")
    parser.add_argument("--rounds", type=int, default=1, help="default: %(default)s")
    parser.add_argument("--peer", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.peer:
        with np.load(arguments.peer) as file:
            print(*peers(file["separation"], float(file["dx"])))
        return
    ours(*window(arguments.places[0]))  # compiles
    ratios = [ratio for place in arguments.places for ratio in beside(place, arguments.rounds, arguments.peer_python)]
    ratio_text = f"from {min(ratios):.1f} to {max(ratios):.1f}, median {np.median(ratios):.1f}"
    print(f"{len(arguments.places)} places: ratio {ratio_text}")


def beside(place, rounds, python):
    """Print a row for each round at a place; return the ratios of the processor times."""
    separation, dx = window(place)
    same, _ = ours(separation, dx, np.arange(-16.0, DEPTH + STEP, STEP))
    ratios = []
    for _ in range(rounds):
        pull, seconds = ours(separation, dx)
        other, peer_seconds, states, missed = asked_of(python, separation, dx)
        ratios.append(peer_seconds / seconds)
        print(
            f"place {place}: ours {seconds:.2f} s, the peer {peer_seconds:.1f} s ({states:.0f} states, "
            f"{missed:.0f} not converged), ratio {ratios[-1]:.1f}; "
            f"at its displacements ours {same:.1f} nN, the peer's {other:.1f} nN; between them ours {pull:.1f} nN",
            flush=True,
        )
    return ratios


if __name__ == "__main__":
    main()
