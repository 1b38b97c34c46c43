"""Sweeps of the constants of single modules: each is multiplied by some factors, and the effect is measured."""

from __future__ import annotations

__all__ = ["swept"]

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from benchmarks.constants import ROOT, find_constants

FACTORS = (0.7, 0.85, 1.0, 1.2, 1.4)


def swept(
    places: Sequence[str], measure: Callable[[], dict[str, Any]], factors: Sequence[float] = FACTORS
) -> list[dict[str, Any]]:
    """Measure for every constant of some modules times every factor; a row each, the value among them.

    Parameters
    ----------
    places : sequence of str
        Modules, as paths in ``lbskel``.
    measure : callable
        What is measured, by name.
    factors : sequence of float
    """
    rows = []
    for constant in find_constants(ROOT / "lbskel", places):
        module, stem = import_module(constant.module), constant.module.rpartition(".")[2]
        try:
            for factor in factors:
                value = type(constant.value)(round(constant.value * factor, 12))
                setattr(module, constant.name, value)
                row = {"constant": f"`{stem}.{constant.name}`", "factor": factor, "value": value}
                rows.append({**row, **measure()})
        finally:
            setattr(module, constant.name, constant.value)
    return rows
