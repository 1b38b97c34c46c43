"""From any mesh to a checked skeleton: the stages in their order, and many meshes at once."""

__all__: list[str] = []
