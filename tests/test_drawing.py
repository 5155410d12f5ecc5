"""Figures drawn by another process while places are solved are those drawn here, and nothing waits for that process."""

import time

import pytest

import roughxr
from roughxr.runs import drawing
from roughxr.scans.synthetic import self_affine

OPTIONS = {"subregions": (2, 2), "mesh": 1, "budget": 1}


@pytest.fixture(scope="module")
def surface():
    scan = self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    return roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.05)


@pytest.fixture(scope="module")
def folder(surface, tmp_path_factory):
    """The folder of a run that draws nothing itself but the figures of its error budget."""
    folder = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawing.os, "cpu_count", lambda: 2)
        patch.setattr(drawing, "_draw", lambda *_: pytest.fail("drawn here, not by the other process"))
        roughxr.run(surface, folder, **OPTIONS)
    return folder


def test_what_another_process_draws_is_what_is_drawn_here(surface, folder, tmp_path):
    (tmp_path / "run.nc").write_bytes((folder / "run.nc").read_bytes())
    roughxr.run(surface, tmp_path, **OPTIONS)  # only draws
    files = {file.name for file in folder.iterdir()}
    assert files == {file.name for file in tmp_path.iterdir()}
    assert {"overview.png", "scan.png", "error-budget.png", "report.html"} <= files
    for name in files - {"run.nc", "places.xlsx"}:  # a workbook holds the time
        assert (folder / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_where_the_other_process_fails_all_is_drawn_here(folder, monkeypatch, tmp_path):
    monkeypatch.setattr(drawing.os, "cpu_count", lambda: 2)
    tried = drawing.Drawing(folder / "absent.nc", tmp_path)
    with tried.beside():
        pass
    assert not tried.pictures
    tried.finish(roughxr.archive.load(folder / "run.nc"))
    assert (tmp_path / "overview.png").read_bytes() == (folder / "overview.png").read_bytes()


def test_an_interrupt_ends_the_other_process(folder, monkeypatch, tmp_path):
    monkeypatch.setattr(drawing.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(drawing, "_COMMAND", "import time; time.sleep(60)")
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt), drawing.Drawing(folder / "run.nc", tmp_path).beside():
        raise KeyboardInterrupt
    assert time.monotonic() - begun < 20
