"""Every shape of the catalog is what it promises, and its truth is the axis of its mesh."""

import sys
from functools import lru_cache
from pathlib import Path

import igl
import numpy as np
import pytest

from lbskel.errors import MissingDependency, UnknownChoice
from lbskel.io import read_mesh
from lbskel.preprocess.pymeshlab_adapter import remesh_isotropic
from lbskel.shapes import SHAPES, VARIANTS, make
from lbskel.shapes.__main__ import EXAMPLES, main
from lbskel.shapes.catalog import LONGEST_EDGE

MESHES = Path(__file__).parents[2] / "meshes"

# genus, tips, junctions
PROMISED = {
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


def test_the_table_here_names_every_shape():
    assert PROMISED.keys() == SHAPES.keys()


@pytest.mark.parametrize("name", SHAPES)
def test_mesh_and_truth_have_the_promised_topology(name):
    shape = made(name)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.n_components, shape.truth.n_components) == (1, 1)
    assert shape.mesh.volume > 0
    assert len(np.unique(shape.mesh.faces)) == len(shape.mesh.vertices)
    assert (shape.truth.genus, shape.truth.n_tips, len(shape.truth.junctions)) == PROMISED[name]
    assert shape.mesh.genus == shape.truth.genus


@pytest.mark.parametrize("name", SHAPES)
def test_coarse_meshes_are_coarse_and_even(name):
    mesh = made(name).mesh
    assert 500 <= len(mesh.vertices) <= 2900
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    lengths = np.linalg.norm(end - start, axis=1)
    assert np.percentile(lengths, 95) < 2 * np.percentile(lengths, 5)  # the remesher keeps 4/5 to 4/3 of its target
    assert lengths.mean() < 1.1 * LONGEST_EDGE * SHAPES[name]().radii.min()  # of the target, by a twentieth


@pytest.mark.parametrize("name", SHAPES)
def test_every_vertex_is_on_the_surface(name):
    value = SHAPES[name]().distance(made(name).mesh.vertices, reach=0.01)
    assert np.abs(value).max() < 1e-8  # Newton's method ends at 1e-13 but in the flat saddles between fingers


@pytest.mark.parametrize("name", SHAPES)
def test_truth_runs_inside_at_its_radius_from_the_surface(name):
    mesh, truth = made(name).mesh, made(name).truth
    points, radii = truth.sample(0.05)
    assert igl.fast_winding_number(mesh.vertices, mesh.faces, points).min() > 0.5
    distance = np.sqrt(igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)[0])
    # Edges of up to 4/3 of 3/4 of the radius r cut into a sphere: a triangle inscribed in it with edges l has its
    # center at sqrt(r^2 - l^2 / 3), 0.82 r, and less where four of them meet at a corner. Blends add to the radius.
    assert (distance / radii).min() > 0.65
    assert (distance / radii).max() < 1.5
    tips = np.sqrt(igl.point_mesh_squared_distance(truth.nodes[truth.tips], mesh.vertices, mesh.faces)[0])
    assert (tips <= truth.radii[truth.tips]).all()


@pytest.mark.parametrize("name", SHAPES)
def test_every_end_stands_clear_of_its_trunk(name):
    truth = made(name).truth
    tips = set(truth.tips.tolist())
    for path in truth.branches:
        tip, trunk = (path[0], path[-1]) if path[0] in tips else (path[-1], path[0])
        if tip not in tips:
            continue
        length = np.linalg.norm(np.diff(truth.nodes[path], axis=0), axis=1).sum()
        assert length - truth.radii[trunk] > 1.5 * truth.radii[tip]


def test_full_size_is_near_what_was_asked():
    assert len(make("knot").mesh.vertices) == pytest.approx(5000, rel=0.1)


def test_noise_is_along_the_normals_at_its_scale_and_by_its_seed():
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
def test_the_same_bytes_every_time(options):
    first, second = (make("tripod", n_vertices=1000, **options).mesh for _ in range(2))
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.faces.tobytes() == second.faces.tobytes()


def test_an_unknown_shape_is_answered_with_the_known_ones():
    with pytest.raises(UnknownChoice, match=r"unknown shape 'cube'; choose one of: limbs, tree, .*dinosaur"):
        make("cube")


def test_without_pymeshlab_the_message_carries_the_pip_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymeshlab", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[preprocess\]'"):
        make("knot", n_vertices=500)


def test_remeshing_keeps_sharp_edges_only_if_asked():
    box = igl.upsample(*_box(), 4)
    kept, rounded = (remesh_isotropic(*box, target_length=0.1, feature_angle=angle)[0] for angle in (30.0, 180.0))

    def worst(vertices):
        """Distance of the corner of the box that is furthest from all vertices."""
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        return np.linalg.norm(vertices[:, None] - corners, axis=2).min(axis=0).max()

    assert worst(kept) == 0.0
    assert worst(rounded) > 0.05  # half an edge


def _box():
    """The unit cube in twelve triangles."""
    V = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return V, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def test_the_example_meshes_are_those_of_the_command():
    assert {path.name for path in MESHES.iterdir()} == {*EXAMPLES, "README.md"}
    assert sum(path.stat().st_size for path in MESHES.iterdir()) < 2_000_000
    assert (MESHES / "dinosaur.ply").stat().st_size < 400_000


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_mesh_is_the_shape_that_it_is_named_after(name):
    mesh, solid = read_mesh(MESHES / name), SHAPES[Path(name).stem]()
    genus, tips, _ = PROMISED[Path(name).stem]
    assert mesh.is_closed_manifold
    assert mesh.genus == genus
    row = next(line for line in (MESHES / "README.md").read_text(encoding="utf-8").splitlines() if f"`{name}`" in line)
    assert row.endswith(f" | {len(mesh.vertices):,} | {genus} | {tips} |")
    noise = EXAMPLES[name].get("noise", 0.0) * _mean_edge(mesh)
    value = solid.distance(mesh.vertices, reach=5 * noise + 0.01)
    assert np.abs(value).max() < 5 * noise + 1e-6  # STL has single precision; noise beyond 5 deviations is one in 1e6


def test_the_command_writes_what_it_says(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("lbskel.shapes.__main__.EXAMPLES", {"tripod.off": {"n_vertices": 600}})
    main(tmp_path / "new")
    mesh = read_mesh(tmp_path / "new" / "tripod.off")
    assert f"{mesh}, genus 0, 3 tips" in capsys.readouterr().out
