"""One bit of an archive or a checkpoint is flipped: it is read as it was, or refused in words, never otherwise."""

import sqlite3
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from roughxr import archive
from roughxr.asperity.superposition import superpose
from roughxr.contact.elastic import direct
from roughxr.jobs import executor
from roughxr.jobs.checkpoint import Checkpoint
from roughxr.statistics import pull_off

from . import a_run
from .surfaces import glass_pair, rough, scan

#: Few tries by default, many with ``-m soak``; each begins with another seed.
FEW_AND_MANY = [25, pytest.param(250, marks=pytest.mark.soak)]


def flipped(content, rng):
    """Return the bytes of a file with one bit flipped."""
    changed = bytearray(content)
    place = int(rng.integers(len(content)))
    changed[place] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def outcome(read, whole):
    """Return what reading gave: as it was, refused in words, other numbers without a word, or any other error."""
    try:
        found = read()
    except (ValueError, OSError) as error:
        return "refused" if "damaged" in str(error) else f"traceback {error!r}"
    except Exception as error:
        return f"traceback {error!r}"
    same = list(found) == list(whole) and all(found[name].identical(ds) for name, ds in whole.items())
    return "equal" if same else "silent"


def loaded(path):
    return {name: ds.load() for name, ds in archive.load(path).items()}


@pytest.fixture(scope="module")
def groups():
    surface = glass_pair(scan(rough(32, seed=2)))
    sweep = superpose(surface, delta=np.arange(-2, 6, 1.0), subregions=(2, 2))
    return {
        "scan": surface,
        "solutions/direct": direct(surface, delta=[2.0, 6.0], subregions=(2, 2), fields=True),
        "solutions/energy": sweep,
        "statistics/energy": pull_off(sweep),
        "log": xr.Dataset({"message": ("entry", ["begun", "all computed"])}),
    }


@pytest.mark.parametrize("tries", FEW_AND_MANY)
@pytest.mark.parametrize("packed", [True, False], ids=["compressed", "bare"])
def test_no_bit_of_an_archive_changes_unnoticed(groups, tmp_path, monkeypatch, packed, tries):
    if not packed:
        monkeypatch.setattr(archive, "_COMPRESSED", {})
    path, rng = archive.save(groups, tmp_path / "run.nc"), np.random.default_rng(tries)
    whole, content = loaded(path), path.read_bytes()
    found = Counter()
    for _ in range(tries):
        path.write_bytes(flipped(content, rng))
        found[outcome(lambda: loaded(path), whole)] += 1
    print(dict(found))  # seen with pytest -rP
    assert set(found) <= {"equal", "refused"}
    assert found["refused"] > tries // 3


STAGES, RESULTS = ("direct", "energy", "map"), np.random.default_rng(0).random((20, 2))


def kept_in(path):
    """Return all that a checkpoint keeps, in the words of an archive's groups."""
    checkpoint = Checkpoint(path)
    try:
        said, items = {"identity": checkpoint.identity()}, {}
        for stage in STAGES:
            for batch in checkpoint.kept(stage):
                items[stage, batch.start, len(batch)] = checkpoint.get(stage, batch.start, RESULTS.dtype).tolist()
        checkpoint.log()
        checkpoint.put(STAGES[0], 1000, RESULTS)
    finally:
        checkpoint.close()
    return said, items


@pytest.mark.parametrize("tries", [180, pytest.param(2000, marks=pytest.mark.soak)])
def test_what_a_checkpoint_returns_is_what_was_put(tmp_path, tries):
    """Short results, so that most bits are those of keys, hashes, tables and pages."""
    path = tmp_path / "run.nc"
    made = Checkpoint(path)
    made.identify({"scan": "a surface", "delta": [1.0, 2.0]})
    for k in range(60):
        made.put(STAGES[k % 3], 7 * k, RESULTS[k % 20 :][:3])
        made.say(f"{k} kept")
    made.close()
    content, (said, items), found = made.path.read_bytes(), kept_in(path), Counter()
    rng = np.random.default_rng(tries)
    for _ in range(tries):
        for file in tmp_path.iterdir():
            file.unlink()
        made.path.write_bytes(flipped(content, rng))
        try:
            again, other = kept_in(path)
        except OSError:
            found["refused"] += 1
            continue
        right = again in (said, {"identity": None}) and all(items.get(key) == value for key, value in other.items())
        aside = any("damaged" in file.name for file in tmp_path.iterdir())
        found["silent" if not right else "set aside" if aside else "equal" if other == items else "less"] += 1
    print(dict(found))  # seen with pytest -rP
    assert not found["silent"]
    assert found["less"] and found["set aside"] and found["refused"] <= tries // 50


@pytest.mark.parametrize(
    "command", ["DROP TABLE log", "ALTER TABLE batches ADD COLUMN more", "UPDATE identity SET text = 'no'"]
)
def test_a_checkpoint_with_other_tables_or_another_identity_is_set_aside(tmp_path, command):
    path = tmp_path / "run.nc"
    made = Checkpoint(path)
    made.identify({"scan": "a surface"})
    made.close()
    sqlite3.connect(made.path, isolation_level=None).execute(command).connection.close()
    assert kept_in(path) == ({"identity": None}, {})
    assert (tmp_path / "run.nc.checkpoint.damaged-1").exists()


@pytest.mark.parametrize(
    "change", ["data = x'00'", "data = NULL", "count = 3", "first = 1", "first = 'one'", "hash = NULL"]
)
def test_a_changed_row_is_thrown_away_and_said(tmp_path, change):
    path = tmp_path / "run.nc"
    made = Checkpoint(path)
    made.put("direct", 0, RESULTS)
    made.close()
    sqlite3.connect(made.path, isolation_level=None).execute(f"UPDATE batches SET {change}").connection.close()
    again = Checkpoint(path)
    assert again.kept("direct") == []
    assert "damaged results thrown away" in again.log().message.values[-1]
    again.close()


def test_a_finished_checkpoint_is_removed_where_open_files_cannot_be(tmp_path, monkeypatch):
    """As on Windows."""
    made, unlink = Checkpoint(tmp_path / "run.nc"), Path.unlink

    def refused(path, **options):
        try:
            made._connection.execute("SELECT 1")
        except sqlite3.ProgrammingError:  # it is closed
            return unlink(path, **options)
        raise PermissionError(f"{path} is used by another process")

    monkeypatch.setattr(Path, "unlink", refused)
    made.close(remove=True)
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """Return the content of a checkpoint whose archive could not be written, and the run's groups."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(executor, "_SECONDS", 0.0)  # small batches: many rows
        patch.setattr(archive, "save", lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            a_run.run(folder / "run.nc")
    kept = folder / "run.nc.checkpoint"
    sqlite3.connect(kept).execute("PRAGMA wal_checkpoint(TRUNCATE)").connection.close()
    content = kept.read_bytes()
    a_run.run(folder / "run.nc")
    return content, without_log(folder / "run.nc")


def without_log(path):
    return {name: ds for name, ds in loaded(path).items() if name != "log"}


def resumed(path):
    a_run.run(path)
    return without_log(path)


@pytest.mark.soak
@pytest.mark.parametrize("tries", [60])
def test_a_run_goes_on_from_a_checkpoint_with_a_flipped_bit(stopped, tmp_path, tries):
    content, whole = stopped
    rng, found = np.random.default_rng(tries), Counter()
    for k in range(tries):
        path = tmp_path / str(k) / "run.nc"
        path.parent.mkdir()
        path.with_name("run.nc.checkpoint").write_bytes(flipped(content, rng))
        found[outcome(lambda path=path: resumed(path), whole)] += 1
    print(dict(found))  # seen with pytest -rP
    assert set(found) <= {"equal", "refused"}
    assert found["equal"] > tries // 2
