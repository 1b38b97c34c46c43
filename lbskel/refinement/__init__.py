"""From the graph that surgery leaves to centred nodes, placed junctions and reached tips."""

__all__: list[str] = []
