"""The bar of stages: where it is shown, and that it follows the stages."""

import io
import re
import sys
import time
from types import ModuleType, SimpleNamespace

import lbskel


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_stages_of_a_skeleton_are_shown_on_a_terminal(monkeypatch, rod):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with lbskel.StageBar("rod") as bar:
        lbskel.skeletonize(rod, on_stage=bar.show)
    assert all(f"rod: {stage}" in sys.stderr.getvalue() for stage in ("contract", "score"))
    assert sys.stderr.getvalue().endswith("\r")


def test_nothing_is_shown_elsewhere(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with lbskel.StageBar("rod") as bar:
        bar.show("contract")
    assert sys.stderr.getvalue() == ""


def test_it_is_shown_in_a_notebook(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    running = ModuleType("IPython")
    running.get_ipython = lambda: SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", running)
    with lbskel.StageBar("rod") as bar:
        bar.show("contract")
    assert "rod: contract" in sys.stderr.getvalue()


def test_it_is_not_shown_by_a_program_that_runs_notebooks(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    imported = ModuleType("IPython")
    imported.get_ipython = lambda: None
    monkeypatch.setitem(sys.modules, "IPython", imported)
    monkeypatch.setitem(sys.modules, "ipykernel", ModuleType("ipykernel"))
    with lbskel.StageBar("rod") as bar:
        bar.show("contract")
    assert sys.stderr.getvalue() == ""


def test_it_waits_and_then_shows_a_long_stage(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with lbskel.StageBar("rod", delay=1e6) as bar:
        bar.show("contract")
        assert sys.stderr.getvalue() == ""
    with lbskel.StageBar("rod", delay=1e-3) as bar:
        bar.show("contract")
        while not re.search(r"rod: contract \d\d:\d\d", sys.stderr.getvalue()):
            time.sleep(0.01)


def test_it_can_be_cleared_for_other_text(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with lbskel.StageBar("rod", is_shown=False) as bar:
        bar.clear()
    assert sys.stderr.getvalue() == ""
