"""The shapes by name, meshed as a benchmark or a test wants them."""

from __future__ import annotations

__all__ = ["SHAPES", "VARIANTS", "make", "mesh_solid"]

from collections.abc import Callable
from typing import Any

import igl
import numpy as np

from lbskel.errors import choose
from lbskel.mesh import Mesh
from lbskel.preprocess.pymeshlab_adapter import remesh_isotropic
from lbskel.shapes import solids
from lbskel.shapes.dinosaur import dinosaur
from lbskel.shapes.solid import Solid
from lbskel.shapes.surface import marching_cubes, project
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
    "figure_eight": solids.chain_of_tori,
    "tripod": solids.tripod,
    "dinosaur": dinosaur,
}

VARIANTS: dict[str, dict[str, Any]] = {"clean": {}, "noisy": {"noise": 0.25}, "coarse": {"n_vertices": 1500}}


def mesh_solid(solid: Solid, *, n_vertices: int = 5000) -> Mesh:
    """The surface of a solid in nearly equilateral triangles, about that many vertices, all of them on the surface."""
    start, end = solid.centres[solid.segments].transpose(1, 0, 2)
    area = 2 * np.pi * np.linalg.norm(end - start, axis=1) @ solid.radii.mean(axis=1)
    raw = marching_cubes(solid, 0.7 * np.sqrt(2 * area / (np.sqrt(3) * n_vertices)))
    length = np.sqrt(2 * raw.area / (np.sqrt(3) * n_vertices))
    V, F = remesh_isotropic(raw.vertices, raw.faces, target_length=length)
    return Mesh(project(solid, V, step=length), F)


def make(name: str, *, n_vertices: int = 5000, noise: float = 0.0, seed: int = 0) -> Shape:
    """A shape of the catalogue.

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
