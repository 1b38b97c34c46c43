"""Threads for kernels, which let other threads run."""

from __future__ import annotations

__all__ = ["in_threads", "n_processors", "n_threads"]

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")


def n_processors() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def n_threads() -> int:
    """Threads to use: OMP_NUM_THREADS where it is set, as for BLAS, else one for each processor of the process."""
    given = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0]
    if given.isdecimal() and int(given) > 0:
        return int(given)
    return n_processors()


def in_threads(function: Callable[[Item], Answer], items: Sequence[Item]) -> list[Answer]:
    """Return the answers of a function for all items in their order; after an error no further item is begun.

    Parameters
    ----------
    function : callable
        Whose answers do not depend on each other.
    items : sequence
    """
    n = min(n_threads(), len(items))
    if n < 2:
        return [function(item) for item in items]
    pool = ThreadPoolExecutor(n)
    try:
        return list(pool.map(function, items))
    finally:
        pool.shutdown(cancel_futures=True)
