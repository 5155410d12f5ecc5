"""Capped pressures beside those of Tamaas and ContactMechanics, on one rough window, by displacement and by load.

    python tests/benchmarks/yield_peers.py [--peer-python PYTHON]

PYTHON is that of an environment with either of them (`pip install tamaas ContactMechanics`), by default this one; what
it lacks is left out. Each peer solves 0 ≤ p ≤ H on a free half space in a process of its own, which knows numpy and the
peer alone: ContactMechanics' system with a hardness at our displacement, Tamaas' saturated solver at our load. Printed
are force, contact area, and the shares of area and force at the hardness, over ours; the largest difference of
pressures over H; and by how much (nm) each solution misses the conditions that all of them state. Within one per cent
is asked for.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

DX = 9.77
RADIUS = 3000.0
MODULUS = 39.4
CASES = ((15.0, 4.0), (15.0, 2.0), (8.0, 1.0), (15.0, 0.5))
PEERS = ("contactmechanics", "tamaas")


def window():
    """Return the separation (nm) of a self-affine window of 64 × 64 cells under the sphere."""
    from roughxr.mechanics.scans.synthetic import self_affine

    options = {"rms": 3.5, "hurst": 0.8, "rolloff": 128 * DX, "cutoff": 4 * DX, "seed": 2026}
    tile = self_affine((128, 128), DX, **options).height.values[32:96, 32:96]
    x = (np.arange(64) - 31.5) * DX
    return tile.max() - tile + (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)


def ours(separation, delta, hardness):
    """Return our pressures, GPa."""
    sys.path.insert(0, str(Path(__file__).parents[2]))
    from tests import half_space as kalker

    return kalker.solve(separation, delta, DX, MODULUS, hardness=kalker.Hardness(hardness)).pressure


def tamaas(separation, hardness, pressure, delta):
    """Return the pressures of Tamaas' saturated solver at the same load, and whether it says to have converged."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    n, m = separation.shape
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [n * DX, m * DX], [n, m])
    model.E = MODULUS
    model.nu = 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.KatoSaturated(model, np.ascontiguousarray(-separation), 1e-10, float(hardness))
    solver.setIntegralOperator("dcfft")
    solver.max_iter = 5000
    residual = solver.solve(float(pressure.mean()))
    return np.array(model.traction), bool(residual < 1e-8)


def contactmechanics(separation, hardness, pressure, delta):
    """Return the pressures of ContactMechanics' plastic system at the same displacement, and whether converged."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.PlasticSystemSpecialisations import PlasticNonSmoothContactSystem
    from SurfaceTopography import PlasticTopography, Topography

    sizes = tuple(n * DX for n in separation.shape)
    surface = PlasticTopography(Topography(-separation, physical_sizes=sizes), float(hardness))
    substrate = FreeFFTElasticHalfSpace(separation.shape, young=MODULUS, physical_sizes=sizes)
    system = PlasticNonSmoothContactSystem(substrate, surface)
    minimum = system.minimize_proxy(offset=float(delta), pentol=1e-6, maxiter=5000)
    return np.asarray(minimum.jac) / DX**2, bool(minimum.success)


def told(pressure, hardness):
    """Return force (nN), contact area (nm²), and the shares of area and of force at the hardness."""
    touching = pressure > 1e-6 * hardness
    yields = pressure > hardness * (1 - 1e-4)
    force = pressure.sum()
    shares = yields.sum() / max(touching.sum(), 1), pressure[yields].sum() / force
    return np.array([force * DX**2, touching.sum() * DX**2, *shares])


def violated(pressure, separation, hardness):
    """Return by how much (nm) a solution misses its conditions, on Love's coefficients and at its own approach."""
    from scipy.signal import fftconvolve

    from roughxr.mechanics.kernels.halfspace.products import coefficients_for

    n, m = separation.shape
    quarter = coefficients_for((n, m))[:n, :m]
    half = np.concatenate([quarter[:0:-1], quarter])
    whole = np.concatenate([half[:, :0:-1], half], axis=1)
    level = separation + fftconvolve(pressure, whole, mode="full")[n - 1 : 2 * n - 1, m - 1 : 2 * m - 1] * DX / MODULUS
    touching = pressure > 1e-6 * hardness
    yields = pressure > hardness * (1 - 1e-4)
    elastic = touching & ~yields
    approach = np.median(level[elastic])
    misses = abs(level - approach)[elastic], (level - approach)[yields], (approach - level)[~touching]
    return max(float(part.max(initial=0.0)) for part in misses)


def solved_elsewhere(python, peer, problem):
    """Return a peer's pressures and whether it converged, from a process of its own, or what went wrong."""
    with tempfile.TemporaryDirectory() as folder:
        task = Path(folder) / "task.npz"
        answer = Path(folder) / "answer.npz"
        np.savez(task, **problem)
        command = [python, __file__, "--solve", peer, str(task), str(answer)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return done.stderr.strip().splitlines()[-1][:200]
        solution = np.load(answer)
        return solution["pressure"], bool(solution["converged"])


def main():
    """Compare all cases with all peers, or solve one as a peer."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peer-python", default=sys.executable)
    parser.add_argument("--solve", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.solve:
        peer, task, answer = options.solve
        pressure, converged = globals()[peer](**{name: value[()] for name, value in np.load(task).items()})
        np.savez(answer, pressure=pressure, converged=converged)
        return
    separation = window()
    for delta, hardness in CASES:
        pressure_here = ours(separation, delta, hardness)
        force, area, share, force_share = told(pressure_here, hardness)
        missed = violated(pressure_here, separation, hardness)
        print(f"{delta:g} nm, {hardness:g} GPa: {force:.5g} nN, {area:.5g} nm², {share:.1%} of it at the hardness")
        print(f"  conditions missed by {missed:.1e} nm")
        for peer in PEERS:
            problem = {"separation": separation, "hardness": hardness, "pressure": pressure_here, "delta": delta}
            solution = solved_elsewhere(options.peer_python, peer, problem)
            if isinstance(solution, str):
                print(f"  {peer:17s} not there: {solution}")
                continue
            pressure, converged = solution
            values = told(pressure, hardness) / (force, area, share or 1.0, force_share or 1.0)
            ratios = " ".join(
                f"{name} {value:.5f}" for name, value in zip(("force", "area", "share", "of force"), values)
            )
            change = abs(pressure - pressure_here).max() / hardness
            misses = f"|Δp|/H {change:.0e}, missed {violated(pressure, separation, hardness):.0e}"
            ending = "" if converged else ", not converged by its own word"
            print(f"  {peer:17s} over ours: {ratios}; {misses}{ending}")


if __name__ == "__main__":
    main()
