"""The stage on a terminal, and silence elsewhere."""

import io
import sys

import pytest

from lbskel.cli.progress import StageBar


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "is_quiet", "shows"), [(Terminal, False, True), (Terminal, True, False), (io.StringIO, False, False)]
)
def test_the_stage_is_shown_on_a_terminal_only(monkeypatch, stream, is_quiet, shows):
    monkeypatch.setattr(sys, "stderr", stream())
    with StageBar("rod.off", is_quiet) as bar:
        bar.show("contract")
    assert ("rod.off: contract" in sys.stderr.getvalue()) == shows
    assert sys.stderr.getvalue().endswith("\r") == shows  # it leaves an empty line
