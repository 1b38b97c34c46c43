"""Findings as sentences, and reasons against contraction."""

import numpy as np
from helpers import joined, moved, triangle_soup

from lbskel import Mesh, check
from lbskel.preprocess.messages import describe_findings, reasons_against_contraction
from lbskel.preprocess.result import identity_result
from lbskel.shapes import flat_grid, torus


def test_contraction_of_unconnected_or_collinear_faces_is_not_advised():
    V = np.random.default_rng(0).normal(size=(300, 3))
    assert check(Mesh(V, np.arange(300).reshape(-1, 3))).is_advised is False
    assert check(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])).is_advised is False


def test_a_soup_of_which_most_faces_stay_unconnected_is_not_advised():
    """The corners are shaken by three times the tolerance, so that few of them merge."""
    ring = torus(1.0, 0.3)
    soup = triangle_soup(ring)
    shaken = soup.vertices + 1e-5 * np.random.default_rng(0).uniform(-1, 1, soup.vertices.shape)
    report = check(soup.with_vertices(shaken))
    assert not report.is_advised
    assert report.findings[-1].endswith("most faces are not connected; raise the tolerance of merge_close.")
    [note] = [finding for finding in report.findings if "too small for a skeleton" in finding]
    assert "% of the area: if the faces should be connected, raise the tolerance of merge_close" in note
    assert check(soup.with_vertices(soup.vertices + 1e-3 * (shaken - soup.vertices))).is_advised


def test_a_few_faces_are_not_told_to_be_connected(tetrahedron):
    for n in (1, 3):
        reason = check(Mesh(tetrahedron.vertices, tetrahedron.faces[:n])).findings[-1]
        assert reason == f"Contraction is not advised: a surface of {n} face{'s' if n > 1 else ''} has no inside."


def test_many_components_without_an_inside_are_named_in_one_line(ring):
    flat = ring.with_vertices(ring.vertices * [1, 1, 0])
    [reason] = reasons_against_contraction(identity_result(joined(*(moved(flat, 5 * k) for k in range(6)))))
    assert reason.startswith("Contraction is not advised: component 0, at ")
    assert "component 1, at" in reason
    assert "component 2" not in reason
    assert reason.endswith("and 4 more.")


def test_defects_are_counted_in_the_singular_or_plural():
    facts = {**check(torus(1.0, 0.4, 40, 24)).as_dict(), "needles": 1, "caps": 1200}
    assert describe_findings(facts, ["8 faces were split into 320"]) == (
        "1 needle triangle (angle near 0): if not removed, handled by the operator.",
        "1,200 cap triangles (angle near 180 degrees): if not removed, handled by the operator.",
        "8 faces are split into 320.",
    )


def test_what_is_said_to_happen_is_what_preprocessing_does(ring):
    """Coincident copies are merged, bodies that share an edge are split, crumbs removed, open surfaces reoriented."""
    V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1]]
    tetrahedron = Mesh(V[:4], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    twins = Mesh(V, [*tetrahedron.faces, [0, 1, 4], [0, 5, 1], [0, 4, 5], [1, 5, 4]])
    crumbs = [moved(tetrahedron.with_vertices(0.001 * tetrahedron.vertices), 5 + k) for k in range(5)]
    texts = {
        "copies": " ".join(check(joined(ring, ring)).findings),
        "twins": " ".join(check(twins).findings),
        "crumbs": " ".join(check(joined(torus(1.0, 0.4, 60, 40), *crumbs)).findings),
        "inside out with a hole": " ".join(check(Mesh(ring.vertices, ring.faces[1:, ::-1])).findings),
    }
    assert f"{len(ring.faces)} duplicate faces are removed" in texts["copies"]
    assert "kept" not in texts["twins"]
    assert "were split" not in texts["twins"]
    assert "2 vertices are added where surfaces that meet in an edge or a vertex are split." in texts["twins"]
    assert "5 components are removed as too small for a skeleton." in texts["crumbs"]
    assert f"{len(ring.faces) - 1} faces are reversed." in texts["inside out with a hole"]


def test_a_valid_mesh_has_no_reasons_against_contraction(ring):
    assert reasons_against_contraction(identity_result(ring)) == ()
    assert reasons_against_contraction(identity_result(flat_grid())) == (
        "Contraction is not advised: the surface is a sheet that encloses no volume.",
    )
