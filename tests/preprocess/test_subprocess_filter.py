"""Filters in a subprocess: crashes, timeouts and invalid results become errors."""

import os
import signal

import pytest

from lbskel import MeshError
from lbskel.preprocess import subprocess_filter
from lbskel.preprocess.remeshing import remesh_isotropic
from lbskel.preprocess.subprocess_filter import run_in_subprocess
from lbskel.shapes import torus

TORUS = torus(1.0, 0.4, 40, 24)


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (f"import os, signal; os.kill(os.getpid(), {int(signal.SIGSEGV)})", f"signal {int(signal.SIGSEGV)}"),
        ("import time; time.sleep(60)", "took more than 1 s"),
        ("raise ValueError('odd mesh')", "ValueError: odd mesh"),
        ("import os; os._exit(3)", "code 3"),
        ("import sys; sys.stdout.write('noise')", "returned nothing"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_failed_subprocess_raises_an_error_that_names_the_cause(tmp_path, monkeypatch, script, message):
    pytest.importorskip("pymeshlab")
    path = tmp_path / "child.py"
    path.write_text(f"import sys; sys.stdin.buffer.read()\n{script}\n")
    monkeypatch.setattr(subprocess_filter, "SCRIPT", path)
    with pytest.raises(MeshError, match=message):
        run_in_subprocess("remesh_isotropic", TORUS, seconds=1.0 if "sleep" in script else 1000.0, target_length=0.1)
    if "odd" in script:
        result = remesh_isotropic(TORUS)
        assert result.mesh is TORUS
        assert "the mesh was not remeshed" in result.notes[0]
