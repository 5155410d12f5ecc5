"""NanoScope's curves and volumes and exported texts hold what was written, and the real files what was read by hand."""

from pathlib import Path

import numpy as np
import pytest

import roughxr
from roughxr.measured import open_curves
from roughxr.scans import UnreadableScan

from . import force_curves as made

SHARED = Path(__file__).resolve().parents[2] / "shared" / "curves"


@pytest.fixture(scope="module")
def cycles():
    rng = np.random.default_rng(0)
    return [made.cycle(rng, n=400) for _ in range(4)]


def assert_written(curves, branches, force_error):
    """Check a curve's travel, from any zero, and its forces."""
    for branch, (piezo, force) in zip(("loading", "retraction"), branches):
        part = curves.sel(branch=branch)
        np.testing.assert_allclose(part.force, force, atol=force_error)
        np.testing.assert_allclose(np.diff(part.piezo), np.diff(piezo), atol=0.06)


COUNT = made.STIFFNESS * made.DEFLECTION_SENSITIVITY * made.VOLTS_PER_COUNT


@pytest.mark.parametrize(
    ("options", "count"),
    [({"dtype": "<i2"}, COUNT), ({"dtype": "<i4"}, COUNT), ({"dtype": "<i4", "bits": 8}, COUNT / 256)],
)
def test_a_nanoscope_curve_is_what_was_written(tmp_path, cycles, options, count):
    path = made.write_nanoscope_curves(tmp_path / "curve.spm", cycles[:1], **options)
    curves = open_curves(path)
    assert_written(curves.isel(subregion=0), cycles[0], 0.51 * count)
    assert curves.attrs["spring_constant"] == made.STIFFNESS
    assert curves.attrs["sensitivity"] == made.DEFLECTION_SENSITIVITY
    pull = roughxr.open_pull_off(path)
    assert abs(float(pull.pull_off_force[0]) - made.PULL) < 4 * float(pull.pull_off_standard_error[0]) + count


@pytest.mark.parametrize("sensor", [True, False])
def test_an_extension_that_the_trigger_stopped_is_filled_before_the_retraction(tmp_path, cycles, sensor):
    """As "1024 925": the retraction begins at half of the samples; from sample 925 on it began with filler."""
    path = made.write_nanoscope_curves(tmp_path / "curve.001", cycles[:1], dtype="<i2", stopped=325, sensor=sensor)
    curve = open_curves(path).isel(subregion=0)
    np.testing.assert_allclose(curve.force.sel(branch="retraction"), cycles[0][1][1], atol=0.51 * COUNT)
    extension = curve.force.sel(branch="loading").dropna("sample")
    np.testing.assert_allclose(extension, cycles[0][0][1][-325:], atol=0.51 * COUNT)


def test_a_volume_has_as_many_curves_as_it_states_whatever_its_image(tmp_path, cycles):
    path = made.write_nanoscope_curves(tmp_path / "volume.spm", cycles, dtype="<i2", volume=True, finer=8)
    curves = open_curves(path)
    assert curves.sizes["subregion"] == 4
    assert_written(curves.isel(subregion=3), cycles[3], 0.51 * COUNT)
    np.testing.assert_allclose(curves.subregion_x, [500, 1500, 500, 1500])


def test_a_height_sensor_takes_the_place_of_the_ramp(tmp_path, cycles):
    bent = [[(piezo + 20 * np.sin(piezo / 100), force) for piezo, force in cycles[0]]]
    path = made.write_nanoscope_curves(tmp_path / "curve.000", bent, dtype="<i2", sensor=True)
    assert_written(open_curves(path).isel(subregion=0), bent[0], 0.51 * COUNT)


@pytest.mark.parametrize("trigger", [True, False])
def test_a_nanoscope_volume_has_fractional_bits_and_places(tmp_path, cycles, trigger):
    path = tmp_path / "volume.spm"
    made.write_nanoscope_curves(path, cycles, bits=8, volume=True, trigger=trigger)
    curves = open_curves(path)
    for number, cycle in enumerate(cycles):
        assert_written(curves.isel(subregion=number), cycle, 0.51 * COUNT / 256)
    np.testing.assert_allclose(curves.subregion_x, [500, 1500, 500, 1500])
    np.testing.assert_allclose(curves.subregion_y, [500, 500, 1500, 1500])


def test_a_peak_force_capture_moves_as_a_sine(tmp_path):
    rng = np.random.default_rng(0)
    phase = np.pi * np.arange(128) / 128
    approach = -100.0 * np.cos(phase)
    retraction = 100.0 * np.cos(phase)
    pixels = [[(piezo, made.noisy_force(rng, piezo)) for piezo in (approach, retraction)] for _ in range(4)]
    path = made.write_nanoscope_curves(tmp_path / "map.pfc", pixels, dtype="<i2", capture=True)
    curves = open_curves(path)
    assert curves.sizes["subregion"] == 4 and set(curves.subregion_x.values) == {500, 1500}
    for number, cycle in enumerate(pixels):
        for branch, (piezo, force) in zip(("loading", "retraction"), cycle):
            part = curves.sel(branch=branch).isel(subregion=number).dropna("sample")
            at = np.interp(part.piezo, np.sort(piezo), force[np.argsort(piezo)])
            assert part.sizes["sample"] > 100 and float(abs(part.force - at).median()) < 0.51 * COUNT


def test_a_calibration_that_is_missing_is_asked_for(tmp_path, cycles):
    path = made.write_nanoscope_curves(tmp_path / "curve.spm", cycles[:1], lacking="Spring Constant")
    with pytest.raises(UnreadableScan, match=r"without spring_constant; give spring_constant='0.2 N/m'"):
        open_curves(path)
    calibrated = open_curves(path, spring_constant=made.STIFFNESS)
    assert_written(calibrated.isel(subregion=0), cycles[0], 0.51 * COUNT)


@pytest.mark.parametrize("lacking", ["Image Data", "Samps", "Z scale", "Ramp Size", "Data offset"])
def test_a_damaged_nanoscope_header_is_named(tmp_path, cycles, lacking):
    path = made.write_nanoscope_curves(tmp_path / "curve.spm", cycles[:1], lacking=lacking)
    with pytest.raises(UnreadableScan, match="expected"):
        open_curves(path)
    whole = made.write_nanoscope_curves(tmp_path / "whole.spm", cycles[:1]).read_bytes()
    path.write_bytes(whole[:-100])
    with pytest.raises(UnreadableScan, match="cut short"):
        open_curves(path)


@pytest.mark.parametrize("unit", ["N", "pN", "m", "nm", "V"])
def test_a_jpk_text_is_what_was_written(tmp_path, cycles, unit):
    curves = open_curves(made.write_jpk_text(tmp_path / "curve.txt", cycles[0], unit))
    assert_written(curves.isel(subregion=0), cycles[0], 1e-5)
    assert float(curves.subregion_x[0]) == 2000 and float(curves.subregion_y[0]) == 3000


@pytest.mark.parametrize("unit", ["pN", "nm", "V"])
def test_a_text_of_nanoscope_analysis_is_what_was_written(tmp_path, cycles, unit):
    curves = open_curves(made.write_nanoscope_text(tmp_path / "curve.txt", cycles[0], unit=unit))
    assert_written(curves.isel(subregion=0), cycles[0], 1e-5)
    assert curves.attrs["spring_constant"] == made.STIFFNESS
    bare = made.write_nanoscope_text(tmp_path / "bare.txt", cycles[0], unit=unit, head=False)
    if unit == "pN":
        assert_written(open_curves(bare).isel(subregion=0), cycles[0], 1e-5)
    else:
        with pytest.raises(UnreadableScan, match=r"give .*spring_constant="):
            open_curves(bare)


#: Pull-off force by hand and its error, nN: a line through the free part, and the lowest sample.
BY_HAND = {
    "jpk_text_force-save-1.txt": (1.10, 0.02),
    "polymergel.jpk-force": (11.2, 0.06),
    "brain.jpk-force": (7.3, 0.1),
    "spot3-0192.jpk-force": (0.419, 0.02),
    "flipsign.jpk-force": (0.77, 0.02),
    "SiN_FD_plot.ibw": (12.82, 0.02),
    "U3_3_p10004.ibw": (26.225, 0.015),
    "workshop_2021-10-22.csv": (0.01305, 0.0002),
    "workshop_2020-02-14.csv": (877.0, 20.0),
}


@pytest.mark.filterwarnings("ignore::roughxr.files.curves.force_curves.ImplausibleCurves")
@pytest.mark.skipif(not SHARED.is_dir(), reason="real force curves are not part of the repository")
@pytest.mark.parametrize("name", BY_HAND)
def test_real_curves_have_the_pull_that_was_read_by_hand(name):
    if name != "jpk_text_force-save-1.txt":
        pytest.importorskip("afmformats", reason="microscopes' curves need the extra roughxr[curves]")
    pull = roughxr.open_pull_off(SHARED / name).isel(subregion=0)
    force, error = BY_HAND[name]
    assert abs(float(pull.pull_off_force) - force) < error + 2 * float(pull.pull_off_standard_error)


@pytest.mark.skipif(not SHARED.is_dir(), reason="real force curves are not part of the repository")
@pytest.mark.parametrize(
    ("name", "jump", "largest"), [("nanoscope_text.txt", 0.047, 0.29), ("nanoscope_curve.spm", 0.37, 0.9)]
)
def test_a_real_jump_no_higher_than_waves_and_slips_is_a_limit(name, jump, largest):
    """By hand no pull exceeds the waves of 0.04 nN, or the drift of 0.9 nN with a slip of 0.19 nN in contact."""
    measured = roughxr.open_pull_off(SHARED / name)
    assert np.isnan(measured.pull_off_force[0]) and jump < float(measured.pull_off_at_most[0]) < largest


@pytest.mark.skipif(not SHARED.is_dir(), reason="real force curves are not part of the repository")
def test_real_nanoscope_curves_reach_the_trigger_that_their_header_states():
    """Thresholds of 1.2 V on 27.39 nm/V and 0.1332 N/m, and of 0.2061 V on 72.77 nm/V and 90 N/m."""
    for name, count, reached in (
        ("nanoscope_curve.spm", 1, 1.2 * 27.39 * 0.1332),
        ("nanoscope_force_volume.spm", 256, 1.2 * 27.39 * 0.1332),
        ("nanoscope_curve_sapphire.001", 1, 0.2061311 * 72.76923 * 90),
    ):
        loading = open_curves(SHARED / name).force.sel(branch="loading")
        assert loading.sizes["subregion"] == count
        depth = loading.max("sample") - loading.isel(sample=slice(0, 100)).median("sample")
        np.testing.assert_allclose(depth.median(), reached, rtol=0.05)


def test_a_jpk_text_of_the_data_processing_program_may_state_no_place(tmp_path):
    """Curves that were recorded at no stated place have dashes there."""
    path = made.write_jpk_text(tmp_path / "curve.txt", made.cycle(np.random.default_rng(0)))
    with_place = roughxr.open_pull_off(path)
    path.write_text(path.read_text().replace("2.0E-6", "----").replace("3.0E-6", "----"))
    without = roughxr.open_pull_off(path)
    assert "subregion_x" in with_place.coords and "subregion_x" not in without.coords
    np.testing.assert_array_equal(without.pull_off_force, with_place.pull_off_force)
