"""The node at which a tree begins: the soma of a neuron where there is one, else the thickest tip.

The thickest tip is the inlet of a vessel tree, the trunk of a plant, the cut end of a neuron without its soma; its
thickness is that of the branch near it.
"""

from __future__ import annotations

__all__ = ["find_roots", "find_soma", "is_in_soma", "reroot_by_thickness", "with_mean_radii"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.normals import vector_lengths
from lbskel.skeleton.editing import reroot
from lbskel.skeleton.skeleton import Skeleton

# Distance from the center of the soma, in its radii, at which the radius of a branch is taken; nearer, branches widen.
# At 2 the ratio below is 2.5 for the soma of a neuron, by inscribed radii; at 3 an elephant and a koala have a soma.
EXIT_DISTANCE = 2.5
# Radii of a node within which it counts as near a tip. At the center of a flat end a tip has a radius of zero, and the
# largest ball of the tube is one radius away, or 1.4 where the end is oblique by 45 degrees
TIP_REACH = 2.0
# Smallest radius of a soma, in radii of the thickest branch that leaves it, by the kind of radius: tubes widen farther
# from the soma. Measured on the five hemibrain neurons that navis 1.12 ships, at the four somata and at the thickest
# node of the neuron without one: inscribed radii 6.7 to 15.7, and 2.2; mean radii 3.4 to 8.5, and 2.5; the radii of
# their SWC files, made by others, 8.1 to 12.5, and 2.1.
MIN_SOMA_RATIO = 4.0
MIN_SOMA_RATIO_OF_TUBES = 3.0


def reroot_by_thickness(skeleton: Skeleton, radius_kind: str = "inscribed") -> Skeleton:
    """Reorder the nodes so that the soma comes first, or the thickest tip where there is no soma.

    The first node stays where there is neither. An empty skeleton is returned as it is.

    Parameters
    ----------
    skeleton : Skeleton
        With ``mean_radii`` if these count.
    radius_kind : {"inscribed", "mean"}
        Which radii count.
    """
    if len(skeleton.nodes) == 0:
        return skeleton
    measured = with_mean_radii(skeleton) if radius_kind == "mean" else skeleton
    root = find_soma(measured)
    if root is None:
        roots = find_roots(measured)
        root = int(roots[np.argmax(_tip_radii(measured)[roots])])
    return reroot(skeleton, root)


def with_mean_radii(skeleton: Skeleton) -> Skeleton:
    """Put the mean radii in the place of the inscribed ones.

    Parameters
    ----------
    skeleton : Skeleton
    """
    return replace(skeleton, radii=skeleton.mean_radii, radius_kind="mean")


def find_roots(skeleton: Skeleton) -> NDArray[np.int64]:
    """(c,) for each component its thickest tip by the branch near it, or its first node where it has no tip.

    Parameters
    ----------
    skeleton : Skeleton
    """
    is_tip = skeleton.degrees == 1
    own = np.where(is_tip, _known_radii(skeleton), 0.0)  # decides where the thickest node is near both tips of a branch
    order = np.lexsort((-own, -_tip_radii(skeleton), ~is_tip, skeleton.component_of_node))
    return order[np.unique(skeleton.component_of_node[order], return_index=True)[1]]


def find_soma(skeleton: Skeleton) -> int | None:
    """Find the thickest node of all, if every branch that leaves it is far thinner; else None.

    Its inscribed ball stands for the soma. The thickness of a branch is its radius where it is 2.5 radii of the soma
    away from the center; at least one branch must reach that far.

    Parameters
    ----------
    skeleton : Skeleton
    """
    radii = _known_radii(skeleton)
    if not radii.max(initial=0.0) > 0:
        return None
    center, k = int(np.argmax(radii)), len(radii)
    is_near = vector_lengths(skeleton.nodes - skeleton.nodes[center]) / EXIT_DISTANCE <= radii[center]
    near_edges = skeleton.edges[is_near[skeleton.edges].all(axis=1)]
    graph = weighted_graph(near_edges, np.ones(len(near_edges), dtype=np.int8), k)
    label = connected_components(graph, directed=False)[1]
    is_core = label == label[center]
    leaving = skeleton.edges[is_core[skeleton.edges].sum(axis=1) == 1]
    thickness = radii[leaving[~is_core[leaving]]]
    ratio = MIN_SOMA_RATIO_OF_TUBES if skeleton.radius_kind == "mean" else MIN_SOMA_RATIO
    is_soma = len(thickness) > 0 and radii[center] / ratio >= thickness.max()
    return center if is_soma else None


def is_in_soma(skeleton: Skeleton, node: int) -> bool:
    """Whether a node is in the ball of the soma; which node is the thickest there depends on the kind of radius.

    Parameters
    ----------
    skeleton : Skeleton
    node : int
    """
    soma = find_soma(skeleton)
    if soma is None:
        return False
    return bool(np.linalg.norm(skeleton.nodes[node] - skeleton.nodes[soma]) <= skeleton.radii[soma])


def _tip_radii(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k,) the largest radius near each tip on its branch, outside of the ball of the junction; 0 for other nodes."""
    nodes, radii, degrees = skeleton.nodes, _known_radii(skeleton), skeleton.degrees
    thickness = np.zeros(len(nodes))
    for branch in skeleton.branches:
        for path in (branch, branch[::-1]):
            tip, end = path[0], path[-1]
            if degrees[tip] == 1:
                is_near = vector_lengths(nodes[path] - nodes[tip]) / TIP_REACH <= radii[path]
                if degrees[end] >= 3:
                    is_near &= vector_lengths(nodes[path] - nodes[end]) >= radii[end]
                    is_near[-1] = False
                thickness[tip] = max(radii[tip], radii[path[is_near]].max(initial=0.0))
    return thickness


def _known_radii(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k,) the radii, 0 where they are not known."""
    return np.where(np.isnan(skeleton.radii), 0.0, skeleton.radii)
