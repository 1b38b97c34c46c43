"""Editing: motions that are reproduced exactly, handles hard and soft, components, and what is refused."""

import numpy as np
import pytest
from helpers import joined, moved, with_flat_triangle

from lbskel import EDITING_METHODS, Editor, Mesh, MeshError, SolveError, UnknownChoice, edit, rigid_motion
from lbskel.applications.deformation_methods import ITERATIVE
from lbskel.operators import OPERATORS
from lbskel.shapes import capsule, flat_grid

TURN = rigid_motion(axis=[1, 2, 3], angle_deg=160, center=[1, 0, 0], translation=[0, 5, 0])


def placed(points, motion):
    return points @ motion[:3, :3].T + motion[:3, 3]


def ends(mesh):
    z = mesh.vertices[:, 2]
    return [z < z.min() + 0.5, z > z.max() - 0.5]


@pytest.mark.parametrize("method", EDITING_METHODS)
@pytest.mark.parametrize("weight", [None, 3.0])
def test_identity_and_translation_of_all_handles_are_exact(rod, method, weight):
    editor = Editor(rod, ends(rod), method=method, handle_weight=weight)
    shift = rigid_motion(translation=[1, -2, 3])
    for motion in (np.eye(4), shift):
        assert editor.edit([motion] * 2).vertices == pytest.approx(placed(rod.vertices, motion), abs=1e-10)


@pytest.mark.parametrize("method", ["arap", "similarity", "rotated"])
@pytest.mark.parametrize("weight", [None, 3.0])
def test_a_rotation_of_all_handles_is_exact(rod, method, weight):
    result = edit(rod, ends(rod), [TURN, TURN], method=method, handle_weight=weight)
    assert result.vertices == pytest.approx(placed(rod.vertices, TURN), abs=1e-10)


@pytest.mark.parametrize("method", ["naive", "biharmonic", "harmonic"])
def test_linear_methods_do_not_turn_the_surface(rod, method):
    result = edit(rod, ends(rod), [TURN, TURN], method=method)
    assert np.abs(result.vertices - placed(rod.vertices, TURN)).max() > 0.1


@pytest.mark.parametrize("method", EDITING_METHODS)
def test_a_rigid_motion_of_mesh_and_motions_moves_the_result(rod, method):
    motions = [np.eye(4), rigid_motion(axis=[0, 1, 0], angle_deg=40)]
    result = edit(rod, ends(rod), motions, method=method)
    back = np.linalg.inv(TURN)
    other = edit(
        rod.with_vertices(placed(rod.vertices, TURN)),
        ends(rod),
        [TURN @ each @ back for each in motions],
        method=method,
    )
    assert other.vertices == pytest.approx(placed(result.vertices, TURN), abs=1e-8)


@pytest.mark.parametrize("method", EDITING_METHODS)
def test_hard_handles_are_at_their_targets_and_soft_ones_approach_them(rod, method):
    handles, motions = ends(rod), [np.eye(4), rigid_motion(axis=[0, 1, 0], angle_deg=40)]
    target = placed(rod.vertices[handles[1]], motions[1])
    result = edit(rod, handles, motions, method=method)
    assert result.vertices[handles[1]] == pytest.approx(target, abs=1e-12)
    distances = [
        np.abs(edit(rod, handles, motions, method=method, handle_weight=weight).vertices[handles[1]] - target).max()
        for weight in (0.01, 1.0, 100.0)
    ]
    assert distances == sorted(distances, reverse=True)
    assert distances[2] < 0.05


@pytest.mark.parametrize("operator", [name for name in OPERATORS if name not in ("mean_value", "cotangent_identity")])
def test_every_symmetric_operator_edits(rod, operator):
    result = edit(rod, ends(rod), [np.eye(4), rigid_motion(axis=[0, 1, 0], angle_deg=40)], operator=operator)
    assert np.isfinite(result.vertices).all()
    assert 0.7 < result.volume / rod.volume < 1.3


def test_flat_triangles_hardly_change_the_result(rod):
    """A triangle a millionth as high as long: with cotangent weights vertices are thrown thousands of diagonals off."""
    capped, n = with_flat_triangle(rod), len(rod.vertices)
    motions = [np.eye(4), rigid_motion(axis=[0, 1, 0], angle_deg=40)]
    handles = [np.flatnonzero(end) for end in ends(rod)]
    found, expected = (Editor(mesh, handles).edit(motions).vertices for mesh in (capped, rod))
    assert np.abs(found[:n] - expected).max() < 0.01 * rod.diagonal
    thrown = edit(capped, handles, motions, operator="cotangent").vertices
    assert np.abs(thrown[:n] - expected).max() > rod.diagonal


def test_what_no_handle_holds_stays(rod):
    both = joined(rod, moved(rod, 4.0))
    mesh = Mesh([*both.vertices, [9.0, 9, 9]], both.faces)
    handles = [np.flatnonzero(mask) for mask in ends(rod)]
    for method in EDITING_METHODS:
        result = edit(mesh, handles, [TURN, TURN], method=method).vertices
        assert result[152:] == pytest.approx(mesh.vertices[152:], abs=1e-12)
        if method in ("arap", "similarity", "rotated"):
            assert result[:152] == pytest.approx(placed(rod.vertices, TURN), abs=1e-10)


def test_an_open_surface_is_edited():
    grid = flat_grid(9, 9)
    x = grid.vertices[:, 0]
    for method in EDITING_METHODS:
        lifted = edit(grid, [x < 0.1, x > 0.9], [np.eye(4), rigid_motion(translation=[0, 0, 0.3])], method=method)
        assert np.isfinite(lifted.vertices).all()
        assert 0 < lifted.vertices[40, 2] < 0.3


def test_a_start_may_be_given(rod):
    editor, motions = Editor(rod, ends(rod)), [np.eye(4), rigid_motion(angle_deg=40)]
    first = editor.edit(motions, iterations=3)
    assert editor.edit(motions, iterations=0, initial=first).vertices == pytest.approx(first.vertices, abs=1e-12)
    array = editor.edit(motions, iterations=4, initial=first.vertices).vertices
    assert (array == editor.edit(motions, iterations=4, initial=first).vertices).all()


@pytest.mark.parametrize("method", ITERATIVE)
def test_other_numbers_of_vertices_are_named(rod, method):
    editor, n = Editor(rod, ends(rod), method=method), len(rod.vertices)
    for k in (n - 1, n + 1):
        with pytest.raises(MeshError, match=f"one position for each of the {n} vertices"):
            editor.edit([np.eye(4)] * 2, initial=np.zeros((k, 3)))
    with pytest.raises(MeshError, match=f"one position for each of the {n} vertices"):
        editor.rigidity_energy(joined(rod, rod))


@pytest.mark.parametrize(
    ("error", "handles", "motions", "options"),
    [
        (MeshError, [], [], {}),
        (MeshError, [[]], [np.eye(4)], {}),
        (MeshError, [[0, 1], [1]], [np.eye(4)] * 2, {}),
        (MeshError, [[0, 999]], [np.eye(4)], {}),
        (MeshError, [[0]], [np.eye(3)], {}),
        (MeshError, [[0]], [np.eye(4)] * 2, {}),
        (MeshError, [[0]], [np.full((4, 4), np.nan)], {}),
        (MeshError, [[0]], [2 * np.eye(4)], {}),
        (MeshError, [[0]], "a", {}),
        (MeshError, ["a"], [np.eye(4)], {}),
        (MeshError, [[[0], [1, 2]]], [np.eye(4)], {}),
        (UnknownChoice, [[0]], [np.eye(4)], {"method": "poisson"}),
        (UnknownChoice, [[0]], [np.eye(4)], {"handle_weight": 0.0}),
        (UnknownChoice, [[0]], [np.eye(4)], {"iterations": -1}),
        (UnknownChoice, [[0]], [np.eye(4)], {"iterations": 3, "method": "harmonic"}),
    ],
)
def test_wrong_input_is_named(rod, error, handles, motions, options):
    with pytest.raises(error):
        edit(rod, handles, motions, **options)


def test_handles_of_too_few_vertices_are_an_error_with_a_way_out():
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(SolveError, match="merge vertices at one place by the preprocessing step merge_close"):
        edit(triangle, [[0]], [np.eye(4)], method="similarity", operator="graph")


@pytest.mark.parametrize("method", EDITING_METHODS)
def test_each_component_follows_its_own_handles(method):
    """Two rods: one rests, the other is moved aside by one handle."""
    rod = capsule(3.0, 0.4, 10)
    n, z = len(rod.vertices), rod.vertices[:, 2]
    both = Mesh(np.concatenate([rod.vertices, rod.vertices + [2, 0, 0]]), np.concatenate([rod.faces, rod.faces + n]))
    low = np.flatnonzero(z < z.min() + 0.5)
    motions = [rigid_motion(), rigid_motion(translation=[0, 0, 1])]
    moved = edit(both, [low, low + n], motions, method=method).vertices
    assert moved == pytest.approx(both.vertices + np.repeat([[0, 0, 0], [0, 0, 1]], n, axis=0), abs=1e-9)
