"""Read foreign files in a separate process, so that no file can hang or crash the caller, or fill the memory.

A process serves all files of one reader in a session, and ends with its caller. Imported, this file is the client; run
as a script, it is the server. A reader is a file that imports nothing of roughxr and has a function ``read(path,
**options)`` whose result is a dictionary, with ``refused`` for a file that it refuses: what ReadingFailed states.
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

#: Time limit, s, of the smallest files; a hundred times the need of intact ones.
SECONDS = 60.0

#: Bytes of a file that allow one second more.
BYTES_PER_SECOND = 1e6

#: Limit of memory, bytes; several times the need of intact files.
MEMORY = 2**32

#: Further bytes for each byte of the file.
MEMORY_PER_BYTE = 32

#: Time between two looks after the caller, s.
_BETWEEN_LOOKS = 0.5

_LOCK = threading.Lock()
_running: dict[tuple[int, str], subprocess.Popen] = {}


class ReadingFailed(Exception):
    """A reading failed by time limit, death of the process, or an error of the library: expected, found, advice."""


def unsupported(reason: str) -> tuple[str, str, str]:
    """Return what was expected, what was found and what to do where a library cannot read a file."""
    fault = f"a damaged one, or another variant ({reason})"
    return "an intact file of a supported variant", fault, "copy it again, or save it anew in its program"


def answer(path: Path, reader: str, **options: Any) -> dict[str, Any]:
    """Return a reader's result; raise ReadingFailed if it takes too long, or its process dies."""
    limit = SECONDS + path.stat().st_size / BYTES_PER_SECOND
    with _LOCK:
        process = _process(reader)
        clock = threading.Timer(limit, process.kill)
        clock.daemon = True
        clock.start()
        try:
            pickle.dump({"path": os.path.abspath(path), **options}, process.stdin)  # type: ignore[arg-type]
            process.stdin.flush()  # type: ignore[union-attr]
            result = pickle.load(process.stdout)  # type: ignore[arg-type]
        except (EOFError, OSError, pickle.UnpicklingError):
            is_late = clock.finished.is_set()
            code = _kill(process)
            if is_late:
                expected = "an end within the time that intact files of its size need"
                fault = f"none: reading was stopped after {limit:.0f} s: damaged, or on a slow disk"
                advice = "open it in the program that wrote it, and save or export it again"
                raise ReadingFailed(expected, fault, advice) from None
            end = signal.Signals(-code).name if code < 0 else code
            raise ReadingFailed(*unsupported(f"the process that read it was ended by {end}")) from None
        except BaseException:
            _kill(process)  # interrupted: a late answer would belong to the next question
            raise
        finally:
            clock.cancel()
    if "refused" in result:
        raise ReadingFailed(*result["refused"])
    return result


def _process(reader: str) -> subprocess.Popen:
    """Return this process's reader; after a fork, not the parent's."""
    process = _running.get((os.getpid(), reader))
    if process is None or process.poll() is not None:
        if process is not None:
            _kill(process)
        process = subprocess.Popen(
            [sys.executable, "-P", __file__, reader, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        _running[os.getpid(), reader] = process
    return process


def _kill(process: subprocess.Popen) -> int:
    """End a process and return its exit code."""
    process.kill()
    for pipe in (process.stdin, process.stdout):
        with suppress(OSError):  # unsent data in its pipe are lost with the process
            pipe.close()  # type: ignore[union-attr]
    return process.wait()


def _serve(reader: ModuleType) -> None:
    """Answer requests until the input ends, with the reader's result."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not mix with the answers
    while True:
        try:
            question = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            limit = _limit_memory(question["path"])
            result = reader.read(**question)
        except MemoryError:
            result = {"refused": unsupported(f"reading it needs more than {limit / 2**30:.3g} GiB of memory")}
        except Exception as error:  # any error of a library
            reason = " ".join(str(error).split())[:300] or "no reason given"
            reason = reason if type(error) is ValueError else f"{type(error).__name__}: {reason}"
            result = {"refused": unsupported(reason)}
        pickle.dump(result, answers)
        answers.flush()


def _limit_memory(path: str) -> int:
    """Limit the memory of this process by the size of a file, where the system can, and return the limit in bytes."""
    limit = MEMORY + MEMORY_PER_BYTE * os.path.getsize(path)
    with suppress(ImportError, ValueError, OSError):
        import resource  # not on Windows

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
    return limit


def _end_with(caller: int) -> None:
    """End this process once its caller has ended, however deep in a library it is."""
    while os.getppid() == caller:
        time.sleep(_BETWEEN_LOOKS)
    os._exit(1)


def _loaded(path: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location("reader", path)
    assert spec is not None and spec.loader is not None
    reader = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reader)
    return reader


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the caller, who ends this process
    sys.path[:] = sys.argv[2:]
    if os.name == "posix":
        threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    warnings.simplefilter("ignore")  # such as the notice that it runs without MPI
    _serve(_loaded(sys.argv[1]))
