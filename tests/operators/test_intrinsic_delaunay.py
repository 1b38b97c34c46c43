"""The intrinsic Delaunay Laplacian, against libigl and robust_laplacian; boundaries, orientation, mollification."""

import igl
import numpy as np
import pytest
import robust_laplacian
from operator_shapes import PYTHAGORAS, stiffness_of_lengths

from lbskel import Mesh, MeshError
from lbskel.operators import laplacian
from lbskel.operators.intrinsic_delaunay import intrinsic_delaunay, mollified_lengths
from lbskel.shapes import flat_grid, sphere


@pytest.mark.parametrize("name", ["real", "distorted", "sphere"])
def test_the_stiffness_is_libigls_and_that_of_robust_laplacian(name, meshes_by_kind):
    mesh = meshes_by_kind[name]
    ours = laplacian(mesh, operator="intrinsic_delaunay").stiffness
    theirs = -igl.intrinsic_delaunay_cotmatrix(mesh.vertices, mesh.faces)[0]
    # lengths of flipped edges come from different formulas
    assert abs(ours - theirs).max() < 1e-10 * abs(theirs).max()
    tufted = robust_laplacian.mesh_laplacian(np.array(mesh.vertices), np.array(mesh.faces), mollify_factor=0)[0]
    assert abs(ours - tufted).max() < 1e-10 * abs(tufted).max()
    if name != "sphere":
        assert abs(ours - laplacian(mesh).stiffness).max() > 0.01


def test_intrinsic_delaunay_takes_a_boundary_and_any_orientation_but_no_third_face():
    grid = flat_grid(5, 5)
    assert abs(laplacian(grid, operator="intrinsic_delaunay").stiffness - laplacian(grid).stiffness).max() < 1e-14 * 4
    ball = sphere(1)
    F = ball.faces.copy()
    F[::3] = F[::3, ::-1]
    turned = laplacian(Mesh(ball.vertices, F), operator="intrinsic_delaunay").stiffness
    assert abs(turned - laplacian(ball, operator="intrinsic_delaunay").stiffness).max() < 1e-14 * 10
    fin = Mesh(np.eye(5, 3) + 1, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    strip = Mesh(np.eye(5, 3) + 1, [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]])
    repeated = Mesh(ball.vertices, np.concatenate([ball.faces, [[0, 0, 1], [3, 3, 3]]]))
    for mesh, fault in (
        (fin, r"edges of more than two faces: \(0, 1\)"),
        (repeated, "faces that use a vertex twice: 80, 81"),
        (strip, "Moebius strip"),
    ):
        for name in ("intrinsic_delaunay", "anisotropic"):
            with pytest.raises(MeshError, match=f"{name} is not defined with .*{fault}.*use the operator 'robust'"):
                laplacian(mesh, operator=name)
        assert laplacian(mesh, operator="robust").mass.sum() > 0


def test_the_mollified_operators_reach_across_triangles_without_area():
    """A closed surface flattened to a line keeps a null space of dimension one."""
    ball = sphere(1)
    line = ball.with_vertices(ball.vertices * [1, 0, 0])
    for name in ("intrinsic_delaunay", "robust"):
        S = laplacian(line, operator=name).stiffness.toarray()
        eigenvalues = np.linalg.eigvalsh(S)
        # thin triangles are a millionth as wide as long, and eigenvalues are rounded at 1e-15
        assert eigenvalues[1] > 1e-11 * eigenvalues[-1]
        assert len(laplacian(line, operator=name).treated_vertices) == 42
    assert np.linalg.eigvalsh(laplacian(ball).stiffness.toarray())[1] > 1e-3


def test_the_edges_of_a_component_are_lengthened_by_what_its_thinnest_triangle_needs():
    L = intrinsic_delaunay(PYTHAGORAS, mollify_factor=0.3)
    # the triangle with sides 3, 4, 5 has a slack of 2; the collinear one needs the slack itself, 0.3 (1 + 1 + 2) / 3
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(stiffness_of_lengths(5, 3, 4), rel=1e-12, abs=1e-12)
    assert L.stiffness.toarray()[3:, 3:] == pytest.approx(stiffness_of_lengths(1.4, 2.4, 1.4), rel=1e-12, abs=1e-12)
    assert L.treated_vertices.tolist() == [3, 4, 5]
    assert L.mass.diagonal() == pytest.approx([3, 1.5, 1.5, 0, 0, 0])  # of the triangles as given


def test_lengths_stay_where_the_triangle_inequalities_hold():
    faces = np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6], [7, 8, 9]])
    lengths = np.array([[3.0, 4.0, 5.0], [3.0, 3.0, 6.0], [1.0, 1.0, 2.5], [1.0, 1.0, 1.0]])
    mean = 4.0  # of the first two faces, which are one component
    for factor, offsets in ((0.0, [0, 0, 0.5, 0]), (0.3, [0.3 * mean, 0.3 * mean, 0.5 + 0.45, 0])):
        found, is_thin = mollified_lengths(faces, lengths, factor)
        assert found - lengths == pytest.approx(np.repeat(np.array(offsets)[:, None], 3, axis=1))
        assert is_thin.tolist() == [False, factor > 0, True, False]


@pytest.mark.parametrize("operator", ["intrinsic_delaunay", "robust", "mollified"])
def test_a_small_part_is_not_rounded_by_the_size_of_another(operator):
    ball = sphere(2)
    small, large = ball.vertices * [1, 1, 6] * 1e-6, flat_grid(4, 4).vertices * 10 + 5
    F = np.concatenate([flat_grid(4, 4).faces, ball.faces + 16])
    both = laplacian(Mesh(np.concatenate([large, small]), F), operator=operator)
    alone = laplacian(Mesh(small, ball.faces), operator=operator)
    assert abs(both.stiffness[16:, 16:] - alone.stiffness).max() < 1e-9  # edges of 1e-6 beside coordinates of 10
    assert both.mass.diagonal()[16:] == pytest.approx(alone.mass.diagonal(), rel=1e-9)
    assert not (both.treated_vertices >= 16).any()


def test_an_edge_that_is_not_delaunay_is_flipped():
    """A rhombus cut along its long diagonal, 4, has the cotangent weights of the one cut along the short one, 2."""
    V = np.array([[-2, 0, 0], [2, 0, 0], [0, 1, 0], [0, -1, 0]])
    long, short = Mesh(V, [[0, 1, 2], [1, 0, 3]]), Mesh(V, [[0, 3, 2], [1, 2, 3]])
    found = intrinsic_delaunay(long).stiffness.toarray()
    assert found == pytest.approx(laplacian(short).stiffness.toarray(), abs=1e-14)
    # opposite the short diagonal are two angles with tan(a / 2) = 1 / 2, so cot a = 3 / 4
    assert found[2, 3] == pytest.approx(-3 / 4)
    assert found[0, 1] == 0
