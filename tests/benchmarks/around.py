"""What stands around the direct solver: catalogue of a 4096 × 4096 scan, reconstruction of a 2048 × 2048 one.

    python tests/benchmarks/around.py [--repeat 5]

Beside each time stands what the machine could do at best, measured in the same process: one pass over the heights for
the search of peaks (it reads every pixel once), and for the envelope one evaluation of a paraboloid, about ten floating
point operations, per pixel that is drawn at least.
"""

import argparse
import time

import numpy as np

import roughxr
from roughxr.kernels.topography.envelope import asperity_rows, upper_envelope
from roughxr.kernels.topography.paraboloid import fit_paraboloids
from roughxr.kernels.topography.peaks import search
from roughxr.scans.synthetic import self_affine

PIXEL = 10.0


def median_seconds(call, repeat):
    """Return the median wall time of a call, after one that compiles."""
    call()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def surface(n):
    """Return a self-affine scan whose smallest features span some pixels."""
    options = {"rms": 3.0, "hurst": 0.8, "rolloff": 100 * PIXEL, "cutoff": 12 * PIXEL, "seed": 1}
    return self_affine((n, n), PIXEL, **options)


def catalogue(repeat):
    """Print the parts of the catalogue and the labelled whole, over one pass through the heights."""
    scan = surface(4096)
    z = scan.height.values
    once = median_seconds(z.max, repeat)
    peaks = search(z)
    parts = {
        "peaks": lambda: search(z),
        "fit_paraboloids": lambda: fit_paraboloids(z, peaks.ix, peaks.iy, PIXEL, PIXEL),
        "asperities (labelled)": lambda: roughxr.asperities(scan),
    }
    print(f"4096² scan, {peaks.ix.size} asperities; one pass over the heights {1e3 * once:.1f} ms")
    for name, call in parts.items():
        took = median_seconds(call, repeat)
        each = f"{1e6 * took / peaks.ix.size:.2f} µs an asperity" if "fit" in name else ""
        print(f"  {name:24s} {1e3 * took:8.1f} ms   {took / once:5.1f} passes   {each}", flush=True)


def envelope(repeat):
    """Print the reconstruction, over drawing each pixel once."""
    scan = surface(2048)
    found = roughxr.asperities(scan)
    columns = ("x", "y", "height", "curvature_min", "curvature_max", "orientation")
    rows = asperity_rows(*(found[name].values for name in columns))
    x, y = scan.x.values, scan.y.values
    one = median_seconds(lambda: upper_envelope(x, y, rows[:1]), repeat)
    print(f"2048² scan, {len(rows)} asperities; one paraboloid drawn on every pixel {1e3 * one:.1f} ms")
    for name, call in {
        "upper_envelope": lambda: upper_envelope(x, y, rows),
        "reconstruct (labelled)": lambda: roughxr.reconstruct(scan, found),
    }.items():
        took = median_seconds(call, repeat)
        print(f"  {name:24s} {1e3 * took:8.1f} ms   {took / one:5.1f} drawings", flush=True)


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--repeat", type=int, default=5)
    chosen = options.parse_args()
    catalogue(chosen.repeat)
    envelope(chosen.repeat)
