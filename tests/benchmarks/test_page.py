"""The benchmark of interactive pages, in a browser that is not there."""

import os
from pathlib import Path

import pytest

from benchmarks import page


class Browser:
    """Is ready at once."""

    def get(self, address):
        self.address = address

    def execute_script(self, program):
        if "performance" in program:
            return [[name, 1000.0 * k] for k, name in enumerate(page.MARKS)]
        return 4000.0 if program == "return window.shownAt" else "yes"


def test_a_load_has_the_seconds_of_the_marks(tmp_path):
    seconds = page._load(Browser(), tmp_path / "page.html", tmp_path)
    assert list(seconds.values()) == [0.0, 1.0, 2.0, 3.0, 4.0, 0.0]


def test_the_longest_time_to_the_screen_is_told_beside_the_medians():
    loads = [{"first picture": seconds, "on the screen": 3 * seconds} for seconds in (2.0, 1.0, 5.0)]
    assert page._summary(loads) == {"first picture": 2.0, "on the screen": 6.0, "longest on the screen": 15.0}


def test_processor_seconds_are_of_the_processes_with_the_profile():
    command = Path(f"/proc/{os.getpid()}/cmdline").read_text()
    assert page._processor_seconds(command) > 0
    assert page._processor_seconds("no process has this in its command " + "x") == pytest.approx(0)
