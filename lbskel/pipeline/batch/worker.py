"""A worker process that makes one skeleton after another, and the handle on it.

Jobs and replies are lines of JSON on its standard input and output. A limit or a crash stops only this process; the
next job starts a new one. The process ends when its standard input is closed.
"""

from __future__ import annotations

__all__ = ["WorkerProcess", "serve"]

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, TextIO

from lbskel.errors import LbskelError, MemoryLimitError, MissingDependency
from lbskel.pipeline.batch.records import BatchStatus

READY = "ready\n"
MEGABYTE = 1_000_000
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # unless the caller's environment says otherwise


class WorkerProcess:
    """A process for jobs, started when first needed and again after it has ended."""

    def __init__(self, time_limit: float | None, memory_limit: float | None):
        self._time_limit = time_limit
        self._memory_limit = memory_limit
        self._process: subprocess.Popen[str] | None = None
        self._is_stopped = False

    def run(self, job: dict[str, Any]) -> dict[str, Any]:
        """Do a job and return its reply: ``outcome``, ``seconds`` and fields of a record."""
        process = self._process = self._process or self._started()
        if self._is_stopped:
            process.kill()
        is_over_time = threading.Event()

        def stop() -> None:
            is_over_time.set()
            process.kill()

        timer = threading.Timer(min(self._time_limit, threading.TIMEOUT_MAX), stop) if self._time_limit else None
        began = time.perf_counter()
        try:
            if timer is not None:
                timer.start()
            reply = self._exchange(process, job)
        finally:
            if timer is not None:
                timer.cancel()
        seconds = time.perf_counter() - began
        if reply is None:
            code = process.wait()
            self.close()
            if is_over_time.is_set():
                return {"outcome": BatchStatus.OVER_TIME, "message": f"over {self._time_limit:g} s", "seconds": seconds}
            message = f"the process ended with code {code}"
            if self._memory_limit and -code in (
                signal.SIGABRT,
                signal.SIGSEGV,
            ):  # how compiled code ends without memory
                return {"outcome": BatchStatus.OVER_MEMORY, "message": f"out of memory: {message}", "seconds": seconds}
            return {"outcome": BatchStatus.ENDED, "message": message, "seconds": seconds}
        reply["outcome"] = BatchStatus(reply["outcome"])
        if reply["outcome"] is BatchStatus.OVER_MEMORY:  # how much it still holds is unknown
            self.close()
        return {**reply, "seconds": seconds}

    def stop(self) -> None:
        """End the process from any thread, whatever it does; later jobs end at once."""
        self._is_stopped = True
        if process := self._process:
            process.kill()

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with contextlib.suppress(BrokenPipeError):  # of data that it did not read
                        pipe.close()

    def _started(self) -> subprocess.Popen[str]:
        """Start a process that has imported lbskel, so that no job has to wait for that."""
        process = subprocess.Popen(
            [sys.executable, "-m", "lbskel.pipeline.batch", str(self._memory_limit or 0)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
            env={**ONE_THREAD, **os.environ},
            start_new_session=True,  # an interrupt at the terminal reaches the caller only
        )
        assert process.stdout is not None
        if process.stdout.readline() != READY:
            raise LbskelError(
                f"no process could be started; run '{sys.executable} -m lbskel.pipeline.batch 0' to see why"
            )
        return process

    @staticmethod
    def _exchange(process: subprocess.Popen[str], job: dict[str, Any]) -> dict[str, Any] | None:
        """Send a job and wait for its reply; None if the process has ended."""
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps(job) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except (OSError, ValueError):  # ValueError: closed by another thread
            return None
        return json.loads(line) if line.endswith("\n") else None


def serve(jobs: TextIO, replies: TextIO, memory_limit: float) -> None:
    """Do jobs in the worker process until its input ends."""
    from lbskel.pipeline import stages  # noqa: F401  before the limit is set, and before the first job

    if 0 < memory_limit * MEGABYTE < sys.maxsize:
        import resource

        n_bytes = int(memory_limit * MEGABYTE)
        resource.setrlimit(resource.RLIMIT_DATA, (n_bytes, n_bytes))
    replies.write(READY)
    replies.flush()
    for line in jobs:
        replies.write(json.dumps(_reply(json.loads(line))) + "\n")
        replies.flush()


class NotWritten(Exception):
    """A result that could not be written, as on a full disk."""


def _write(job: dict[str, Any], mesh: Any, skeleton: Any) -> None:
    """Write the files of a skeleton; NotWritten where that fails."""
    from lbskel.io import write_safely, write_skeleton

    output = Path(job["output"])
    try:
        write_skeleton(output, skeleton, scale=job["scale"], units=job["units"])
        if job["report"]:
            text = json.dumps({"mesh": job["input"], **skeleton.report}, indent=1) + "\n"
            write_safely(output.with_suffix(".report.json"), text)
        if job["picture"]:
            from lbskel.visualization import picture

            picture(mesh, skeleton, output.with_suffix(".png"))
    except MissingDependency:
        raise
    except LbskelError as error:
        raise NotWritten(" ".join(str(error).splitlines())) from error


def _reply(job: dict[str, Any]) -> dict[str, Any]:
    """Make one skeleton and describe it."""
    from lbskel.io import as_shape
    from lbskel.pipeline.cycles import cut_cycles
    from lbskel.pipeline.stages import skeletonize

    try:
        mesh = as_shape(job["input"])
        skeleton = skeletonize(mesh, **job["options"])
        output = Path(job["output"])
        skeleton, cut_note = cut_cycles(skeleton, tree=job["tree"], extension=output.suffix.removeprefix("."))
        _write(job, mesh, skeleton)
    except MemoryLimitError as error:
        return {"outcome": BatchStatus.OVER_MEMORY, "message": str(error)}
    except (MissingDependency, NotWritten) as error:
        # without a key, so that the input is tried again after an installation, or when there is space
        return {"outcome": BatchStatus.REFUSED, "message": str(error), "key": ""}
    except LbskelError as error:
        if isinstance(error.__context__, MemoryError):
            return {"outcome": BatchStatus.OVER_MEMORY, "message": "out of memory"}
        return {"outcome": BatchStatus.REFUSED, "message": " ".join(str(error).splitlines())}
    except MemoryError:
        return {"outcome": BatchStatus.OVER_MEMORY, "message": "out of memory"}
    except Exception as error:
        return {"outcome": BatchStatus.ENDED, "message": f"internal error: {type(error).__name__}: {error}"}
    report = skeleton.report
    failed = {name for name, verdict in report["score"]["verdicts"].items() if verdict == "fail"}
    return {
        "outcome": BatchStatus.PASSED if report["passed"] else BatchStatus.FAILED_CHECKS,
        "message": "; ".join(filter(None, [", ".join(sorted(failed)), cut_note])),
        "verdict": report["score"]["verdict"],
        "vertices": report["input"]["vertices"],
        "faces": report["input"]["faces"],
        "nodes": len(skeleton.nodes),
        "tips": len(skeleton.tips),
        "junctions": len(skeleton.junctions),
        "cycles": skeleton.cycle_rank,
        "length": skeleton.length * job["scale"],
        "inside_fraction": report["score"]["measures"]["inside_fraction"],
    }
