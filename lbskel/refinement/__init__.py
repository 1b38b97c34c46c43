"""Refinement of the collapsed graph: centering, junctions, tips, containment, anchors, radii and the vertex map."""

__all__: list[str] = []
