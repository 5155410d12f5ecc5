"""Containers of contact.engineering: maps and lines in one call, whatever their metadata try."""

import io
import json
import os
import zipfile

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.scans import synthetic
from roughxr.scans import UnreadableScan

META = """
surfaces:
- name: film
  category: exp
  topographies:
  - name: profile
    datafile: {original: profile.asc}
    size: !!python/tuple
    - 2.0
    unit: um
    height_scale: 2.0
    detrend_mode: height
  - name: map
    datafile: {original: map.txt}
    data_source: 0
    size: !!python/tuple [0.4, 0.2]
    unit: um
    height_scale: 0.5
    detrend_mode: center
"""

X = np.array([0.0, 0.3, 0.5, 1.1, 2.0])
ROWS = np.array([[0.04, 0.05, 0.06, 0.09], [0.00, 0.01, 0.03, 0.04]])  # um, from the top


def container(path, meta, name="meta.yml", **files):
    texts = {"profile.asc": "\n".join(f"{x} {0.01 * x**2}" for x in X), "map.txt": io.StringIO()}
    np.savetxt(texts["map.txt"], ROWS)
    texts["map.txt"] = texts["map.txt"].getvalue()
    with zipfile.ZipFile(path, "w") as archive:
        for member, content in {name: meta, **texts, **files}.items():
            archive.writestr(member, content)
    return path


def test_maps_and_lines_come_in_nm_as_the_container_says(tmp_path):
    line, scan = roughxr.scans.open_container(container(tmp_path / "film.zip", META))
    heights = 20 * X**2
    expected = heights - np.polyval(np.polyfit(X, heights, 1), X)
    np.testing.assert_allclose(line.height, expected, atol=1e-9)
    np.testing.assert_allclose(line.x, 1000 * X)
    assert line.attrs["title"] == "profile" and line.attrs["surface"] == "film" and line.height.units == "nm"
    np.testing.assert_allclose(scan.height, 500 * (ROWS - ROWS.mean())[::-1].T, atol=1e-9)
    np.testing.assert_allclose(scan.y, [50, 150])
    assert roughxr.schema.history(scan)[-1]["operation"] == "open_container"


def test_what_the_software_of_the_containers_writes_is_read(tmp_path):
    topography = pytest.importorskip("SurfaceTopography", reason="needs the extra afm")
    from SurfaceTopography.Container.IO.CE import write_containers
    from SurfaceTopography.Container.SurfaceContainer import InMemorySurfaceContainer

    heights = np.random.default_rng(1).normal(size=(6, 4))
    parts = [
        topography.Topography(heights, (60.0, 40.0), unit="nm"),
        topography.UniformLineScan(heights[0], 8.0, unit="µm"),
        topography.NonuniformLineScan(X, 0.01 * X**2, unit="µm"),
    ]
    write_containers([InMemorySurfaceContainer(parts)], str(tmp_path / "made.zip"))
    scan, even, uneven = roughxr.scans.open_container(tmp_path / "made.zip")
    np.testing.assert_allclose(scan.height, heights[:, ::-1])  # y is counted from the top there
    np.testing.assert_allclose(even.height, 1000 * heights[0])
    np.testing.assert_allclose(np.diff(even.x), 2000)
    np.testing.assert_allclose([uneven.x, uneven.height], [1000 * X, 10 * X**2])


def test_tags_of_objects_make_nothing(tmp_path):
    made = tmp_path / "made"
    for tag in ("!!python/object/apply:os.mkdir", "!!python/object/new:os.mkdir", "!!python/name:os.mkdir", "!any"):
        hostile = META + f"creator: {tag} ['{made}']\nother: !!python/object:os.stat_result {{a: {tag} b}}\n"
        assert len(roughxr.scans.open_container(container(tmp_path / "hostile.zip", hostile))) == 2
    assert not made.exists()


def test_nothing_is_written_under_a_name_that_the_container_gives(tmp_path):
    outside = tmp_path / "outside.asc"
    for name in ("../" * 20 + str(outside)[1:], str(outside), "..", ".hidden/.."):
        meta = META.replace("profile.asc", json.dumps(name))
        profile = {name: "0 1\n1 2\n2 1\n"}
        line, _ = roughxr.scans.open_container(container(tmp_path / "film.zip", meta, **profile))
        assert line.sizes["x"] == 3 and os.listdir(tmp_path) == ["film.zip"]


@pytest.mark.parametrize(
    ("meta", "name", "reason"),
    [
        ("surfaces: [", "meta.yml", "damaged"),
        ("{}", "index.json", "surfaces"),
        (META.replace("profile.asc", "other.asc"), "meta.yml", "other.asc"),
        (META.replace("unit: um", "unit: V"), "meta.yml", "'V'"),
        (META.replace("mode: center", "mode: sphere"), "meta.yml", "sphere"),
        (META, "about.yml", "without meta.yml"),
        ("a: " + "[" * 100_000, "meta.yml", "damaged"),
        (" " * (2**19 + 1), "meta.yml", "at most 512 KiB"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_containers_name(tmp_path, meta, name, reason):
    with pytest.raises(UnreadableScan, match=f"film.zip.*{reason}"):
        roughxr.scans.open_container(container(tmp_path / "film.zip", meta, name))


def test_a_member_that_is_named_a_thousand_times_is_refused(tmp_path):
    line = {"name": "a", "size": [2.0], "unit": "um", "datafile": {"original": "long.asc"}}
    meta = json.dumps({"surfaces": [{"topographies": [line] * 1000}]})
    path = container(tmp_path / "a.zip", meta, **{"long.asc": "0 0\n" * 5000 + "1 1\n"})
    with pytest.raises(UnreadableScan, match=r"expected each file once, found 'long\.asc' 1,000 times"):
        roughxr.scans.open_container(path)


def test_a_container_is_no_scan_and_a_text_no_container(tmp_path):
    with pytest.raises(UnreadableScan, match=r"roughxr\.scans\.open_container"):
        roughxr.open_scan(container(tmp_path / "film.zip", META))
    (tmp_path / "plain.txt").write_text("1 2\n3 4\n")
    with pytest.raises(UnreadableScan, match="found no zip file"):
        roughxr.scans.open_container(tmp_path / "plain.txt")


@pytest.mark.filterwarnings("ignore::roughxr.scans.ImplausibleScan")
def test_the_published_film_has_one_spectrum(shared_scans):
    """Its AFM map and its TEM profile agree where both reach: heights are not scaled twice."""
    parts = roughxr.scans.open_container(shared_scans / "uncd_container_ccby.zip")
    assert [part.sizes["x"] for part in parts] == [76, 512, 3001]
    tem, afm = (roughxr.scans.combined_spectrum([part], per_decade=3) for part in parts[:2])
    wavevectors = np.geomspace(2 * np.pi / 45, 2 * np.pi / 25, 9)
    tem, afm = (
        np.exp(np.interp(np.log(wavevectors), np.log(part.wavevector), np.log(part.psd))) for part in (tem, afm)
    )
    assert 0.2 < float(np.exp(np.mean(np.log(tem / afm)))) < 5
    together = roughxr.scans.combined_spectrum(parts, shortest=[None, "25 nm", "2.5 um"])
    assert 2 * np.pi / float(together.wavevector.max()) < 15 and 2 * np.pi / float(together.wavevector.min()) > 5e4


def lines_of(surface, step):
    """Return lines along y, each at steps of its own."""
    kept = np.random.default_rng(2).integers(0, 2, (surface.sizes["x"], surface.sizes["y"] // 2))
    for k in range(0, surface.sizes["x"], step):
        at = np.arange(0, surface.sizes["y"], 2) + kept[k]
        yield xr.Dataset({"height": ("x", surface.height.values[k, at])}, {"x": surface.y.values[at]})


@pytest.mark.parametrize("hurst", [0.3, 0.9])
def test_lines_have_the_spectrum_of_the_surface_that_they_are_cut_from(hurst):
    make = {"rms": 2.0, "hurst": hurst, "rolloff": 200.0, "cutoff": 10.0}
    surfaces = [synthetic.self_affine((384, 384), 2.5, seed=seed, **make) for seed in range(4)]
    of_lines = roughxr.scans.combined_spectrum(
        [line for surface in surfaces for line in lines_of(surface, 24)], per_decade=5
    )
    of_surfaces = roughxr.scans.combined_spectrum(surfaces, per_decade=5)
    assert float(of_lines.wavevector.max()) > 2 * np.pi / 25  # four steps of 5 nm in the mean
    wanted = np.exp(np.interp(np.log(of_lines.wavevector), np.log(of_surfaces.wavevector), np.log(of_surfaces.psd)))
    off = np.log(of_lines.psd / wanted)
    assert abs(float(off[1:].mean())) < 0.1 and float(abs(off[1:]).max()) < 0.3


def test_what_is_no_line_is_refused():
    line = xr.Dataset({"height": ("x", np.arange(32.0))}, {"x": np.arange(32.0)})
    for wrong in (line.isel(x=slice(None, None, -1)), line.where(line.x > 3), line.isel(x=slice(3))):
        with pytest.raises(ValueError, match="four heights of a line or more"):
            roughxr.scans.combined_spectrum([wrong])
    with pytest.raises(ValueError, match="one for each of 2 scans, found 3"):
        roughxr.scans.combined_spectrum([line, line], shortest=[10, 20, 30])


def test_a_container_that_unfolds_to_far_more_is_refused(tmp_path):
    path = tmp_path / "bomb.zip"
    topography = {"name": "a", "size": [1.0, 1.0], "unit": "um", "datafile": {"original": "a.txt"}}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", "0 " * 25_000_000)
        archive.writestr("index.json", json.dumps({"surfaces": [{"topographies": [topography]}]}))
    with pytest.raises(UnreadableScan, match="content of at most 4 MiB, by its size, found 47"):
        roughxr.scans.open_container(path)


def test_a_container_is_no_single_scan_and_is_opened_in_python(tmp_path):
    path = container(tmp_path / "film.zip", META)
    with pytest.raises(ValueError, match="several topographies; in Python, open it with"):
        roughxr.open_scan(path)
