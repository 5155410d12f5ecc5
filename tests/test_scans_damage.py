"""A damaged file is refused with its name and the reason, or read right; never a hang, never a wrong size."""

import os
import pickle
import re
import signal
import struct
import subprocess
import sys
import time
import tracemalloc
import warnings
import zipfile
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import archive
from roughxr.application import cli
from roughxr.files.images import reader_process, stated_sizes, vendor_reader
from roughxr.mechanics.scans import plausibility
from roughxr.mechanics.scans.plausibility import doubts
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.scans import ImplausibleScan, UnreadableScan, describe, open_scan, to_netcdf

from .afm_files import WRITERS, given, image_size, picture, write_asd, write_binary_sdf, write_gwy, write_sxm
from .surfaces import rough, scan

SECONDS = 5
FLIPS = 16

#: How many of the first bytes are header, where a format has heights after them.
HEADER = {"gsf": 152, "gwy": 235, "text": 90, "npy": 128, "surfacetopography": 384, "bruker": 1200, "igor": 384}


@contextmanager
def time_limit(seconds):
    """Raise TimeoutError after some seconds, where the system has an alarm."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def ring(*_):
        raise TimeoutError(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def damaged(content, header, rng):
    """Yield (what was done, bytes): cuts, and flipped bits in the header."""
    yield "empty", b""
    for part in range(1, 6):
        yield f"cut at {part}/6", content[: len(content) * part // 6]
    for fewer in (1, 2, 9, 100):
        yield f"{fewer} bytes fewer", content[:-fewer]
    for _ in range(FLIPS):
        place = int(rng.integers(header))
        bit = int(rng.integers(8))
        yield f"bit {bit} of byte {place}", content[:place] + bytes([content[place] ^ 1 << bit]) + content[place + 1 :]


def assert_refused_or_right(path, whole, options):
    """Open a damaged file: refused, doubted by a warning, or of the right size.

    Heights can be other ones: most formats have no checksum, and a flipped sensitivity is as good as any.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            with time_limit(SECONDS):
                scan = open_scan(path, **options).load()
        except UnreadableScan as refusal:
            assert path.name in str(refusal) and len(str(refusal)) > len(str(path)) + 20
            return "refused"
    scan.close()
    changed = not (same_heights(scan, whole) and same_axes(scan, whole))
    if changed and any(issubclass(warning.category, UserWarning) for warning in caught):
        return "doubted"
    assert same_axes(scan, whole)
    return "right" if same_heights(scan, whole) else "other heights"


def same_heights(scan, whole):
    if dict(scan.sizes) != dict(whole.sizes):
        return False
    return np.allclose(scan["height"], whole["height"], rtol=1e-9, atol=1e-9, equal_nan=True)


def same_axes(scan, whole):
    return dict(scan.sizes) == dict(whole.sizes) and all(np.allclose(scan[a], whole[a], rtol=1e-6) for a in "xy")


@pytest.fixture(scope="module")
def vendors_reader(tmp_path_factory):
    """Start the process that reads vendors' files: what follows is the files' own time."""
    rows = picture()
    open_scan(WRITERS["bruker"](tmp_path_factory.mktemp("sound"), rows, image_size(rows))).close()


@pytest.mark.usefixtures("vendors_reader")
@pytest.mark.parametrize("name", WRITERS)
def test_damage(name, tmp_path):
    rows = picture()
    path = WRITERS[name](tmp_path, rows, image_size(rows))
    options = given(name, image_size(rows))
    whole = open_scan(path, **options).load()
    whole.close()
    written = path.read_bytes()
    outcomes = []
    for number, (what, content) in enumerate(
        damaged(written, HEADER.get(name, len(written)), np.random.default_rng(5))
    ):
        other = tmp_path / f"damaged-{number}{path.suffix}"
        other.write_bytes(content)
        try:
            outcomes.append(assert_refused_or_right(other, whole, options))
            if what.startswith(("cut", "empty")) or "bytes" in what.split()[1:2]:
                assert outcomes[-1] != "other heights"
        except BaseException as error:
            error.add_note(f"{name}: {what}")
            raise
    assert outcomes.count("refused") >= 6  # the empty file and the five cuts at least, whatever else


def test_real_files_cut_anywhere(shared_scans, tmp_path):
    for path in sorted(shared_scans.iterdir()):
        if path.is_dir() or path.suffix in (".md", ".zip") or path.name.startswith("NEGATIVE"):
            continue
        with warnings.catch_warnings(action="ignore"):
            whole = open_scan(path)
        content = path.read_bytes()
        for part in range(1, 11):
            other = tmp_path / f"{part}-{path.name}"
            other.write_bytes(content[: len(content) * part // 11])
            outcome = assert_refused_or_right(other, whole, {})
            assert outcome in ("refused", "right"), (path.name, part)


def test_garbled_pictures_and_lines_are_doubted_and_real_ones_are_not():
    ordinary = rough(64)
    rng = np.random.default_rng(0)
    spiked = ordinary.copy()
    spiked[5, 5] = 400.0
    lines = ordinary + 200.0 * (np.arange(64) % 2)  # every second line, along x, has an offset
    garbled = rng.permutation(ordinary.ravel()).reshape(64, 64)
    for height, message in (
        (garbled, "heights are uncorrelated"),
        (lines, "lines along x are uncorrelated"),
        (lines.T, "lines along y are uncorrelated"),
    ):
        assert any(message in str(doubt) for doubt in doubts(scan(height)))
    for height in (ordinary, spiked):
        assert not any("uncorrelated" in str(doubt) for doubt in doubts(scan(height)))


def pages(path, count):
    """Write a TIFF of very many empty pages, each of which its reader looks at."""
    tag = struct.pack("<HHII", 50432, 4, 1, 0x0E031301)
    length = 18
    body = b"".join(
        struct.pack("<H", 1) + tag + struct.pack("<I", 8 + length * (k + 1) if k < count - 1 else 0)
        for k in range(count)
    )
    path.write_bytes(b"II*\0" + struct.pack("<I", 8) + body)
    return path


def test_a_file_that_keeps_its_reader_busy_is_given_up(tmp_path, monkeypatch):
    rows = picture()
    sound = WRITERS["bruker"](tmp_path, rows, image_size(rows))
    whole = open_scan(sound)  # the process is there: what follows is the file's own time
    process = reader_process._running[os.getpid(), vendor_reader.__file__]
    monkeypatch.setattr(reader_process, "SECONDS", 0.5)
    start = time.monotonic()
    with pytest.raises(UnreadableScan, match=r"pages.tiff: .*reading was stopped after 1 s.*save or export it again"):
        open_scan(pages(tmp_path / "pages.tiff", 20_000))
    assert time.monotonic() - start < 10
    assert process.wait(5) != 0
    monkeypatch.undo()
    xr.testing.assert_identical(open_scan(sound), whole)
    assert reader_process._running[os.getpid(), vendor_reader.__file__] is not process


def test_a_reader_that_dies_by_a_signal_is_a_refusal(tmp_path):
    dying = tmp_path / "dying.py"
    dying.write_text("import os\ndef read(path):\n    os.abort()\n")
    with pytest.raises(reader_process.ReadingFailed, match="ended by SIGABRT"):
        reader_process.answer(dying, str(dying))


READER = """import time
def read(path, action):
    if action == "fill the memory":
        return {"size": len(bytes(2**36))}
    while action == "never end":
        time.sleep(0.01)
    return {"action": action}
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="this system does not limit the memory of a process")
def test_a_reader_has_a_limit_of_memory(tmp_path):
    reader = tmp_path / "reader.py"
    reader.write_text(READER)
    with pytest.raises(reader_process.ReadingFailed, match=r"reading it needs more than 4 GiB of memory"):
        reader_process.answer(reader, str(reader), action="fill the memory")
    assert reader_process.answer(reader, str(reader), action="read") == {"action": "read"}  # by the same process


@pytest.mark.skipif(os.name != "posix", reason="a process of this system keeps the number of its parent")
def test_a_reader_ends_with_its_caller(tmp_path):
    """A caller that is killed while its reader is busy."""
    reader = tmp_path / "reader.py"
    reader.write_text(READER)
    code = (
        "import pathlib, threading, time\n"
        "from roughxr.files.images import reader_process as rp\n"
        f"path = pathlib.Path({str(reader)!r})\n"
        "asked = {'target': rp.answer, 'args': (path, str(path)), 'kwargs': {'action': 'never end'}}\n"
        "threading.Thread(daemon=True, **asked).start()\n"
        "while not rp._running: time.sleep(0.01)\n"
        "print(next(iter(rp._running.values())).pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as caller:
        number = int(caller.stdout.readline())
        time.sleep(1)  # until the reader is busy
        caller.kill()
    end = time.monotonic() + 20
    while is_running(number) and time.monotonic() < end:
        time.sleep(0.1)
    assert not is_running(number)


def is_running(number):
    """Return whether a process runs, and is no zombie that nobody asked for its status."""
    status = Path(f"/proc/{number}/stat")
    if status.exists():
        return status.read_text().rpartition(")")[2].split()[0] != "Z"
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return not Path("/proc").exists()


@pytest.mark.parametrize(
    "name",
    ["nid", "bcr", "mdt", "igor", "sxm", "asd", "gsf", "gwy", "npy", "bruker", "mi", "sur", "sdf", "wsxm", "park"],
)
def test_bytes_inserted_into_a_file_are_named(name, tmp_path):
    """Four bytes anywhere in the data would shift most heights."""
    rows = picture()
    path = {**WRITERS, "sdf": write_binary_sdf}[name](tmp_path, rows, image_size(rows))
    whole = path.read_bytes()
    options = {"size": image_size(rows), "height_units": "nm"} if name == "npy" else {}
    open_scan(path, **options)
    for place in (len(whole) // 2, len(whole) - 30, len(whole)):
        path.write_bytes(whole[:place] + b"\1\2\3\4" + whole[place:])
        with pytest.raises(UnreadableScan, match="damaged"):
            open_scan(path, **options)


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("asylum_20um_256.ibw", "ibw"),
        ("asylum_2um_256_film.ibw", "ibw"),
        ("nanosurf_20um_256.nid", "ezd"),
        ("bruker_10um_256_tilted.di", "di"),
        ("bruker_10um_512_rough.di", "di"),
        ("surfaces/di-5.di", "di"),
        ("surfaces/veeco.001", "di"),
        ("agilent_20um.mi", "mi"),
        ("digitalsurf_optical_masked.sur", "sur"),
        ("park_1um_512_grains.tiff", "ps"),
        ("surfaces/stp-1.stp", "wsxm"),
    ],
)
def test_files_of_instruments_are_as_long_as_they_state(name, code, shared_scans, tmp_path):
    path = shared_scans / name
    if not path.exists():
        pytest.skip(f"{name} is not beside these files")
    assert stated_sizes.refuse_longer(path, code) is None
    content = path.read_bytes()
    for place in (len(content) // 3, len(content) - 2**14):
        longer = tmp_path / path.name
        longer.write_bytes(content[:place] + b"\1\2\3\4" + content[place:])
        with pytest.raises(UnreadableScan, match="as its header states, found"):
            open_scan(longer)


def test_text_or_a_further_object_after_the_heights_is_no_damage(tmp_path):
    """ISO 25178-71 ends with free text, and a Digital Surf file may hold several objects."""
    rows = picture()
    for write, addition in (
        (write_binary_sdf, b"measured by hand\r\n\x1a"),
        (WRITERS["sur"], b"DIGITAL SURF" + bytes(600)),
    ):
        path = write(tmp_path, rows, image_size(rows))
        scan_alone = open_scan(path)
        path.write_bytes(path.read_bytes() + addition)
        np.testing.assert_array_equal(open_scan(path)["height"], scan_alone["height"])


def test_doubts_about_a_scan_take_little_more_memory_than_its_heights():
    surface = scan(rough(1024))
    tracemalloc.start()
    doubts(surface)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 3 * surface["height"].nbytes


def test_control_characters_of_a_file_never_reach_the_terminal(tmp_path, capsys):
    path = tmp_path / "scan.nc"
    nasty = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202e"
    surface = scan(rough(32), title=nasty, source=nasty, channel=nasty, source_file=nasty, remark=nasty)
    to_netcdf(surface.assign_attrs({"channel": nasty}), path)
    other = tmp_path / "other.nc"
    xr.Dataset({"height\u202e": (("x", "y"), np.ones((3, 3)), {"units": nasty})}).to_netcdf(other)
    assert cli.main(["info", str(path)]) == 0
    assert cli.main(["info", str(other)]) == 1
    printed = "".join(capsys.readouterr())
    assert "\\x1b" in printed and not set("\x1b\x07\x9b\u202e") & set(printed)
    with pytest.raises(UnreadableScan) as refusal:
        open_scan(other)
    assert not set("\x1b\x07\x9b\u202e") & set(str(refusal.value))


@pytest.mark.parametrize("kind", ["external", "link", "virtual"])
def test_hdf5_that_takes_data_from_other_files_is_refused(kind, tmp_path):
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["h"] = np.ones((16, 16))
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        if kind == "external":
            file.create_dataset("Height", shape=(16, 16), dtype="u1", external=[(str(secret), 0, 256)])
        elif kind == "link":
            file["Height"] = h5py.ExternalLink(str(secret), "h")
        else:
            layout = h5py.VirtualLayout((16, 16), "f8")
            layout[:] = h5py.VirtualSource(str(secret), "h", (16, 16))
            file.create_virtual_dataset("Height", layout)
    with pytest.raises(UnreadableScan, match="found 'Height' in another file"):
        open_scan(path, size=(100, 100), height_units="nm")
    with pytest.raises(ValueError, match="found 'Height' in another file"):
        archive.load(path)


def test_deeply_nested_groups_are_refused(tmp_path):
    path = tmp_path / "deep.nc"
    with h5py.File(path, "w") as file:
        file.create_group("/".join("g" * 60))
    with pytest.raises(UnreadableScan, match="groups nested at most 50 deep"):
        open_scan(path)


def test_a_refusal_of_a_file_has_fields(tmp_path):
    path = write_sxm(tmp_path, picture(), image_size(picture()))
    path.write_bytes(path.read_bytes()[:-4])
    size = 4 * 4 * picture().size  # bytes of both directions of two channels
    with pytest.raises(UnreadableScan) as refusal:
        open_scan(path)
    error = pickle.loads(pickle.dumps(refusal.value))
    assert error.what == error.path == path and error.where == ("Nanonis (.sxm)",)
    assert error.expected.startswith(f"{size:,} bytes") and error.found == f"{size - 4:,}: cut short"
    assert error.advice.startswith("copy the whole file again") and str(error) == str(refusal.value)


def test_frames_without_length_are_refused(tmp_path):
    path = write_asd(tmp_path, picture(), image_size(picture()))
    content = bytearray(path.read_bytes())
    content[8:12] = struct.pack("<i", -2 * picture().size)  # bytes before the heights of each frame
    path.write_bytes(content)
    with pytest.raises(UnreadableScan, match="damaged"):
        open_scan(path)


def test_long_header_lines_are_refused_at_once(tmp_path):
    path = tmp_path / "long.txt"
    path.write_text("# k:" + " " * 100_000 + "z" + " " * 100_000 + "q\n1 2\n3 4\n")
    with pytest.raises(UnreadableScan):
        open_scan(path, size=(10, 10), height_units="nm")


def test_a_container_without_images_is_refused(tmp_path):
    from gwyfile.objects import GwyContainer

    path = tmp_path / "empty.gwy"
    GwyContainer().tofile(str(path))
    for verb in (describe, open_scan, roughxr.open_pull_off):
        with pytest.raises(UnreadableScan, match=r"Gwyddion \(\.gwy\): expected an AFM image, found none"):
            verb(path)


def test_labels_longer_than_their_igor_wave_are_refused_at_once(tmp_path):
    path = WRITERS["igor"](tmp_path, rough(16), (160.0, 160.0))
    wave = bytearray(path.read_bytes())
    struct.pack_into("<4i", wave, 36, *[2**31 - 1] * 4)
    wave[2:4] = bytes(2)
    total = int(np.frombuffer(wave[:384], "<i2").sum(dtype=np.int64))
    struct.pack_into("<H", wave, 2, -total & 0xFFFF)
    path.write_bytes(wave)
    with time_limit(SECONDS), pytest.raises(UnreadableScan, match="truncated"):
        open_scan(path)


def test_a_zip_file_of_a_later_version_is_refused_with_its_name(tmp_path):
    path = tmp_path / "later.zip"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.txt", "0 0")
    content = bytearray(path.read_bytes())
    start = content.find(b"PK\x01\x02")
    content[start + 6 : start + 8] = struct.pack("<H", 6300)
    path.write_bytes(content)
    with pytest.raises(UnreadableScan, match=r"later\.zip"):
        open_scan(path)


@pytest.mark.skipif(sys.platform != "linux", reason="names that are no UTF-8 are refused by the file system")
def test_a_file_name_that_is_no_utf8_is_read_and_stored(tmp_path):
    path = write_gwy(tmp_path, picture(), image_size(picture()))
    latin = path.rename(os.fsdecode(os.fsencode(tmp_path / "5") + b"\xb5m.gwy"))
    opened = open_scan(latin)
    assert opened.attrs["source_file"] == r"5\udcb5m.gwy"
    to_netcdf(opened, tmp_path / "copy.nc")
    assert describe(latin).attrs["source_file"] == r"5\udcb5m.gwy"
    copy = (tmp_path / "copy.nc").rename(latin.with_suffix(".nc"))
    for call in (open_scan, lambda path: to_netcdf(opened, path)):
        with pytest.raises(ValueError, match="expected a path in UTF-8"):
            call(copy)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_scar_along_one_line_is_doubted_and_a_particle_is_not(axis):
    height = scan(rough(64, seed=2)).transpose("x", "y")
    assert not any("a scan fault" in str(doubt) for doubt in doubts(height))
    line = {axis: 20}
    scarred = height.copy(deep=True)
    scarred["height"][line] += 20 * float(height.height.std())
    assert any(
        f"line 20, counted along {axis}" in str(doubt) and "a scan fault" in str(doubt) for doubt in doubts(scarred)
    )
    dusty = height.copy(deep=True)
    dusty["height"][{"x": 20, "y": 30}] += 50 * float(height.height.std())
    assert not any("a scan fault" in str(doubt) for doubt in doubts(dusty))


@pytest.mark.parametrize("mark", [-9999.0, -32768.0, 9999.0, 1e38, -3.4e38])
@pytest.mark.parametrize("form", ["text", "netcdf"])
def test_a_mark_for_missing_pixels_is_no_height(tmp_path, mark, form):
    heights = np.random.default_rng(1).normal(0.0, 3.0, (48, 40))
    heights[7, 9] = mark
    path = tmp_path / "scan"
    if form == "text":
        np.savetxt(path, heights, header="Width: 320 nm\nHeight: 384 nm\nValue units: nm")
    else:
        axes = {axis: (axis, 8.0 * np.arange(n), {"units": "nm"}) for axis, n in (("x", 48), ("y", 40))}
        xr.Dataset({"height": (("x", "y"), heights, {"units": "nm"})}, axes).to_netcdf(path)
    with pytest.raises(UnreadableScan, match=r"at 1 of 1920 pixels.*replace it by nan.*--fill linear"):
        open_scan(path).load()


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_a_value_far_off_on_a_wide_scan_is_a_doubt(tmp_path):
    heights = np.random.default_rng(1).normal(0.0, 3.0, (40, 40))
    heights[7, 9] = -9999.0
    path = tmp_path / "scan.txt"
    np.savetxt(path, heights, header="Width: 20 um\nHeight: 20 um\nValue units: nm")
    assert "-9999 nm at 1 of 1600 pixels" in describe(path).doubts
    with pytest.warns(ImplausibleScan, match="if it marks missing pixels"):
        open_scan(path)


def recorded(change):
    """Return a surface of 128 x 128 pixels as a recorder with a fault would give it."""
    whole = self_affine((128, 128), 10, rms=5, hurst=0.8, rolloff=400, seed=1)
    return xr.Dataset({"height": (("x", "y"), change(whole.height.values), {"units": "nm"})}, whole[["x", "y"]].coords)


def overflowing(height):
    counts = np.round(height * 2000).astype(np.int64) + 8000
    return ((counts + 2**15) % 2**16 - 2**15) / 2000.0


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda height: np.minimum(height, 8.0), "have exactly the highest value"),
        (lambda height: np.maximum(height, -9.0), "have exactly the lowest value"),
        (lambda height: np.round(np.maximum(height, -9.0), 1), "have exactly the lowest value"),
        (overflowing, "values wrapped around"),
        (lambda height: height + 5.0 * (np.arange(128) > 59)[:, None], "jump from line 59 to line 60 along x"),
    ],
)
def test_faults_of_recording_are_doubted_and_said_by_level(change, message):
    scan = recorded(change)
    assert any(re.search(message, str(doubt)) for doubt in plausibility.doubts(scan))
    with pytest.warns(plausibility.ImplausibleScan, match=message):
        roughxr.level(scan)


@pytest.mark.parametrize(
    "change",
    [
        lambda height: height,
        lambda height: np.round(height),  # a coarse converter
        lambda height: 0.01 * height + 20.0 * (np.add.outer(np.arange(128), np.arange(128)) // 23 % 2),  # terraces
    ],
)
def test_sound_recordings_are_not_doubted(change):
    assert plausibility.faults(recorded(change).height.values) == []
