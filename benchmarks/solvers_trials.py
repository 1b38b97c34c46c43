"""Watching solvers: errors of iterates by number and by processor seconds, up to a limit of time."""

from __future__ import annotations

__all__ = ["DENSE", "ITERATIONS", "OTHER_LOAD", "OutOfTimeError", "Watch", "how_ended", "is_iterative"]

import signal
import time

import numpy as np
from numpy.typing import NDArray

from lbskel.solvers import DIRECT_SOLVERS

DENSE = ("qr", "svd")
ITERATIONS = 2000  # a guess
OTHER_LOAD = 20.0  # wall seconds over the cap in processor seconds, after which a process is ended; a guess


def is_iterative(method: str) -> bool:
    """Whether a method reports its iterates."""
    return method not in (*DENSE, "augmented", "plain normal equations", *DIRECT_SOLVERS)


def how_ended(error: str, cap: float) -> str:
    """Say how a process ended: over the cap in processor seconds, or with that error."""
    is_over = error.endswith((f"code -{signal.SIGXCPU.value}", f"over {OTHER_LOAD * cap:g} s"))
    return f"over {cap:g} s" if is_over else error


class OutOfTimeError(Exception):
    """The cap has been reached."""


class Watch:
    """Records the errors of iterates by number and by seconds, without the seconds of recording.

    scipy's lsqr and lsmr are run anew for 1, 2, 4, ... iterations, so that each look tells the seconds of a run of its
    own, and the last is one that leaves no time for twice as many.
    """

    def __init__(self, exact: NDArray[np.float64], cap: float, *, by_restarts: bool):
        self.exact, self.size = exact, float(np.linalg.norm(exact))
        self.cap, self.by_restarts = cap, by_restarts
        self.curve: list[tuple[int, float, float]] = []
        self.number, self.looking, self.began = 0, 0.0, time.process_time()

    def error(self, X: NDArray[np.float64]) -> float:
        """Return the relative error of a solution."""
        return float(np.linalg.norm(X - self.exact)) / self.size

    def __call__(self, number: int, X: NDArray[np.float64]) -> None:
        at = time.process_time()
        spent = at - self.began - self.looking
        is_over = spent > self.cap / (2 if self.by_restarts else 1)
        self.number = number
        if self.by_restarts or is_over or number < 8 or number & (number - 1) == 0 or number % 100 == 0:
            self.curve.append((number, spent, self.error(X)))
        if is_over:
            raise OutOfTimeError
        if self.by_restarts:
            self.began = time.process_time()
        else:
            self.looking += time.process_time() - at
