"""The graph of a contracted cloud: samples of the points, links between their neighborhoods, and no triangles.

Cao, Tagliasacchi, Olson, Zhang, Su 2010, https://doi.org/10.1109/SMI.2010.25, section 5: the contracted points are
sampled by balls; each point links its sample to that of the first neighbor in its ring that has another sample;
triangles are then collapsed as by Li, Woon, Tan, Huang 2001, "Decomposing polygon meshes for interactive applications",
https://doi.org/10.1145/364338.364343. A loop of three samples counts as a triangle, so it is lost.

In the authors' program the test that should join a sample without links to its nearest is inverted, so that it never
does; and its comment says that the diagonal of the bounding box is made 1.6 long, where its longest side is. Here such
samples are joined, and the weights follow the longest side.
"""

from __future__ import annotations

__all__ = ["collapse_stars"]

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.point_stars import PointStars

SAMPLE_RADIUS = 0.02  # of the ball of a sample, relative to the diagonal of the source; Cao et al. 2010


def collapse_stars(contracted: Mesh, source: PointStars, *, deadline: Deadline = NEVER) -> CollapsedGraph:
    """Sample contracted points, link the samples, and collapse the triangles of the graph.

    Parameters
    ----------
    contracted : Mesh
        The points of the source after contraction.
    source : PointStars
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    points = contracted.vertices
    samples, sample_of_point = _sampled(points, SAMPLE_RADIUS * source.diagonal, deadline)
    links = _joined(_links(source, sample_of_point), points[samples])
    deadline.check()
    positions, edges, node = _without_triangles(points[samples], links, deadline)
    kept = np.unique(node, return_index=True)[1]
    return CollapsedGraph(positions, samples[kept], edges, node[sample_of_point], False, 0)


def _sampled(
    points: NDArray[np.float64], radius: float, deadline: Deadline
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sample points until their balls cover all points; return (s,) samples, and (n,) the nearest sample of each point.

    The next sample is the covered point farthest from its sample whose ball covers further points; where there is none,
    the first point not yet covered.
    """
    tree = cKDTree(points)
    distance, owner = np.full(len(points), -1.0), np.full(len(points), -1)  # a point not covered has -1
    samples: list[int] = []
    n_left = len(points)
    for seed in range(len(points)):
        if owner[seed] >= 0:
            continue
        deadline.check()
        distance[seed] = np.inf
        while n_left and distance[farthest := int(np.argmax(distance))] > 0:
            near = np.array(tree.query_ball_point(points[farthest], radius))
            if (owner[near] >= 0).all():
                distance[farthest] = 0
                continue
            from_sample = np.linalg.norm(points[near] - points[farthest], axis=1)
            n_left -= int(np.count_nonzero(owner[near] < 0))
            is_nearer = (owner[near] < 0) | (from_sample < distance[near])
            owner[near[is_nearer]] = len(samples)
            distance[near[is_nearer]] = from_sample[is_nearer]
            samples.append(farthest)
    return np.array(samples), owner


def _links(source: PointStars, sample: NDArray[np.int64]) -> NDArray[np.int64]:
    """(l, 2) pairs of samples: that of each point, and that of the first neighbor in its ring with another sample."""
    pairs = source.ring_edges
    pairs = pairs[sample[pairs[:, 0]] != sample[pairs[:, 1]]]
    first = pairs[np.unique(pairs[:, 0], return_index=True)[1]]
    return np.unique(np.sort(sample[first], axis=1), axis=0)


def _joined(links: NDArray[np.int64], positions: NDArray[np.float64]) -> NDArray[np.int64]:
    """(l, 2) links, and one more from each sample without a link to its nearest sample."""
    alone = np.setdiff1d(np.arange(len(positions)), links)
    if len(alone) == 0 or len(positions) < 2:
        return links
    nearest = cKDTree(positions).query(positions[alone], k=2)[1]
    other = np.where(nearest[:, 0] == alone, nearest[:, 1], nearest[:, 0])
    return np.unique(np.concatenate([links, np.sort(np.stack([alone, other], axis=1), axis=1)]), axis=0)


def _without_triangles(
    positions: NDArray[np.float64], links: NDArray[np.int64], deadline: Deadline
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Merge the ends of links in triangles to their midpoints: (k, 3) nodes, (e, 2) edges, (s,) node of each sample.

    The link to merge is the one with the least mean degree of its ends, and of several the shortest.
    """
    P, node = np.array(positions), np.arange(len(positions))
    linked: list[set[int]] = [set() for _ in P]
    for i, j in links.tolist():
        linked[i].add(j)
        linked[j].add(i)

    def cost(link: tuple[int, int]) -> tuple[int, float, int, int]:
        i, j = link
        return len(linked[i]) + len(linked[j]), float(np.linalg.norm(P[i] - P[j])), i, j

    while in_triangles := [(i, j) for i, near in enumerate(linked) for j in near if i < j and near & linked[j]]:
        deadline.check()
        i, j = min(in_triangles, key=cost)
        P[i] = (P[i] + P[j]) / 2
        node[node == j] = i
        for other in linked[j]:
            linked[other].discard(j)
            if other != i:
                linked[other].add(i)
                linked[i].add(other)
        linked[j] = set()
    kept = np.unique(node)
    edges = [(i, j) for i, near in enumerate(linked) for j in near if i < j]
    number = np.searchsorted(kept, np.array(sorted(edges), dtype=np.int64).reshape(-1, 2))
    return P[kept], number, np.searchsorted(kept, node)
