"""One small call of every public function that takes a Dataset, for tests of all of them."""

import functools
import inspect
import re
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import roughxr
from roughxr import archive, measured, particles, reference, scans, statistics
from roughxr.accessor import ContactAccessor
from roughxr.mechanics.scans import regions

from .surfaces import rough, scan

#: Contact centres, nm.
PLACES = ([-31.0, 17.0, 52.0, -8.0], [12.0, -44.0, 33.0, 61.0])
PAIR = {"sphere_radius": 800.0, "contact_modulus": 30.0, "work_of_adhesion": 0.2, "adhesion_range": 0.5}

#: Options of the adhesive simulation that take a second or less.
QUICK = {"law": "jkr", "mesh": roughxr.Mesh(1, step=1.0)}
FLOW = {"friction_velocity": [1.0, 5.0]}


def surface(seed=3, n=24):
    """Return a rough scan of few pixels with its pair of bodies."""
    return roughxr.assign_pair(scan(rough(n, rms=1.5, smooth=2.0, seed=seed), pixel=8.0), **PAIR)


@functools.cache
def made():
    """Return Datasets of every kind."""
    ground = surface()
    far = {"subregions": (5, 5)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pulls = roughxr.pull_off_map(ground, **far)
        held = roughxr.rolling(ground, directions=6, **far)
        noise = np.random.default_rng(1).uniform(0.8, 1.6, pulls.sizes["subregion"])
        measured = (pulls[["pull_off_force"]] * xr.DataArray(noise, dims="subregion")).assign_coords(pulls.coords)
        return {
            "scan": ground,
            "catalogue": roughxr.asperities(ground),
            "indenter": scan(-0.3 * np.add.outer(np.arange(-11.0, 8) ** 2, np.arange(-6.0, 13) ** 2), pixel=8.0),
            "pressed": roughxr.direct(ground, delta=np.linspace(1, 9, 12), subregions=PLACES),
            "summed": roughxr.superpose(ground, delta=np.linspace(-2, 9, 23), subregions=PLACES),
            "hertz": roughxr.superpose(ground, delta=np.linspace(1, 9, 12), law="hertz", subregions=PLACES),
            "pulls": pulls,
            "measured": roughxr.schema.label(measured),
            "held": held,
            "critical": roughxr.particles.critical_load(held),
            "fields": roughxr.direct(ground, delta=[3.0], subregions=([0.0], [0.0]), fields=True),
            "curves": _curves(),
        }


def _curves():
    piezo = np.linspace(150.0, -800.0, 400)
    force = np.where(piezo > 0, 0.5 * piezo, np.where(piezo > -60, 0.5 * piezo, 0.0))
    noise = np.random.default_rng(0).normal(0, 0.5, (3, piezo.size))
    columns = {"piezo": ("sample", piezo, {"units": "nm"}), "force": (("subregion", "sample"), force + noise)}
    return roughxr.schema.label(xr.Dataset(columns))


def written(function, suffix, **options):
    """Return a call of a function that writes its first Dataset, as what it has written."""

    def call(ds):
        with tempfile.TemporaryDirectory() as folder:
            function(ds, Path(folder) / f"out{suffix}", **options)
            return (Path(folder) / f"out{suffix}").read_bytes()

    return call


def archived(ds):
    """Return a Dataset as an archive holds it."""
    with tempfile.TemporaryDirectory() as folder:
        return archive.load(archive.save({"one": ds}, Path(folder) / "run.nc"))["one"].load()


def on(*kinds, **options):
    """Return how a verb is called: on what, and with which options."""
    return kinds, options


#: Verb -> its calls. A verb of a module is named with it.
CALLS = {
    "adhesive": [on("scan", subregions=PLACES, preload=[0.0, 40.0], **QUICK)],
    "asperities": [on("scan")],
    "assign_pair": [on("scan", sphere_radius=900, contact_modulus=3, work_of_adhesion=0.05)],
    "bootstrap": [on("pulls", "pull_off_force", resamples=19, confidence=0.9)],
    "certificate": [on("pressed"), on("fields")],
    "cdf": [on("pulls", "pull_off_force"), on("catalogue", "height")],
    "combined_spectrum": [on(["scan"])],
    "compare": [on("pulls", "measured", resamples=39)],
    "critical_load": [on("held"), *(on("held", load, particle_density=2500.0) for load in ("vibration", "tilt"))],
    "crop": [on("scan", x=(-51.0, 41.0), y=(-51.0, 61.0))],
    "curves_pull_off": [on("curves", spring_constant=0.5)],
    "particles.parameters": [on("held")],
    "particles.removing_load": [on("critical", 0.9)],
    "dilate": [on("scan", tip_radius=20.0)],
    "direct": [
        on("scan", delta=[1.0, 4.0, 7.0], subregions=PLACES),
        on("scan", load=[50.0, 300.0], subregions=PLACES),
    ],
    "erode": [on("scan", tip_radius=20.0)],
    "fill": [on("scan")],
    "fit": [on("pulls", "pull_off_force", simulations=0)],
    "fit_curve": [on("curves", sphere_radius=2000, spring_constant=5.0)],
    "fit_sphere": [on("indenter")],
    "fit_pair": [on("scan", "measured", method="superposed", subregions=(4, 4), confidence=0.9)],
    "force_ratio": [on("hertz", "pressed")],
    "formulas": [on("scan", subregions=(1, 1), mesh=2)],
    "level": [on("scan"), on("scan", method="quadratic")],
    "pdf": [on("pulls", "pull_off_force", bins=4), on("catalogue", "curvature_max")],
    "placements": [on("scan", sphere_radius=500.0, count=2)],
    "power_spectrum": [on("scan")],
    "pull_off": [on("summed")],
    "pull_off_map": [on("scan", subregions=PLACES), on("catalogue", subregions=PLACES)],
    "reconstruct": [on("scan"), on("scan", "catalogue")],
    "reduction": [on("pulls")],
    "regime": [on("scan", subregions=(1, 1), mesh=2)],
    "regions.centres": [on("scan", (2, 3)), on("scan", "pulls")],
    "regions.extent": [on("scan"), on("catalogue")],
    "resample": [on("scan", size=12.0)],
    "resuspension": [on("held", **FLOW)],
    "rigid": [
        on("scan", delta=[-4.0, -1.0], subregions=PLACES),
        on("scan", delta=[-1.0], subregions="pulls"),
    ],
    "rolling": [on("scan", directions=6, subregions=PLACES), on("catalogue", directions=6, subregions=PLACES)],
    "roughness": [on("scan")],
    "self_affine_fit": [on("scan")],
    "smooth": [on("scan", shortest=30.0)],
    "summary": [on("pulls"), on("catalogue")],
    "superpose": [
        on("scan", delta=[-1.0, 2.0, 5.0], subregions=PLACES),
        on("catalogue", delta=[-1.0, 2.0, 5.0], subregions=PLACES, law="dugdale"),
    ],
    "tabor": [on("catalogue")],
    "tip_flags": [on("catalogue", tip_radius=10.0)],
    "to_file": [on("scan")],
    "to_table": [on("pulls")],
    "vary": [on("scan", "pull_off_map", work_of_adhesion=[0.1, 0.3], subregions=PLACES)],
}

#: Those built of the verbs above that take minutes, or need more than a small scan, and why each is not called.
NOT_CALLED = {
    "archive.save": "writes what it is given",
    "checkpointed": "computes what it is given; tests/test_identities.py",
    "compute": "computes what it is given",
    "error_budget": "`adhesive` at some places",
    "answer": "numbers that it holds, in words",
    "extrapolated": "`adhesive` and its error budget",
    "pooled": "wants several scans: tests/test_pooling.py",
    "resting": "one map: tests/test_resting.py",
    "run": "all of them",
    "particles.to_dem": "text for other programs, of `parameters`",
}
WRITES = {"to_file": ".gsf", "to_table": ".csv"}


def documented():
    """Return the names of rooms' functions that have a page, without those of `particles`."""
    pages = Path(__file__).parent.parent / "notebooks" / "site" / "api.rst"
    return re.findall(r"^   (?:scans|statistics|measured|reference)\.(\w+)$", pages.read_text(encoding="utf-8"), re.M)


def named(name):
    """Return the public function of a name, from the package or its subpackages."""
    rooms = (roughxr, scans, statistics, measured, reference, particles)
    return next(getattr(room, name) for room in rooms if hasattr(room, name))


def public_verbs():
    """Return all public functions that take a Dataset, by name."""
    modules = {"": roughxr, "particles.": particles, "regions.": regions, "archive.": archive}
    verbs = {name: named(name) for name in documented()}
    for prefix, module in modules.items():
        names = getattr(module, "__all__", ["save"])
        for name in names:
            attribute = getattr(module, name)
            if inspect.isfunction(attribute) and "Dataset" in str(inspect.signature(attribute).parameters):
                verbs[name if hasattr(ContactAccessor, name) else prefix + name] = attribute
    return {
        name: attribute
        for name, attribute in verbs.items()
        if "Dataset" in str(inspect.signature(attribute).parameters)
        and (name.split(".")[-1] not in roughxr.__all__ or "." not in name)
    }


def call(verb, kinds, options, datasets):
    """Call a verb on Datasets by their kinds; other words are its own options."""

    def given(word):
        if isinstance(word, list) and word and isinstance(word[0], str):
            return [given(kind) for kind in word]
        if verb == "vary" and isinstance(word, str) and word in ("direct", "pull_off_map"):
            return getattr(roughxr, word)
        return datasets.get(word, word) if isinstance(word, str) else word

    module, _, name = verb.rpartition(".")
    function = getattr({"particles": particles, "regions": regions}[module], name) if module else named(name)
    if verb in WRITES:
        function = written(function, WRITES[verb])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function(*map(given, kinds), **{key: given(value) for key, value in options.items()})


def kinds_read(kinds, options):
    """Return the kinds of Datasets that a call reads."""
    flat = [
        word_or_kind
        for word in (*kinds, *options.values())
        for word_or_kind in (word if isinstance(word, list) else [word])
    ]
    return [word_or_kind for word_or_kind in flat if isinstance(word_or_kind, str) and word_or_kind in made()]


def numbers(result, leave=()):
    """Return the numbers of any result by name."""
    if isinstance(result, (xr.Dataset, xr.DataArray)):
        parts = result.variables if isinstance(result, xr.Dataset) else {"values": result.variable, **result.coords}
        return {
            str(name): np.asarray(part.values, float)
            for name, part in parts.items()
            if part.dtype.kind in "fiub" and name not in leave
        }
    if isinstance(result, pd.DataFrame):
        return {str(name): result[name].to_numpy() for name in result.select_dtypes("number")}
    if isinstance(result, bytes):
        return {"bytes": np.frombuffer(result, np.uint8).astype(float)} if b"," not in result else _text_numbers(result)
    return {"values": np.asarray(result, float)}


def unlabelled(result):
    """Return the names in a result without a row in the table of variables, without units or without a long name."""
    if not isinstance(result, xr.Dataset):
        return []
    bare = {
        name
        for name, variable in result.data_vars.items()
        if not (variable.attrs.get("units") and variable.attrs.get("long_name"))
    }
    return sorted(bare | {str(name) for name in result.variables if name not in roughxr.schema.VARIABLES})


def _text_numbers(text):
    cells = text.decode("utf-8", "replace").replace("\n", ",").split(",")
    cell_values = []
    for cell in cells:
        try:
            cell_values.append(float(cell))
        except ValueError:
            continue
    return {"cells": np.asarray(cell_values)}


def assert_same(result, expected, *, rtol, leave=(), context=""):
    """Raise where two results differ by more than rounding, relative to the largest of each variable."""
    result = numbers(result, leave)
    expected = numbers(expected, leave)
    assert result.keys() == expected.keys(), context
    for name in expected:
        scale = np.abs(expected[name][np.isfinite(expected[name])]).max(initial=0.0)
        np.testing.assert_allclose(
            result[name], expected[name], rtol=rtol, atol=rtol * scale, err_msg=f"{context}: {name}"
        )
