"""A process that reads others' files and can be ended, so that none can hang or crash the caller or use up its memory.

One process serves all files of a session that one reader reads. It starts with the first, imports the reader's library
but nothing of roughxr, and ends with its caller. This file is both sides: imported, it is the client; run as a script,
it is the server.

A reader is a file with the name of its ``LIBRARY``, and ``read(path, **question)``, which returns what can be pickled.
It may say itself how much ``MEMORY`` it needs.
"""

from __future__ import annotations

import importlib
import importlib.util
import logging
import os
import pickle
import signal
import subprocess
import sys
import threading
import warnings
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

#: Seconds that reading may take, and bytes that allow one second more: a hundred times what intact files need.
SECONDS, BYTES_PER_SECOND = 60.0, 1e6

#: Bytes of memory that reading may take, and those more for each byte of the file: ten copies of compressed content.
MEMORY, MEMORY_PER_BYTE = 2**31, 64

_LOCK = threading.Lock()
_running: dict[tuple[int, str], subprocess.Popen] = {}


class ReadingFailed(Exception):
    """A reading failed, with the reason in words: time limit, death of the process, or an error of the library."""


def ask(path: Path, reader: str, **question: Any) -> dict[str, Any]:
    """Return a reader's answer about a file; raise ReadingFailed if it takes too long or too much memory, or dies."""
    limit = SECONDS + path.stat().st_size / BYTES_PER_SECOND
    with _LOCK:
        answer = _answer({"path": os.path.abspath(path), **question}, reader, limit)
    if "failed" in answer:
        raise ReadingFailed(f"damaged, or a variant not supported: {answer['failed']}")
    return answer


def _answer(request: dict[str, Any], reader: str, limit: float) -> dict[str, Any]:
    late = threading.Event()
    try:
        process = _process(reader)

        def end() -> None:
            late.set()
            process.kill()

        clock = threading.Timer(limit, end)
        clock.daemon = True
        clock.start()
        try:
            return _exchange(process, request)
        finally:
            clock.cancel()
    except (EOFError, OSError, pickle.UnpicklingError):
        raise ReadingFailed(_why(late.is_set(), limit, _end(reader))) from None
    except BaseException:
        _end(reader)  # interrupted: a late answer would be taken for the answer to the next question
        raise


def _why(late: bool, limit: float, code: int | None) -> str:
    if late:
        return (
            f"reading was stopped after {limit:.0f} s, longer than any intact file of its length needs: damaged, or on "
            "a slow disk; open it in the program that wrote it, and save or export it again"
        )
    if code is None or code >= 0:
        return f"damaged: the process that read it ended with code {code}"
    return f"damaged, or malicious: the process that read it was ended by {signal.Signals(-code).name}"


def _process(reader: str) -> subprocess.Popen:
    """Return this process's own reader, ready for questions; one inherited by a fork belongs to the other process."""
    process = _running.get((os.getpid(), reader))
    if process is None or process.poll() is not None:
        pipe, command = subprocess.PIPE, (sys.executable, "-P", __file__, reader)
        serial = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # threads take address space
        process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, env=serial)
        _running[os.getpid(), reader] = process
        missing = _exchange(process, sys.path)  # importing takes its own time, which is not the file's
        if missing:
            raise ImportError(missing)
    return process


def _exchange(process: subprocess.Popen, question: Any) -> Any:
    assert process.stdin is not None and process.stdout is not None
    pickle.dump(question, process.stdin)
    process.stdin.flush()
    return pickle.load(process.stdout)


def _end(reader: str) -> int | None:
    """End this process's reader, so that the next question starts another; return the code that it ended with."""
    process = _running.pop((os.getpid(), reader), None)
    if process is None:
        return None
    process.kill()
    code = process.wait()
    for pipe in filter(None, (process.stdin, process.stdout)):
        with suppress(OSError):  # unsent data in its pipe are lost with the process
            pipe.close()
    return code


def serve(path: str, questions: BinaryIO, answers: BinaryIO) -> None:
    """Answer the questions sent to a reader until there are no more; the first is the import path."""
    sys.path[:] = pickle.load(questions)
    warnings.simplefilter("ignore")  # a notice that it runs without MPI is of no interest here
    # readers that try a file of another format may report that on standard error, through this log
    logging.getLogger("tifffile").addHandler(logging.NullHandler())
    reader = _loaded(path)
    _send(_imported(reader.LIBRARY), answers)
    while True:
        try:
            question = pickle.load(questions)
        except EOFError:
            return
        _send(_safely(reader, question), answers)


def _limit_memory(more: int) -> None:
    """Let this process take no more than so many bytes beyond what it has, where the system keeps to that."""
    try:
        import resource

        taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except (ImportError, OSError):
        return  # Windows, macOS
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    wanted = taken + more if most == resource.RLIM_INFINITY else min(taken + more, most)
    resource.setrlimit(resource.RLIMIT_AS, (wanted, most))


def _send(answer: Any, answers: BinaryIO) -> None:
    pickle.dump(answer, answers)
    answers.flush()


def _loaded(path: str) -> ModuleType:
    """Return the module of a reader's file."""
    spec = importlib.util.spec_from_file_location("reader", path)
    assert spec is not None and spec.loader is not None
    reader = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reader)
    return reader


def _imported(library: str) -> str:
    """Import the library; return the error if that failed, else an empty text."""
    try:
        importlib.import_module(library)
    except ImportError as error:
        return str(error)
    return ""


def _safely(reader: ModuleType, question: dict[str, Any]) -> dict[str, Any]:
    try:
        _limit_memory(getattr(reader, "MEMORY", MEMORY) + MEMORY_PER_BYTE * os.stat(question["path"]).st_size)
        return reader.read(**question)
    except Exception as error:  # any error of a library
        return {"failed": _words(error)}


def _words(error: Exception) -> str:
    said = " ".join(str(error).split())[:300] or "no reason given"
    return said if type(error) is ValueError else f"{type(error).__name__}: {said}"


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the caller, who ends this process
    own = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not mix with the answers
    serve(sys.argv[1], sys.stdin.buffer, own)
