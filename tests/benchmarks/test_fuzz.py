"""The benchmark of fuzzing: what it says of a target that was not fuzzed."""

import subprocess

import pytest

from benchmarks import fuzz


def test_without_atheris_nothing_is_said_to_be_found(monkeypatch, tmp_path):
    monkeypatch.setattr(fuzz, "find_spec", lambda name: None)
    with pytest.raises(RuntimeError, match="pip install atheris"):
        fuzz.run(True, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("code", "printed", "found"),
    [
        (0, "#7 NEW\nDone 12 runs in 1 second(s)\n", "nothing"),
        (1, "a Python\nKeyError: 'x'\n", "KeyError: 'x'"),
        (77, "#7 NEW\n === Uncaught Python exception: ===\nKeyError: 'x'\nTraceback\n", "KeyError: 'x'"),
    ],
)
def test_a_process_that_fails_has_found_something(monkeypatch, tmp_path, code, printed, found):
    pytest.importorskip("trimesh")
    monkeypatch.setattr(
        fuzz.subprocess, "run", lambda command, **options: subprocess.CompletedProcess(command, code, "", printed)
    )
    row = fuzz._row("off", 1, tmp_path)
    assert found in row["found"]
    assert (row["code"], row["inputs"]) == (code, {0: 12, 1: 0, 77: 7}[code])
