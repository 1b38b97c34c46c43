"""Which tunnels of a surface the cycles of a graph inside it go around.

A cycle that is moved inside the solid keeps its linking numbers with all loops outside, and these numbers are all zero
if and only if the cycle bounds inside.
"""

from __future__ import annotations

__all__ = ["are_around_tunnels", "tunnel_cochain", "tunnels_missed"]

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from lbskel.contraction.homology import outer_loops
from lbskel.contraction.linking_form import OuterLoops, random_integers
from lbskel.contraction.spurious_loops import PRIME, spurious_loop_edges
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface

# Upper bound on the number of tunnels that are compared with cycles, which is done after every pass: the time of
# elimination grows with its cube; with all else 0.03 s for 325 and 0.23 s for 833 (benchmarks/results/scaling.md)
MAX_TUNNELS = 400


@dataclass(frozen=True, eq=False)
class _Outside:
    """The loops outside a surface of genus g, and how often g combinations of them cross each edge."""

    loops: OuterLoops

    @cached_property
    def flows(self) -> NDArray[np.int32]:
        """(k, g) flow of each combination: below 2^30, as a sum of at most 2 MAX_TUNNELS numbers below PRIME."""
        basis = self.loops.basis
        n = len(basis.generators)
        combinations = (random_integers(n, 1 + i) % np.uint64(PRIME) for i in range(n // 2))
        flows = [basis.flow_across(combination).view(np.int64).astype(np.int32) for combination in combinations]
        return np.stack(flows, axis=1)

    @cached_property
    def mixed_flow(self) -> NDArray[np.int64]:
        """(k, 1) flow of one combination with coefficients modulo 2^64."""
        basis = self.loops.basis
        return basis.flow_across(random_integers(len(basis.generators), 0))[:, None].view(np.int64)

    def cochain(self, segments: NDArray[np.float64], flows: NDArray[np.signedinteger]) -> NDArray[np.int64]:
        """(e, c) signed number of times that c combinations pass above (e, 2, 3) segments.

        The sums along a cycle are its linking numbers with the combinations, up to one sign for all.
        """
        rows, edges, signs = self.loops.crossings(segments)
        crossed, columns = np.unique(edges, return_inverse=True)
        shape = (len(segments), len(crossed))
        crossings = coo_array((signs.view(np.int64), (rows, columns)), shape=shape).tocsr()
        cochain: NDArray[np.int64] = crossings @ flows[crossed].astype(np.int64)
        return cochain


def tunnels_missed(
    points: NDArray[np.float64], edges: NDArray[np.int64], mesh: Mesh, *, deadline: Deadline = NEVER
) -> int | None:
    """Count the tunnels of a surface that the cycles of a graph inside do not go around.

    The rank of the linking numbers of independent cycles is the number of tunnels that they go around.

    Parameters
    ----------
    points : (n, 3) array of float
        The nodes of a connected graph inside the surface.
    edges : (e, 2) array of int
    mesh : Mesh
        One closed manifold component.
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    int or None
        The genus minus that rank; None if the surface intersects itself, or has more than MAX_TUNNELS tunnels.
    """
    genus = mesh.genus
    if not genus or genus > MAX_TUNNELS:
        return None if genus else 0
    if (outside := _outside(mesh, deadline)) is None:
        return None
    edges = np.sort(edges, axis=1)
    cochain = outside.cochain(points[edges], outside.flows)
    n_cycles = len(edges) - len(points) + 1
    return genus - n_cycles + len(spurious_loop_edges(points, edges, cochain, deadline=deadline))


def are_around_tunnels(
    loops: Sequence[NDArray[np.float64]] | NDArray[np.float64], surface: Surface
) -> NDArray[np.bool_]:
    """(p,) whether closed polygons inside a solid go around its tunnels, up to chance; False where that is not known.

    Parameters
    ----------
    loops : sequence of (n, 3) array of float, or (p, n, 3) array of float
        Corners; an edge leads from the last back to the first.
    surface : Surface
        Its proxy is used in its place; nothing is known if the proxy is open or intersects itself.
    """
    if len(loops) == 0 or not surface.proxy.mesh.genus:
        return np.zeros(len(loops), dtype=bool)
    corners, begins = np.concatenate(loops), np.cumsum([0, *map(len, loops)])
    following = np.arange(1, len(corners) + 1)
    following[begins[1:] - 1] = begins[:-1]
    values = tunnel_cochain(np.stack([corners, corners[following]], axis=1), surface)
    if values is None:
        return np.zeros(len(loops), dtype=bool)
    are_linked: NDArray[np.bool_] = np.add.reduceat(values, begins[:-1]) != 0
    return are_linked


def tunnel_cochain(segments: NDArray[np.float64], surface: Surface) -> NDArray[np.int64] | None:
    """(e,) numbers modulo 2^64 whose sum around a closed polygon inside is zero if it goes around no tunnel.

    Else the sum is zero with a chance of about 2^-64. None if the surface has no tunnels, is open, or intersects
    itself.

    Parameters
    ----------
    segments : (e, 2, 3) array of float
        The ends of each.
    surface : Surface
        Its proxy is used in its place.
    """
    mesh = surface.proxy.mesh
    if not mesh.genus or (outside := _outside(mesh, surface.deadline)) is None:
        return None
    values: NDArray[np.int64] = outside.cochain(segments, outside.mixed_flow)[:, 0]
    return values


def _outside(mesh: Mesh, deadline: Deadline) -> _Outside | None:
    """Find the loops outside; their flows are computed once per mesh."""
    loops = outer_loops(mesh, deadline=deadline)
    found: _Outside | None = Surface(mesh).memoize("outside", lambda: None if loops is None else _Outside(loops))
    return found
