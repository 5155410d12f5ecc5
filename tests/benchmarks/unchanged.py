"""Every number that must stay as it is when only the code changes, by the public functions alone.

    python tests/benchmarks/unchanged.py --save before.json        (on the tree as it was)
    python tests/benchmarks/unchanged.py --against before.json     (on the tree as it is)

Each variable of each result is kept as its size, sum, extremes, a position-weighted sum and a checksum of its float64
bytes: the checksum tells bit-for-bit equality from equality to 1e-12, relative to the values' own size. Texts are the
tables of `roughxr paper` and what the notebooks print; pictures are the pixels of the paper's figures. One thread,
seeds fixed. ``--only direct,adhesive`` takes a part; ``--verdict`` adds the notebook that takes many minutes.
"""

import argparse
import contextlib
import difflib
import hashlib
import io
import json
import os
import re
import sys
import tempfile
import time
import warnings
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ.setdefault("MPLBACKEND", "Agg")

import dask
import numpy as np
import xarray as xr

import roughxr

TOLERANCE = 1e-12
GLASS = {"young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.6747}
FORMULATIONS = ("energy", "self_similar", "published")

NOTEBOOKS = Path(__file__).resolve().parents[2] / "notebooks"
SLOW = "adhesion-verdict"

#: What a notebook shows that is no number of ours: addresses, temporary files, sizes, times.
_PASSING = re.compile(r"0x[0-9a-f]+|/tmp/\S+|\S+ [kMG]i?B\b|Size: \S+|[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:+.Z-]+")


# ---------------------------------------------------------------- problems


def glass():
    """Return the glass twin with the paper's pair."""
    return roughxr.assign_pair(roughxr.open_sample("glass"), sphere_radius=3000, **GLASS)


def corner(size=96):
    """Return a corner of it."""
    return glass().isel(x=slice(0, size), y=slice(0, size))


def made(shape=(96, 80), **changes):
    """Return a self-affine surface with a smaller sphere on it."""
    options = {"rms": 1.5, "hurst": 0.8, "rolloff": 200.0, "cutoff": 25.0, "seed": 3} | changes
    return roughxr.assign_pair(roughxr.scans.synthetic.self_affine(shape, 6.0, **options), sphere_radius=800, **GLASS)


def flat(pixel, size):
    """Return a flat under the paper's sphere."""
    axes = {name: (name, (np.arange(size) - (size - 1) / 2) * pixel, {"units": "nm"}) for name in "xy"}
    ds = xr.Dataset({"height": (("x", "y"), np.zeros((size, size)), {"units": "nm"})}, axes)
    return roughxr.assign_pair(ds, sphere_radius=3000, **GLASS)


# ---------------------------------------------------------------- cases: functions that yield names and results


def scans():
    """Yield scans and what is done to them."""
    ds = corner()
    yield "sample", glass()
    yield "roughness", roughxr.roughness(ds)
    yield "power_spectrum", roughxr.scans.power_spectrum(ds)
    yield "power_spectrum hann", roughxr.scans.power_spectrum(ds, window="hann")
    yield "autocorrelation", roughxr.scans.autocorrelation(ds)
    for method in ("plane", "quadratic", "median", "median_difference"):
        yield f"level {method}", roughxr.level(ds, method=method)
    yield "level cubic", roughxr.level(ds, method="polynomial", order=3)
    yield "resample", roughxr.scans.resample(ds, size=8.0)
    yield "rotate90", roughxr.scans.rotate90(ds)
    yield "crop", roughxr.scans.crop(ds, x=(100.0, 500.0), y=(200.0, 600.0))
    yield "fill", roughxr.fill(ds.where(ds.height < ds.height.quantile(0.97, method="nearest").item()))
    yield "dilate", roughxr.scans.dilate(ds, tip_radius=20.0)
    yield "erode", roughxr.scans.erode(ds, tip_radius=20.0)
    yield "self_affine", made()
    yield "gilman", xr.Dataset({"w": roughxr.reference.gilman_surface_energy(75.0, poisson_ratio=0.22)})
    yield "modulus", xr.Dataset({"E": roughxr.reference.contact_modulus((75, 210), (0.22, 0.3))})


def catalogues():
    """Yield asperities and the surfaces they make."""
    for words, options in {
        "fitted": {},
        "pixel": {"vertex": "pixel"},
        "patch 3": {"patch": 3},
        "patch 7": {"patch": 7},
    }.items():
        catalogue = roughxr.asperities(glass(), **options)
        yield words, catalogue
        yield f"reconstruct {words}", roughxr.reconstruct(glass(), catalogue)
    yield "reconstruct reach", roughxr.reconstruct(glass(), catalogue, reach=60.0)
    yield "tip_flags", roughxr.scans.tip_flags(catalogue, tip_radius=20.0)
    yield "debris", roughxr.statistics.debris(catalogue).to_dataset(name="debris")
    yield (
        "debris of tiles",
        roughxr.statistics.debris(catalogue, roughxr.scans.regions.centres(glass(), (8, 8))).to_dataset(name="d"),
    )


def direct():
    """Yield direct solutions."""
    ds, rough = glass(), made()
    yield "glass", roughxr.direct(ds, delta=[5.08, 10, 15.4], subregions=(4, 4))
    yield "fields", roughxr.direct(ds, delta=[4.0, 12.0], subregions=([2500.0], [2500.0]), fields=True)
    yield "load", roughxr.direct(ds, load=[100.0, 2000.0, 30000.0], subregions=(3, 3))
    yield "load fields", roughxr.direct(rough, load=[500.0], subregions=(2, 2), fields=True)
    yield "first contact", roughxr.direct(ds, delta=[1.0, 3.0], subregions=(4, 4), datum="first_contact")
    yield "off centre", roughxr.direct(rough, delta=[2.0], subregions=([101.3, 250.7], [111.1, 77.7]), fields=True)
    yield "indenter", roughxr.direct(_under_a_map(rough), delta=[1.0, 3.0], subregions=(2, 2))
    yield "flat", roughxr.direct(flat(9.77, 65), delta=[1.0, 5.0, 20.0])


def _under_a_map(ds):
    """Return a scan under an indenter given as a height map."""
    t = (np.arange(31) - 15) * 6.0
    height = (t[:, None] ** 2 + 0.5 * t[None, :] ** 2) / 1000
    axes = {"x": ("x", t, {"units": "nm"}), "y": ("y", t, {"units": "nm"})}
    indenter = xr.DataArray(height, axes, ("x", "y"), attrs={"units": "nm"})
    return roughxr.assign_pair(ds.drop_vars(["sphere_radius"]), indenter=indenter, contact_modulus=40.0)


def superposition():
    """Yield superposed sweeps by every law, and their pull-off at many places."""
    catalogue, delta = roughxr.asperities(glass(), vertex="pixel"), np.arange(-5, 25, 0.5)
    for words, length, options in _laws():
        ranged = catalogue.assign_coords(adhesion_range=length)
        yield words, roughxr.superpose(ranged, delta=delta, subregions=(8, 8), **options)
    yield "first contact", roughxr.superpose(catalogue, delta=delta, subregions=(8, 8), datum="first_contact")
    yield "scan", roughxr.superpose(made(), delta=delta, subregions=(3, 3))


def _laws():
    yield from ((f"jkr {name}", 0.3, {"formulation": name}) for name in FORMULATIONS)
    yield from ((f"maugis {length:g}", length, {"law": "maugis"}) for length in (0.1, 0.3, 2.0))
    yield "hertz", 0.3, {"law": "hertz"}


def pull_off_maps():
    """Yield the exact pull-off at many places."""
    ds = made()
    for words, length, options in _laws():
        if "law" in options and words != "hertz":
            ranged = glass().assign_coords(adhesion_range=length)
            yield words, roughxr.pull_off_map(ranged, subregions=(24, 24), **options)
    yield "every pixel", roughxr.pull_off_map(ds)
    yield "first contact", roughxr.pull_off_map(ds, subregions=(9, 8), datum="first_contact")


def adhesive(ds, **options):
    """Return a cycle in the limit without range on the scan's own pixels, unless the options say otherwise."""
    return roughxr.adhesive(ds, **{"law": "griffith", "mesh": 1} | options)


def adhesion():
    """Yield adhesive cycles, small ones."""
    ds = glass()
    options = {"delta": [1.0, 4.0], "datum": "first_contact", "mesh": roughxr.Mesh(1, step=0.5)}
    yield "griffith", adhesive(ds, subregions=(3, 3), **options)
    yield "from the datum", adhesive(ds, subregions=(2, 2), delta=[4.0, 12.0], mesh=roughxr.Mesh(1, step=0.5))
    rough = made((64, 64))
    yield "fields", adhesive(rough, subregions=([190.0], [180.0]), fields=True, **options)
    yield "refined", adhesive(rough, subregions=([190.0], [180.0]), **options | {"mesh": roughxr.Mesh(2, step=0.5)})
    yield "flat", adhesive(flat(9.77, 65), delta=[0.0, 2.0], mesh=roughxr.Mesh(1, step=0.5))
    for law, reach in (("dugdale", 0.5), ("exponential", 0.75)):
        weak = roughxr.assign_pair(made((48, 48)), sphere_radius=300, contact_modulus=20.0, work_of_adhesion=0.3)
        small = {"delta": [0.5, 1.5], "datum": "first_contact", "law": law}
        weak = weak.assign_coords(adhesion_range=reach)
        yield law, adhesive(weak, subregions=([140.0], [150.0]), **small)
        yield f"{law} fields", adhesive(weak, subregions=([100.0], [100.0]), fields=True, **small)


def estimates():
    """Yield estimates of adhesion from elastic sweeps and from curvatures."""
    ds = glass()
    elastic = roughxr.direct(ds, delta=np.arange(0.0, 8.1, 0.25), subregions=(4, 4), datum="first_contact")
    yield "elastic_pull_off", roughxr.pull_off(elastic, method="ciavarella")
    yield "elastic_pull_off smoothing", roughxr.pull_off(elastic, method="ciavarella", smoothing=1.0)
    yield "tabor", roughxr.reference.tabor(ds)
    yield "tabor distance", roughxr.reference.tabor(made().assign_coords(adhesion_range=0.5))


def statistics():
    """Yield what is said of samples."""
    catalogue = roughxr.asperities(glass(), vertex="pixel")
    sweep = roughxr.superpose(catalogue, delta=np.arange(-5, 25, 0.25), subregions=(8, 8))
    pull = roughxr.pull_off(sweep)
    yield "pull_off", pull
    yield "reduction", roughxr.statistics.reduction(pull)
    yield "summary", roughxr.summary(pull)
    yield "summary weights", roughxr.summary(pull, weights=xr.DataArray(np.arange(1.0, 65), dims="subregion"))
    yield "bootstrap", roughxr.bootstrap(pull, "pull_off_force")
    yield "bootstrap asperities", roughxr.bootstrap(catalogue, "axis_ratio", resamples=99)
    yield "fit", roughxr.fit(pull, "pull_off_force")
    yield "cdf", roughxr.statistics.cdf(pull, "pull_off_force").to_dataset(name="cdf")
    for words, ds, name in (("pull_off", pull, "pull_off_force"), ("ratio", catalogue, "axis_ratio")):
        for method in ("histogram", "kde"):
            yield f"pdf {words} {method}", roughxr.pdf(ds, name, method=method).to_dataset(name="pdf")
    hertz = roughxr.superpose(catalogue, delta=np.arange(0, 16, 0.5), subregions=(8, 8), law="hertz")
    yield (
        "force_ratio",
        roughxr.statistics.force_ratio(hertz, roughxr.direct(glass(), delta=[5.0, 10.0, 15.0], subregions=(8, 8))),
    )


def varied():
    """Yield results over parameters."""
    ds, catalogue = made(), roughxr.asperities(made())
    pairs = {"sphere_radius": [300.0, 800.0], "contact_modulus": [20.0, 40.0]}
    yield "direct", roughxr.vary(ds, roughxr.direct, **pairs, delta=[1.0, 3.0], subregions=(2, 2))
    adhering = pairs | {"work_of_adhesion": [0.0, 0.5, 1.0]}
    yield "superpose", roughxr.vary(catalogue, roughxr.superpose, **adhering, delta=[0.0, 2.0], subregions=(3, 3))
    yield "pull_off_map", roughxr.vary(catalogue, roughxr.pull_off_map, **adhering, subregions=(5, 5))
    small = {"delta": [1.0], "mesh": roughxr.Mesh(step=0.5), "subregions": ([190.0], [180.0]), "datum": "first_contact"}
    yield "adhesive", roughxr.vary(ds, roughxr.adhesive, work_of_adhesion=[0.2, 0.5], contact_modulus=[30.0], **small)


def runs():
    """Yield the run of any scan, with its tables."""
    here = dask.config.set(scheduler="synchronous")
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as printed, here:
        groups = roughxr.run(made((128, 128)), Path(folder) / "run.nc", subregions=(4, 4))
        yield from groups.items()
        yield "intervals", roughxr.report.interval_table(groups).to_string(float_format="{:.12g}".format)
    yield "printed", printed.getvalue()


def paper():
    """Yield `roughxr paper`: groups, tables to all their digits, and figures as pixels."""
    from matplotlib.image import imread

    with tempfile.TemporaryDirectory() as folder:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            groups = roughxr.reproduction.paper(folder)
        yield from groups.items()
        yield "printed", printed.getvalue()
        for path in sorted(Path(folder).glob("table*")):
            yield path.name, path.read_text(encoding="utf-8")
        for path in sorted(Path(folder).glob("*.png")):
            yield path.name, imread(path)


def notebooks(slow=False):
    """Yield what the notebooks print, each executed away from any other files."""
    import nbformat
    from nbclient import NotebookClient

    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        if (path.stem == SLOW) != slow:
            continue
        with tempfile.TemporaryDirectory() as folder:
            notebook = nbformat.read(path, as_version=4)
            NotebookClient(notebook, timeout=3600, resources={"metadata": {"path": folder}}).execute()
        yield path.stem, "\n".join(_printed(notebook))


def _printed(notebook):
    """Yield the texts of a notebook's outputs, without what differs from run to run."""
    for output in (output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs):
        text = output.get("text") or output.get("data", {}).get("text/plain", "")
        if output.get("name") != "stderr" and (text.startswith("<xarray") or not text.startswith("<")):
            yield _PASSING.sub("…", text)


CASES = {
    "scans": scans,
    "catalogues": catalogues,
    "direct": direct,
    "superposition": superposition,
    "pull_off_maps": pull_off_maps,
    "adhesion": adhesion,
    "estimates": estimates,
    "statistics": statistics,
    "varied": varied,
    "runs": runs,
    "paper": paper,
    "notebooks": notebooks,
    "verdict": lambda: notebooks(slow=True),
}


# ---------------------------------------------------------------- what is kept


def kept(case, name, result):
    """Yield (key, record) of a result: Dataset, text or picture."""
    key = f"{case}: {name}"
    if isinstance(result, str):
        yield key, {"text": result}
    elif isinstance(result, np.ndarray):
        yield key, {"picture": hashlib.sha256(np.ascontiguousarray(result).tobytes()).hexdigest()[:16]}
    else:
        for variable in sorted(result.variables, key=str):
            yield f"{key}: {variable}", of_values(result[variable].values)
        yield from ((f"{key}: @{name}", record) for name, record in _attributes(result))


def _attributes(ds):
    """Yield the numbers among the attributes of a Dataset and of its variables."""
    for owner, attrs in [("", ds.attrs), *((f"{name}.", ds[name].attrs) for name in ds.data_vars)]:
        for name, value in attrs.items():
            if isinstance(value, (int, float, np.number, np.ndarray)) and np.asarray(value).dtype.kind in "iuf":
                yield f"{owner}{name}", of_values(np.asarray(value))


def of_values(values):
    """Return the record of an array."""
    if values.dtype.kind not in "biuf":
        return {"text": "\n".join(map(str, np.ravel(values)))}
    values = np.ascontiguousarray(values, dtype=np.float64)
    present = np.isfinite(values)
    some = values[present]
    weights = np.cos(np.flatnonzero(present.ravel()))
    return {
        "bytes": hashlib.sha256(np.where(np.isnan(values), np.nan, values).tobytes()).hexdigest()[:16],
        "shape": list(values.shape),
        "finite": int(some.size),
        "scale": float(np.abs(some).sum()),
        "sum": float(some.sum()),
        "weighted": float((some * weights).sum()),
        "min": float(some.min(initial=np.inf)),
        "max": float(some.max(initial=-np.inf)),
    }


def computed(cases, say):
    """Return the records of all cases."""
    found = {}
    for case in cases:
        start = time.process_time()
        for name, result in CASES[case]():
            if name != "log":  # a run's times
                found.update(kept(case, name, result))
        say(f"{case}: {time.process_time() - start:.0f} s of processor time")
    return found


# ---------------------------------------------------------------- comparison


def difference(before, after):
    """Return how two records differ in words: "" for not at all, "bits" for less than the tolerance."""
    if before == after:
        return ""
    if before.keys() != after.keys():
        return "is of another kind"
    if "text" in before:
        lines = difflib.unified_diff(before["text"].splitlines(), after["text"].splitlines(), lineterm="", n=0)
        return "\n    ".join(["", *list(lines)[2:]])
    if "picture" in before:
        return "is drawn otherwise"
    for name in ("shape", "finite"):
        if before[name] != after[name]:
            return f"{name} {before[name]} → {after[name]}"
    return _numbers(before, after)


def _numbers(before, after):
    largest = max(abs(before["min"]), abs(before["max"])) if before["finite"] else 0.0
    scales = {"sum": before["scale"], "weighted": before["scale"], "min": largest, "max": largest}
    off = {
        name: abs(after[name] - before[name]) / max(scale, 1e-300)
        for name, scale in scales.items()
        if after[name] != before[name]
    }
    worst = max(off, key=off.get, default=None)
    if worst is None or off[worst] <= TOLERANCE:
        return "bits"
    return f"{worst} {before[worst]!r} → {after[worst]!r} (relative {off[worst]:.1e})"


def renamed(lost, new):
    """Return the pairs of lost and new keys of one case whose numbers are the same bytes."""
    pairs, left = {}, dict(new)
    for key, record in lost.items():
        same = (k for k, r in left.items() if r == record and k.split(": ")[:2] == key.split(": ")[:2])
        if match := next(same, None):
            pairs[key] = match
            del left[match]
    return pairs


def report(before, after):
    """Print what differs; return the number of differences beyond the tolerance."""
    lost = {key: record for key, record in before.items() if key not in after}
    new = {key: record for key, record in after.items() if key not in before}
    pairs = renamed(lost, new)
    for old, name in pairs.items():
        print(f"renamed, same bytes: {old} → {name.split(': ')[-1]}")
    gone = [key for key in lost if key not in pairs]
    for key in gone:
        print(f"only before: {key}")
    for key in sorted(new.keys() - set(pairs.values())):
        print(f"only after: {key}")
    found = {key: difference(before[key], after[key]) for key in before if key in after}
    for key, words in found.items():
        if words:
            print(f"{key}: {'equal to 1e-12, not bit for bit' if words == 'bits' else words}")
    bits = sum(words == "bits" for words in found.values())
    beyond = sum(words not in ("", "bits") for words in found.values())
    equal = len(found) - bits - beyond + len(pairs)
    print(f"{equal} equal bit for bit, {bits} to {TOLERANCE:g}, {beyond} differ, {len(gone)} missing")
    return beyond + len(gone)


def shown(found):
    """Print every number."""
    for key, record in found.items():
        if "sum" in record:
            shape = "×".join(map(str, record["shape"])) or "scalar"
            print(f"{key} ({shape}): " + ", ".join(f"{n} {record[n]:.12g}" for n in ("sum", "min", "max")))
        else:
            print(f"{key}: {record.get('text', record.get('picture'))}")


def main():
    """Return 0 if nothing differs beyond the tolerance."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--save", metavar="FILE", type=Path)
    parser.add_argument("--against", metavar="FILE", type=Path)
    parser.add_argument("--only", metavar="CASES", help=", ".join(CASES))
    parser.add_argument("--verdict", action="store_true", help=f"also the notebook {SLOW}")
    options = parser.parse_args()
    cases = options.only.split(",") if options.only else [c for c in CASES if c != "verdict" or options.verdict]
    warnings.simplefilter("ignore")
    with dask.config.set(scheduler="synchronous"):
        found = computed(cases, lambda words: print(words, file=sys.stderr, flush=True))
    if options.save:
        options.save.write_text(json.dumps(found, indent=1, ensure_ascii=False), encoding="utf-8")
    if options.against:
        before = json.loads(options.against.read_text(encoding="utf-8"))
        return int(report({k: r for k, r in before.items() if k.split(":")[0] in cases}, found) > 0)
    if not options.save:
        shown(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
