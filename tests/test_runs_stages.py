"""The archive of a run holds its stages as they end, whatever stops it, and says what is missing."""

import warnings

import pytest
import xarray as xr

import roughxr
from roughxr import archive, cli, report
from roughxr.runs import analysis
from roughxr.scans.synthetic import self_affine

from .surfaces import bare_runs

OPTIONS = {"subregions": (3, 2), "mesh": 1, "budget": 0}

#: Stages of such a run that are interrupted, each with a group that the archive has by then.
MOMENTS = {"asperities": None, "rigid": "solutions/adhesive", "rolling": "statistics/energy"}


@pytest.fixture(scope="module", autouse=True)
def _quick():
    with bare_runs():
        yield


@pytest.fixture(scope="module")
def surface():
    scan = self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    return roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05)


@pytest.fixture(scope="module")
def whole(surface, tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "run.nc"
    return path, roughxr.run(surface, path, **OPTIONS)


@pytest.mark.parametrize("moment", MOMENTS)
def test_an_interrupted_run_reads_says_what_is_missing_and_resumes(
    surface, whole, moment, tmp_path, monkeypatch, capsys
):
    there = MOMENTS[moment]
    path = tmp_path / "run.nc"

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    parts = [part._replace(make=interrupted) if part.name == moment else part for part in analysis._PARTS]
    monkeypatch.setattr(analysis, "_PARTS", parts)
    with pytest.raises(KeyboardInterrupt):
        roughxr.run(surface, path, **OPTIONS)
    monkeypatch.undo()
    assert path.exists() == (there is not None)
    if there:
        with pytest.warns(UserWarning, match=r"not finished, missing: .*detachment|not finished, missing: its"):
            found = archive.load(path)
        assert there in found and "log" not in found
        assert cli.main(["report", str(path)]) == 0
        assert cli.main(["info", str(path)]) == 0
        said = capsys.readouterr()
        assert "is not finished" in said.err and "run: not finished, missing: " in said.out
        assert "The run is not finished" in (tmp_path / "report.html").read_text(encoding="utf-8")
    with warnings.catch_warnings():
        warnings.filterwarnings("error", ".*not finished")
        groups = roughxr.run(surface, path, **OPTIONS)
    assert list(groups) == list(whole[1])
    for name in set(groups) - {"log"}:
        xr.testing.assert_allclose(groups[name], whole[1][name], rtol=1e-6)
    assert "not finished" not in report.page(groups)


def test_one_preload_is_what_a_run_takes(surface, tmp_path):
    for preload in ([0.0, 50.0], -1.0):
        with pytest.raises(ValueError, match=r"preload: expected one force of at least 0 nN"):
            roughxr.run(surface, tmp_path / "run.nc", preload=preload, **OPTIONS)
    assert not list(tmp_path.iterdir())
