"""Shapes of the catalog: topology, edge lengths, noise, and a truth that is the axis of the mesh."""

import sys
from functools import lru_cache

import igl
import numpy as np
import pytest

from lbskel.errors import MeshError, MissingDependency, UnknownChoice
from lbskel.shapes import SHAPES, VARIANTS, chain_of_tori, make, mesh_solid, solid_of
from lbskel.shapes.catalog import MAX_EDGE_LENGTH

# genus, number of tips, number of junctions
EXPECTED = {
    "limbs": (0, 6, 2),
    "tree": (0, 13, 10),
    "octopus": (0, 9, 1),
    "helix": (0, 2, 0),
    "knot": (1, 0, 0),
    "spiked_ring": (1, 5, 5),
    "ladder": (4, 4, 10),
    "cube_frame": (5, 0, 8),
    "dumbbell": (0, 2, 0),
    "hand": (0, 6, 1),
    "figure_eight": (2, 0, 1),
    "tripod": (0, 3, 1),
    "dinosaur": (0, 6, 2),
}

made = lru_cache(maxsize=None)(lambda name: make(name, **VARIANTS["coarse"]))


def _mean_edge(mesh):
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    return np.linalg.norm(end - start, axis=1).mean()


def test_the_table_of_this_test_names_every_shape():
    assert EXPECTED.keys() == SHAPES.keys()


@pytest.mark.parametrize("name", SHAPES)
def test_mesh_and_truth_have_the_expected_topology(name):
    shape = made(name)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.n_components, shape.truth.n_components) == (1, 1)
    assert shape.mesh.volume > 0
    assert len(np.unique(shape.mesh.faces)) == len(shape.mesh.vertices)
    assert (shape.truth.genus, shape.truth.n_tips, len(shape.truth.junctions)) == EXPECTED[name]
    assert shape.mesh.genus == shape.truth.genus


@pytest.mark.parametrize("name", SHAPES)
def test_coarse_meshes_have_few_vertices_and_even_edges(name):
    mesh = made(name).mesh
    assert 500 <= len(mesh.vertices) <= 2900
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    lengths = np.linalg.norm(end - start, axis=1)
    assert np.percentile(lengths, 95) < 2 * np.percentile(lengths, 5)  # the remesher allows 4/5 to 4/3 of its target
    assert lengths.mean() < 1.1 * MAX_EDGE_LENGTH * SHAPES[name]().radii.min()  # 5 % over the target


@pytest.mark.parametrize("name", SHAPES)
def test_every_vertex_is_on_the_surface(name):
    value = SHAPES[name]().distance(made(name).mesh.vertices, cutoff=0.01)
    assert np.abs(value).max() < 1e-8  # Newton's method ends at 1e-13, except in the flat saddles between fingers


@pytest.mark.parametrize("name", SHAPES)
def test_truth_is_inside_the_mesh_at_its_radius_from_the_surface(name):
    mesh, truth = made(name).mesh, made(name).truth
    points, radii = truth.sample(0.05)
    assert igl.fast_winding_number(mesh.vertices, mesh.faces, points).min() > 0.5
    distance = np.sqrt(igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)[0])
    # A triangle with edges l = 4/3 * 3/4 r inscribed in a sphere of radius r is sqrt(r^2 - l^2 / 3), 0.82 r, away from
    # the sphere's center; less where four triangles meet. Blending adds to the radius.
    assert (distance / radii).min() > 0.65
    assert (distance / radii).max() < 1.5
    tips = np.sqrt(igl.point_mesh_squared_distance(truth.nodes[truth.tips], mesh.vertices, mesh.faces)[0])
    assert (tips <= truth.radii[truth.tips]).all()


@pytest.mark.parametrize("name", SHAPES)
def test_every_tip_is_clear_of_the_branch_it_grows_from(name):
    truth = made(name).truth
    tips = set(truth.tips.tolist())
    for path in truth.branches:
        tip, trunk = (path[0], path[-1]) if path[0] in tips else (path[-1], path[0])
        if tip not in tips:
            continue
        length = np.linalg.norm(np.diff(truth.nodes[path], axis=0), axis=1).sum()
        assert length - truth.radii[trunk] > 1.5 * truth.radii[tip]


def test_the_number_of_vertices_is_near_the_target():
    assert len(make("knot").mesh.vertices) == pytest.approx(5000, rel=0.1)


def test_noise_displaces_along_the_normals_by_the_given_deviation_and_seed():
    clean, noisy = made("knot").mesh, make("knot", **VARIANTS["coarse"], noise=0.25).mesh
    assert np.array_equal(clean.faces, noisy.faces)
    moves = noisy.vertices - clean.vertices
    normals = igl.per_vertex_normals(clean.vertices, clean.faces)
    heights = (moves * normals).sum(axis=1)
    assert np.abs(moves - heights[:, None] * normals).max() < 1e-12
    # The standard deviation of 1,900 samples is known to 1 / sqrt(2 * 1900), 1.6 %; three of these.
    assert heights.std() == pytest.approx(0.25 * _mean_edge(clean), rel=0.05)
    assert not np.array_equal(noisy.vertices, make("knot", **VARIANTS["coarse"], noise=0.25, seed=1).mesh.vertices)


@pytest.mark.parametrize("options", [{}, {"noise": 0.25}])
def test_two_calls_give_the_same_bytes(options):
    first, second = (make("tripod", n_vertices=1000, **options).mesh for _ in range(2))
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.faces.tobytes() == second.faces.tobytes()


def test_an_unknown_shape_raises_an_error_that_lists_the_known_ones():
    with pytest.raises(UnknownChoice, match=r"unknown shape 'cube'; choose one of: limbs, tree, .*dinosaur"):
        make("cube")


def test_without_pymeshlab_the_error_names_the_pip_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymeshlab", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[preprocess\]'"):
        make("knot", n_vertices=500)


@pytest.mark.parametrize("genus", [0, 1, 2, 5, 9])
def test_chain_of_tori_has_its_genus(genus):
    mesh = chain_of_tori(genus, step=0.12)
    assert mesh.is_closed_manifold
    assert (mesh.genus, mesh.n_components) == (genus, 1)
    assert mesh.volume > 0
    assert mesh.face_areas.min() > 0


def test_edges_are_no_longer_than_the_thinnest_branch_allows():
    thin = mesh_solid(solid_of([([[0, 0, 0], [1, 0, 0]], 0.05)]), n_vertices=100)
    assert _mean_edge(thin) == pytest.approx(MAX_EDGE_LENGTH * 0.05, rel=0.1)
    assert len(thin.vertices) > 200  # more than asked for


def test_noise_is_measured_in_mean_edge_lengths():
    """A mesh with twice the vertices has edges 0.7 times as long, and so are its displacements."""
    deviations = []
    for n_vertices in (1000, 2000):
        clean, noisy = (make("tripod", n_vertices=n_vertices, noise=noise).mesh for noise in (0.0, 0.1))
        deviations.append(np.linalg.norm(noisy.vertices - clean.vertices, axis=1).std() / _mean_edge(clean))
    # |normal deviate| has the standard deviation sqrt(1 - 2 / pi)
    assert deviations == pytest.approx([0.1 * np.sqrt(1 - 2 / np.pi)] * 2, rel=0.1)


def test_a_step_that_changes_the_genus_and_no_vertices_are_refused():
    with pytest.raises(MeshError, match=r"with step=0\.4 the surface has genus 0 in place of 2; make step smaller"):
        chain_of_tori(2, step=0.4)
    with pytest.raises(UnknownChoice, match="n_vertices must be positive, not 0"):
        make("knot", n_vertices=0)
