"""The check of a mesh: measures, counts of defects, and its text."""

import json

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import Mesh, check, write_mesh
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


def test_the_text_is_that_of_the_command_line():
    report = check(TORUS)
    lines = str(report).splitlines()
    assert lines[0] == "960 vertices, 1,920 faces, 1 component: genus 1"
    assert lines[1].startswith("  edges     shortest, median and longest ")
    assert lines[1].endswith(f"of the diameter bound, {TORUS.diameter_bound:.6g}")
    assert lines[2] == f"  angles    {report.min_angle_deg:.2g} to {report.max_angle_deg:.4g} degrees"
    assert lines[3:] == ["  found     Nothing that prevents a skeleton."]
    holed = str(check(Mesh(TORUS.vertices, TORUS.faces[1:])))
    assert "1 component: open" in holed
    assert holed.endswith("  found     1 hole in the surface.\n  found     1 hole is closed with 1 face.")


def test_components_of_one_genus_are_counted(tetrahedron):
    crumbs = [moved(tetrahedron, 3.0 + 2 * i) for i in range(12)]
    [line, *_] = str(check(joined(TORUS, *crumbs))).splitlines()
    assert line.endswith("13 components: 12 genus 0, 1 genus 1")


def test_vertices_and_faces_and_paths_are_taken(tmp_path):
    assert check((TORUS.vertices, TORUS.faces)) == check(TORUS)
    write_mesh(tmp_path / "ring.ply", TORUS)
    assert check(tmp_path / "ring.ply").genera == (1,)


def test_angles_are_in_degrees_and_edges_relative_to_the_diameter_bound():
    """A right triangle with sides 3, 4 and 5, whose centroid is (1, 4/3)."""
    report = check(Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]]))
    assert (report.min_angle_deg, report.max_angle_deg) == pytest.approx((np.degrees(np.arctan(0.75)), 90.0))
    bound = 2 * np.hypot(1, 8 / 3)
    assert bound * np.array([report.shortest_edge, report.median_edge, report.longest_edge]) == pytest.approx([3, 4, 5])
    assert (report.diameter_bound, report.area, report.volume) == (pytest.approx(bound), 6.0, None)
