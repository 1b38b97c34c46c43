"""Parts of shapes with known limbs, their table, invariances, and meshes with faults."""

import tracemalloc

import numpy as np
import pytest
from helpers import triangle_soup, with_reversed_faces, without_faces
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

import lbskel
from lbskel import Mesh, MeshError, UnknownChoice, segment, skeletonize
from lbskel.applications import boundary_smoothing, segmentation
from lbskel.applications.face_graph import FaceGraph, face_graph
from lbskel.applications.segmentation import MAX_SHIFT, REACH, _costs, _edge_costs, _near, _nodes_of_vertices
from lbskel.shapes import SHAPES, capsule, make, mesh_solid


def rand_index(a, b):
    """Share of the pairs of faces on which two segmentations agree: Rand 1971, doi 10.1080/01621459.1971.10482356."""
    table = np.zeros((a.max() + 1, b.max() + 1))
    np.add.at(table, (a, b), 1)

    def pairs(counts):
        return (counts * (counts - 1) / 2).sum()

    total = pairs(np.array([len(a)]))
    return 1 - (pairs(table.sum(axis=1)) + pairs(table.sum(axis=0)) - 2 * pairs(table)) / total


@pytest.fixture(scope="module")
def limbs():
    """A body with six limbs: the mesh, its skeleton, and the true part of each face."""
    solid = SHAPES["limbs"]()
    mesh = mesh_solid(solid, n_vertices=1500)
    return mesh, skeletonize(mesh), solid.nearest_branches(mesh.vertices[mesh.faces].mean(axis=1))


@pytest.mark.parametrize("thickness", ["inscribed", "shape_diameter"])
def test_the_limbs_are_the_parts(limbs, thickness):
    mesh, skeleton, truth = limbs
    parts = segment(mesh, skeleton, thickness=thickness)
    assert len(parts) == 7
    assert rand_index(parts.part_of_face, truth) > 0.95


def test_an_edge_costs_its_length_and_less_where_the_surface_is_concave():
    turns = np.array([-1.0, 0.0, 1.0])  # over half a local radius: two radians per radius
    graph = FaceGraph(np.array([[0, 1], [1, 2], [2, 3]]), np.full(3, 1.5), turns, np.full(3, 1.5))
    assert _edge_costs(graph, np.full(4, 3.0)) == pytest.approx([0.5, 0.5, 0.5 / 3])


def test_the_table_sums_to_the_mesh_and_the_skeleton(limbs):
    mesh, skeleton, _ = limbs
    parts = segment(mesh, skeleton)
    assert parts.n_faces.sum() == len(mesh.faces)
    assert parts.area.sum() == pytest.approx(mesh.area)
    assert parts.volume.sum() == pytest.approx(mesh.volume)
    assert parts.length.sum() == pytest.approx(skeleton.length)
    assert parts.to_csv().splitlines()[0] == "part,n_faces,area,volume,length,mean_radius"
    assert len(parts.to_csv().splitlines()) == 8
    body = parts.part_of_face[np.argmin(np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1) - [0, 0, 0.3], axis=1))]
    assert parts.mean_radius.argmax() == body


def test_every_part_is_connected(limbs):
    mesh, skeleton, _ = limbs
    label, graph = segment(mesh, skeleton).part_of_face, face_graph(mesh)
    for part in range(label.max() + 1):
        faces = np.flatnonzero(label == part)
        inside = graph.pairs[(label[graph.pairs] == part).all(axis=1)]
        assert Mesh(np.zeros((len(label), 3)), np.column_stack([inside, inside[:, 0]])).n_components == 1
        assert np.array_equal(np.unique(inside), faces)


def test_the_same_mesh_has_the_same_parts_again(limbs):
    mesh, skeleton, _ = limbs
    again = Mesh(np.array(mesh.vertices), np.array(mesh.faces))
    assert np.array_equal(segment(mesh, skeleton).part_of_face, segment(again, skeletonize(again)).part_of_face)


def test_labels_diffuse_over_the_width_of_a_region_that_is_wider_than_its_branch(monkeypatch):
    rod = capsule(3.0, 0.4, 48)
    nodes = np.array([[0, 0, -1.5], [0, 0, -0.5], [0, 0, 0.5], [0, 0, 1.5]])
    region = np.searchsorted([-1.0, 0.0, 1.0], rod.vertices[:, 2])
    thin = lbskel.Skeleton(nodes, np.array([[0, 1], [1, 2], [2, 3]]), np.array([0.4, 0.4, 0.02, 0.02]), region)
    given = []
    monkeypatch.setattr(segmentation, "smooth_labels", lambda labels, *rest: given.append(rest[2]) or labels)
    segment(rod, thin)
    assert given[0].min() > 0.39  # of 0.4; the flat of a polygon's side is nearer to the axis by 0.2 %


def rods(n):
    """Rods side by side, each with a skeleton of ten nodes."""
    rod, z = capsule(3.0, 0.4, 8), np.linspace(-1.4, 1.4, 10)
    nodes = np.stack([np.repeat(2.0 * np.arange(n), 10), np.zeros(10 * n), np.tile(z, n)], axis=1)
    path = np.arange(10 * n).reshape(n, 10)
    V = np.concatenate([rod.vertices + [2.0 * k, 0, 0] for k in range(n)])
    F = np.concatenate([rod.faces + k * len(rod.vertices) for k in range(n)])
    edges = np.stack([path[:, :-1].ravel(), path[:, 1:].ravel()], axis=1)
    return Mesh(V, F), lbskel.Skeleton(nodes, edges, np.full(10 * n, 0.4), cKDTree(nodes).query(V)[1])


def test_memory_is_proportional_to_the_number_of_faces_however_many_parts_there_are():
    peaks = []
    for n in (1, 20, 40):  # the first imports what is needed
        mesh, skeleton = rods(n)
        tracemalloc.start()
        parts = segment(mesh, skeleton)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert parts.n_faces.tolist() == [len(mesh.faces) // n] * n
    assert peaks[2] < 2.2 * peaks[1]  # 3.0 with a cost of every part at every face


def test_costs_are_those_of_all_parts_within_reach():
    """Against a matrix of all distances: a part is far from most nodes, and no face is far from all parts."""
    rng = np.random.default_rng(0)
    near = np.where(rng.random((30, 8)) < 0.3, 14 * rng.random((30, 8)), np.inf)
    near[np.arange(30), rng.integers(8, size=30)] = 0.1
    near[near > REACH * MAX_SHIFT] = np.inf
    corners, sizes = rng.integers(30, size=(200, 3)), rng.random(200)
    cost = np.minimum(near, REACH * MAX_SHIFT)[corners].mean(axis=1)
    distances = csr_array(np.where(np.isfinite(near), near, 0))
    labels, found = _costs(distances, _near(distances, corners), corners, sizes)
    assert labels.tolist() == cost.argmin(axis=1).tolist()
    expected = cost <= np.maximum(cost.min(axis=1), MAX_SHIFT)[:, None]
    assert found.nnz == expected.sum()
    assert found.toarray() == pytest.approx(np.where(expected, sizes[:, None] * cost, 0))


def test_how_many_parts_are_treated_together_does_not_matter(limbs, monkeypatch):
    mesh, skeleton, _ = limbs
    expected = segment(mesh, skeleton)
    monkeypatch.setattr(segmentation, "PARTS_AT_ONCE", 2)
    monkeypatch.setattr(boundary_smoothing, "COLUMNS", 2)
    assert np.array_equal(segment(mesh, skeleton).part_of_face, expected.part_of_face)


def test_scale_and_place_do_not_matter(limbs):
    mesh, skeleton, _ = limbs
    from dataclasses import replace

    moved = replace(skeleton, nodes=1e-3 * skeleton.nodes + 5, radii=1e-3 * skeleton.radii)
    there = segment(mesh.with_vertices(1e-3 * mesh.vertices + 5), moved)
    assert (there.part_of_face != segment(mesh, skeleton).part_of_face).mean() < 0.01  # ties of rounded costs


@pytest.mark.parametrize("every", [1, 2])
@pytest.mark.parametrize("thickness", ["inscribed", "shape_diameter"])
def test_the_orientation_of_the_faces_does_not_matter_for_an_open_mesh(limbs, thickness, every):
    mesh = limbs[0]
    opened = without_faces(mesh, [0])
    skeleton = skeletonize(opened)
    turned = with_reversed_faces(opened, np.arange(0, len(opened.faces), every))
    expected, found = (segment(each, skeleton, thickness=thickness) for each in (opened, turned))
    assert len(found) == len(expected)
    # the cone of rays begins at the first edge of a face
    assert (found.part_of_face != expected.part_of_face).mean() <= (0.01 if thickness == "shape_diameter" else 0)
    assert found.volume == pytest.approx(expected.volume, rel=0.05)


def test_a_rod_is_one_part_also_as_a_soup():
    rod = capsule(3.0, 0.4, 10)
    soup = triangle_soup(rod)
    assert len(segment(rod, skeletonize(rod))) == len(segment(soup, skeletonize(soup))) == 1


def test_unknown_radii_degenerate_faces_and_wrong_input(rod):
    skeleton = skeletonize(rod)
    flat = Mesh(rod.vertices, np.concatenate([rod.faces, [[0, 1, 1]]]))
    unknown = lbskel.Skeleton(
        skeleton.nodes, skeleton.edges, np.full(len(skeleton.nodes), np.nan), skeleton.node_of_vertex
    )
    parts = segment(flat, unknown)
    assert parts.n_faces.tolist() == [len(flat.faces)]
    assert np.isnan(parts.mean_radius).all()
    assert parts.to_csv().splitlines()[1].endswith(",")
    known = np.arange(len(skeleton.nodes)) % 2 == 0
    some = lbskel.Skeleton(skeleton.nodes, skeleton.edges, np.where(known, 0.4, np.nan), skeleton.node_of_vertex)
    assert segment(flat, some).mean_radius == pytest.approx(0.4)
    with pytest.raises(MeshError, match="give the mesh that the skeleton was made from"):
        segment(capsule(3.0, 0.4, 12), skeleton)
    with pytest.raises(UnknownChoice, match="inscribed, shape_diameter"):
        segment(rod, skeleton, thickness="mean")


def test_a_tip_is_no_part_in_large_units():
    """Above 2^53, adding one changes no length."""
    mesh = make("octopus", n_vertices=1500).mesh
    large = mesh.with_vertices(mesh.vertices * 2.0**60)
    parts = [segment(each, skeletonize(each)).part_of_face for each in (mesh, large)]
    assert np.array_equal(*parts)


def test_roots_of_fingers_belong_to_the_nearest_of_them():
    """Where fingers join, the map from vertices to nodes may take one for another."""
    fingers = [np.array([[0, 0, 0], [0, 0, 1.0]]) + [x, 0, 0] for x in (-0.2, 0.2)]
    nodes = np.vstack([[[0, 0, -1.0]], [[0, 0, -0.2]], *fingers])
    edges = np.array([[0, 1], [1, 2], [2, 3], [1, 4], [4, 5]])
    region = np.array([5, 5, 5, 0])  # of the first two, the wrong finger
    skeleton = lbskel.Skeleton(nodes, edges, np.full(6, 0.2), node_of_vertex=region)
    surface = Mesh([[-0.3, 0, 1], [-0.25, 0, 0.4], [0.3, 0, 1], [0, 0.3, -1]], [[0, 1, 2], [1, 2, 3]])
    parts = np.array([0, 0, 1, 1, 2, 2])
    near, far = np.full((6, 3), 1.0), np.full((6, 3), REACH * MAX_SHIFT)
    radii = skeleton.radii
    assert _nodes_of_vertices(skeleton, radii, surface, parts, near).tolist() == [3, 2, 5, 0]
    assert _nodes_of_vertices(skeleton, radii, surface, parts, far).tolist() == region.tolist()
    thick = np.where(parts == 2, 1.5, 0.2)  # a trunk, on which a thin limb lies
    assert _nodes_of_vertices(skeleton, thick, surface, parts, near).tolist() == region.tolist()


def test_patches_are_told_from_parts_with_an_end_of_the_skeleton(monkeypatch):
    mesh = lbskel.shapes.make("dinosaur", n_vertices=1500).mesh
    seen = []
    monkeypatch.setattr(segmentation, "merge_flat_parts", lambda labels, *rest: seen.append(rest[0]) or labels * 0)
    assert len(segment(mesh, skeletonize(mesh))) == 1
    assert (np.count_nonzero(seen[0]), len(seen[0])) == (6, 7)  # not the body between the legs
