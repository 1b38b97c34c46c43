"""A batch: which inputs are still to be done, in which processes, and the record of each."""

from __future__ import annotations

__all__ = ["skeletonize_many"]

import os
import queue
import tempfile
import threading
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from inspect import signature
from pathlib import Path
from typing import Any, TypeAlias

from lbskel.errors import FormatError, MissingDependency, UnknownChoice, choose, counted
from lbskel.geometry.threads import n_processors
from lbskel.io import FORMATS, write_safely
from lbskel.io.gltf import buffer_files
from lbskel.io.skeleton_io import require_writable
from lbskel.pipeline.batch.names import files_of, skeleton_names
from lbskel.pipeline.batch.records import (
    MANIFEST,
    SUMMARY,
    BatchStatus,
    Record,
    hash_of,
    is_final,
    known,
    put_in_place,
    summary,
    unwritable,
    written,
)
from lbskel.pipeline.batch.worker import WorkerProcess
from lbskel.pipeline.stages import skeletonize

CONNECT_SECONDS = 10  # wait for a Dask scheduler at most; a guess

Job: TypeAlias = tuple[str, str, "Record | None"]  # mesh, name of the skeleton, and its record in the manifest
Answer: TypeAlias = tuple[Record, bool, str]  # a record, whether it is from an earlier batch, and where its files are

_thread_data = threading.local()  # on a worker of a cluster: the process of each of its threads


@dataclass(frozen=True)
class _Task:
    """The options of every input, which can be pickled."""

    folder: str
    unfinished: str  # folder of the files that are not in their places yet
    extension: str
    writing: Mapping[str, Any]  # what a worker does with each skeleton
    options: Mapping[str, Any]  # of skeletonize
    time_limit: float | None
    memory_limit: float | None


def skeletonize_many(
    inputs: Iterable[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    extension: str = "json",
    tree: bool = False,
    scale: float = 1.0,
    units: str | None = None,
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
    """Make the skeletons of many meshes, each in a process that can fail without the others.

    Inputs of the same content and options that the folder's ``manifest.jsonl`` lists as done or refused are skipped. At
    the end ``summary.csv`` has a row for each input.

    Parameters
    ----------
    inputs : iterable of path-like
    output : path-like
        A folder, made if it does not exist. Skeletons have the names of their meshes, relative to the common folder of
        the meshes.
    extension : str
        A format in FORMATS.
    tree : bool
        Whether to make each skeleton a tree, as :func:`lbskel.to_tree`.
    scale, units
        As for :func:`lbskel.write_skeleton`.
    pictures, reports : bool
        Whether to write a picture (``NAME.png``) and the full report (``NAME.report.json``) beside each skeleton.
    workers : int, optional
        Number of processes, each on one thread; the number of processors by default.
    dask : str, optional
        Address of a Dask scheduler, ``tcp://...``, whose workers see the same files and do the work.
    time_limit, memory_limit : float, optional
        Seconds for each input, and megabytes of data for its process, of which lbskel itself needs about 300.
    force : bool
        Whether files that no batch has written, by the folder's manifest, may be replaced.
    on_record : callable, optional
        Called with each record, and whether it is from an earlier batch.
    **options
        Of :func:`lbskel.skeletonize`; other names raise TypeError. With a value out of range each input is refused.

    Returns
    -------
    list of Record
        One for each input, in the order of the inputs.

    Raises
    ------
    FormatError
        If there is no input or one is named twice, the folder cannot be made or written, outputs exist that no batch
        has made, or one has the name of an input.
    UnknownChoice
        If the format is unknown, a number is not positive, no scheduler answers, or an option is not text or numbers.
    MissingDependency
        If Dask is asked for and not installed, or a package that the format or the pictures need.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lbskel.write_mesh(Path(folder) / "ring.off", torus(1.0, 0.2, 16, 8))
    ...     records = lbskel.skeletonize_many([Path(folder) / "ring.off"], Path(folder) / "out", workers=1)
    >>> [record.outcome.value for record in records]
    ['passed']
    """
    choose(FORMATS, extension, "format of skeletons")
    require_writable(extension, scale=scale, units=units)
    if pictures:
        from lbskel.visualization.rendering import require_matplotlib

        require_matplotlib()
    for name, number in (("workers", workers), ("time_limit", time_limit), ("memory_limit", memory_limit)):
        if number is not None and not number > 0:
            raise UnknownChoice(f"{name} must be positive, not {number}")
    signature(skeletonize).bind(None, **options)
    special = [name for name, option in options.items() if not _is_plain(option)]
    if special:
        raise UnknownChoice(
            f"{', '.join(special)}: a batch takes plain numbers, and presets and operators by name, "
            "since its work is done in other processes"
        )
    paths = [Path(path) for path in inputs]
    if not paths:
        raise FormatError("no mesh is named, so there is nothing to do")
    folder = Path(output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(f"{folder}: the folder cannot be made: {error.strerror}; name another") from None
    earlier, ours = known(folder), written(folder)
    suffixes = [".png"] * pictures + [".report.json"] * reports
    names = skeleton_names(paths, extension, suffixes)
    files = [file for name in names for file in files_of(name, suffixes)]
    meshes = {path.resolve() for path in paths}
    if replaced := [file for file in files if (folder / file).resolve() in meshes]:
        raise FormatError(f"{folder / replaced[0]}: is a mesh of the batch, not to be replaced; name another folder")
    taken = [file for file in [*files, MANIFEST, SUMMARY] if file not in ours and (folder / file).exists()]
    if taken and not force:
        raise FormatError(
            f"{folder} has {counted(len(taken), 'file')} already that no batch has made, such as {taken[0]}; give "
            "force=True (--force on the command line) to replace what is there, or name another folder"
        )
    writing = {"tree": tree, "scale": scale, "units": units, "picture": pictures, "report": reports}
    records: dict[str, Record] = {}
    jobs = [(str(path), name, earlier.get(name)) for path, name in zip(paths, names, strict=True)]
    with _unfinished(folder) as unfinished:
        task = _Task(str(folder.absolute()), unfinished, extension, writing, options, time_limit, memory_limit)
        all_done = _on_cluster(task, jobs, dask) if dask else _on_this_machine(task, jobs, workers or n_processors())
        with closing(all_done) as answers:
            for record, is_earlier, made in answers:
                records[record.output] = record if is_earlier else put_in_place(folder, record, made)
                if on_record is not None:
                    on_record(records[record.output], is_earlier)
    in_order = [records[name] for name in names]
    write_safely(folder / SUMMARY, summary(in_order), force=True)
    return in_order


def _unfinished(folder: Path) -> tempfile.TemporaryDirectory[str]:
    """Make the folder of the files that are not in their places yet; a FormatError if nothing can be written."""
    try:
        return tempfile.TemporaryDirectory(prefix=".unfinished-", dir=folder.absolute(), ignore_cleanup_errors=True)
    except OSError as error:
        raise FormatError(f"{folder}: cannot be written: {error.strerror}; name another folder") from None


def _is_plain(option: Any) -> bool:
    """Whether an option can be sent to another process as JSON: text, numbers and lists of these."""
    if isinstance(option, list | tuple):
        return all(_is_plain(each) for each in option)
    return isinstance(option, str | int | float | None)


def _do(task: _Task, worker: WorkerProcess, job: Job) -> Answer:
    """Do one job in a process, unless an earlier batch has done it."""
    mesh, name, before = job
    try:
        key = _key(Path(mesh), task)
    except OSError as error:
        return Record(mesh, name, BatchStatus.REFUSED, f"cannot be read: {error.strerror or error}"), False, ""
    folder = Path(task.folder)
    if before is not None and is_final(before, key, folder):
        return before, True, ""
    try:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        made = tempfile.mkdtemp(dir=task.unfinished)
        output = os.path.join(made, Path(name).name)
        reply = worker.run({"input": mesh, "output": output, "options": dict(task.options), **task.writing})
    except OSError as error:
        return unwritable(Record(mesh, name, BatchStatus.REFUSED), error), False, ""
    return Record(**{"input": mesh, "output": name, "key": key, **reply}), False, made


def _key(mesh: Path, task: _Task) -> str:
    """Hash of a file, of those that it or the options name, and of everything else that its skeleton depends on."""
    parameters = {"lbskel": version("lbskel"), "format": task.extension, **task.writing, **task.options}
    steps = str(task.options.get("preprocess"))
    named = [*buffer_files(mesh), *([Path(steps)] if steps.lower().endswith(".toml") else [])]
    return hash_of(parameters, [mesh, *filter(Path.is_file, named)])


def _on_this_machine(task: _Task, jobs: Sequence[Job], workers: int) -> Generator[Answer, None, None]:
    """Yield answers in the order of completion, from processes on this machine, which end with this generator."""
    processes = [WorkerProcess(task.time_limit, task.memory_limit) for _ in range(min(workers, len(jobs)))]
    idle: queue.SimpleQueue[WorkerProcess] = queue.SimpleQueue()
    for process in processes:
        idle.put(process)

    def do(job: Job) -> Answer:
        process = idle.get()
        try:
            return _do(task, process, job)
        finally:
            idle.put(process)

    executor = ThreadPoolExecutor(len(processes))
    try:
        for future in as_completed([executor.submit(do, job) for job in jobs]):
            yield future.result()
    finally:
        for process in processes:
            process.stop()
        executor.shutdown(cancel_futures=True)
        for process in processes:
            process.close()


def _on_cluster(task: _Task, jobs: Sequence[Job], address: str) -> Generator[Answer, None, None]:
    """Yield answers in the order of completion, from the workers of a Dask cluster."""
    try:
        import dask.distributed
    except ImportError:
        raise MissingDependency("dask", "batch", "a batch on a cluster") from None
    cluster: Any = dask.distributed  # its functions have no types
    try:
        client = cluster.Client(address, timeout=CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        raise UnknownChoice(f"no Dask scheduler answers at {address}: {error}") from None
    with client:
        located = [(str(Path(mesh).absolute()), name, before) for mesh, name, before in jobs]
        futures = client.map(partial(_do_on_worker, task), located, pure=False)
        job_of = {future.key: job for future, job in zip(futures, jobs, strict=True)}
        try:
            for future in cluster.as_completed(futures):
                mesh, name, _ = job_of[future.key]
                if future.status == "finished":
                    record, is_earlier, made = future.result()
                    yield replace(record, input=mesh), is_earlier, made
                else:
                    message = f"the worker was lost: {future.exception()}"
                    yield Record(mesh, name, BatchStatus.ENDED, message), False, ""
        finally:
            client.cancel(futures)


def _do_on_worker(task: _Task, job: Job) -> Answer:
    """Do one job in the process of this thread, on a worker of the cluster."""
    limits = task.time_limit, task.memory_limit
    if getattr(_thread_data, "limits", None) != limits:
        if hasattr(_thread_data, "process"):
            _thread_data.process.close()
        _thread_data.process, _thread_data.limits = WorkerProcess(*limits), limits
    return _do(task, _thread_data.process, job)
