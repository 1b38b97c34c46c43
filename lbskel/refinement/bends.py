"""Sharp bends: the spur that contraction leaves in the corner is merged into its junction.

The two limbs of a bend, of radius r and with the angle a between them, overlap over a length of r / sin(a / 2) before
their axes meet. Contraction gives the overlap a branch of its own, from a junction where the limbs part to a tip in the
corner. This spur differs from a limb: the centerlines of the two other branches meet at its tip, not at the junction.
"""

from __future__ import annotations

__all__ = ["contract_corner_spurs"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.branch_lines import BranchLines, branch_lines
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.tunnel_sides import keep_sides
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton


def contract_corner_spurs(
    skeleton: Skeleton, contracted: Skeleton, centers: SectionCenters, surface: Surface
) -> Skeleton:
    """Contract each end branch if the lines of the two other branches at its junction meet in the ball at its tip.

    Parameters
    ----------
    skeleton : Skeleton
    contracted : Skeleton
        The same graph with the positions that contraction gave.
    centers : SectionCenters
        Of the same nodes.
    surface : Surface

    Returns
    -------
    Skeleton
        The junction of each contracted branch lies where the two lines are nearest to each other, and both branches
        lead straight there from their own section nearest to it.
    """
    degrees, ends = skeleton.degrees, skeleton.branch_ends
    is_spur = (np.sort(degrees[ends], axis=1) == [1, 3]).all(axis=1)
    spurs = np.flatnonzero(is_spur & ~np.isin(ends, skeleton.anchors).any(axis=1))
    junctions, tips = np.take_along_axis(ends[spurs], np.argsort(-degrees[ends[spurs]], axis=1), axis=1).T
    lines = branch_lines(skeleton, centers)
    rows, groups = lines.at(junctions[:, None])
    is_other = lines.branches[rows] != spurs[groups]
    rows, groups = rows[is_other], groups[is_other]
    has_two = np.bincount(groups, minlength=len(spurs)) == 2
    first, second = (lines.take(each) for each in rows[has_two[groups]].reshape(-1, 2).T)
    spurs, junctions, tips = spurs[has_two], junctions[has_two], tips[has_two]
    places, gaps = _meeting_places(first, second)
    corner_tips = contracted.nodes[tips]
    distances, radii = vector_lengths(places - corner_tips), surface.distance(corner_tips)
    is_corner = (distances <= radii) & (gaps <= radii) & (first.branches != second.branches)
    corners = np.flatnonzero(is_corner)[np.unique(junctions[is_corner], return_index=True)[1]]
    target, positions = np.arange(len(skeleton.nodes)), np.array(skeleton.nodes)
    for corner in corners.tolist():
        junction = junctions[corner]
        target[skeleton.branches[spurs[corner]]] = junction
        positions[junction] = places[corner]
        for branch in (skeleton.branches[first.branches[corner]], skeleton.branches[second.branches[corner]]):
            path = branch if branch[0] == junction else branch[::-1]
            last = int(np.argmax(centers.is_known[path[1:]])) + 1
            share = np.arange(1, last)[:, None] / last
            positions[path[1:last]] = (1 - share) * places[corner] + share * skeleton.nodes[path[last]]
    if len(corners) == 0:
        return skeleton
    positions = keep_sides(skeleton, positions, surface)
    return contract_nodes(replace(skeleton, nodes=positions), target)


def _meeting_places(first: BranchLines, second: BranchLines) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) the middle of the shortest segment between two lines, and (k,) its length; infinite for parallel lines."""
    u, v, between = first.directions, second.directions, second.means - first.means
    cosine, along_u, along_v = (np.einsum("ij,ij->i", a, b) for a, b in ((u, v), (between, u), (between, v)))
    squared_sine = 1 - cosine**2
    has_place = squared_sine > 0
    squared_sine[~has_place] = 1.0
    P = first.means + ((along_u - cosine * along_v) / squared_sine)[:, None] * u
    Q = second.means + ((cosine * along_u - along_v) / squared_sine)[:, None] * v
    return (P + Q) / 2, np.where(has_place, vector_lengths(P - Q), np.inf)
