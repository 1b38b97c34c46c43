"""The shapes by name, meshed as a benchmark or a test wants them."""

from __future__ import annotations

__all__ = ["SHAPES", "VARIANTS", "chain_of_tori", "make", "mesh_solid"]

from collections.abc import Callable
from typing import Any

import igl
import numpy as np

from lbskel.errors import choose
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.pymeshlab_adapter import remesh_isotropic
from lbskel.shapes import solids
from lbskel.shapes.dinosaur import dinosaur
from lbskel.shapes.isosurface import marching_cubes, project
from lbskel.shapes.solid import Solid
from lbskel.shapes.truth import Shape

SHAPES: dict[str, Callable[[], Solid]] = {
    "limbs": solids.limbs,
    "tree": solids.tree,
    "octopus": solids.octopus,
    "helix": solids.helix,
    "knot": solids.knot,
    "spiked_ring": solids.spiked_ring,
    "ladder": solids.ladder,
    "cube_frame": solids.cube_frame,
    "dumbbell": solids.dumbbell,
    "hand": solids.hand,
    "figure_eight": solids.rings,
    "tripod": solids.tripod,
    "dinosaur": dinosaur,
}

# options of make()
VARIANTS: dict[str, dict[str, Any]] = {"clean": {}, "noisy": {"noise": 0.25}, "coarse": {"n_vertices": 2000}}

LENGTH_RATIO = 0.99  # of target to mean length of the edges that the remesher leaves; measured on all shapes
LONGEST_EDGE = 0.75  # of the smallest radius; at 0.9 the remesher begins to eat ends, at 1.3 whole branches are gone


def mesh_solid(solid: Solid, *, n_vertices: int = 5000) -> Mesh:
    """The surface of a solid in nearly equilateral triangles of one size, all vertices on the surface.

    Parameters
    ----------
    solid : Solid
    n_vertices : int
        About how many vertices to have. There are more where the thinnest part needs shorter edges.
    """
    longest = LONGEST_EDGE * solid.radii.min()
    start, end = solid.centers[solid.segments].transpose(1, 0, 2)
    overlapping = 2 * np.pi * np.linalg.norm(end - start, axis=1) @ solid.radii.mean(axis=1)
    raw = marching_cubes(solid, 0.7 * min(_edge_length(overlapping, n_vertices), longest))
    length = min(_edge_length(raw.area, n_vertices), longest)
    V, F = remesh_isotropic(raw.vertices, raw.faces, target_length=LENGTH_RATIO * length, feature_angle=180.0)
    return Mesh(project(solid, V, step=length), F)


def _edge_length(area: float, n_vertices: int) -> float:
    """Edge length of twice as many equilateral triangles as vertices that have that area together."""
    return np.sqrt(2 * area / (np.sqrt(3) * n_vertices))


def chain_of_tori(genus: int = 2, *, step: float = 0.1) -> Mesh:
    """A closed surface of any genus, the vertices of marching cubes on it: no pymeshlab, and some slivers.

    Parameters
    ----------
    genus : int
        Rings in a row, each of radius 1 and thickness 0.25.
    step : float
        Of the grid.
    """
    solid = solids.rings(genus)
    raw = marching_cubes(solid, step)
    return Mesh(project(solid, raw.vertices, step=step), raw.faces)


def make(name: str, *, n_vertices: int = 5000, noise: float = 0.0, seed: int = 0) -> Shape:
    """A shape of the catalog.

    Parameters
    ----------
    name : str
        A key of SHAPES.
    n_vertices : int
        About how many vertices to have.
    noise : float
        Standard deviation of a Gaussian displacement along the vertex normals, in mean edge lengths.
    seed : int
        Of the noise.

    Raises
    ------
    UnknownChoice
        If there is no shape of that name.
    MissingDependency
        If pymeshlab is not installed.

    Examples
    --------
    >>> from lbskel import shapes
    >>> knot = shapes.make("knot", n_vertices=1000)
    >>> knot.mesh.genus, knot.truth.genus, knot.truth.n_tips
    (1, 1, 0)
    """
    solid = choose(SHAPES, name, "shape")()
    mesh = mesh_solid(solid, n_vertices=n_vertices)
    if noise > 0:
        start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
        height = noise * np.linalg.norm(end - start, axis=1).mean()
        heights = height * np.random.default_rng(seed).standard_normal(len(mesh.vertices))
        normals = igl.per_vertex_normals(mesh.vertices, mesh.faces)
        mesh = Mesh(mesh.vertices + heights[:, None] * normals, mesh.faces)
    return Shape(mesh, solid.truth, name)
