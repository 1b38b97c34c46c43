"""Kernels give the same whether they are compiled or not."""

import importlib
import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Delaunay

from lbskel import _kernels as kernels
from lbskel._kernels import dijkstra as ways_module
from lbskel.contraction import coarsening
from lbskel.contraction.coarsening import Coarsened, coarsen
from lbskel.geometry import bvh as boxes
from lbskel.geometry import cross_sections as sections
from lbskel.geometry import mesh as mesh_module
from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.mesh import Mesh
from lbskel.io import text as reading
from lbskel.io.text import parse_numbers
from lbskel.operators import assembly, masses
from lbskel.operators import corner_angles as corners
from lbskel.operators import intrinsic_triangulation as flips
from lbskel.operators.intrinsic_delaunay import intrinsic_delaunay
from lbskel.operators.intrinsic_triangulation import IntrinsicTriangulation, delaunay, half_edge_twins
from lbskel.operators.masses import voronoi_mass
from lbskel.refinement import region_map as mapping
from lbskel.refinement.region_map import is_in_largest_piece, reassign_to_nearest_node
from lbskel.shapes import make
from lbskel.skeleton.skeleton import Skeleton

roughness_module = importlib.import_module("lbskel.preprocess.noise")  # its function hides it

FOLDER = Path(kernels.__file__).parent
NAMES = sorted(
    path.stem for path in FOLDER.glob("*.py") if "cython" in path.read_text(encoding="utf-8").split("\n", 1)[0]
)


def uncompiled(name):
    """A kernel run as plain Python."""
    spec = importlib.util.spec_from_file_location(f"uncompiled_{name}", FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def mesh():
    return make("limbs", n_vertices=600).mesh


def nearest():
    points = np.random.default_rng(0).normal(size=(40, 3))
    return mesh().boxes.nearest(points)


def rays():
    ways = np.random.default_rng(1).normal(size=(40, 3))
    return *mesh().boxes.first_hits(0.1 * ways[::-1], ways), mesh().boxes.windings(0.3 * ways)


def curves():
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(12, 3))
    found = cross_sections(
        mesh(), 0.3 * rng.normal(size=(12, 3)), normals / np.linalg.norm(normals, axis=1, keepdims=True)
    )
    return found.surrounds, found.areas, found.lengths, found.radii, found.centroids


def flipped():
    faces = mesh().faces
    lengths = 1 + np.random.default_rng(3).random(faces.shape) * 0.9
    lengths.ravel()[np.maximum(half_edge_twins(faces), np.arange(faces.size))] = (
        lengths.ravel()
    )  # the same on both sides
    lengths = np.maximum(lengths.ravel(), lengths.ravel()[half_edge_twins(faces)]).reshape(-1, 3)
    result = delaunay(IntrinsicTriangulation(faces, lengths, half_edge_twins(faces)))
    return result.faces, result.lengths, result.twins


def coarsened():
    n = len(mesh().vertices)
    result = coarsen(Coarsened(mesh(), np.arange(n), np.arange(n), np.ones(n)), np.full(n, 0.15))
    return result.mesh.vertices, result.mesh.faces, result.vertex_map.indices


def regions():
    rng = np.random.default_rng(4)
    n = len(mesh().vertices)
    nodes = rng.normal(size=(9, 3))
    skeleton = Skeleton(nodes, np.stack([np.arange(8), np.arange(1, 9)], axis=1), np.ones(9), rng.integers(9, size=n))
    whole = is_in_largest_piece(rng.integers(3, size=n), mesh())
    sums = roughness_module.sums_beside(mesh().edges, rng.normal(size=(n, 2)))
    return (
        reassign_to_nearest_node(skeleton, mesh()).node_of_vertex,
        whole,
        sums,
        np.array([mesh().is_closed_manifold, mesh().n_components]),
    )


def triangles():
    measures = mesh_module.integrals(mesh().vertices, mesh().faces)
    return *corners.corners_of(mesh().vertices, mesh().faces), voronoi_mass(mesh()).diagonal(), *map(np.array, measures)


def assembled():
    faces = mesh().faces
    weights = np.random.default_rng(6).normal(size=faces.shape)
    weights[0] = 0  # places where nothing is left have no entry
    matrix = assembly.symmetric_matrix(faces, weights, np.arange(len(mesh().vertices)) % 7.0)
    return matrix.data, matrix.indices, matrix.indptr


def ways():
    edges = mesh().edges
    lengths = np.linalg.norm(np.diff(mesh().vertices[edges], axis=1)[:, 0], axis=1)
    graph = coo_array((lengths, edges.T), shape=2 * mesh().vertices.shape[:1])
    graph = (graph + graph.T).tocsr()
    return graph, np.array([0, 17, 230])


def searched():
    graph, sources = ways()
    search = ways_module.ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)
    kinds = np.ones(graph.shape[0], dtype=np.int8)
    kinds[400:], kinds[300:340] = 2, 0
    return search.distances(sources), *map(np.array, search.first_of(sources, kinds))


def test_shortest_ways_are_those_of_scipy():
    graph, sources = ways()
    far, length, way = searched()
    expected = dijkstra(graph, indices=sources)
    assert far == pytest.approx(expected, rel=1e-12)
    allowed = np.delete(np.arange(graph.shape[0]), np.arange(300, 340))
    there = dijkstra(graph[allowed][:, allowed], indices=np.searchsorted(allowed, sources)).min(axis=0)
    assert length == pytest.approx(there[allowed >= 400].min(), rel=1e-12)
    assert way[0] >= 400 > way[1:].max()
    assert way[-1] in sources
    steps = np.asarray(graph[way[1:], way[:-1]]).ravel()
    assert (steps > 0).all()
    assert steps.sum() == pytest.approx(length, rel=1e-12)


WORDS = "0 -0 1e5 -1.5E-300 1e400 .5 5. +3 123456789012345678 1234567890123456789 0.30000000000000004 nan -inf 2.675"
HALFWAY = (
    "9007199254740993 4503599627370497.5 900719925474099.25 1.0000000000000001110223024625156540423631668090820312"
)


def numbers():
    rng = np.random.default_rng(5)
    values = rng.normal(size=600) * 10.0 ** rng.integers(-9, 9, size=600)
    forms = ("{!r}", "{:.6f}", "{:.15e}", "{:.18f}", "{:.17g}")
    words = [form.format(value) for value in values.tolist() for form in forms]
    return (parse_numbers(" ".join([*words, WORDS, HALFWAY])),)


def test_numbers_are_those_of_python():
    words = [f"{value:.{digits}g}" for value in np.pi ** np.arange(-40, 40.0) for digits in range(1, 25)]
    words += [*WORDS.split(), *HALFWAY.split()]
    expected = np.array([float(word) for word in words])
    assert np.array_equal(parse_numbers(" \r\n\t".join(words)).view(np.int64), expected.view(np.int64))


@pytest.mark.parametrize("text", ["1 2 x", "1_0", "--1", "1..2", ".", "-", "1,2", "0x10", "1\0", "1e", "\u0661"])
def test_what_is_no_number_is_an_error(text):
    with pytest.raises(ValueError, match=r"number|convert"):
        parse_numbers(text)


CASES = {
    "assembly": (assembled, {assembly: ("symmetric",)}),
    "trees": (nearest, {boxes: ("halved", "nearest_places", "tree_of")}),
    "rays": (rays, {boxes: ("first_hits", "windings")}),
    "curves": (curves, {sections: ("Curves",)}),
    "flips": (flipped, {flips: ("cotangents", "flip_to_delaunay")}),
    "regions": (
        regions,
        {
            roughness_module: ("sums_beside",),
            mesh_module: ("fans", "pieces"),
            mapping: ("nearer_nodes", "pieces"),
        },
    ),
    "triangles": (
        triangles,
        {corners: ("corners_of",), masses: ("corners_of", "voronoi_of"), mesh_module: ("integrals",)},
    ),
    "ways": (searched, {ways_module: ("ShortestPaths",)}),
    "text": (numbers, {reading: ("numbers_in",)}),
    "collapses": (coarsened, {coarsening: ("independent_collapses", "short_edges")}),
}


def test_every_kernel_has_a_case():
    assert sorted(CASES) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_compiled_or_not_is_the_same(name, monkeypatch):
    if importlib.import_module(f"lbskel._kernels.{name}").__file__.endswith(".py"):
        pytest.skip("kernels were not compiled at installation")
    case, places = CASES[name]
    compiled = case()
    for module, functions in places.items():
        for function in functions:
            monkeypatch.setattr(module, function, getattr(uncompiled(name), function))
    with np.errstate(all="raise"):
        plain = case()
    for one, other in zip(compiled, plain, strict=True):
        assert np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")  # the same operations, in order


def test_curves_at_a_vertex_and_of_planes_that_are_none_come_to_an_end():
    at = mesh().vertices[mesh().boxes.order[:1]]
    points = np.concatenate([mesh().vertices[mesh().faces[:3, 0]], at, [[np.nan, 0, 0], [0, 0, 0]]])
    normals = np.array([[0, 0, 1.0]] * 5 + [[np.nan, 0, 0]])
    found = cross_sections(mesh(), points, normals)
    assert found.is_cut.tolist() == [True] * 4 + [False] * 2
    assert np.array_equal(found.centroids[4:], points[4:], equal_nan=True)


def test_what_is_no_place_does_not_disturb_others():
    points = np.tile([0.1, 0.2, 0.3], (6, 1))
    points[[1, 3, 4], 0] = np.nan, np.inf, np.inf
    distance, place = mesh().boxes.nearest(points)
    assert np.isfinite(distance).tolist() == [True, False, True, False, False, True]
    assert np.array_equal(place[0], place[2])
    assert np.array_equal(place[0], place[5])


def test_flips_leave_a_boundary_as_it_is():
    rng = np.random.default_rng(6)
    for _ in range(30):
        flat = rng.random((14, 2)) * [1, 0.05]
        faces = Delaunay(flat * [0.05, 1]).simplices.astype(np.int64)
        V = np.column_stack([flat, np.zeros(14)])
        turned = np.cross(V[faces[:, 1]] - V[faces[:, 0]], V[faces[:, 2]] - V[faces[:, 0]])[:, 2] < 0
        faces[turned] = faces[turned][:, ::-1]
        given = Mesh(V, faces)
        rim = np.sort(given.edges[given.faces_per_edge == 1], axis=1)
        lengths = np.linalg.norm(V[faces[:, [1, 2, 0]]] - V[faces[:, [2, 0, 1]]], axis=2)
        result = delaunay(IntrinsicTriangulation(faces, lengths, half_edge_twins(faces)))
        ends = np.sort(
            np.stack([result.faces[:, [1, 2, 0]], result.faces[:, [2, 0, 1]]], axis=2).reshape(-1, 2), axis=1
        )
        assert np.array_equal(np.unique(ends[result.twins < 0], axis=0), rim)
        assert result.lengths.shape == lengths.shape
        assert intrinsic_delaunay(given).stiffness.shape == (14, 14)
