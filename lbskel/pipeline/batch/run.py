"""A batch: which inputs are left to do, who does them, and what became of each."""

from __future__ import annotations

__all__ = ["skeletonize_many"]

import hashlib
import json
import os
import queue
import shutil
import tempfile
import threading
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from inspect import signature
from pathlib import Path
from typing import Any, TypeAlias

from lbskel.errors import FormatError, MissingDependency, UnknownChoice, choose
from lbskel.io import FORMATS, write_safely
from lbskel.pipeline.batch.records import SUMMARY, BatchStatus, Record, append, is_settled, known, summary
from lbskel.pipeline.batch.worker import WorkerProcess
from lbskel.pipeline.stages import skeletonize

CONNECT = 10  # seconds to wait for a scheduler
CHUNK = 1 << 20  # bytes hashed at a time

Job: TypeAlias = tuple[str, str, "Record | None"]  # mesh, name of the skeleton, and what is known of that
Answer: TypeAlias = tuple[Record, bool]  # and whether it was there before

_of_thread = threading.local()  # on a worker of a cluster: the process of each of its threads


@dataclass(frozen=True)
class _Task:
    """What is asked of every input, plain enough to be sent anywhere."""

    folder: str
    extension: str
    cut_cycles: bool
    join: bool
    pictures: bool
    reports: bool
    options: Mapping[str, Any]
    time_limit: float | None
    memory_limit: float | None


def skeletonize_many(
    inputs: Iterable[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    extension: str = "json",
    cut_cycles: bool = False,
    join: bool = False,
    pictures: bool = False,
    reports: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    force: bool = False,
    on_record: Callable[[Record, bool], None] | None = None,
    **options: Any,
) -> list[Record]:
    """The skeletons of many meshes, each made in a process that can fail by itself.

    What the folder's ``manifest.jsonl`` says was done, of the same content and with the same parameters, is not done
    again; refused inputs neither. At the end ``summary.csv`` has a row for each input.

    Parameters
    ----------
    inputs : iterable of path-like
    output : path-like
        A folder, made if it is not there. Skeletons are named after their meshes, below what these have in common.
    extension : str
        A format in FORMATS.
    cut_cycles : bool
        For a format that holds trees only (swc).
    join : bool
        Whether to join the graphs of several components to one.
    pictures, reports : bool
        Whether to write a picture (``NAME.png``) and the full report (``NAME.report.json``) beside each skeleton.
    workers : int, optional
        Processes at a time, each on one thread; as many as there are processors by default.
    dask : str, optional
        Address of a Dask scheduler whose workers see the same files, ``tcp://...``, to do the work instead.
    time_limit, memory_limit : float, optional
        Seconds that an input may take, and megabytes of data that its process may hold, of which some 300 are
        lbskel's own.
    force : bool
        Whether skeletons that no manifest tells of may be replaced.
    on_record : callable, optional
        Called with each record as it comes, and whether it was there before.
    **options
        Of :func:`lbskel.skeletonize`.

    Returns
    -------
    list of Record
        One for each input, in their order.

    Raises
    ------
    FormatError
        If there is no input, or outputs exist that are not the batch's own.
    UnknownChoice
        If a name or a number makes no sense.
    MissingDependency
        If Dask is asked for and not installed.
    """
    choose(FORMATS, extension, "format of skeletons")
    for name, number in (("workers", workers), ("time_limit", time_limit), ("memory_limit", memory_limit)):
        if number is not None and not number > 0:
            raise UnknownChoice(f"{name} must be positive, not {number}")
    signature(skeletonize).bind(None, **options)
    if not all(_is_plain(option) for option in options.values()):
        raise UnknownChoice("a batch takes presets and operators by name, since its work is done in other processes")
    paths = [Path(path) for path in inputs]
    if not paths:
        raise FormatError("no mesh is named, so there is nothing to do")
    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    before = known(folder)
    names = _names(paths, extension)
    taken = [name for name in names if name not in before and (folder / name).exists()]
    if taken and not force:
        raise FormatError(
            f"{len(taken)} files exist already in {folder} that no batch has made, such as {taken[0]}; "
            "give force=True (--force on the command line) to replace them"
        )
    task = _Task(
        str(folder.absolute()), extension, cut_cycles, join, pictures, reports, options, time_limit, memory_limit
    )
    records: dict[str, Record] = {}
    jobs = [(str(path), name, before.get(name)) for path, name in zip(paths, names, strict=True)]
    with closing(_there(task, jobs, dask) if dask else _here(task, jobs, workers or _processors())) as answers:
        for record, is_old in answers:
            records[record.output] = record
            if not is_old:
                append(folder, record)
            if on_record is not None:
                on_record(record, is_old)
    in_order = [records[name] for name in names]
    write_safely(folder / SUMMARY, summary(in_order), force=True)
    return in_order


def _is_plain(option: Any) -> bool:
    """Whether an option can be sent to another process as JSON: text, numbers and lists of these."""
    if isinstance(option, list | tuple):
        return all(_is_plain(each) for each in option)
    return isinstance(option, str | int | float | None)


def _processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _names(paths: Sequence[Path], extension: str) -> list[str]:
    """Where each skeleton goes, below the folder that all inputs have in common; a full name where two would clash."""
    whole = [path.absolute() for path in paths]
    if len(set(whole)) < len(whole):
        twice = next(path for path, count in Counter(whole).items() if count > 1)
        raise FormatError(f"{twice} is named twice; name each mesh once")
    below = Path(os.path.commonpath([path.parent for path in whole]))
    short = [path.relative_to(below).with_suffix(f".{extension}").as_posix() for path in whole]
    count = Counter(short)
    full = [f"{path.relative_to(below).as_posix()}.{extension}" for path in whole]
    return [name if count[name] == 1 else longer for name, longer in zip(short, full, strict=True)]


def _do(task: _Task, child: WorkerProcess, job: Job) -> Answer:
    """Do one job in a process of its own, unless it was done before."""
    mesh, name, before = job
    try:
        key = _key(Path(mesh), task)
    except OSError as error:
        return Record(mesh, name, BatchStatus.REFUSED, f"cannot be read: {error.strerror or error}"), False
    folder = Path(task.folder)
    if before is not None and is_settled(before, key, folder):
        return before, True
    place = (folder / name).parent
    place.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
    try:
        whole = unfinished / Path(name).name
        asked = {
            "input": mesh,
            "output": str(whole),
            "options": dict(task.options),
            "cut_cycles": task.cut_cycles,
            "join": task.join,
            "picture": task.pictures,
            "report": task.reports,
        }
        reply = child.run(asked)
        if reply["outcome"] in (BatchStatus.PASSED, BatchStatus.FAILED_CHECKS):
            for path in sorted(unfinished.iterdir()):
                os.replace(path, place / path.name)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    return Record(input=mesh, output=name, key=key, **reply), False


def _key(mesh: Path, task: _Task) -> str:
    """Hash of a file and of everything that the skeleton made of it depends on."""
    parameters = {
        "lbskel": version("lbskel"),
        "format": task.extension,
        "cut_cycles": task.cut_cycles,
        "join": task.join,
        "pictures": task.pictures,
        "reports": task.reports,
        **task.options,
    }
    digest = hashlib.sha256(json.dumps(parameters, sort_keys=True).encode())
    with open(mesh, "rb") as file:
        while chunk := file.read(CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def _here(task: _Task, jobs: Sequence[Job], workers: int) -> Generator[Answer, None, None]:
    """Answers as they come, from processes on this machine; whatever ends this ends them."""
    children = [WorkerProcess(task.time_limit, task.memory_limit) for _ in range(min(workers, len(jobs)))]
    idle: queue.SimpleQueue[WorkerProcess] = queue.SimpleQueue()
    for child in children:
        idle.put(child)

    def do(job: Job) -> Answer:
        child = idle.get()
        try:
            return _do(task, child, job)
        finally:
            idle.put(child)

    executor = ThreadPoolExecutor(len(children))
    try:
        for future in as_completed([executor.submit(do, job) for job in jobs]):
            yield future.result()
    finally:
        for child in children:
            child.stop()
        executor.shutdown(cancel_futures=True)


def _there(task: _Task, jobs: Sequence[Job], address: str) -> Generator[Answer, None, None]:
    """Answers as they come, from the workers of a Dask cluster."""
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as as_completed_there
    except ImportError:
        raise MissingDependency("dask", "batch", "a batch on a cluster") from None
    try:
        client = Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise UnknownChoice(f"no Dask scheduler answers at {address}: {error}") from None
    with client:
        futures = client.map(partial(_do_there, task), jobs, pure=False)
        job_of = {future.key: job for future, job in zip(futures, jobs, strict=True)}
        try:
            for future in as_completed_there(futures):
                if future.status == "finished":
                    yield future.result()
                else:
                    mesh, name, _ = job_of[future.key]
                    yield Record(mesh, name, BatchStatus.ENDED, f"the worker was lost: {future.exception()}"), False
        finally:
            client.cancel(futures)


def _do_there(task: _Task, job: Job) -> Answer:
    """On a worker of the cluster: do one job in the process that belongs to this thread."""
    limits = task.time_limit, task.memory_limit
    if getattr(_of_thread, "limits", None) != limits:
        _of_thread.child, _of_thread.limits = WorkerProcess(*limits), limits
    return _do(task, _of_thread.child, job)
