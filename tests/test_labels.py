"""Every name that roughxr writes has its row in the table: units, and words that a reader understands."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.vocabulary import schema

from .surfaces import glass_pair, rough, scan

PLACES = {"subregions": (3, 3)}


@pytest.fixture(scope="module")
def results():
    surface = glass_pair(scan(rough(48)))
    sweep = surface.contact.superpose(delta=np.linspace(-6, 6, 41), **PLACES)
    pull = sweep.contact.pull_off()
    cycle = surface.contact.adhesive(delta=[1.0], mesh=roughxr.Mesh(1, step=1.0), law="griffith", fields=True)
    held = surface.contact.rolling(directions=4, **PLACES)
    return {
        "rolling": held,
        "rolling off states": roughxr.rolling(cycle, directions=4),
        "critical_load": held.contact.critical_load(),
        "critical angle": held.contact.critical_load("tilt", particle_density=2500),
        "critical acceleration": held.contact.critical_load("centrifuge", particle_density=2500),
        "resuspension": held.contact.resuspension(friction_velocity=[1.0, 100.0]),
        "scan": surface,
        "asperities": surface.contact.asperities(),
        "superpose": sweep,
        "direct": surface.contact.direct(delta=[1.0], fields=True),
        "direct by load": surface.contact.direct(load=[50.0]),
        "adhesive": cycle,
        "pull_off of a cycle": cycle.contact.pull_off(),
        "pull_off": roughxr.statistics.reduction(pull),
        "pull_off_map": surface.contact.pull_off_map(**PLACES),
        "rigid": surface.contact.rigid(**PLACES, fields=True, delta=[-1.0]),
        "regime": surface.assign_coords(hardness=6.0).contact.regime(subregions=(1, 1)),
        "formulas": surface.contact.formulas(subregions=(1, 1)),
        "scale_dependence": surface.contact.scale_dependence(shortest=[40, 80], seeds=1, subregions=(1, 1)),
        "self_affine_fit": roughxr.scans.self_affine_fit(surface),
        "jkr_sphere": roughxr.reference.jkr_sphere([1.0], radius=9, contact_modulus=9, work_of_adhesion=1),
        "roughness": surface.contact.roughness(),
        "fit": pull.contact.fit("pull_off_force", simulations=0),
        "bootstrap": pull.contact.bootstrap("pull_off_force", resamples=99),
        "summary": pull.contact.summary(),
        "pdf": pull.contact.pdf("pull_off_force").to_dataset(),
        "debris": roughxr.statistics.debris(surface.contact.asperities()).to_dataset(),
        "tabor": roughxr.reference.tabor(surface.contact.asperities()),
        "error_budget": surface.contact.error_budget(places=1, mesh=1, settings={"modulus": [2.0]}),
        "compare": roughxr.compare(pull, pull.assign(pull_off_force=2 * pull.pull_off_force), resamples=20),
        "curves_pull_off": roughxr.measured.curves_pull_off(
            xr.Dataset(
                {
                    name: ("sample", np.linspace(5, -5, 99), {"units": u})
                    for name, u in (("piezo", "nm"), ("force", "nN"))
                }
            )
        ),
        "fit_pair": surface.contact.fit_pair(pull, method="superposed", subregions=(2, 2)),
        "force_ratio": roughxr.statistics.force_ratio(sweep, surface.contact.direct(delta=[1.0, 2.0, 3.0], **PLACES)),
    }


def test_every_name_has_its_row(results):
    unknown = {
        (verb, str(name)) for verb, ds in results.items() for name in ds.variables if name not in schema.VARIABLES
    }
    assert not unknown


def test_every_variable_has_units_and_words(results):
    bare = {
        (verb, str(name))
        for verb, ds in results.items()
        for name in ds.data_vars
        if not (ds[name].attrs.get("units") and ds[name].attrs.get("long_name"))
    }
    assert not bare
