"""What small functions return, one line each: those that no other test calls by themselves."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from roughxr import report
from roughxr.archive import as_characters
from roughxr.bodies.liquid import kelvin_radius
from roughxr.bodies.substances import combined, pair_of, softer_hardness
from roughxr.figures.distributions import _step
from roughxr.figures.saving import mean_and_spread
from roughxr.figures.style import decimals, display_unit, in_words
from roughxr.jobs.progress import about
from roughxr.measured.baselines import baseline_of
from roughxr.measured.forces import Calibration, converts, forces, magnitudes
from roughxr.measured.registration import _vertex, grid_of
from roughxr.measured.tables import Column, _split, place_columns
from roughxr.particles.loads import in_range
from roughxr.scans.channel import direction_in, is_length
from roughxr.scans.plain import separators
from roughxr.statistics import places, sampling
from roughxr.statistics.pooling import random_effects
from roughxr.vocabulary.numbers import interval, number, percent, prefixed, quantity, sure
from roughxr.vocabulary.text import did_you_mean, printable
from roughxr.vocabulary.units import factor, in_units, magnitude, mass_power

GRID = np.argwhere(np.ones((4, 4))) * 10.0
QUANTISED = np.array([1.0, 1.1, 1.1, 1.3, 1.1, 1.0, 1.3, 1.0])
FOUND = sampling.Samples(np.array([5.0, 6.0, 7.0]), None, np.array([[0.0, 0.0], [0.0, 2.0], [1.0, 0.0]]), 0)
CALIBRATED = Calibration(sensitivity="50 nm/V", spring_constant="0.2 N/m")
COLUMNS = [Column("X Position", "um", np.zeros(1)), Column("subregion_y", "nm", np.zeros(1))]

TOLD = xr.Dataset(coords={"work_of_adhesion": 0.1, "sphere_radius": 500.0}, attrs={"expectation": "half of it"})


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        ([kelvin_radius("50 %"), kelvin_radius(0.9)], pytest.approx([0.7563, 4.9758], rel=1e-4)),
        (softer_hardness(*pair_of("glass/gold")), 1.0),
        ([combined(0.065, 0.152), combined(0.065, 0.065, 0.037)], pytest.approx([0.0994, 0.00392], rel=1e-3)),
        (in_range(np.array([0.5, 1.2, 3.0]), "leighton_acrivos").tolist(), [True, False, False]),
        (as_characters(xr.Dataset({"law": ("k", ["jkr", "hertz"]), "k": [1.0, 2.0]})), {"law": {"dtype": "S1"}}),
        ([about(20), about(200), about(3 * 3600)], ["less than a minute", "about 3 min", "about 3 h"]),
        (baseline_of(z := np.linspace(0.0, -100.0, 101), 3.0 + 0.01 * z, 0.3).at(0.0), pytest.approx(3.0)),
        ([converts("pN", "nN"), converts("V", "nN"), converts(None, "nN")], [True, False, False]),
        (forces(np.array([2.0]), "V", CALIBRATED)[0].tolist(), pytest.approx([20.0])),
        (magnitudes(np.array([-3.0, 2.0]), "negative")[0].tolist(), [3.0, -2.0]),
        (magnitudes(np.array([-3.0, np.nan]), None)[1], "negative"),
        (grid_of(FOUND).values.ravel().tolist(), pytest.approx([5.0, 6.0, 7.0, np.nan], nan_ok=True)),
        (_vertex(np.array([0.0, 1.0, 0.5]), 1), pytest.approx(1 / 6)),
        ([_split("x [um]  force (nN)", None), _split('1,"2",', ",")], [["x [um]", "force (nN)"], ["1", "2", ""]]),
        (list(place_columns(Path("pulls.csv"), COLUMNS, Column("F", "nN", np.zeros(1)))), ["x", "y"]),
        ([_step(QUANTISED), _step(np.array([1.0, 1.1, 1.25]))], [pytest.approx(0.1), None]),
        (mean_and_spread([1000.0, 3000.0], "µN", size=1e3), "2.00 ± 1.41 µN"),
        ([decimals(np.array([0.0, 0.5, 1.25])), decimals(np.array([1e-9]))], [2, None]),
        ([display_unit("nN", 2e4), display_unit("nN", 20)], [("µN", 1000.0), ("nN", 1.0)]),
        ([in_words("contact_area"), in_words("axis_ratio")[:10]], ["contact area [nm²]", "axis ratio"]),
        (in_words("force", display_unit("nN", 1e3)), "contact force [µN]"),
        (report.superposed({"solutions/energy": TOLD}), ["Superposed (energy): half of it."]),
        (report.text(pd.DataFrame({"direct": {"pull [nN]": np.nan}}), "Contact").split()[-1], "–"),
        ([is_length("um"), is_length("deg"), is_length(None)], [True, False, False]),
        ([direction_in("HeightRetrace"), direction_in("Z-Axis forward"), direction_in("Z")], ["retrace", "trace", ""]),
        (
            [separators("1.5,2.5"), separators("1,5;2,5"), separators("1.5 2.5")],
            [(",", False), (";", True), (None, False)],
        ),
        (places.normal_scores(np.array([1.0, 1000.0, 2.0])).tolist(), pytest.approx([-0.967, 0.967, 0.0], abs=1e-3)),
        (sorted(places.blocks(GRID, 20.0)[0].tolist()), [0, 1, 4, 5]),
        (random_effects(np.array([1.0, 2.0, 3.0]), np.zeros(3), confidence=0.95).between, 1.0),
        (sampling.shares(xr.DataArray([1.0, 3.0], dims="subregion")).values.tolist(), [1.0, 1.0]),
        (sampling.other_dimensions(xr.Dataset({"f": (("seed", "subregion"), [[1.0, 2.0]])}), "f"), ["seed"]),
        ([sampling.per("nN"), sampling.per("J/m^2"), sampling.per("1")], ["1/nN", "m^2/J", "1"]),
        ([number(2.04, "µN", 2), number(-0.5), number(99.96, "%"), number(1263.0)], ["2 µN", "−0.5", "100 %", "1263"]),
        ([number(6.5e-20, "J"), number(0.0), number(0.99996), number(np.inf)], ["6.5 × 10⁻²⁰ J", "0", "1", "∞"]),
        ([percent(0.9999), percent(0.0042), percent(12.3)], ["100 %", "0.42 %", "1230 %"]),
        ([prefixed(999.96), prefixed(12842.0, "nm"), prefixed(3, "GPa")], [("µN", 1e3), ("µm", 1e3), ("GPa", 1.0)]),
        ([quantity(6.011), quantity(0.0126), quantity(-26.2e3)], ["6.01 nN", "12.6 pN", "−26.2 µN"]),
        (sure(871.0, 156.0, 4850.0), "871 nN (95 % interval 156 … 4850 nN)"),
        ([interval(388.0, 1817.0, "nN"), interval(-0.1, 0.25)], ["0.388 … 1.82 µN", "−0.1 … 0.25"]),
        (printable("5 µm\x1b[2J\u202e"), r"5 µm\x1b[2J\u202e"),
        ([did_you_mean("adhesiv", ("adhesive",)), did_you_mean(3, ("direct",))], ["; did you mean 'adhesive'?", ""]),
        ([factor("um", "nm"), factor("mJ/m^2", "J/m^2")], pytest.approx([1000.0, 0.001])),
        ([magnitude("3 um", "nm", "R"), magnitude("6.5e-20 J", "nN nm", "A")], pytest.approx([3000.0, 0.065])),
        (in_units(xr.Variable("x", [0.5, 1.0], {"units": "um"}), "nm", "x").values.tolist(), [500.0, 1000.0]),
        ([mass_power(units) for units in ("nN", "J/m^2", "GPa", "1/nm", "1")], [1.0, 1.0, 1.0, 0.0, 0.0]),
    ],
)
def test_it_returns(found, expected):
    assert found == expected


def test_a_share_weighs_a_place_and_weights_go_by_label():
    force = xr.DataArray([1.0, 3.0], {sampling.SHARE: ("subregion", [0.75, 0.25])}, ["subregion"])
    assert float(sampling.by_share(force).mean()) == 1.5
    ds = xr.Dataset({"force": ("subregion", [1.0, 2.0])}, {"subregion": [0, 1]})
    found, name = sampling.with_weights(ds, "force", xr.DataArray([5.0, 3.0], {"subregion": [1, 0]}, ["subregion"]))
    assert found[name].values.tolist() == [3.0, 5.0]


def test_neighbours_that_are_alike_are_fewer_independent_places():
    at = np.argwhere(np.ones((12, 12))) * 100.0
    assert places.independent_places(np.random.default_rng(0).normal(size=144), at) > 100
    assert places.independent_places(at[:, 0], at) < 10
