"""Many meshes: the same skeletons as one by one, whatever happens to some of them, and nothing done twice."""

import csv
import importlib.util
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from lbskel import (
    FormatError,
    MissingDependency,
    UnknownChoice,
    read_skeleton,
    skeletonize,
    skeletonize_many,
    write_mesh,
)
from lbskel.pipeline import memory
from lbskel.pipeline.batch import BatchStatus
from lbskel.pipeline.batch import run as running
from lbskel.pipeline.batch.records import MANIFEST, SUMMARY, known
from lbskel.pipeline.batch.worker import WorkerProcess, _reply
from lbskel.shapes import sphere


@pytest.fixture
def meshes(tmp_path, ring, rod, tripod):
    """Three meshes that are sound and one that is cut off, in a folder of their own."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    for name, mesh in (("ring", ring), ("rod", rod), ("tripod", tripod)):
        write_mesh(folder / f"{name}.off", mesh)
    (folder / "broken.off").write_text("OFF\n4 4 0\n0 0 0\n")
    return sorted(folder.iterdir())


def outcomes(records):
    return [record.outcome for record in records]


def files(folder):
    """What is in a folder, with when it was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir() if path.name != SUMMARY}


def test_a_batch_gives_what_each_alone_gives_and_one_failure_stops_no_other(meshes, tmp_path):
    told = []
    out = tmp_path / "out"
    records = skeletonize_many(meshes, out, workers=2, on_record=lambda record, is_earlier: told.append(record.input))
    assert [record.input for record in records] == [str(path) for path in meshes]
    assert sorted(told) == [str(path) for path in meshes]
    assert outcomes(records) == [BatchStatus.REFUSED] + [BatchStatus.PASSED] * 3
    assert "broken.off" in records[0].message
    assert "truncated" in records[0].message
    for path, record in zip(meshes[1:], records[1:], strict=True):
        alone, ours = skeletonize(path), read_skeleton(out / f"{path.stem}.json")
        assert (ours.nodes.tobytes(), ours.radii.tobytes()) == (alone.nodes.tobytes(), alone.radii.tobytes())
        assert (ours.edges.tolist(), ours.node_of_vertex.tolist()) == (
            alone.edges.tolist(),
            alone.node_of_vertex.tolist(),
        )
        assert (record.nodes, record.tips, record.cycles) == (len(alone.nodes), len(alone.tips), alone.cycle_rank)
    assert sorted(files(out)) == [MANIFEST, "ring.json", "rod.json", "tripod.json"]
    with open(out / SUMMARY, newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["outcome"] for row in rows] == ["refused", "passed", "passed", "passed"]


class WorkerHere:
    """Does the jobs of a worker process in this one, which takes no time to start."""

    def __init__(self, time_limit, memory_limit):
        pass

    def run(self, job):
        reply = _reply(job)
        return {**reply, "outcome": BatchStatus(reply["outcome"]), "seconds": 0.0}

    def close(self):
        """There is no process."""

    def stop(self):
        pass


@pytest.fixture
def no_processes(monkeypatch):
    monkeypatch.setattr(running, "WorkerProcess", WorkerHere)


def test_what_was_done_is_not_done_again(no_processes, meshes, tmp_path, tripod):
    out = tmp_path / "out"
    first = skeletonize_many(meshes, out, workers=1)
    before = files(out)
    old = []
    again = skeletonize_many(meshes, out, workers=1, on_record=lambda record, is_earlier: old.append(is_earlier))
    assert (again, old, files(out)) == (first, [True] * 4, before)

    def redone(**options):
        new = []
        skeletonize_many(
            meshes,
            out,
            workers=1,
            on_record=lambda record, is_earlier: is_earlier or new.append(record.output),
            **options,
        )
        return new

    write_mesh(meshes[2], tripod, force=True)  # rod.off has another content now
    assert redone() == ["rod.json"]
    (out / "ring.json").unlink()
    assert redone() == ["ring.json"]
    with open(out / MANIFEST, "a") as manifest:
        manifest.write('{"input": "half a li')
    assert redone() == []
    assert len(redone(preset="least_squares")) == 4
    assert known(out)["rod.json"].outcome in (BatchStatus.PASSED, BatchStatus.FAILED_CHECKS)


def test_other_content_of_a_file_that_is_named_is_done_again(no_processes, tmp_path, tetrahedron):
    def redone(mesh, **options):
        new = []
        skeletonize_many(
            [mesh], tmp_path / "out", on_record=lambda _, is_earlier: new.append(not is_earlier), workers=1, **options
        )
        return new[0]

    steps, mesh = tmp_path / "steps.TOML", tmp_path / "a.ply"
    write_mesh(mesh, tetrahedron)
    assert redone(mesh, preprocess=str(steps))  # there is no such file: the mesh is refused
    steps.write_text("[[step]]\nname = 'merge_close'\n")
    assert redone(mesh, preprocess=str(steps))
    assert not redone(mesh, preprocess=str(steps))
    steps.write_text("[[step]]\nname = 'merge_close'\n\n")
    assert redone(mesh, preprocess=str(steps))

    scene, buffer = tmp_path / "b.gltf", tmp_path / "b.bin"
    scene.write_text('{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 1, "uri": "b.bin"}]}')
    assert redone(scene)
    buffer.write_bytes(b"1")
    assert redone(scene)
    assert not redone(scene)
    buffer.write_bytes(b"2")
    assert redone(scene)


def test_a_place_that_cannot_be_written_ends_one_input(no_processes, tmp_path, rod):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_mesh(tmp_path / name / "rod.ply", rod)
    paths, out = [tmp_path / "a" / "rod.ply", tmp_path / "b" / "rod.ply"], tmp_path / "out"
    out.mkdir()
    (out / "a").write_text("where a folder is needed")
    first, second = skeletonize_many(paths, out, workers=1)
    assert (first.outcome, second.outcome) == (BatchStatus.REFUSED, BatchStatus.PASSED)
    assert first.message.startswith(f"a/rod.json cannot be written: File exists: {out / 'a'}; move away")
    assert (out / SUMMARY).exists()
    (out / "a").unlink()
    assert outcomes(skeletonize_many(paths, out, workers=1)) == [BatchStatus.PASSED] * 2
    with pytest.raises(FormatError, match=r"rod\.ply: the folder cannot be made: File exists; name another"):
        skeletonize_many(paths, paths[0])


class Killed(BaseException):
    """Nothing that is done after this error counts."""


@pytest.mark.parametrize("options", [{"n_nodes": 9}, {"reports": True}])
def test_a_batch_that_is_killed_before_it_has_told_what_it_moved_does_it_again(
    options, no_processes, tmp_path, rod, monkeypatch
):
    mesh, out = tmp_path / "rod.ply", tmp_path / "out"
    write_mesh(mesh, rod)
    if "n_nodes" in options:  # replaces files of an earlier batch, which are then not those of its record
        skeletonize_many([mesh], out, workers=1)
    move = os.replace

    def kill(source, target):
        move(source, target)
        if os.path.dirname(target) == str(out):
            raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", kill)
        with pytest.raises(Killed):
            skeletonize_many([mesh], out, workers=1, **options)
    assert outcomes(skeletonize_many([mesh], out, workers=1)) == [BatchStatus.PASSED]
    assert len(read_skeleton(out / "rod.json").nodes) == len(skeletonize(mesh).nodes) != 9


def test_a_folder_that_cannot_be_written_is_named_before_any_work(tmp_path, rod, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    write_mesh(tmp_path / "rod.ply", rod)
    monkeypatch.setattr(running.tempfile, "TemporaryDirectory", refuse)
    with pytest.raises(FormatError, match=r"out: cannot be written: Permission denied; name another folder"):
        skeletonize_many([tmp_path / "rod.ply"], tmp_path / "out")


def test_no_skeleton_takes_the_place_of_a_mesh(no_processes, tmp_path, rod):
    write_mesh(tmp_path / "rod.ply", rod)
    (tmp_path / "link").symlink_to(tmp_path)
    before = (tmp_path / "rod.ply").read_bytes()
    with pytest.raises(FormatError, match=r"rod\.ply: is a mesh of the batch, not to be replaced; name another folder"):
        skeletonize_many([tmp_path / "link" / "rod.ply"], tmp_path, extension="ply", force=True)
    assert (tmp_path / "rod.ply").read_bytes() == before


def test_a_mesh_that_needs_a_package_is_tried_again(no_processes, tmp_path, rod, monkeypatch):
    def read(path):
        raise MissingDependency("laspy", "las", "a compressed cloud")

    write_mesh(tmp_path / "rod.ply", rod)
    with monkeypatch.context() as patch:
        patch.setattr("lbskel.io.as_shape", read)
        [record] = skeletonize_many([tmp_path / "rod.ply"], tmp_path / "out", workers=1)
    assert record.outcome is BatchStatus.REFUSED
    assert "pip install 'lbskel[las]'" in record.message
    assert outcomes(skeletonize_many([tmp_path / "rod.ply"], tmp_path / "out", workers=1)) == [BatchStatus.PASSED]


def test_a_time_limit_ends_one_input_and_it_is_tried_again_without(tmp_path, rod):
    write_mesh(tmp_path / "large.off", sphere(4))
    write_mesh(tmp_path / "small.off", rod)
    paths = [tmp_path / "large.off", tmp_path / "small.off"]
    out = tmp_path / "out"
    [limited] = skeletonize_many(paths[:1], out, workers=1, time_limit=0.01)  # it takes a hundred times that
    assert (limited.outcome, limited.message) == (BatchStatus.OVER_TIME, "over 0.01 s")
    assert list(files(out)) == [MANIFEST]
    assert outcomes(skeletonize_many(paths, out, workers=1)) == [BatchStatus.PASSED] * 2


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep to a limit on data")
def test_a_memory_limit_ends_one_input(tmp_path, rod):
    write_mesh(tmp_path / "large.ply", sphere(8))  # 1.3 million faces: more than the limit when they are read
    write_mesh(tmp_path / "small.off", rod)
    records = skeletonize_many(
        [tmp_path / "large.ply", tmp_path / "small.off"], tmp_path / "out", workers=1, memory_limit=400
    )
    assert outcomes(records) == [BatchStatus.OVER_MEMORY, BatchStatus.PASSED]


STOP_AT_THE_SECOND = """
import builtins, signal, sys

def opened(file, *arguments, **options):
    while str(file).endswith("1.ply") and "lbskel.pipeline.batch" in sys.orig_argv:
        signal.pause()
    return real(file, *arguments, **options)

real, builtins.open = builtins.open, opened
"""


def test_an_interrupted_batch_leaves_no_half_file_and_goes_on_from_there(tmp_path, tripod):
    """The interrupt comes while the second mesh is worked on: its process waits, for ever, where it would read it."""
    meshes, out, patch = tmp_path / "meshes", tmp_path / "out", tmp_path / "patch"
    meshes.mkdir()
    patch.mkdir()
    write_mesh(meshes / "0.ply", tripod)
    write_mesh(meshes / "1.ply", tripod)
    (patch / "sitecustomize.py").write_text(STOP_AT_THE_SECOND)
    command = [sys.executable, "-m", "lbskel", "batch", str(meshes / "*.ply"), "-o", str(out), "--workers", "1"]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(patch), os.environ.get("PYTHONPATH", "")])},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a test run in the background ignores it
    )
    while process.poll() is None and not known(out):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert (process.returncode, errors) == (130, "lbskel: interrupted; no partial file is left\n")
    assert list(known(out)) == ["0.json"]
    assert sorted(path.name for path in out.iterdir()) == ["0.json", MANIFEST]
    before = files(out)
    finished = subprocess.run(command, capture_output=True, text=True)
    assert (finished.returncode, finished.stderr) == (0, "")
    assert finished.stdout.startswith("2 inputs: 2 passed\n  1 from earlier batches")
    assert files(out)["0.json"] == before["0.json"]


needs_dask = pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs lbskel[batch]")


@needs_dask
def test_a_scheduler_that_does_not_answer_is_named(meshes, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "CONNECT_SECONDS", 0.5)
    with pytest.raises(UnknownChoice, match="no Dask scheduler answers at tcp:"):
        skeletonize_many(meshes, tmp_path / "out", dask="tcp://127.0.0.1:9")


@needs_dask
def test_a_dask_cluster_gives_the_same_and_survives_a_lost_worker(meshes, tmp_path, monkeypatch):
    from dask.distributed import LocalCluster

    with monkeypatch.context() as patch:
        patch.setattr(running, "WorkerProcess", WorkerHere)
        here = skeletonize_many(meshes, tmp_path / "here", workers=1)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        victims = [next(iter(cluster.workers.values())).pid]

        def kill_one(record, is_earlier):
            while victims:
                os.kill(victims.pop(), signal.SIGKILL)

        there = skeletonize_many(meshes, tmp_path / "there", dask=cluster.scheduler_address, on_record=kill_one)
    assert outcomes(there) == outcomes(here)
    for name in ("ring", "rod", "tripod"):
        ours, theirs = (read_skeleton(tmp_path / place / f"{name}.json") for place in ("here", "there"))
        assert ours.nodes.tobytes() == theirs.nodes.tobytes()


def test_inputs_of_one_name_keep_apart(no_processes, tmp_path, rod):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    paths = [tmp_path / "a" / "rod.off", tmp_path / "b" / "rod.off", tmp_path / "b" / "rod.ply"]
    for path in paths:
        write_mesh(path, rod)
    records = skeletonize_many(paths, tmp_path / "out", workers=1)
    assert [record.output for record in records] == ["a/rod.json", "b/rod.off.json", "b/rod.ply.json"]
    assert outcomes(records) == [BatchStatus.PASSED] * 3
    with pytest.raises(FormatError, match="named twice"):
        skeletonize_many([paths[0], paths[0]], tmp_path / "out")


@pytest.mark.parametrize(
    ("options", "file"),
    [
        ({"pictures": True}, "rod.png"),
        ({"reports": True}, "rod.report.json"),
        ({"extension": "csv"}, "rod_edges.csv"),
        ({}, SUMMARY),
        ({}, MANIFEST),
    ],
)
def test_what_is_written_beside_skeletons_replaces_nothing_unless_forced(options, file, meshes, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / file).write_text("mine")
    with pytest.raises(FormatError, match=f"out has 1 file already that no batch has made, such as {file}; "):
        skeletonize_many(meshes, out, **options)
    assert [(path.name, path.read_text()) for path in out.iterdir()] == [(file, "mine")]


def test_a_file_beside_a_record_that_no_batch_has_written_stays_unless_forced(no_processes, meshes, tmp_path, ring):
    out = tmp_path / "out"
    skeletonize_many(meshes, out, workers=1)
    skeletonize_many(meshes, out, workers=1, preset="least_squares")  # replaces what the batch wrote
    for file, options in (("rod.png", {"pictures": True}), ("broken.json", {})):
        (out / file).write_text("mine")
        with pytest.raises(FormatError, match=f"out has 1 file already that no batch has made, such as {file}"):
            skeletonize_many(meshes, out, workers=1, **options)
        (out / file).unlink()
    write_mesh(meshes[0], ring, force=True)  # of broken.off, which is refused no longer
    assert outcomes(skeletonize_many(meshes, out, workers=1))[0] is BatchStatus.PASSED


def test_a_mesh_for_which_no_memory_is_free_is_tried_again(no_processes, meshes, tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "free_megabytes", lambda: 50.0)
    [record] = skeletonize_many(meshes[2:3], tmp_path / "out", workers=1)
    assert record.outcome is BatchStatus.OVER_MEMORY
    assert "the limit is 50" in record.message
    monkeypatch.undo()
    monkeypatch.setattr(running, "WorkerProcess", WorkerHere)
    assert outcomes(skeletonize_many(meshes[2:3], tmp_path / "out", workers=1)) == [BatchStatus.PASSED]


@needs_dask
def test_workers_of_a_cluster_in_another_folder_find_the_meshes(tmp_path, rod, monkeypatch):
    from dask.distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        write_mesh(tmp_path / "rod.off", rod)
        monkeypatch.chdir(tmp_path)
        [record] = skeletonize_many(["rod.off"], "out", dask=cluster.scheduler_address)
    assert (record.input, record.outcome) == ("rod.off", BatchStatus.PASSED)


def test_files_of_the_user_stay_unless_forced(no_processes, meshes, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "rod.json").write_text("mine")
    with pytest.raises(FormatError, match=r"out has 1 file already that no batch has made, such as rod\.json"):
        skeletonize_many(meshes, out)
    assert files(out).keys() == {"rod.json"}
    skeletonize_many(meshes[2:3], out, workers=1, force=True)
    assert len(read_skeleton(out / "rod.json").tips) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"extension": "doc"}, "unknown format of skeletons 'doc'"),
        ({"workers": 0}, "workers must be positive"),
        ({"time_limit": -1}, "time_limit must be positive"),
        ({"operator": len}, "operator: .* by name"),
        ({"n_nodes": np.int64(20), "join": "none"}, "^n_nodes: a batch takes plain numbers"),
    ],
)
def test_what_makes_no_sense_is_refused_before_any_work(options, message, meshes, tmp_path):
    with pytest.raises(UnknownChoice, match=message):
        skeletonize_many(meshes, tmp_path / "out", **options)
    with pytest.raises(FormatError, match="nothing to do"):
        skeletonize_many([], tmp_path / "out")


def test_the_command_tells_failures_in_a_line_each(meshes, tmp_path, python):
    done = python("-m", "lbskel", "batch", *meshes, tmp_path / "none.off", "-o", tmp_path / "out", "--workers", "1")
    assert done.returncode == 2
    assert done.stdout.splitlines()[0] == "5 inputs: 3 passed, 2 refused"
    broken, absent = done.stderr.splitlines()
    assert broken.startswith(f"lbskel: {meshes[0]}:")
    assert absent == f"lbskel: {tmp_path / 'none.off'}: cannot be read: No such file or directory"


def test_a_batch_closes_the_pipes_of_its_processes(tmp_path, rod, monkeypatch):
    started = []

    def start(worker, real=WorkerProcess._started):
        started.append(real(worker))
        return started[-1]

    monkeypatch.setattr(WorkerProcess, "_started", start)
    write_mesh(tmp_path / "rod.ply", rod)
    skeletonize_many([tmp_path / "rod.ply"], tmp_path / "out", workers=1)
    assert [(process.stdin.closed, process.stdout.closed) for process in started] == [(True, True)]
