"""Scores of skeletons, distances to known axes, and diagnostics of discrete Laplacians."""

__all__: list[str] = []
