"""Every name that roughxr writes has its row in the table: units, and words that a reader understands."""

import numpy as np
import pytest

import roughxr
from roughxr import schema

from .surfaces import glass_pair, rough, scan

PLACES = {"subregions": (3, 3)}


@pytest.fixture(scope="module")
def results():
    surface = glass_pair(scan(rough(48)))
    sweep = surface.contact.superpose(delta=np.linspace(-6, 6, 41), **PLACES)
    pull = sweep.contact.pull_off()
    cycle = surface.contact.adhesive(delta=[1.0], step=1.0, law="griffith", refine=1, fields=True)
    return {
        "scan": surface,
        "asperities": surface.contact.asperities(),
        "superpose": sweep,
        "direct": surface.contact.direct(delta=[1.0], fields=True),
        "direct by load": surface.contact.direct(load=[50.0]),
        "adhesive": cycle,
        "pull_off of a cycle": cycle.contact.pull_off(),
        "pull_off": pull.contact.reduction(),
        "pull_off_map": surface.contact.pull_off_map(**PLACES),
        "roughness": surface.contact.roughness(),
        "fit": pull.contact.fit("pull_off_force", simulations=0),
        "bootstrap": pull.contact.bootstrap("pull_off_force", resamples=99),
        "summary": pull.contact.summary(),
        "pdf": pull.contact.pdf("pull_off_force").to_dataset(),
        "debris": roughxr.debris(surface.contact.asperities()).to_dataset(),
        "tabor": surface.contact.asperities().contact.tabor(),
        "sensitivity": surface.contact.sensitivity(subregions=(2, 2), settings={"modulus": [2.0]}),
        "compare": roughxr.compare(sweep, surface.contact.direct(delta=[1.0, 2.0, 3.0], **PLACES)),
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


def test_rows_say_what_they_mean():
    for name, row in schema.VARIABLES.items():
        assert (row.long_name and row.long_name[0].islower()) or row.long_name[0] in "AEKRSTλ", name
