"""The check of a mesh: measures, counts of defects, and its text."""

import json

import numpy as np
import pytest

from lbskel import Mesh, check
from lbskel.shapes import flat_grid, torus

TORUS = torus(1.0, 0.4, 40, 24)


def test_a_valid_mesh_has_no_findings():
    report = check(TORUS)
    assert report.findings == ()
    assert report.is_advised
    assert report.genera == (1,)
    assert report.volume == pytest.approx(TORUS.volume)
    assert json.loads(json.dumps(report.as_dict()))["faces"] == len(TORUS.faces)


DEFECTS = {
    "duplicate_vertices": (
        lambda m: Mesh(m.vertices[m.faces].reshape(-1, 3), np.arange(3 * len(m.faces)).reshape(-1, 3)),
        4800,
    ),
    "duplicate_faces": (lambda m: Mesh(m.vertices, [*m.faces, *m.faces[:4, ::-1]]), 4),
    "repeated_corners": (lambda m: Mesh(m.vertices, [*m.faces, [0, 0, 1]]), 1),
    "unreferenced_vertices": (lambda m: Mesh([*m.vertices, [9, 9, 9], [8, 8, 8]], m.faces), 2),
    "boundary_loops": (lambda m: Mesh(m.vertices, np.delete(m.faces, [0, 500], axis=0)), 2),
    "nonmanifold_edges": (lambda m: Mesh([*m.vertices, [0, 0, 1]], [*m.faces, [*m.faces[0, :2], len(m.vertices)]]), 1),
    "misoriented_edges": (lambda m: Mesh(m.vertices, [m.faces[0, ::-1], *m.faces[1:]]), 3),
    "is_inside_out": (lambda m: Mesh(m.vertices, m.faces[:, ::-1]), True),
    "zero_area_faces": (lambda m: Mesh([*m.vertices, m.vertices[0]], [*m.faces, [0, 1, len(m.vertices)]]), 1),
    "sheets": (lambda m: flat_grid(), 1),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_each_defect_is_counted_and_reported(name):
    spoil, count = DEFECTS[name]
    report = check(spoil(TORUS))
    assert getattr(report, name) == count
    assert report.findings
    assert report.is_advised is (name != "sheets")
