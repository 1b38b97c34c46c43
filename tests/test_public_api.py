"""The public names: what takes a mesh takes every kind of mesh, and the stages compose to the whole."""

import inspect
import tempfile
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers import joined, moved, triangle_soup

import lbskel
from lbskel.shapes import make
from lbskel.skeleton.root import reroot_by_thickness


def view_of(mesh):
    with tempfile.TemporaryDirectory() as folder:
        return lbskel.view(mesh, Path(folder) / "page.html").nodes


TAKES_A_MESH = {
    "as_mesh": lambda mesh: lbskel.as_mesh(mesh).vertices,
    "branch_table": lambda mesh: lbskel.branch_table(lbskel.skeletonize(mesh), mesh).volume,
    "check": lambda mesh: lbskel.check(mesh).faces,
    "collapse_mesh": lambda mesh: lbskel.collapse_mesh(mesh, mesh).edges,
    "compress": lambda mesh: lbskel.compress(mesh, 10).coefficients,
    "contract": lambda mesh: lbskel.contract(mesh).mesh.vertices,
    "extend_values": lambda mesh: lbskel.extend_values(mesh, [0, 5], [1.0, 2.0]),
    "geodesic_distance": lambda mesh: lbskel.geodesic_distance(mesh, 0),
    "laplacian": lambda mesh: lbskel.laplacian(mesh).stiffness.data,
    "laplacian_diagnostics": lambda mesh: lbskel.laplacian_diagnostics(lbskel.laplacian(mesh), mesh).area_ratio,
    "prepare": lambda mesh: lbskel.prepare(mesh).mesh.vertices,
    "prune": lambda mesh: lbskel.prune(lbskel.skeletonize(mesh), mesh).nodes,
    "rig": lambda mesh: lbskel.rig(mesh, lbskel.skeletonize(mesh)).weights,
    "score": lambda mesh: lbskel.score(lbskel.skeletonize(mesh), mesh).coverage,
    "segment": lambda mesh: lbskel.segment(mesh, lbskel.skeletonize(mesh)).part_of_face,
    "skeletonize": lambda mesh: lbskel.skeletonize(mesh).nodes,
    "delta_coordinates": lambda mesh: lbskel.delta_coordinates(mesh),
    "edit": lambda mesh: lbskel.edit(mesh, [[0, 1, 2]], [lbskel.rigid_motion(angle_deg=9)]).vertices,
    "reconstruct": lambda mesh: lbskel.reconstruct(mesh, np.zeros((152, 3)), [0]).vertices,
    "least_squares_mesh": lambda mesh: lbskel.least_squares_mesh(mesh, 20)[0].vertices,
    "quantize_deltas": lambda mesh: lbskel.quantize_deltas(mesh).codes,
    "smooth": lambda mesh: lbskel.smooth(mesh).vertices,
    "spectral_basis": lambda mesh: lbskel.spectral_basis(mesh, 5).functions,
    "Pipeline": lambda mesh: lbskel.Pipeline(["merge_close"])(mesh).mesh.vertices,
    "view": lambda mesh: view_of(mesh),
    "write_mesh": lambda mesh: b"",  # writes a file: tested below
}
MESH_PARAMETERS = {"mesh", "shape", "contracted", "data"}


class HasVerticesAndFaces:
    """What trimesh's meshes look like."""

    def __init__(self, mesh):
        self.vertices, self.faces = mesh.vertices, mesh.faces


def forms(mesh, folder):
    """One mesh in every form that users have."""
    lbskel.write_mesh(folder / "mesh.ply", mesh, force=True)
    yield mesh.vertices, mesh.faces
    yield mesh.vertices.tolist(), mesh.faces.tolist()
    yield folder / "mesh.ply"
    yield str(folder / "mesh.ply")
    yield HasVerticesAndFaces(mesh)


def test_every_function_with_a_mesh_is_in_the_table():
    found = {
        name
        for name in lbskel.__all__
        if inspect.isfunction(getattr(lbskel, name))
        and MESH_PARAMETERS & set(inspect.signature(getattr(lbskel, name)).parameters)
    }
    assert found | {"Pipeline", "as_mesh"} == set(TAKES_A_MESH)


@pytest.mark.parametrize("name", TAKES_A_MESH)
def test_what_takes_a_mesh_takes_every_kind_of_mesh(name, rod, tmp_path):
    expected = TAKES_A_MESH[name](rod)
    for form in forms(rod, tmp_path):
        assert np.array_equal(TAKES_A_MESH[name](form), expected)


def test_a_mesh_in_every_form_is_written(rod, tmp_path):
    for number, form in enumerate(forms(rod, tmp_path)):
        lbskel.write_mesh(tmp_path / f"{number}.off", form)
        assert np.array_equal(lbskel.read_mesh(tmp_path / f"{number}.off").vertices, rod.vertices)


@cache
def mesh_named(name):
    """A shape of the catalog, or one with several components or without shared vertices."""
    if name == "two bodies":
        return joined(mesh_named("octopus"), moved(mesh_named("octopus"), 3.0))
    return triangle_soup(mesh_named("octopus")) if name == "soup" else make(name, n_vertices=1000).mesh


@cache
def skeleton_named(name):
    return lbskel.skeletonize(mesh_named(name))


def composed(mesh):
    """A skeleton by the public stages, as the README shows them."""
    prepared = lbskel.prepare(mesh)
    skeletons = []
    for body in prepared.bodies:
        contraction = lbskel.contract(body.proxy.mesh)
        graph = lbskel.collapse(contraction)
        skeletons.append(lbskel.refine(lbskel.to_skeleton(graph), body))
    skeleton = lbskel.assemble(skeletons, prepared)
    return skeleton, lbskel.score(skeleton, prepared)


@pytest.mark.parametrize("name", ["octopus", "ladder", "helix", "two bodies", "soup"])
def test_the_stages_compose_to_skeletonize(name):
    """To the last digit."""
    expected = skeleton_named(name)
    skeleton, score = composed(mesh_named(name))
    for field in fields(lbskel.Skeleton):
        if field.name != "report":
            assert np.array_equal(getattr(skeleton, field.name), getattr(expected, field.name)), field.name
    assert score.report() == expected.report["score"]


@pytest.mark.parametrize("name", ["octopus", "limbs", "tree"])
@pytest.mark.parametrize("ratio", [2.0, 3.0, 6.0])
def test_a_branch_ratio_is_a_pruning_of_the_finished_skeleton(name, ratio):
    direct = lbskel.skeletonize(mesh_named(name), min_branch_ratio=ratio)
    pruned = reroot_by_thickness(lbskel.prune(skeleton_named(name), mesh_named(name), min_branch_ratio=ratio))
    assert np.array_equal(direct.nodes, pruned.nodes)
    assert np.array_equal(direct.nodes[direct.tips], pruned.nodes[pruned.tips])


def test_every_public_class_and_function_has_an_example_that_runs():
    """``tests/test_readme.py`` runs them."""
    values = {name: getattr(lbskel, name) for name in lbskel.__all__}
    documented = {name: value for name, value in values.items() if inspect.isclass(value) or inspect.isfunction(value)}
    assert len(documented) > 80
    assert [name for name, value in documented.items() if ">>> " not in (inspect.getdoc(value) or "")] == []
