"""The figure that sets the pull-offs side by side."""

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot

from roughxr.presentation.figures.verdict_figure import verdict


@pytest.fixture
def forces():
    force = np.array([[100.0, 200.0, np.nan], [3000.0, 4000.0, 5000.0]])
    return xr.Dataset({"pull_off_force": (("method", "subregion"), force)}, {"method": ["elastic sweep", "direct"]})


def test_rows_are_named_and_the_axis_has_its_unit(forces):
    ax = verdict(forces, marks={"smooth sphere": 1e4})
    assert [label.get_text() for label in ax.get_yticklabels()] == ["elastic sweep", "direct"]
    assert ax.get_xlabel() == "pull-off force [µN]"
    assert ax.get_xscale() == "log"
    assert "smooth sphere" in [text.get_text() for text in ax.get_legend().get_texts()]
    pyplot.close(ax.figure)


def test_intervals_are_drawn_where_they_are_known(forces):
    words = {}
    for name, ds in (
        ("bare", forces),
        ("known", forces.assign(low=("method", [90, 3e3]), high=("method", [210, 5e3]))),
    ):
        ax = verdict(ds)
        words[name] = {text.get_text() for text in ax.get_legend().get_texts()}
        pyplot.close(ax.figure)
    assert words["known"] - words["bare"] == {"mean, 95 %"}
