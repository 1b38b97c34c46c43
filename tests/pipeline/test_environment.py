"""What results and their speed depend on: told once, in the report, by ``lbskel info --system`` and in a warning."""

import lbskel
from lbskel import _kernels
from lbskel.pipeline import environment
from lbskel.pipeline.environment import SLOW, are_kernels_compiled, system, versions
from lbskel.shapes import torus


def test_the_report_says_whether_kernels_are_compiled(monkeypatch):
    mesh = torus(1.0, 0.3)
    assert lbskel.skeletonize(mesh).report["kernels_compiled"] is are_kernels_compiled() is (not _kernels.is_slow())
    are_kernels_compiled.cache_clear()
    monkeypatch.setattr(_kernels, "is_slow", lambda: True)
    assert lbskel.skeletonize(mesh).report["kernels_compiled"] is False
    assert system()["advice"] == SLOW
    assert "pip install" in SLOW
    monkeypatch.undo()
    are_kernels_compiled.cache_clear()


def test_versions_are_those_installed(monkeypatch):
    assert versions()["lbskel"] == lbskel.__version__
    monkeypatch.setattr(environment, "OPTIONAL_PACKAGES", ("no-such-package",))
    assert system()["no-such-package"] == "not installed"
