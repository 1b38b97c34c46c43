"""The current stage and the seconds since the start, on a terminal or in a notebook, by tqdm."""

from __future__ import annotations

__all__ = ["StageBar"]

import sys
import threading
from typing import Any

TICK = 0.5  # seconds between two refreshes; a choice of style


class StageBar:
    """A bar with the current stage and the seconds since the start, while it is open.

    It is shown on a terminal and in a notebook, and nowhere else, and is gone when it is closed.

    Parameters
    ----------
    name : str
        What is done; shown in front of the stage.
    is_shown : bool, optional
        Whether it is shown; by default on a terminal (stderr) and in a notebook.
    delay : float
        Seconds before the bar is shown; work that ends earlier shows nothing.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> with lbskel.StageBar("a ring") as bar:
    ...     skeleton = lbskel.skeletonize(torus(1.0, 0.2), on_stage=bar.show)
    """

    def __init__(self, name: str = "", *, is_shown: bool | None = None, delay: float = 0.0):
        self._name = name
        self._is_shown = (sys.stderr.isatty() or _is_in_notebook()) if is_shown is None else is_shown
        self._delay = delay
        self._text = name
        self._bar: Any = None
        self._lock = threading.RLock()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._refresh, daemon=True)

    def __enter__(self) -> StageBar:
        if self._is_shown and self._delay <= 0:
            self._draw()
        if self._is_shown:
            self._thread.start()
        return self

    def show(self, stage: str) -> None:
        """Show the name of a stage."""
        self._text = f"{self._name}: {stage}" if self._name else stage
        if self._bar is not None:
            self._draw()

    def clear(self) -> None:
        """Remove the bar from the line until it is refreshed, so that text can be printed there."""
        with self._lock:
            if self._bar is not None:
                self._bar.clear()

    def __exit__(self, *_: object) -> None:
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._bar is not None:
            self._bar.close()

    def _refresh(self) -> None:
        """Draw the bar again and again, in a thread of its own: the stage may take long."""
        if not self._closed.wait(self._delay):
            self._draw()
        while not self._closed.wait(TICK):
            self._draw()

    def _draw(self) -> None:
        with self._lock:
            if self._bar is None:
                from tqdm.auto import tqdm  # in notebooks a widget

                self._bar = tqdm(bar_format="{desc} {elapsed}", leave=False)
                self._bar.start_t -= self._delay
            self._bar.set_description_str(self._text)


def _is_in_notebook() -> bool:
    """Whether this process is the kernel of a notebook, not one that only runs notebooks in other processes."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return getattr(shell, "kernel", None) is not None
