"""Contraction of a surface to its curve skeleton: energies, weights, steps, and the collapse to a graph."""

__all__: list[str] = []
