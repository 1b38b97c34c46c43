"""Time and memory of each stage of a run, and whether the time limit leaves time for the next."""

from __future__ import annotations

__all__ = ["Progress", "StageTimer"]

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias, TypeVar

from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime

Progress: TypeAlias = Callable[[str], None]
Result = TypeVar("Result")

# Time after the time limit that stages may take which a result needs, as a share of the limit and in seconds, whichever
# is more: half of what a run may take beyond its limit; benchmarks/results/scaling.md has the limits that hold with it
GRACE_SHARE, GRACE_SECONDS = 0.25, 1.0

RESET_PEAK, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")  # Linux's record of peak memory


@dataclass
class StageTimer:
    """Measures the stages of a run: ``with timer("contract"): ...``.

    Parameters
    ----------
    on_stage : callable, optional
        Called with the name of each stage as it begins.
    time_limit : float, optional
        Seconds from now after which optional stages are skipped.
    measures_memory : bool
        Whether to measure the peak memory of each stage, which resets the process's own record of it.

    Attributes
    ----------
    seconds, megabytes : dict
        By stage, in the order in which the stages began.
    skipped : list of str
        Optional stages for which no time was left.
    """

    on_stage: Progress | None = None
    time_limit: float | None = None
    measures_memory: bool = False
    seconds: dict[str, float] = field(default_factory=dict)
    megabytes: dict[str, float] = field(default_factory=dict)
    skipped: list[str] = field(default_factory=list)
    _began: float = field(default_factory=time.perf_counter)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Measure the block as part of a stage."""
        if self.on_stage is not None:
            self.on_stage(stage)
        measures_memory = self.measures_memory and RESET_PEAK.exists()
        if measures_memory:
            RESET_PEAK.write_text("5")
        began = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - began
            if measures_memory:
                self.megabytes[stage] = max(self.megabytes.get(stage, 0.0), _peak_megabytes())

    @property
    def deadline(self) -> Deadline:
        """The end of the time limit."""
        return NEVER if self.time_limit is None else Deadline(self._began + self.time_limit)

    @property
    def grace(self) -> Deadline:
        """The end of the time for stages that a result needs, a little later than the time limit."""
        if self.time_limit is None:
            return NEVER
        return Deadline(self.deadline.end + max(GRACE_SHARE * self.time_limit, GRACE_SECONDS))

    @property
    def seconds_left(self) -> float:
        """Seconds until the time limit; infinite without one."""
        return self.deadline.seconds_left

    def has_time_for(self, stage: str, *, seconds: float = 0.0) -> bool:
        """Whether time is left for an optional stage; if not, the stage is listed as skipped.

        Parameters
        ----------
        stage : str
        seconds : float
            Time that the stage is expected to take. It must end by ``grace``, not by the time limit.
        """
        if self.seconds_left > 0 and self.grace.seconds_left > seconds:
            return True
        self.skip(stage)
        return False

    def optional(
        self, stage: str, make: Callable[[Deadline], Result], otherwise: Result, *, is_needed: bool = False
    ) -> Result:
        """Measure a stage that is left out if its deadline passes before it begins or while it runs.

        Parameters
        ----------
        stage : str
        make : callable
            Does the work by a deadline, or raises OutOfTime, and returns the result of the stage.
        otherwise
            The result if the stage is left out.
        is_needed : bool
            Whether the result needs the stage, so that its deadline is ``grace`` instead of the time limit.
        """
        deadline = self.grace if is_needed else self.deadline
        try:
            deadline.check()
            with self(stage):
                return make(deadline)
        except OutOfTime:
            self.skip(stage)
        return otherwise

    def skip(self, stage: str) -> None:
        """List a stage as skipped, once.

        Parameters
        ----------
        stage : str
        """
        if stage not in self.skipped:
            self.skipped.append(stage)


def _peak_megabytes() -> float:
    """Peak memory of the process since it was last reset."""
    kilobytes = next(line.split()[1] for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kilobytes) * 1024 / 1e6
