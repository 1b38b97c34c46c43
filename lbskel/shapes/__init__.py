"""Shapes whose curve skeleton or spectrum is known exactly, for tests, benchmarks and the demo.

``make(name)`` returns a :class:`Shape`, a mesh with the skeleton that it was built around, for any name in SHAPES;
``make(name, **VARIANTS["noisy"])`` returns a variant of it. ``mesh_solid(solid_of(branches))`` meshes a solid around
other polylines, and :func:`creature` returns a shape with limbs at random places. These three need pymeshlab. The
others do not: the meshes in closed form (:func:`sphere`, :func:`torus`, ...), :func:`chain_of_tori`, the tubes
(:func:`coil`, :func:`vessel_tree`, ...) and the surfaces of voxels (:func:`lattice`, :func:`porous_block`, ...).
"""

from __future__ import annotations

__all__ = [
    "SHAPES",
    "VARIANTS",
    "Shape",
    "Solid",
    "Truth",
    "brush",
    "capsule",
    "chain_of_tori",
    "coil",
    "creature",
    "cylinder",
    "flat_grid",
    "lattice",
    "make",
    "marching_cubes",
    "mesh_solid",
    "mesh_tubes",
    "perforated_plate",
    "porous_block",
    "project",
    "schwarz_lantern",
    "solid_of",
    "sphere",
    "torus",
    "tube",
    "tube_mesh",
    "vessel_tree",
    "voxel_surface",
    "voxel_tree",
    "with_local_noise",
]

from lbskel.shapes.catalog import SHAPES, VARIANTS, chain_of_tori, make, mesh_solid
from lbskel.shapes.creatures import creature
from lbskel.shapes.isosurface import marching_cubes, project
from lbskel.shapes.primitives import capsule, cylinder, flat_grid, schwarz_lantern, sphere, torus, tube
from lbskel.shapes.restricted_delaunay import mesh_tubes
from lbskel.shapes.round_cones import Solid, solid_of
from lbskel.shapes.thin import coil, tube_mesh, vessel_tree, with_local_noise
from lbskel.shapes.truth import Shape, Truth
from lbskel.shapes.voxels import brush, lattice, perforated_plate, porous_block, voxel_surface, voxel_tree
