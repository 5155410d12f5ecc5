"""A small selection of the kernels' tests passes without compilation too: they are plain Python underneath."""

import os
import subprocess
import sys
from pathlib import Path

SELECTION = ["test_ellipse.py", "test_peaks.py", "test_asperity_contact.py"]


def test_kernels_run_as_plain_python():
    folder = Path(__file__).parent
    files = [str(folder / name) for name in SELECTION]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "pytest", "-n", "0", "-p", "no:cacheprovider", *files]
    command += ["-k", "(plain or ellipse or peaks) and not test_agrees_with_labelling"]  # whose surfaces are many
    done = subprocess.run(command, env=environment, cwd=folder.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
    assert "passed" in done.stdout
