"""Centering: nodes on the centerlines of their branches."""

import numpy as np
import pytest
from helpers import loop_in, path_in

from lbskel import Skeleton, collapse_mesh, contract
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import _on_loops_without_sections, fit_to_centerlines, recenter
from lbskel.refinement.centerlines import SectionCenters
from lbskel.shapes import capsule, torus


def test_a_crooked_path_in_a_capsule_goes_to_its_axis():
    mesh = capsule(4.0, 0.5, 32)
    rng = np.random.default_rng(0)
    z = np.linspace(-2, 2, 17)
    off = path_in(mesh, np.stack([0.1 * rng.standard_normal(17), 0.1 * rng.standard_normal(17), z], axis=1))
    skeleton = recenter(off, Surface(mesh))
    # sections are nearly circles round the axis; the smoothing and the free ends leave a hundredth of the radius
    assert np.hypot(*skeleton.nodes[1:-1, :2].T).max() < 0.01 * 0.5


def test_a_bare_loop_goes_to_the_circle_of_its_torus():
    mesh = torus(1.0, 0.3, 64, 24)
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    loop = np.stack([0.9 * np.cos(angle), 0.9 * np.sin(angle), 0.1 + 0 * angle], axis=1)
    skeleton = recenter(loop_in(mesh, loop), Surface(mesh))
    # sections of a torus are centered r^2 / (8 R) inside at most; the smoothing of 24 nodes adds as much again
    assert np.abs(np.hypot(*skeleton.nodes[:, :2].T) - 1).max() < 0.03
    assert np.abs(skeleton.nodes[:, 2]).max() < 0.01


def test_recentering_moves_a_contracted_shape_nearer_to_its_axis():
    mesh = torus(1.0, 0.3, 64, 24)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    raw = Skeleton(graph.nodes, graph.edges, np.full(len(graph.nodes), 0.3), graph.node_of_vertex)
    error = [np.abs(np.hypot(*s.nodes[:, :2].T) - 1).mean() for s in (raw, recenter(raw, Surface(mesh)))]
    assert error[1] < 0.5 * error[0]


def test_known_centers_on_a_line_are_reproduced_and_a_gap_is_bridged_straight():
    mesh = capsule(4.0, 0.5, 32)
    z = np.linspace(-2, 2, 17)
    off = path_in(mesh, np.stack([0.1 * np.cos(9 * z), 0 * z, z], axis=1))
    is_known = (np.abs(z) > 0.6) & (np.abs(z) < 1.9)
    on_axis = np.where(is_known[:, None], off.nodes * [0, 0, 1], off.nodes)
    fitted = fit_to_centerlines(off, SectionCenters(is_known, on_axis), Surface(mesh))
    # only the tips, which are between no two sections, keep three thousandths of their positions
    assert np.abs(fitted.nodes[:, 0]).max() < 0.01 * 0.1 + 1e-3
    assert np.abs(fitted.nodes[np.abs(z) < 0.6, 0]).max() < 1e-4
    assert fitted.nodes[:, 2] == pytest.approx(z, abs=0.01)


def test_a_bend_is_smoothed_by_the_stated_weight():
    """Of three sections the middle one is off the line by h; weights of 1, and 1/2 of the bend, share it."""
    mesh, h = capsule(4.0, 0.5, 32), 0.1
    path = path_in(mesh, [[0, 0, -1], [h, 0, 0], [0, 0, 1]])
    fitted = fit_to_centerlines(path, SectionCenters(np.ones(3, dtype=bool), path.nodes), Surface(mesh))
    # minimize |x - t|^2 + (x0 - 2 x1 + x2)^2 / 2: x = t - B^T B x / 2, so B x = B t / (1 + B B^T / 2) = B t / 4
    assert fitted.nodes[:, 0] == pytest.approx([h / 4, h - h / 2, h / 4], rel=1e-9)


def test_a_gap_that_would_leave_the_surface_stays_parallel_to_its_course():
    """In a thin torus only the first sections of half a turn are known: their tangent leaves the tube."""
    mesh = torus(1.0, 0.08, 96, 24)
    angle = np.linspace(0, np.pi, 31)
    arc = path_in(mesh, np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1))
    centers = SectionCenters(angle < 0.6, arc.nodes + np.where(angle < 0.6, 0.02, 0)[:, None] * [0, 0, 1])
    fitted = fit_to_centerlines(arc, centers, Surface(mesh))
    assert Surface(mesh).contains(fitted.nodes).all()
    assert np.hypot(*fitted.nodes[:, :2].T) == pytest.approx(1, abs=0.02)


def test_a_loop_without_sections_keeps_its_positions():
    """A handle that is too small for sections, at a rod whose surface has no tunnel to tell it from."""
    mesh = capsule(4.0, 0.5, 32)
    rod = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-2, 2, 9)], axis=1))
    nodes = np.concatenate([rod.nodes, [[0.1, 0.1, 0], [0.2, 0, 0], [0.1, -0.1, 0]]])
    edges = np.concatenate([rod.edges, [[4, 9], [9, 10], [10, 11], [11, 4]]])
    looped = Skeleton(nodes, edges, np.full(12, 0.5), rod.node_of_vertex)
    fitted = fit_to_centerlines(looped, SectionCenters(np.arange(12) < 9, nodes), Surface(mesh))
    assert fitted.edge_lengths.min() > 0.05


def test_only_loops_without_any_section_keep_their_positions():
    """Two loops at the ends of a path, nodes 0 to 3 and 5 to 8; a section of the second is known."""
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [4, 5], [5, 6], [6, 7], [7, 8], [8, 5]]
    nodes = np.random.default_rng(0).random((9, 3))
    centers = SectionCenters(np.arange(9) == 7, nodes)
    is_on_loop = _on_loops_without_sections(Skeleton(nodes, edges, np.ones(9)), centers)
    assert np.flatnonzero(is_on_loop).tolist() == [1, 2, 3]


def test_a_gap_does_not_take_a_short_cut_past_its_tunnel():
    """The ends of a path once around a thick torus see each other, but not around its tunnel."""
    mesh = torus(1.0, 0.4, 96, 32)
    angle = np.linspace(0.2, 2 * np.pi - 0.2, 41)
    ring = path_in(mesh, np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1))
    fitted = fit_to_centerlines(ring, SectionCenters(np.arange(41) % 40 < 2, ring.nodes), Surface(mesh))
    # the spline shrinks a circle of which all but four of 41 nodes weigh little
    assert fitted.nodes[20, 0] == pytest.approx(-1, abs=0.2)
    assert Surface(mesh).contains(fitted.nodes).all()


def test_a_junction_stays_at_its_position():
    mesh = capsule(4.0, 0.5, 32)
    nodes = np.array([[0, 0, 0], [0, 0, 1], [0, 0, -1], [0.3, 0, 0], [0.05, 0, 0]])
    tee = Skeleton(nodes, [[0, 1], [0, 2], [0, 4], [4, 3]], np.ones(5), np.zeros(len(mesh.vertices)))
    positions = nodes + [[0.1, 0, 0], *np.zeros((4, 3))]
    fitted = fit_to_centerlines(tee, SectionCenters(np.zeros(5, dtype=bool), positions), Surface(mesh))
    assert fitted.nodes[0] == pytest.approx([0.1, 0, 0], abs=1e-3)
