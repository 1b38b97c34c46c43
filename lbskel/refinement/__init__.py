"""Refinement of the collapsed graph: nodes centered, junctions placed, tips extended, branches inside, vertices mapped."""

__all__: list[str] = []
