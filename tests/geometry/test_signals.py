"""Signals end a process: at once in a loop that never looks at them, and without leaving files behind."""

import signal
import subprocess
import sys
import threading

import pytest

from lbskel.geometry.signals import ended_after_tidying_up, ended_at_once

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes are ended in another way")

# What each script does while it is ended; a sum of integers is a compiled loop that looks at no signal
SCRIPTS = {
    "computing": """
from lbskel.cli import skeletonize
from lbskel.cli.main import main

def never_ends(path):
    print("begun", flush=True)
    return sum(range(10**18))

skeletonize.as_shape = never_ends
main(["skeletonize", "mesh.off", "-o", "skeleton.swc", "--quiet"])
""",
    "writing": """
import time
from lbskel.io.atomic_write import write_safely

def half(path):
    path.write_text("half")
    print("begun", flush=True)
    time.sleep(1000)

write_safely("skeleton.swc", half)
""",
}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
@pytest.mark.parametrize("doing", SCRIPTS)
def test_a_signal_ends_the_process_and_leaves_no_file(tmp_path, doing, number):
    script = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n" + SCRIPTS[doing]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen([sys.executable, "-c", script], cwd=tmp_path, **pipes)
    assert process.stdout.readline() == b"begun\n"
    process.send_signal(number)
    try:
        process.communicate(timeout=60)  # which ends a test whose process would never end
    finally:
        process.kill()
    assert process.returncode == -number
    assert list(tmp_path.iterdir()) == []


def test_handlers_are_put_back():
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    with ended_at_once():
        assert signal.getsignal(signal.SIGINT) is (
            signal.SIG_DFL if before[0] is signal.default_int_handler else before[0]
        )
        with ended_after_tidying_up():
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == before


def test_handlers_of_the_caller_are_left_alone():
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with ended_at_once(), ended_after_tidying_up():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, previous)


def test_other_threads_change_nothing():
    errors = []

    def run():
        try:
            with ended_at_once(), ended_after_tidying_up():
                pass
        except ValueError as error:
            errors.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert errors == []
