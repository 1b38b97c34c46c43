"""The worker process: jobs and replies, limits, crashes, and a new process after each."""

import signal

import pytest

from lbskel import read_skeleton, write_mesh
from lbskel.io.text import convert_errors
from lbskel.pipeline.batch import BatchStatus
from lbskel.pipeline.batch.worker import WorkerProcess, _reply

PARAMETERS = {
    "tree": False,
    "scale": 1.0,
    "units": None,
    "picture": False,
    "report": False,
    "options": {},
}


@pytest.fixture
def job(tmp_path, rod):
    """A mesh file and where its skeleton goes."""
    write_mesh(tmp_path / "rod.off", rod)
    return {"input": str(tmp_path / "rod.off"), "output": str(tmp_path / "skeleton.json"), **PARAMETERS}


@pytest.fixture
def worker():
    """A worker process without limits, closed at the end."""
    process = WorkerProcess(None, None)
    yield process
    process.close()


def test_a_reply_describes_the_skeleton(worker, job):
    reply = worker.run(job)
    assert reply["outcome"] is BatchStatus.PASSED
    assert reply["verdict"] == "pass"
    assert (reply["vertices"], reply["faces"], reply["tips"], reply["cycles"]) == (152, 300, 2, 0)
    assert reply["inside_fraction"] == 1.0
    written = read_skeleton(job["output"])
    assert (len(written.nodes), written.length) == (reply["nodes"], reply["length"])


def test_a_refused_mesh_and_a_failed_score_say_why(worker, job, tmp_path):
    (tmp_path / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n")
    reply = worker.run({**job, "input": str(tmp_path / "bad.off")})
    assert reply["outcome"] is BatchStatus.REFUSED
    assert "bad.off" in reply["message"]
    failed = worker.run({**job, "options": {"time_limit": 1e-9}})
    assert failed["outcome"] is BatchStatus.FAILED_CHECKS
    assert "near_surface_fraction" in failed["message"]


@pytest.mark.parametrize(("tree", "cycle_rank"), [(False, 1), (True, 0)])
def test_cycles_in_a_format_of_trees_are_told_and_only_a_tree_loses_them(worker, job, tmp_path, ring, tree, cycle_rank):
    write_mesh(tmp_path / "rod.off", ring, force=True)
    reply = worker.run(
        {
            **job,
            "output": str(tmp_path / "ring.swc"),
            "tree": tree,
            "scale": 2.0,
            "units": "mm",
            "picture": True,
            "report": True,
        }
    )
    assert (reply["outcome"], reply["cycles"]) == (BatchStatus.PASSED, cycle_rank)
    assert reply["message"].startswith("1 cycle cut where the skeleton is thinnest")
    written = read_skeleton(tmp_path / "ring.swc")  # in the units of the mesh
    assert written.cycle_rank == cycle_rank
    assert reply["length"] == pytest.approx(2 * written.length)
    assert "multiplied by 2.0" in (tmp_path / "ring.swc").read_text()
    assert (tmp_path / "ring.png").exists()
    assert reply["message"] in (tmp_path / "ring.report.json").read_text()


@pytest.mark.parametrize("limit", [1e13, float("inf")])
def test_a_limit_beyond_those_of_the_system_is_none(job, limit):
    process = WorkerProcess(limit, limit)
    assert process.run(job)["outcome"] is BatchStatus.PASSED
    process.close()


def test_a_killed_process_is_reported_and_the_next_job_gets_another(worker, job, tmp_path):
    assert worker.run({**job, "output": str(tmp_path / "first.json")})["outcome"] is BatchStatus.PASSED
    worker._process.send_signal(signal.SIGKILL)
    assert worker.run(job)["outcome"] is BatchStatus.ENDED
    assert worker.run(job)["outcome"] is BatchStatus.PASSED


def test_a_stopped_worker_does_no_more_jobs(worker, job):
    worker.stop()
    assert worker.run(job)["outcome"] is BatchStatus.ENDED


def test_a_result_that_cannot_be_written_is_made_again(worker, job, tmp_path):
    """As when the disk was full: a reply without a key is no final one."""
    (tmp_path / "file").write_text("")
    reply = worker.run({**job, "output": str(tmp_path / "file" / "skeleton.json")})
    assert (reply["outcome"], reply["key"]) == (BatchStatus.REFUSED, "")
    assert "skeleton.json" in reply["message"]


def test_memory_that_runs_out_while_reading_is_no_refusal(monkeypatch, job):
    def read(path):
        with convert_errors(path):
            raise MemoryError

    monkeypatch.setattr("lbskel.io.as_shape", read)
    assert _reply(job)["outcome"] is BatchStatus.OVER_MEMORY
