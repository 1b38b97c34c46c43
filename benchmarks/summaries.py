"""Means over the skeletons of shapes with a known axis, and counts of the right ones."""

from __future__ import annotations

__all__ = ["MEASURES", "counts_of_right", "means"]

from collections.abc import Sequence
from typing import Any

import numpy as np

MEASURES = ("accuracy", "accuracy_95", "coverage", "coverage_95")


def means(rows: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    """Compute the mean of each measure over the rows without an error; None if there is no such row."""
    done = [row for row in rows if "error" not in row]
    return {measure: float(np.mean([row[measure] for row in done])) if done else None for measure in MEASURES}


def counts_of_right(rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Count the rows with the topology and with the number of tips of the axis, among all."""
    done = [row for row in rows if "error" not in row]
    return {
        "topology right": f"{sum(row['is_topology_right'] for row in done)}/{len(rows)}",
        "tips right": f"{sum(row['n_tips'] == row['n_true_tips'] for row in done)}/{len(rows)}",
    }
