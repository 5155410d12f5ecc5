"""The start of an installed package beside that of a checkout: processor seconds, and their ratio.

    python tests/benchmarks/installed.py [--pairs 5] [--python ENVIRONMENT/bin/python]

Commands are the import of the first solver, ``roughxr info`` of a sample, and the refusal of a misspelt material. Each
runs in a process of its own, by turns from a wheel that is installed and from a copy of the checkout, with one Python
and the same dependencies. The first calls count, whose modules nobody has compiled to bytecode. Aims: ratios of at most
1.2, and a refusal within 3 s.

Without ``--python`` an environment is made and removed, in about a minute; else the package is installed in that one.
Processor seconds rise too on a busy machine, by half and more: only the ratios are compared.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]

_MAIN = "import sys; from roughxr.application.cli import main; sys.exit(main(sys.argv[1:]))"
_PAIR = ["--sphere-radius", "3 um", "--materials", "glas/silicon"]

#: Arguments of Python and the status with which it ends; ``sample`` stands for the path of a scan.
COMMANDS = {
    "import of the first solver": (
        ["-c", "from roughxr.mechanics.asperity import catalogue; from roughxr.mechanics.contact import adhesion"],
        0,
    ),
    "roughxr info": (["-c", _MAIN, "info", "sample"], 0),
    "refusal of a misspelt material": (["-c", _MAIN, "run", "sample", *_PAIR], 1),
}

#: Variables of the environment that choose a package, or leave its bytecode or kernels elsewhere.
_LEFT_OUT = ("PYTHONPATH", "PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX", "NUMBA_CACHE_DIR", "VIRTUAL_ENV")


def installed_python(folder):
    """Return the Python of a new environment with the wheel of this checkout, whose bytecode pip does not compile."""
    subprocess.run([sys.executable, "-m", "venv", folder / "environment"], check=True)
    python = folder / "environment" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "-q", "--no-compile", f"{REPOSITORY}[afm]"], check=True)
    return python


def processor_seconds(python, arguments, status, folder, path=""):
    """Return the user and system time (s) of a command in a folder, with ``path`` before the installed packages."""
    environment = {name: value for name, value in os.environ.items() if name not in _LEFT_OUT}
    environment |= {"OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg", **({"PYTHONPATH": str(path)} if path else {})}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([python, *arguments], cwd=folder, env=environment, **quiet)
    _, ended, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(ended)
    if process.returncode != status:
        raise SystemExit(f"{' '.join(map(str, arguments))}: ended with {process.returncode}, not {status}")
    return used.ru_utime + used.ru_stime


def source_of(python, folder, path=""):
    """Return the folder of the package that a Python imports."""
    environment = {**os.environ, "PYTHONPATH": str(path)}
    program = "import roughxr; print(roughxr.__file__)"
    done = subprocess.run(
        [python, "-c", program], cwd=folder, env=environment, check=True, capture_output=True, text=True
    )
    return Path(done.stdout.strip()).parent


def main():
    """Measure all commands by turns, and print a row for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=5, help="calls on either side; default: 5")
    parser.add_argument("--python", type=Path, help="Python of an environment in which the package is installed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        python = options.python.absolute() if options.python else installed_python(folder)
        checkout = folder / "checkout"
        shutil.copytree(REPOSITORY / "roughxr", checkout / "roughxr", ignore=shutil.ignore_patterns("__pycache__"))
        elsewhere = folder / "elsewhere"
        elsewhere.mkdir()
        sample = str(shutil.copy(REPOSITORY / "datasets" / "rough.nc", elsewhere))
        print(f"{'processor s':32} {'first':>13} {'all':>13}")
        print(f"{'':32} {'wheel':>6} {'copy':>6} {'wheel':>6} {'copy':>6} {'ratio':>6}")
        for name, (command_words, status) in COMMANDS.items():
            arguments = [sample if word == "sample" else word for word in command_words]
            spent = [
                [processor_seconds(python, arguments, status, elsewhere, path) for path in ("", checkout)]
                for _ in range(options.pairs)
            ]
            wheel, copy = map(sum, zip(*spent))
            print(
                f"{name:32} {spent[0][0]:6.2f} {spent[0][1]:6.2f} {wheel:6.2f} {copy:6.2f} {wheel / copy:6.2f}",
                flush=True,
            )
        assert "site-packages" in source_of(python, elsewhere).parts
        assert source_of(python, elsewhere, checkout) == checkout / "roughxr"


if __name__ == "__main__":
    main()
