"""The clock of a run: what each stage takes of time and of memory, and whether there is time left for the next."""

from __future__ import annotations

__all__ = ["Progress", "StageTimer"]

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

Progress: TypeAlias = Callable[[str], None]

RESET, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")  # of the peak of memory, where there are such


@dataclass
class StageTimer:
    """Seconds spent in each stage, and the caller told of each as it begins.

    Parameters
    ----------
    on_stage : callable, optional
    time_limit : float, optional
        Seconds from now on after which stages that can be left out are.
    measures_memory : bool
        Whether to measure the peak of memory in each stage too, which sets the process's own record of it back.
    """

    on_stage: Progress | None = None
    time_limit: float | None = None
    measures_memory: bool = False
    seconds: dict[str, float] = field(default_factory=dict)
    megabytes: dict[str, float] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    _began: float = field(default_factory=time.perf_counter)

    def __call__(self, stage: str, function: Callable, *arguments: Any, **options: Any) -> Any:
        """What the function returns."""
        if self.on_stage is not None:
            self.on_stage(stage)
        measures_memory = self.measures_memory and RESET.exists()
        if measures_memory:
            RESET.write_text("5")
        began = time.perf_counter()
        result = function(*arguments, **options)
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - began
        if measures_memory:
            self.megabytes[stage] = max(self.megabytes.get(stage, 0.0), _peak())
        return result

    @property
    def seconds_left(self) -> float:
        """Until the time limit; infinite where there is none."""
        return float("inf") if self.time_limit is None else self._began + self.time_limit - time.perf_counter()

    def if_time(self, stage: str, function: Callable, value: Any, *arguments: Any, **options: Any) -> Any:
        """What the function makes of a value, or the value as it is where no time is left."""
        if self.seconds_left > 0:
            return self(stage, function, value, *arguments, **options)
        if stage not in self.left_out:
            self.left_out.append(stage)
        return value


def _peak() -> float:
    """Megabytes of memory that the process has held at most since it was set back."""
    kilobytes = next(line.split()[1] for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kilobytes) * 1024 / 1e6
