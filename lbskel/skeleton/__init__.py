"""The skeleton as a graph with radii and maps, and what edits it: pruning, resampling, joining."""

__all__: list[str] = []
