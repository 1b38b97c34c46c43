"""The queries of the search tree let other threads run, and two threads at once get the results of one."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import lbskel
from lbskel import _kernels
from lbskel.geometry.bvh import build_aabb_tree
from lbskel.shapes import torus


@pytest.fixture(scope="module")
def big_ring():
    """A torus of 40,000 faces."""
    return torus(1.0, 0.3, 200, 100)


@pytest.mark.skipif(_kernels.is_slow(), reason="kernels are not compiled")
def test_another_thread_runs_during_a_query(big_ring):
    """With a switch interval longer than the test, another thread runs only where the kernel lets it."""
    tree = build_aabb_tree(big_ring.vertices, big_ring.faces)
    points = np.tile(big_ring.vertices * 0.99, (10, 1))  # 200,000, some tenths of a second
    interval = sys.getswitchinterval()
    try:
        sys.setswitchinterval(100.0)
        assert any(runs_during(lambda: tree.winding_numbers(points)) for _ in range(10))  # others may use the processor
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


def test_two_threads_at_once_get_the_results_of_one(ring, rod):
    expected = [lbskel.skeletonize(mesh) for mesh in (ring, rod)]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lbskel.skeletonize, [ring, rod]))
    for skeleton, other in zip(found, expected, strict=True):
        assert np.array_equal(skeleton.nodes, other.nodes)
        assert np.array_equal(skeleton.node_of_vertex, other.node_of_vertex)
