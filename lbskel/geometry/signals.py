"""Signals that end a process, such as Ctrl-C: at once while it computes, after tidying up while it writes.

Python runs its handlers of signals between instructions, so not before a compiled loop has ended, which may take
minutes. The default action of the system ends the process at once, whatever it does, but leaves temporary files and
child processes behind.
"""

from __future__ import annotations

__all__ = ["ended_after_tidying_up", "ended_at_once"]

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def ended_at_once() -> Iterator[None]:
    """Let Ctrl-C end the process at once within the block, as SIGTERM does by default."""
    with _handled({signal.SIGINT: signal.SIG_DFL}, instead_of=signal.default_int_handler):
        yield


@contextmanager
def ended_after_tidying_up() -> Iterator[None]:
    """Raise KeyboardInterrupt where a signal would end the process within the block; the signal ends it afterwards."""
    received: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> None:
        received.append(number)
        raise KeyboardInterrupt

    try:
        with _handled(dict.fromkeys(ENDING, interrupt), instead_of=signal.SIG_DFL):
            yield
    finally:
        if received:
            signal.raise_signal(received[0])


@contextmanager
def _handled(
    handlers: dict[signal.Signals, Any], *, instead_of: Callable[..., Any] | signal.Handlers
) -> Iterator[None]:
    """Replace those handlers of signals that are ``instead_of`` within the block; only the main thread can."""
    replaced = [each for each in handlers if signal.getsignal(each) is instead_of]
    if threading.current_thread() is not threading.main_thread():
        replaced = []
    for each in replaced:
        signal.signal(each, handlers[each])
    try:
        yield
    finally:
        for each in replaced:
            signal.signal(each, instead_of)
