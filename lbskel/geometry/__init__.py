"""Triangle meshes and point clouds, and the queries on them: search trees, cross-sections, distances, components."""

__all__: list[str] = []
