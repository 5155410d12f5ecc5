"""How often `compare` is right: intervals that hold a known ratio, two fields of one law that are told apart.

Run as ``python tests/benchmarks/measured_rates.py``.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from tests.test_measured_comparison import field, forces, grid

TRIALS = 60


def rates(n: int, smooth: float) -> str:
    options = {"statistics": ["mean", "q50"], "resamples": 99, "shift": None}
    held, p_values, places = [], [], []
    for k in range(TRIALS):
        predicted, measured = (forces(field(2 * k + one, n, smooth), grid(n)) for one in (0, 1))
        found = roughxr.compare(predicted, measured, **options)
        held.append(((found.ratio_low < 1) & (found.ratio_high > 1)).values)
        p_values.append(float(found.distribution_p_value))
        places.append(float(found.predicted_places))
    mean, median = np.mean(held, axis=0)
    apart = np.mean(np.array(p_values) < 0.05)
    return f"{n * n:6d} {np.median(places):12.0f} {mean:10.2f} {median:10.2f} {apart:10.2f}"


if __name__ == "__main__":
    print("places  independent  mean held  median held  told apart at 5 %")
    for smooth in (0.8, 1.5):
        for n in (24, 36):
            print(rates(n, smooth))
