"""No handle lost and no loop left over, whatever the positions: surgery's promise, and that of the whole way on noise.

``python -m benchmarks topology`` runs the same thousands of times, up to genus 9.
"""

import numpy as np
import pytest

from lbskel import Skeleton, collapse_mesh, skeletonize
from lbskel.shapes import capsule, chain_of_tori, torus

POSITIONS = {
    "scattered": lambda V, rng: rng.normal(size=V.shape),
    "shuffled": lambda V, rng: rng.permutation(V),
    "on a plane": lambda V, rng: rng.normal(size=V.shape) * [1, 1, 0],
    "on a line": lambda V, rng: rng.normal(size=V.shape) * [1, 0, 0],
    "on a grid": lambda V, rng: np.rint(rng.normal(size=V.shape)),
    "squeezed": lambda V, rng: V * 10.0 ** rng.uniform(-4, 1, size=3),
}
MESHES = {
    0: capsule(3.0, 0.4, 8),
    1: torus(1.0, 0.4, 14, 6),
    2: chain_of_tori(2, step=0.35),
    4: chain_of_tori(4, step=0.35),
}


def cycles_and_components(mesh, positions):
    graph = collapse_mesh(mesh.with_vertices(positions), mesh)
    skeleton = Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)))
    assert set(graph.node_of_vertex) == set(range(len(graph.kept)))
    return skeleton.cycle_rank, skeleton.n_components


@pytest.mark.parametrize("genus", MESHES)
@pytest.mark.parametrize("kind", POSITIONS)
def test_surgery_keeps_every_tunnel_on_any_positions(genus, kind):
    mesh = MESHES[genus]
    assert mesh.genus == genus
    for seed in range(3):
        positions = POSITIONS[kind](mesh.vertices, np.random.default_rng(seed))
        assert cycles_and_components(mesh, positions) == (genus, 1)


@pytest.mark.parametrize(("kind", "seed"), [("squeezed", 11), ("on a line", 15), ("on a grid", 46), ("scattered", 78)])
def test_surgery_goes_on_where_no_edge_may_collapse_and_none_is_free(kind, seed):
    # these come down to a torus of a few vertices, each of whose edges would close the tunnel
    mesh = torus(1.0, 0.6, 20, 16)
    positions = POSITIONS[kind](mesh.vertices, np.random.default_rng(seed))
    assert cycles_and_components(mesh, positions) == (1, 1)


@pytest.mark.parametrize("genus", [0, 1])
def test_surgery_ends_where_all_vertices_are_one_point(genus):
    assert cycles_and_components(MESHES[genus], np.zeros(MESHES[genus].vertices.shape)) == (genus, 1)


@pytest.mark.parametrize(("genus", "noise"), [(1, 0.5), (2, 1.0)])
def test_skeletons_of_surfaces_that_cut_themselves_keep_their_handles(genus, noise):
    mesh = MESHES[genus]
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    height = noise * np.linalg.norm(end - start, axis=1).mean()
    heights = height * np.random.default_rng(0).normal(size=mesh.vertices.shape)
    skeleton = skeletonize(mesh.with_vertices(mesh.vertices + heights))
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, genus)
