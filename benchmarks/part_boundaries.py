"""How smooth the boundaries of parts are, and whether they follow concave edges."""

from __future__ import annotations

__all__ = ["boundary_measures"]

import numpy as np
from numpy.typing import NDArray

import lbskel
from lbskel.applications.face_graph import face_graph

EDGES = 1.0  # mean edge lengths over which the labels diffuse for the smooth curves


def boundary_measures(mesh: lbskel.Mesh, part: NDArray[np.int64]) -> dict[str, float | None]:
    """Measure the boundaries of parts, by names of columns.

    "raggedness": the length of the boundaries along edges over that of the curves where the labels, diffused over an
    edge, are one half. A shortest path along the edges of equilateral triangles is 1 to 1.155 times its straight line,
    1.10 on average. It is None where a part is so small that it diffuses away. "turn, degrees": mean turn of the
    surface at the boundaries, inward positive, weighted by lengths; "of all edges": the same for the whole mesh.

    Parameters
    ----------
    mesh : Mesh
    part : (m,) array of int
        Of each face.
    """
    graph = face_graph(mesh)
    cut = part[graph.pairs[:, 0]] != part[graph.pairs[:, 1]]
    if not cut.any():
        return {}
    degrees, lengths, of_curves = np.degrees(graph.turns), graph.lengths, _length_of_curves(mesh, part)
    return {
        "raggedness": 2 * float(lengths[cut].sum()) / of_curves if of_curves > 0 else None,
        "turn, degrees": float(np.average(degrees[cut], weights=lengths[cut])),
        "of all edges": float(np.average(degrees, weights=lengths)),
    }


def _length_of_curves(mesh: lbskel.Mesh, part: NDArray[np.int64]) -> float:
    """Length of the curves around all parts, so that each is counted on both of its sides."""
    n, F = len(mesh.vertices), mesh.faces
    operator = lbskel.laplacian(mesh, operator="robust")
    weights = np.zeros((n, int(part.max()) + 1))
    np.add.at(weights, (F.ravel(), np.repeat(part, 3)), np.repeat(mesh.face_areas, 3))
    shares = weights / np.maximum(weights.sum(axis=1, keepdims=True), np.finfo(np.float64).tiny)
    time = (EDGES * mesh.edge_lengths.mean()) ** 2
    system = (operator.mass + time * operator.stiffness).tocsc()
    fields = lbskel.factorize(system).solve(operator.mass @ shares) - 0.5
    total = 0.0
    for field in fields.T:
        values = field[F]
        faces = np.flatnonzero((values.max(axis=1) > 0) & (values.min(axis=1) <= 0))
        value, corner = values[faces], mesh.vertices[F[faces]]
        is_inside = value > 0
        alone = np.where(is_inside.sum(axis=1) == 1, is_inside.argmax(axis=1), is_inside.argmin(axis=1))
        row = np.arange(len(faces))
        points = []
        for other in ((alone + 1) % 3, (alone + 2) % 3):
            share = value[row, alone] / (value[row, alone] - value[row, other])
            points.append(corner[row, alone] + share[:, None] * (corner[row, other] - corner[row, alone]))
        total += float(np.linalg.norm(points[0] - points[1], axis=1).sum())
    return total
