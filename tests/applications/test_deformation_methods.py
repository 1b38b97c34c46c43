"""Methods of editing: what each minimizes, and parity with libigl."""

import igl
import numpy as np
import pytest
from helpers import with_flat_triangle

from lbskel import Mesh, MeshError, SolveError, UnknownChoice, edit, laplacian, rigid_motion
from lbskel.applications.deformation_methods import EDITING_METHODS, ITERATIVE, Constraints
from lbskel.applications.editing import Editor

MOTIONS = [np.eye(4), rigid_motion(axis=[0, 1, 0], angle_deg=50, translation=[0.3, 0, 0])]


def handles_of(mesh):
    x = mesh.vertices[:, 0]
    return [np.flatnonzero(x < np.quantile(x, 0.1)), np.flatnonzero(x > np.quantile(x, 0.9))]


@pytest.mark.parametrize(("method", "order"), [("harmonic", 1), ("biharmonic", 2)])
def test_displacements_are_those_of_libigl(tripod, method, order):
    handles = handles_of(tripod)
    result = edit(tripod, handles, MOTIONS, method=method, operator="cotangent").vertices
    b = np.concatenate(handles)
    expected = igl.harmonic(tripod.vertices, tripod.faces, b, (result - tripod.vertices)[b], order)
    assert result - tripod.vertices == pytest.approx(expected, abs=1e-10)


def test_as_rigid_as_possible_is_that_of_libigl(tripod):
    handles = handles_of(tripod)
    editor = Editor(tripod, handles, operator="cotangent")
    start = editor.edit(MOTIONS, iterations=0)
    result = editor.edit(MOTIONS, iterations=5, initial=start)
    b = np.concatenate(handles)
    data = igl.ARAPData()
    data.energy, data.max_iter = igl.ARAP_ENERGY_TYPE_SPOKES, 5
    igl.arap_precomputation(tripod.vertices, tripod.faces, 3, b.astype(np.int32), data)
    expected = igl.arap_solve(result.vertices[b], data, np.array(start.vertices))
    # libigl's rotations are in single precision
    assert result.vertices == pytest.approx(expected, abs=1e-4)
    other = editor.rigidity_energy((expected, tripod.faces))
    assert editor.rigidity_energy(result) == pytest.approx(other, rel=1e-5)


def test_every_iteration_decreases_the_rigidity_energy(tripod):
    editor = Editor(tripod, handles_of(tripod))
    meshes = [editor.edit(MOTIONS, iterations=0)]
    for _ in range(10):
        meshes.append(editor.edit(MOTIONS, iterations=1, initial=meshes[-1]))
    energies = [editor.rigidity_energy(mesh) for mesh in meshes]
    assert energies == sorted(energies, reverse=True)
    assert editor.edit(MOTIONS, iterations=10).vertices == pytest.approx(meshes[-1].vertices, abs=1e-12)


@pytest.mark.parametrize("method", ["naive", "similarity"])
def test_the_solution_is_a_minimum(tripod, method):
    """No other positions of the free vertices have less energy."""
    handles = handles_of(tripod)
    S, V = laplacian(tripod).stiffness, tripod.vertices
    X = edit(
        tripod, handles, [np.eye(4), rigid_motion(translation=[0.5, 0, 0])], method=method, operator="cotangent"
    ).vertices
    if method == "naive":
        residual = S.T @ (S @ (X - V))
    else:
        from lbskel.applications.rotation_fitting import rigid_fit
        from lbskel.applications.similarity_invariance import invariant_matrix

        K = invariant_matrix(S, V)
        b = np.concatenate(handles)
        R, t = rigid_fit(V[b], X[b])
        residual = (K.T @ (K @ ((X - t) @ R).ravel())).reshape(-1, 3)
    free = np.setdiff1d(np.arange(len(V)), np.concatenate(handles))
    assert np.abs(residual[free]).max() < 1e-9 * np.abs(residual).max()


def test_details_turn_with_the_surface_in_all_methods_but_linear_ones(tripod):
    """A small bump between the handles keeps its height along the normal where rotations are taken into account."""
    errors = {}
    for method in EDITING_METHODS:
        editor = Editor(tripod, handles_of(tripod), method=method)
        errors[method] = editor.rigidity_energy(editor.edit(MOTIONS))
    assert errors["arap"] < min(errors[name] for name in errors if name != "arap")
    assert errors["rotated"] < errors["naive"]
    assert errors["similarity"] < errors["naive"]


def test_an_operator_that_is_not_symmetric_has_no_rigid_energy(tripod):
    with pytest.raises(MeshError, match="mean_value_symmetric"):
        edit(tripod, handles_of(tripod), MOTIONS, operator="mean_value")
    result = edit(tripod, handles_of(tripod), MOTIONS, operator="mean_value", method="naive")
    assert np.isfinite(result.vertices).all()


def test_soft_constraints_are_weighted_by_the_energys_diagonal(ring):
    Q = laplacian(ring).stiffness
    values = np.ones((2, 1))
    rows = np.array([0, 5])
    soft = Constraints(rows, np.array([9]), np.zeros(10, dtype=int), 2.0, "cholmod").system(Q).solve(values)
    scaled = (
        Constraints(rows, np.array([9]), np.zeros(10, dtype=int), 2.0, "cholmod").system((7 * Q).tocsc()).solve(values)
    )
    assert scaled == pytest.approx(soft, abs=1e-12)
    assert soft[9] == 0


def test_rotating_the_deltas_lowers_the_rigidity_energy(tripod):
    editor = Editor(tripod, handles_of(tripod), method="rotated")
    before, after = (editor.rigidity_energy(editor.edit(MOTIONS, iterations=n)) for n in (0, 10))
    assert after < 0.9 * before


@pytest.mark.parametrize("method", EDITING_METHODS)
def test_the_number_of_iterations_counts_for_the_methods_that_iterate(ring, method):
    """The others solve once, and refuse a number and positions to start from."""
    editor = Editor(ring, handles_of(ring), method=method)
    if method in ITERATIVE:
        none, three = (editor.edit(MOTIONS, iterations=count).vertices for count in (0, 3))
        assert not np.array_equal(none, three)
    else:
        for given in ({"iterations": 3}, {"initial": ring}):
            with pytest.raises(UnknownChoice, match=f"the method {method} solves once"):
                editor.edit(MOTIONS, **given)


@pytest.mark.parametrize("weight", [None, 1.0])
@pytest.mark.parametrize(
    ("operator", "corners", "faces"),
    [
        ("robust", [[0.3, 0, 0], [0.3, 0.15, 0], [0.3, 0, 0.15]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        ("cotangent", [[0.2, 0, 0], [0.2, 0.1, 0]], [[0, 1, 2]]),  # the row of its last corner is zero
    ],
)
def test_parts_that_hang_on_one_vertex_are_refused_as_they_may_turn(rod, weight, operator, corners, faces):
    """A tetrahedron and a triangle, which rounding errors turned and scaled."""
    n, z = len(rod.vertices), rod.vertices[:, 2]
    place = int(np.abs(z).argmin())
    hanging = np.array([place, n, n + 1, n + 2])[np.array(faces)]
    mesh = Mesh([*rod.vertices, *(rod.vertices[place] + np.array(corners))], [*rod.faces, *hanging])
    handles = [np.flatnonzero(z < z.min() + 0.5), np.flatnonzero(z > z.max() - 0.5)]
    with pytest.raises(SolveError, match=r"a part hangs on one vertex and may turn and grow.*take another method"):
        edit(mesh, handles, MOTIONS, method="similarity", operator=operator, handle_weight=weight)
    assert np.isfinite(edit(mesh, handles, MOTIONS, operator=operator, handle_weight=weight).vertices).all()


def test_a_long_thin_triangle_is_no_part_that_may_turn(rod):
    capped, n, z = with_flat_triangle(rod), len(rod.vertices), rod.vertices[:, 2]
    handles = [np.flatnonzero(z < z.min() + 0.5), np.flatnonzero(z > z.max() - 0.5)]
    found, expected = (
        edit(mesh, handles, MOTIONS, method="similarity", operator="cotangent").vertices for mesh in (capped, rod)
    )
    assert np.abs(found[:n] - expected).max() < 0.01 * rod.diagonal
