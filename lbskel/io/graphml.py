"""GraphML, an XML format of graphs, through networkx: nodes with x, y, z and radius, edges with their length.

Format: http://graphml.graphdrawing.org/specification.html
"""

from __future__ import annotations

__all__ = ["encode_graphml", "read_graphml"]

import io
from pathlib import Path

import numpy as np

from lbskel.errors import FormatError, MissingDependency
from lbskel.io.text import as_floats, read_bytes
from lbskel.skeleton.skeleton import Skeleton


def encode_graphml(skeleton: Skeleton, path: Path) -> dict[Path, bytes]:
    """Encode a skeleton as GraphML; the ids of the nodes are 0, 1, 2 and so on."""
    graph = skeleton.to_networkx()
    import networkx

    for _, attributes in graph.nodes(data=True):
        attributes.update(zip("xyz", attributes.pop("pos"), strict=True))
    graph.graph["radius_kind"] = skeleton.radius_kind
    buffer = io.BytesIO()
    networkx.write_graphml_xml(graph, buffer)
    return {path: buffer.getvalue()}


def read_graphml(path: Path) -> Skeleton:
    """Read a skeleton from GraphML with node ids of any kind; missing radii become NaN."""
    try:
        import networkx
    except ImportError:
        raise MissingDependency("networkx", "graph", "reading GraphML") from None
    graph = networkx.read_graphml(io.BytesIO(read_bytes(path)))
    index = {name: number for number, name in enumerate(graph)}
    nodes = []
    for name, attributes in graph.nodes(data=True):
        if not {"x", "y", "z"} <= attributes.keys():
            raise FormatError(f"node {name!r} lacks x, y or z")
        nodes.append([attributes[axis] for axis in "xyz"])
    return Skeleton(
        as_floats(nodes, "positions", 3),
        np.array([(index[start], index[end]) for start, end in graph.edges()], dtype=np.int64).reshape(-1, 2),
        as_floats([attributes.get("radius") for _, attributes in graph.nodes(data=True)], "radii"),
        radius_kind=str(graph.graph.get("radius_kind", Skeleton.radius_kind)),
    )
