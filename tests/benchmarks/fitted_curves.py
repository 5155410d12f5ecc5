"""How often the intervals of `fit_curve` contain the modulus and the work of adhesion of synthetic curves.

    python -m tests.benchmarks.fitted_curves [COUNT]

Curves of `tests.test_curve_fit`: E* from 0.1 to 10 GPa or from 10 kPa to 1 MPa, w from 0.01 to 0.1 J/m², radii from 0.5
to 5 µm, cantilevers from 0.1 to 40 N/m (3 N/m for soft samples), the law by Tabor's parameter, noise of 0.2 to 3 % of
the pull-off force, correlated in time, with tilt and drift; calibrations exact, or wrong by 10 % and 3 %.
"""

import sys

import numpy as np

from tests.test_curve_fit import covered


def main(count):
    print("sample     calibration  branches  fitted  covered: E*      w   without limit of E*  median ± of w")
    for soft in (False, True):
        for errors in ((0.0, 0.0), (0.1, 0.03)):
            for both in (True, False):
                inside, width = covered(count, soft, errors, both=both, drift=1.0)
                share, free = inside.mean(axis=0), np.isinf(width[:, 0]).mean()
                print(
                    f"{'soft' if soft else 'stiff':10s} {'wrong' if any(errors) else 'exact':12s} {1 + both:8d} "
                    f"{len(inside):7d}  {share[0]:12.3f}  {share[1]:.3f}  {free:19.0%}  {np.median(width[:, 1]):13.0%}",
                    flush=True,
                )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
