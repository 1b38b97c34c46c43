"""The catalog of shapes with known skeletons: names, variants, and their meshes."""

from __future__ import annotations

__all__ = ["SHAPES", "VARIANTS", "chain_of_tori", "make", "mesh_solid"]

from collections.abc import Callable
from typing import Any

import igl
import numpy as np

from lbskel.errors import MeshError, UnknownChoice, choose
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.pymeshlab_adapter import remesh_isotropic
from lbskel.shapes import solids
from lbskel.shapes.dinosaur import dinosaur
from lbskel.shapes.isosurface import marching_cubes, project
from lbskel.shapes.round_cones import Solid
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

# Keyword arguments of make() for each variant; "coarse" has 2,000 vertices in place of 5,000.
VARIANTS: dict[str, dict[str, Any]] = {"clean": {}, "noisy": {"noise": 0.25}, "coarse": {"n_vertices": 2000}}

# Ratio of the remesher's target length to the mean edge length that it produces; measured on all shapes.
LENGTH_RATIO = 0.99
# Upper bound on the target edge length, relative to the smallest radius: from 0.9 the remesher shortens tips, at 1.3 it
# removes whole branches (tried on the catalog; there is no committed table).
MAX_EDGE_LENGTH = 0.75
# Grid step of marching cubes, relative to the target edge length; a guess.
GRID_STEP = 0.7


def mesh_solid(solid: Solid, *, n_vertices: int = 5000) -> Mesh:
    """Mesh the surface of a solid by nearly equilateral triangles of one size, with all vertices on the surface.

    Parameters
    ----------
    solid : Solid
    n_vertices : int
        Approximate number of vertices; exceeded if the thinnest branch needs shorter edges.

    Raises
    ------
    UnknownChoice
        If the number of vertices is not positive.
    MissingDependency
        If pymeshlab is not installed.
    """
    if not n_vertices > 0:
        raise UnknownChoice(f"n_vertices must be positive, not {n_vertices}")
    max_length = MAX_EDGE_LENGTH * solid.radii.min()
    start, end = solid.centers[solid.segments].transpose(1, 0, 2)
    lateral_area = 2 * np.pi * np.linalg.norm(end - start, axis=1) @ solid.radii.mean(axis=1)
    raw = marching_cubes(solid, GRID_STEP * min(_edge_length(lateral_area, n_vertices), max_length))
    length = min(_edge_length(raw.area, n_vertices), max_length)
    V, F = remesh_isotropic(raw.vertices, raw.faces, target_length=LENGTH_RATIO * length, feature_angle=180.0)
    return Mesh(project(solid, V, step=length), F)


def _edge_length(area: float, n_vertices: int) -> float:
    """Compute the edge length at which 2 n_vertices equilateral triangles have that total area."""
    length: float = np.sqrt(2 * area / (np.sqrt(3) * n_vertices))
    return length


def chain_of_tori(genus: int = 2, *, step: float = 0.1) -> Mesh:
    """Mesh a closed surface of any genus by marching cubes alone: it does not need pymeshlab and has some slivers.

    Parameters
    ----------
    genus : int
        Number of rings in a row, each of radius 1 with a tube of radius 0.25; for 0, a rod.
    step : float
        Side of a grid cell of marching cubes, in the same units.

    Raises
    ------
    MeshError
        If the step is so large that the surface has another genus.
    """
    solid = solids.rings(genus)
    raw = marching_cubes(solid, step)
    if raw.genus != genus:
        raise MeshError(f"with step={step:g} the surface has genus {raw.genus} in place of {genus}; make step smaller")
    return Mesh(project(solid, raw.vertices, step=step), raw.faces)


def make(name: str, *, n_vertices: int = 5000, noise: float = 0.0, seed: int = 0) -> Shape:
    """Make a shape of the catalog.

    Parameters
    ----------
    name : str
        A key of SHAPES.
    n_vertices : int
        Approximate number of vertices.
    noise : float
        Standard deviation of a Gaussian displacement along the vertex normals, in mean edge lengths.
    seed : int
        Seed of the noise.

    Raises
    ------
    UnknownChoice
        If there is no shape of that name, or the number of vertices is not positive.
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
        deviation = noise * mesh.edge_lengths.mean()
        heights = deviation * np.random.default_rng(seed).standard_normal(len(mesh.vertices))
        normals = igl.per_vertex_normals(mesh.vertices, mesh.faces)
        mesh = Mesh(mesh.vertices + heights[:, None] * normals, mesh.faces)
    return Shape(mesh, solid.truth, name)
