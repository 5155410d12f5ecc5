"""What several tests need."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def shared_scans():
    """Return the folder of real AFM files, which lies beside the checkout where there is one."""
    folder = Path(__file__).resolve().parents[2] / "shared" / "scans"
    if not folder.is_dir():
        pytest.skip("no folder of real AFM files beside the checkout")
    return folder


@pytest.fixture
def small_disk(tmp_path):
    """Yield a function that gives a folder's disk so many bytes, and makes it at the first call; needs root."""
    folder = tmp_path / "disk"
    folder.mkdir()

    def hold(size):
        again = "remount," if folder.is_mount() else ""
        command = ["mount", "-t", "tmpfs", "-o", f"{again}size={size}", "tmpfs", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
        return folder

    if sys.platform != "linux":
        pytest.skip("a small disk is a tmpfs, which is Linux's")
    yield hold
    if folder.is_mount():
        subprocess.run(["umount", "--lazy", str(folder)], check=True)
