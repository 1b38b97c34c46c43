"""Thin and long shapes, whose thinnest radius is a small part of their extent, with their axes."""

from __future__ import annotations

__all__ = ["coil", "tube_mesh", "vessel_tree", "with_local_noise"]

import igl
import numpy as np

from lbskel.errors import MeshError, UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.shapes.primitives import tube
from lbskel.shapes.restricted_delaunay import EDGE_LENGTH, mesh_tubes, volume_factor
from lbskel.shapes.round_cones import solid_of
from lbskel.shapes.truth import Shape, Truth
from lbskel.shapes.tubes import tubular
from lbskel.shapes.vessels import murray_branches
from lbskel.skeleton.skeleton import Skeleton

# Of a coil, in tube radii: the radius of its turns, the height that it gains in a turn, the distance of two sections.
TURN_RADIUS, PITCH, SECTION_SPACING = 8.0, 6.0, 1.0


def coil(n_turns: int, *, sides: int = 12) -> Shape:
    """Build a tube of radius 1 wound around the z axis, with rounded ends.

    The radius of the turns is 8, their pitch 6, so the radius over the diagonal of the box is 0.0245 for 5 turns and
    0.00055 for 300. The polygon of a section has the area of a circle of radius 1; the volume is 0.25 % below
    that of the tube, since the sections are oblique to the chords of the axis.

    Parameters
    ----------
    n_turns : int
    sides : int
        Number of vertices in each section; there are 51 sections in a turn.

    Raises
    ------
    UnknownChoice
        If the number of turns is not positive.
    """
    if not n_turns > 0:
        raise UnknownChoice(f"n_turns must be positive, not {n_turns}")
    turn = 2 * np.pi * n_turns
    length = turn * np.hypot(TURN_RADIUS, PITCH / (2 * np.pi))
    t = np.linspace(0, turn, int(np.ceil(length / SECTION_SPACING)) + 1)
    axis = np.stack([TURN_RADIUS * np.cos(t), TURN_RADIUS * np.sin(t), PITCH * t / (2 * np.pi)], axis=1)
    k = np.arange(len(t) - 1)
    truth = Truth(axis, np.stack([k, k + 1], axis=1), np.ones(len(t)))
    corner = 2 * np.pi / sides
    return Shape(tube(axis, np.sqrt(corner / np.sin(corner)), sides=sides, rounded=True), truth, "coil")


def vessel_tree(n_forks: int, *, min_radius: float = 0.0, seed: int = 0) -> Shape:
    """Build a tree of vessels by Murray's law, the trunk of radius 1, as one surface.

    Edges are half a local radius long. The vertices are outside the tubes by 1.5 % of the radius, so that the volume is
    that of the tubes.

    Parameters
    ----------
    n_forks, min_radius, seed
        As for :func:`lbskel.shapes.vessels.murray_branches`.

    Examples
    --------
    >>> from lbskel.shapes import vessel_tree
    >>> shape = vessel_tree(3, seed=1)
    >>> shape.mesh.is_closed_manifold, shape.truth.n_tips
    (True, 5)
    """
    branches = murray_branches(n_forks, min_radius=min_radius, seed=seed)
    mesh = mesh_tubes([(axis, volume_factor() * radii) for axis, radii in branches])
    return Shape(mesh, solid_of(branches).truth, "vessel tree")


def tube_mesh(skeleton: Skeleton, *, edge_length: float = EDGE_LENGTH) -> Shape:
    """Mesh the tubes around the edges of a skeleton, such as the tracing of a neuron, as one closed surface.

    Parameters
    ----------
    skeleton : Skeleton
        Its radii and edges are first changed by :func:`lbskel.shapes.tubes.tubular`; the result is the truth.
    edge_length : float
        Length of the edges, in local radii.

    Raises
    ------
    MeshError
        If the surface does not become a closed manifold with a handle for each cycle of the skeleton.

    Examples
    --------
    >>> from lbskel import Skeleton
    >>> from lbskel.shapes import tube_mesh
    >>> fork = Skeleton([[0, 0, 0], [0, 0, 9], [5, 0, 15], [-5, 0, 15]], [[0, 1], [1, 2], [1, 3]], [1.0, 0.9, 0.6, 0.7])
    >>> tube_mesh(fork).mesh.is_closed_manifold
    True
    """
    axes = tubular(skeleton)
    factor = volume_factor(edge_length)
    mesh = mesh_tubes(
        [(axes.nodes[branch], factor * axes.radii[branch]) for branch in axes.branches], edge_length=edge_length
    )
    truth = Truth(axes.nodes, axes.edges, axes.radii)
    if (mesh.genus, mesh.n_components) != (truth.genus, truth.n_components):
        raise MeshError("tubes of the skeleton touch where their axes do not meet: lower the radii there")
    return Shape(mesh, truth, "tubes")


def with_local_noise(mesh: Mesh, deviation: float, *, seed: int = 0) -> Mesh:
    """Displace the vertices along their normals by Gaussian noise.

    Parameters
    ----------
    mesh : Mesh
    deviation : float
        Standard deviation, in mean lengths of the edges at each vertex.
    seed : int
    """
    lengths = np.repeat(mesh.edge_lengths, 2)
    ends, n = mesh.edges.ravel(), len(mesh.vertices)
    local = np.bincount(ends, lengths, n) / np.maximum(np.bincount(ends, minlength=n), 1)
    heights = deviation * local * np.random.default_rng(seed).standard_normal(n)
    return mesh.with_vertices(mesh.vertices + heights[:, None] * igl.per_vertex_normals(mesh.vertices, mesh.faces))
