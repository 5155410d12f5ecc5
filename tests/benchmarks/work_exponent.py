"""How the pull-off grows with the work of adhesion, by superposed asperities.

    python tests/benchmarks/work_exponent.py

Printed is the exponent d ln F/d ln w of the mean at 4 × 4 places, from w = 0.05 to 0.1 J/m², for two samples, two
spheres and five moduli: 1 between rigid bodies, more where summits deform. Half a minute of one core.
"""

import warnings

import numpy as np

import roughxr

#: Samples, each with radii of spheres, nm.
SPHERES = (("rough", 500), ("rough", 5000), ("glass", 3000))

#: Contact moduli, GPa.
MODULI = (10.0, 1.0, 0.1, 0.03, 0.01)


def exponent(scan, radius, modulus):
    """Return d ln F/d ln w of the mean pull-off."""
    means = []
    for work in (0.05, 0.1):
        pair = scan.contact.assign_pair(work_of_adhesion=work, sphere_radius=radius, contact_modulus=modulus)
        means.append(float(pair.contact.superpose(subregions=(4, 4)).pull_off_force.mean()))
    return float(np.log2(means[1] / means[0]))


def main():
    """Print one row per case, and the smallest and largest exponent."""
    warnings.simplefilter("ignore")
    exponents = []
    for name, radius in SPHERES:
        scan = roughxr.open_sample(name).contact.level()
        for modulus in MODULI:
            exponents.append(exponent(scan, radius, modulus))
            print(f"{name}, R {radius} nm, E* {modulus:g} GPa: {exponents[-1]:.2f}", flush=True)
    print(f"smallest {min(exponents):.2f}, largest {max(exponents):.2f}, of {len(exponents)}")


if __name__ == "__main__":
    main()
