"""What several tests need."""

from pathlib import Path

import pytest


@pytest.fixture
def shared_scans():
    """Return the folder of real AFM files, which lies beside the checkout where there is one."""
    folder = Path(__file__).resolve().parents[2] / "shared" / "scans"
    if not folder.is_dir():
        pytest.skip("no folder of real AFM files beside the checkout")
    return folder
