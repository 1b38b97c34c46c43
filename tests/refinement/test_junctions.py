"""Junctions go where their branches point; two that all branches lead past are one, and others stay two."""

import itertools

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import recenter
from lbskel.refinement.centerlines import SectionCenters, _is_continuous, branch_of_node, find_section_centers
from lbskel.refinement.junctions import merge_junctions_by_axes, place_junctions
from lbskel.refinement.radii import inscribed_radii
from lbskel.shapes import chain_of_tori, sphere
from lbskel.shapes.isosurface import marching_cubes, project
from lbskel.shapes.round_cones import solid_of


def meshed(branches, step=0.04):
    solid = solid_of(branches)
    raw = marching_cubes(solid, step)
    return Mesh(project(solid, raw.vertices, step=step), raw.faces)


def graph(mesh, places, paths, spacing=0.07):
    """Straight paths between named places, evenly sampled, with the vertices of the mesh given to the nearest node."""
    index = {name: k for k, name in enumerate(places)}
    nodes, edges = [np.asarray(place, dtype=float) for place in places.values()], []
    for a, b in paths:
        start, end = nodes[index[a]], nodes[index[b]]
        n_pieces = max(1, round(np.linalg.norm(end - start) / spacing))
        chain = [index[a], *range(len(nodes), len(nodes) + n_pieces - 1), index[b]]
        nodes += [start + (end - start) * k / n_pieces for k in range(1, n_pieces)]
        edges += list(itertools.pairwise(chain))
    nodes = np.array(nodes)
    nearest = np.linalg.norm(mesh.vertices[:, None] - nodes, axis=2).argmin(axis=1)
    return inscribed_radii(Skeleton(nodes, np.array(edges), np.zeros(len(nodes)), nearest), Surface(mesh))


RADIUS = 0.12
ENDS = {f"end {k}": 1.2 * np.array([np.cos(a), np.sin(a), 0.3]) for k, a in enumerate(2 * np.pi * np.arange(4) / 4)}
FOOT = {"foot": np.array([0, 0, -1.0])}


@pytest.fixture(scope="module")
def star():
    """Four arms and a foot that all meet at the origin."""
    return meshed([([np.zeros(3), end], RADIUS) for end in [*ENDS.values(), *FOOT.values()]])


def star_graph(mesh, center, other=None):
    """The arms from one contracted junction, or two of them and the foot from one and two from another."""
    second = "center" if other is None else "other"
    places = {"center": center, **({} if other is None else {"other": other}), **ENDS, **FOOT}
    paths = [("center", "end 0"), ("center", "end 1"), (second, "end 2"), (second, "end 3"), ("center", "foot")]
    return graph(mesh, places, paths + ([] if other is None else [("center", "other")]))


def test_axes_are_known_along_the_arms_and_not_where_they_meet(star):
    skeleton = star_graph(star, np.zeros(3))
    axes = find_section_centers(skeleton, Surface(star))
    far = np.linalg.norm(skeleton.nodes, axis=1)
    assert axes.is_known[(far > 0.4) & (skeleton.degrees == 2)].all()
    assert not axes.is_known[far < 0.8 * RADIUS].any()
    assert np.array_equal(branch_of_node(skeleton) < 0, skeleton.degrees >= 3)


def test_a_branch_is_left_where_its_sections_leap():
    """Sections of two fingers grown together lie between them: most of a branch's are both's, so its tip is asked."""
    k = np.arange(12)
    nodes = np.concatenate([np.stack([k / 4, 0 * k, 0 * k], axis=1), [[-1, 0, 0], [0, 1, 0]]])
    skeleton = Skeleton(nodes, [*itertools.pairwise(k), (0, 12), (0, 13)], np.full(14, 0.3), np.zeros(1))
    good, even = skeleton.degrees == 2, np.full(14, 0.3)
    between, wide = np.array(nodes), np.where(k < 3, 0.5, 0.3)
    between[1:8, 1] = 0.3
    assert np.flatnonzero(_is_continuous(skeleton, good, even, nodes)).tolist() == [*range(1, 11)]
    assert np.flatnonzero(_is_continuous(skeleton, good, even, between)).tolist() == [8, 9, 10]
    assert np.flatnonzero(_is_continuous(skeleton, good, np.append(wide, [0, 0]), nodes)).tolist() == [*range(3, 11)]


@pytest.mark.parametrize("shift", [[0.1, 0.05, 0.02], [0, 0, 0.15], [-0.08, 0, -0.08]])
def test_a_junction_goes_to_where_its_branches_meet(star, shift):
    skeleton = star_graph(star, np.array(shift))
    axes = place_junctions(skeleton, find_section_centers(skeleton, Surface(star)), Surface(star))
    # sections of oblique paths are off by a few hundredths
    assert np.linalg.norm(axes.positions[skeleton.junctions]) < 0.25 * np.linalg.norm(shift)


@pytest.mark.parametrize("degrees", [45.0, 11.5, 0.1])
def test_a_junction_keeps_its_place_only_where_its_branches_tell_none(degrees):
    """Two exact axes that cross a unit beyond a contracted place: steeply, or so flatly that it says little."""
    mesh, tilt = sphere(3), np.tan(np.radians(degrees))
    arms = [[-k / 10, sign * tilt * (1 + k / 10), 0] for sign in (-1, 1) for k in range(3, 8)]
    edges = [[0, 1], [0, 6], [0, 11], *([k, k + 1] for k in (1, 2, 3, 4, 6, 7, 8, 9))]
    skeleton = Skeleton([[0, 0, 0], *arms, [0, 0, 0.1]], edges, np.full(12, 0.1), np.zeros(1))
    axes = SectionCenters(np.arange(12) % 11 > 0, skeleton.nodes)
    placed = place_junctions(skeleton, axes, Surface(Mesh(3 * mesh.vertices, mesh.faces))).positions[0]
    told, asked = 2 * np.sin(np.radians(degrees)) ** 2, 0.02 * 4  # the curvature along x, and a fiftieth of the sum
    assert placed == pytest.approx([told**2 / (told**2 + asked**2), 0, 0], abs=1e-9)


def test_two_junctions_to_which_all_branches_lead_alike_become_one(star):
    skeleton = star_graph(star, np.array([0.07, 0.07, 0.02]), np.array([-0.07, -0.07, 0.02]))
    assert len(skeleton.junctions) == 2
    gathered = merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(star)), Surface(star))
    assert (len(gathered.junctions), len(gathered.tips), gathered.cycle_rank) == (1, 5, 0)
    assert np.linalg.norm(gathered.nodes[gathered.junctions]) < 0.5 * RADIUS
    assert len(gathered.node_of_vertex) == len(star.vertices)
    refined = recenter(gathered, Surface(star))
    assert np.linalg.norm(refined.nodes[refined.junctions]) < 0.3 * RADIUS


def test_two_junctions_with_branches_of_their_own_stay_two():
    a, b = np.array([-0.3, 0, 0]), np.array([0.3, 0, 0])
    ends = {"p": a + [-0.2, 1, 0], "q": a + [-0.2, -1, 0], "r": b + [0.2, 1, 0], "s": b + [0.2, -1, 0]}
    mesh = meshed([([a, b], RADIUS), *(([a if k in "pq" else b, end], RADIUS) for k, end in ends.items())])
    paths = [("a", "b"), ("a", "p"), ("a", "q"), ("b", "r"), ("b", "s")]
    skeleton = graph(mesh, {"a": a, "b": b, **ends}, paths)
    assert merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(mesh)), Surface(mesh)) is skeleton


def test_gathering_closes_no_loop():
    mesh = chain_of_tori(2, step=0.12)
    t = np.pi * np.arange(2, 39) / 20
    loops = [np.stack([x + np.cos(t + s), np.sin(t + s), 0 * t], axis=1) for x, s in ((0, 0), (2, np.pi))]
    nodes = np.concatenate([[[0.95, 0.0, 0.0], [1.05, 0.0, 0.0]], *loops])
    first = np.arange(2, 39)
    chains = [*itertools.pairwise(first), *itertools.pairwise(first + 37)]
    edges = [[0, 1], [0, 2], [0, 38], [1, 39], [1, 75], *chains]
    nearest = np.linalg.norm(mesh.vertices[:, None] - nodes, axis=2).argmin(axis=1)
    skeleton = inscribed_radii(Skeleton(nodes, np.array(edges), np.zeros(len(nodes)), nearest), Surface(mesh))
    gathered = merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(mesh)), Surface(mesh))
    assert (gathered.cycle_rank, gathered.n_components) == (2, 1)
