"""The harness that all benchmarks use; in a file that imports little, since its children import it."""

import json
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness import (
    fitted_order,
    interleaved,
    machine,
    markdown_table,
    median_ratio,
    peak_growth,
    run_in_subprocess,
    save_json,
)


def test_orders_and_ratios():
    h = np.array([0.4, 0.2, 0.1, 0.05])
    assert abs(fitted_order(h, 3 * h**1.5) - 1.5) < 1e-12
    assert median_ratio([2.0, 9.0, 4.0], [1.0, 3.0, 4.0]) == 2.0


def test_calls_take_turns_and_get_what_was_prepared():
    order = []
    calls = {"a": lambda: order.append("a"), "b": lambda given: order.append(given)}
    seconds = interleaved(calls, 2, prepare={"b": lambda: "b"})
    assert order == ["a", "b"] * 3
    assert {name: len(taken) for name, taken in seconds.items()} == {"a": 2, "b": 2}


def _fails(what):
    raise ValueError(what)


def test_a_child_gives_its_value_its_error_or_its_end():
    assert run_in_subprocess(max, 3, 7)["value"] == 7
    assert run_in_subprocess(_fails, "so it is")["error"] == "ValueError: so it is"
    assert "ended with code" in run_in_subprocess(exit_at_once)["error"]
    assert run_in_subprocess(time.sleep, 600, timeout=0.1)["error"] == "over 0.1 s"


def _starts_another(written):
    return subprocess.Popen(["sh", "-c", f"sleep 120; echo still here > '{written}'"]).pid


@pytest.mark.skipif(not Path("/proc").exists(), reason="processes are looked up in /proc")
def test_what_a_child_has_started_ends_with_it(tmp_path):
    status = Path(f"/proc/{run_in_subprocess(_starts_another, tmp_path / 'written')['value']}/stat")
    while is_running(status):
        time.sleep(0.01)
    assert not (tmp_path / "written").exists()


def is_running(status):
    """Whether a process has not ended, by its file of status; one that nobody has waited for is in state Z."""
    try:
        return status.read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def exit_at_once():
    import os

    os._exit(3)


def peak_of_ones():
    return peak_growth(lambda: np.ones(5_000_000).sum())


def test_memory_at_its_peak():
    found = run_in_subprocess(peak_of_ones, timeout=60)["value"]  # a process that holds no freed memory
    assert found is None or 35 < found < 60  # 40 MB, and what the interpreter takes besides


def test_tables_and_json(tmp_path):
    table = markdown_table([{"a": 1, "b": 0.12345}, {"a": True, "c": None}])
    assert table.splitlines() == ["| a | b | c |", "| --- | --- | --- |", "| 1 | 0.123 | - |", "| yes | - | - |"]
    save_json(tmp_path / "x.json", {"rows": [np.float64(2.5), np.arange(2)]}, packages=["no_such_package"])
    written = json.loads((tmp_path / "x.json").read_text())
    assert written["rows"] == [2.5, [0, 1]]
    assert written["machine"]["versions"]["no_such_package"] == "not installed"
    assert machine()["versions"]["numpy"] == np.__version__
