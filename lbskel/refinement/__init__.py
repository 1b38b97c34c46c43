"""From the graph that surgery leaves to centered nodes, placed junctions and reached tips."""

__all__: list[str] = []
