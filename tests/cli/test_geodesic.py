"""``lbskel geodesic``: the table and the picture of distances, and what is refused."""

import argparse

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import FormatError, MeshError, geodesic_distance
from lbskel.cli import geodesic as command
from lbskel.io import write_mesh
from lbskel.shapes import torus


def run_command(*arguments):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    parsed = parser.parse_args(["geodesic", *map(str, arguments)])
    return parsed.run(parsed)


def test_vertices_that_are_not_reached_are_in_no_band(tmp_path, capsys):
    path = tmp_path / "rings.off"
    ring = torus(1.0, 0.3, 24, 12)
    write_mesh(path, joined(ring, moved(ring, 4.0)))
    assert run_command(path, "--source", 3, "--picture", tmp_path / "distances.png") == 0
    assert "288 of 576 vertices reached" in capsys.readouterr().out


def test_distances_are_printed_written_and_drawn(tmp_path, capsys):
    path, table, picture = tmp_path / "ring.off", tmp_path / "distances.csv", tmp_path / "distances.png"
    mesh = torus(1.0, 0.3, 24, 12)
    write_mesh(path, mesh)
    assert run_command(path, "--source", 3, "--source", 70, "-o", table, "--picture", picture) == 0
    expected = geodesic_distance(path, [3, 70])
    head, *rows = table.read_text().splitlines()
    assert head == "vertex,distance"
    assert np.array_equal(np.array([row.split(",") for row in rows], dtype=float)[:, 1], expected)
    printed = capsys.readouterr().out
    assert "288 of 288 vertices reached" in printed
    assert f"at most {expected.max():.6g}" in printed
    assert picture.read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(FormatError, match="exists"):
        run_command(path, "--source", 3, "-o", table)
    with pytest.raises(MeshError, match="no vertices of the mesh"):
        run_command(path, "--source", 10**6)


def test_there_is_no_operator_since_distances_across_unfolded_triangles_hardly_depend_on_it(here):
    """They differ by 1e-12 between the operators; ``unfolded=False`` is of Python alone."""
    code, _, err = here("geodesic", "rod.off", "--source", "0", "--operator", "graph")
    assert code == 2
    assert "--operator" in err[0]
