"""Make ``forces.csv``, a table of pull-off forces as from force curves: python datasets/make_forces.py.

They are made, not measured: the simulation of a sphere of 500 nm, glass on silicon, at 64 random places of the sample
"rough"; times 0.6, as by roughness that the scan does not show and by the spring constant; with 5 % of noise.
"""

from pathlib import Path

import numpy as np
import pandas as pd

import roughxr

SEED = 76
COUNT = 64
FACTOR = 0.6
NOISE = 0.05


def main() -> None:
    """Write the table beside this file."""
    random = np.random.default_rng(SEED)
    scan = roughxr.open_sample("rough").contact.level()
    scan = scan.contact.assign_pair(sphere_radius="500 nm", materials="glass/silicon")
    x, y = random.uniform(500, 4500, (2, COUNT)).round()  # nm, a radius from the edges
    pull_offs = roughxr.adhesive(scan, subregions=(x, y), mesh=4).pull_off_force.values
    forces = FACTOR * pull_offs * random.normal(1, NOISE, COUNT)
    table = pd.DataFrame({"x [nm]": x.astype(int), "y [nm]": y.astype(int), "pull-off force [nN]": forces.round(1)})
    table.to_csv(Path(__file__).with_name("forces.csv"), index=False)


if __name__ == "__main__":
    main()
