"""Kernels let other threads run, and other threads and processes get the results of one."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from multiprocessing import get_all_start_methods, get_context

import numpy as np
import pytest

import lbskel
from lbskel import _kernels
from lbskel._kernels.connectivity import component_roots, neighbor_sums
from lbskel._kernels.delaunay_flips import cotangents
from lbskel._kernels.dijkstra import ShortestPaths
from lbskel._kernels.number_parsing import parse_decimals
from lbskel._kernels.triangles import integrals
from lbskel.geometry.bvh import build_aabb_tree
from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.graphs import weighted_graph
from lbskel.shapes import torus


@pytest.fixture(scope="module")
def big_ring():
    """A torus of 40,000 faces."""
    return torus(1.0, 0.3, 200, 100)


def search_of(mesh):
    """Shortest paths along the edges, each of length 1."""
    both = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
    graph = weighted_graph(both, np.ones(len(both)), len(mesh.vertices))
    return ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)


# of some tenths of a second each
CALLS = {
    "winding numbers": lambda ring: partial(
        build_aabb_tree(ring.vertices, ring.faces).winding_numbers, np.tile(ring.vertices * 0.99, (10, 1))
    ),
    "integrals": lambda ring: partial(integrals, ring.vertices, np.tile(ring.faces, (100, 1))),
    "components": lambda ring: partial(component_roots, np.tile(ring.edges, (100, 1)), np.zeros(20_000, np.int64)),
    "neighbor sums": lambda ring: partial(neighbor_sums, np.tile(ring.edges, (100, 1)), ring.vertices),
    "sections": lambda ring: partial(cross_sections, ring, ring.vertices[::10], np.tile([0.0, 0, 1], (2000, 1))),
    "paths": lambda ring: partial(search_of(ring).distances, np.arange(20)),
    "numbers": lambda ring: partial(parse_decimals, b"0.125 " * 3_000_000),
    "cotangents": lambda ring: partial(cotangents, np.ones(30_000_000), np.empty(30_000_000)),
}


@pytest.mark.skipif(_kernels.is_slow(), reason="kernels are not compiled")
@pytest.mark.parametrize("name", CALLS)
def test_another_thread_runs_during_a_call(big_ring, name):
    """With a switch interval longer than the test, another thread runs only where the kernel lets it."""
    call = CALLS[name](big_ring)
    interval = sys.getswitchinterval()
    try:
        sys.setswitchinterval(100.0)
        assert any(runs_during(call) for _ in range(10))  # others may use the processor
    finally:
        sys.setswitchinterval(interval)


def runs_during(function):
    """Whether a thread that waits for the interpreter gets it during a call."""
    gate, seen = threading.Event(), []
    other = threading.Thread(target=lambda: gate.wait() and seen.append(True))
    other.start()
    gate.set()
    function()
    has_run = bool(seen)
    other.join()
    return has_run


def test_threads_that_share_a_search_get_the_results_of_one(big_ring):
    search, sources = search_of(big_ring), np.arange(8)
    expected = search.distances(sources)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(search.distances, sources.reshape(-1, 1)))
    assert np.array_equal(np.concatenate(found), expected)


def test_queries_in_threads_have_the_results_of_one(monkeypatch):
    monkeypatch.setattr("lbskel.geometry.deadline.SLICE", 200)  # of the points, of which each thread has several
    mesh = torus(1.0, 0.3, 80, 40)
    points, normals = 0.9 * mesh.vertices, np.tile([0.0, 0, 1], (len(mesh.vertices), 1))
    tree = mesh.aabb_tree
    queries = [
        lambda: vars(cross_sections(mesh, points, normals)).values(),
        lambda: tree.nearest(points),
        lambda: tree.first_hits(points, -normals),
        lambda: (tree.winding_numbers(points),),
    ]
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    expected = [list(query()) for query in queries]
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    for query, arrays in zip(queries, expected, strict=True):
        assert all(np.array_equal(array, other) for array, other in zip(query(), arrays, strict=True))


def test_two_threads_at_once_get_the_results_of_one(ring, rod):
    expected = [lbskel.skeletonize(mesh) for mesh in (ring, rod, ring)]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lbskel.skeletonize, [ring, rod, ring]))
    for skeleton, other in zip(found, expected, strict=True):
        assert np.array_equal(skeleton.nodes, other.nodes)
        assert np.array_equal(skeleton.node_of_vertex, other.node_of_vertex)


@pytest.mark.parametrize("method", get_all_start_methods())
def test_a_process_gets_the_result_of_its_parent(ring, method):
    """However it is started; a fork has the state of the libraries that the parent has used."""
    expected = lbskel.skeletonize(ring)
    with get_context(method).Pool(1) as pool:
        found = pool.apply(lbskel.skeletonize, [ring])
    assert np.array_equal(found.nodes, expected.nodes)
    assert np.array_equal(found.node_of_vertex, expected.node_of_vertex)
