"""How often the intervals of `fit_curve` contain the modulus and the work of adhesion of synthetic curves.

    python -m tests.benchmarks.fitted_curves [COUNT]

Curves of `tests.test_curve_fit`: E* from 0.1 to 10 GPa or from 10 kPa to 1 MPa, w from 0.01 to 0.1 J/m², radii from 0.5
to 5 µm, cantilevers from 0.1 to 40 N/m (3 N/m for soft samples), the law by Tabor's parameter, noise of 0.2 to 3 % of
the pull-off force, correlated in time, with tilt and drift; calibrations exact, or wrong by 10 % and 3 %.
Then harder curves, a tenth as many: interference of 5 % of the pull that goes on in contact, noise of 10 %, stiff
contacts on soft cantilevers, and tips of 50 nm.
"""

import sys

import numpy as np

import roughxr
from tests.test_curve_fit import branch, covered, drawn, measured

#: Harder curves: a draw of modulus, work, radius and stiffness; interference and noise over the pull.
HARDER = {
    "fringes, soft": (lambda rng: drawn(rng, True), 0.05, 0.0),
    "fringes, stiff": (lambda rng: drawn(rng, False), 0.05, 0.0),
    "noise, soft": (lambda rng: drawn(rng, True), 0.0, 0.1),
    "noise, stiff": (lambda rng: drawn(rng, False), 0.0, 0.1),
    "soft lever": (lambda rng: (10 ** rng.uniform(1, 2), *drawn(rng, False)[1:3], 10 ** rng.uniform(-1.5, -0.5)), 0, 0),
    "tip of 50 nm": (lambda rng: (10 ** rng.uniform(0, 1.8), drawn(rng, False)[1], 50.0, rng.uniform(0.5, 30)), 0, 0),
}


def harder(count, draw, fringes, noise):
    """Return in how many curves modulus and work lie in their intervals, and the number of fits."""
    inside = []
    for seed in range(3000, 3000 + count):
        rng = np.random.default_rng(seed)
        modulus, work, radius, stiffness = draw(rng)
        curve = measured(rng, modulus, work, radius, stiffness, (0.0, 0.0))
        pull = -branch(modulus, work, radius)[1].min()
        travel = curve.piezo - curve.piezo.max("sample")
        turns = travel / (rng.uniform(0.15, 0.6) * float(-travel.min())) + rng.uniform()
        added = fringes * np.sin(2 * np.pi * turns) + noise * rng.normal(size=curve.force.shape)
        curve["force"] = (curve.force + pull * added).assign_attrs(units="nN")
        exact = {"spring_constant_std": 0.0, "sensitivity_std": 0.0}
        fit = roughxr.fit_curve(curve, sphere_radius=radius, **exact).isel(subregion=0)
        if not fit.reason.item():
            true = {"modulus": modulus, "work": work}
            ends = {name: (fit[f"fitted_{name}_low"], fit[f"fitted_{name}_high"]) for name in true}
            inside.append([bool(ends[name][0] <= true[name] <= ends[name][1]) for name in true])
    return np.sum(inside, axis=0), len(inside)


def main(count):
    print("sample     calibration  branches  fitted  covered: E*      w   without limit of E*  median ± of w")
    for soft in (False, True):
        for errors in ((0.0, 0.0), (0.1, 0.03)):
            for with_approach in (True, False):
                inside, width = covered(count, soft, errors, with_approach=with_approach, drift=1.0)
                share = inside.mean(axis=0)
                free = np.isinf(width[:, 0]).mean()
                body = "soft" if soft else "stiff"
                calibration = "wrong" if any(errors) else "exact"
                print(
                    f"{body:10s} {calibration:12s} {1 + with_approach:8d} "
                    f"{len(inside):7d}  {share[0]:12.3f}  {share[1]:.3f}  {free:19.0%}  {np.median(width[:, 1]):13.0%}",
                    flush=True,
                )
    for name, case in HARDER.items():
        inside, fitted = harder(max(count // 10, 1), *case)
        print(f"{name:14s} fitted {fitted:4d}  covered: E* {inside[0]:4d}  w {inside[1]:4d}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
