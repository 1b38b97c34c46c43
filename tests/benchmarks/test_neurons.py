"""The benchmark of neurons: shares of cable and tips, parts of a tracing, tubes of it, and rows of failures."""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import neurons, thin_tools
from benchmarks.neurons import hemibrain_row, part_of, remeshed, tube_row
from benchmarks.thin_tools import Answer
from lbskel import Mesh, Skeleton, write_skeleton
from lbskel.shapes import Shape, tube_mesh


def path(points, radius=20.0):
    k = np.arange(len(points) - 1)
    return Skeleton(points, np.stack([k, k + 1], axis=1), np.full(len(points), radius))


def straight(length, y=0.0):
    return path([[0, y, 0], [length, y, 0]])


def test_cable_and_tips_are_found_within_their_distances():
    truth = straight(1000)
    row = hemibrain_row("a", "tool", truth, Answer(straight(500, y=30), 2.5), 12)
    # samples are 5 apart; of the truth 500 and what is within 40 of the end at a height of 30 is found
    assert row["precision"] == 1
    assert row["recall"] == pytest.approx(0.54, abs=0.01)
    assert pytest.approx(2 * row["recall"] / (1 + row["recall"])) == row["F"]
    assert row["to axis"] == pytest.approx(30 / 20)
    assert (row["tips found"], row["tip precision"]) == (0.5, 0.5)
    assert (row["length / true length"], row["cpu seconds"], row["components"]) == (0.5, 2.5, 1)
    apart = hemibrain_row("a", "tool", truth, Answer(straight(1000, y=51), 1.0), 12)
    assert (apart["F"], apart["tips found"]) == (0, 1)


def test_a_failure_is_a_row_and_no_part_of_the_means():
    good = hemibrain_row("a", "tool", straight(100), Answer(straight(100), 1.0), 12)
    bad = hemibrain_row("b", "tool", straight(100), "over 1 s", 12)
    assert bad == {"neuron": "b", "tool": "tool", "faces": 12, "error": "over 1 s"}
    summary = neurons._summary([good, bad], "tool")
    assert (summary["F"], summary["failed"], summary["one component"]) == (1, 1, "1/2")
    assert tube_row("b", "tool", tube_mesh(straight(400)), "no edges")["error"] == "no edges"


def fork():
    """A thick root, a twig, and a fork of three ends."""
    nodes = [[0, 0, 0], [0, 0, 9], [0, 5, 9], [0, 0, 20], [9, 0, 25], [-9, 0, 25], [0, 9, 25]]
    edges = [[0, 1], [1, 2], [1, 3], [3, 4], [3, 5], [3, 6]]
    return Skeleton(nodes, edges, [2.0, 1.0, 0.5, 0.8, 0.5, 0.5, 0.5])


@pytest.mark.parametrize(("n_tips", "nodes"), [(5, 7), (4, 6), (3, 4), (1, 1)])
def test_a_part_is_the_largest_subtree_of_so_many_tips(n_tips, nodes):
    # the whole has five ends, the root among them; without the root four are left, of which three at one fork
    assert len(part_of(fork(), n_tips).nodes) == nodes


@pytest.mark.parametrize(("max_length", "nodes"), [(73, 7), (72, 6), (66, 4), (47, 1)])
def test_a_part_is_no_longer_than_so_many_of_its_radii(monkeypatch, max_length, nodes):
    """The ends of the fork are 15.8 radii from it each, which is 12.2 from the next node, the twig 6.7, the root 6."""
    monkeypatch.setattr(neurons, "MAX_LENGTH", max_length)
    assert len(part_of(fork(), 5).nodes) == nodes


def test_tubes_are_rough_and_coarse_and_give_the_tracing_back():
    shape = tube_mesh(fork())
    coarse = remeshed(shape)
    assert coarse.mesh.is_closed_manifold
    assert len(coarse.mesh.faces) == pytest.approx(len(shape.mesh.faces) / 2, rel=0.1)
    row = tube_row("a", "lbskel", coarse, Answer(Skeleton(shape.truth.nodes, shape.truth.edges, shape.truth.radii), 1))
    assert (row["sections"], row["tips"], row["tips found"]) == ("6/6", "5/5", 1)
    assert abs(row["length error"]) < 1e-12


def test_radii_are_compared_with_those_of_the_mesh_too():
    """The mesh has the radii of the tube, and the tracing a tenth less."""
    tube = tube_mesh(straight(400))
    thin = Shape(tube.mesh, replace(tube.truth, radii=0.9 * tube.truth.radii), "thin")
    right = replace(tube.truth, mean_radii=tube.truth.radii)
    row = tube_row("a", "lbskel", thin, Answer(right, 1))
    assert row["mean radius error"] == pytest.approx(1 / 9)
    assert (
        row["mean radius error to the mesh"] < 0.02
    )  # vertices are 1.5 % outside the tube, so that its volume is kept
    assert tube_row("a", "tool", thin, Answer(tube.truth, 1))["mean radius error to the mesh"] is None


def test_sections_are_counted_without_those_shorter_than_a_radius():
    nodes = [[0, 0, 0], [0, 0, 9], [0, 0, 9.5], [0, 9, 12], [0, -9, 12], [9, 0, 9]]
    two_forks = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [2, 4], [1, 5]], np.full(6, 1.0))
    assert (len(two_forks.branches), neurons._sections(two_forks, two_forks)) == (5, 4)


def test_the_benchmark_writes_its_tables(tmp_path, monkeypatch):
    tracing = fork()
    shape = tube_mesh(tracing)
    monkeypatch.setattr(
        neurons, "hemibrain_neurons", lambda n: [("x", Mesh(shape.mesh.vertices, shape.mesh.faces), tracing)]
    )
    monkeypatch.setattr(neurons, "_files", lambda name: [])
    monkeypatch.setattr(neurons, "ask", lambda tool, mesh, n_calls=1: Answer(tracing, 1.0, "pass"))
    write_skeleton(tmp_path / "other.swc", tracing)
    neurons.run(True, tmp_path, peers=True, meshes=[tmp_path / "other.swc"])
    document = json.loads((tmp_path / "neurons.json").read_text())
    assert [row["tool"] for row in document["summary"]] == list(thin_tools.TOOLS)
    assert {row["F"] for row in document["summary"]} == {1.0}
    assert [row["neuron"] for row in document["tubes"]] == ["x"] * len(thin_tools.TOOLS)
    assert [row["neuron"] for row in document["voxels"]] == ["x"] * len(thin_tools.TOOLS)
    assert [row["neuron"] for row in document["other tubes"]] == ["other"]
    headings = (tmp_path / "neurons.md").read_text()
    assert "## Tubes around parts of the tracings" in headings
    assert "## Voxels in the same tubes" in headings
    assert "## Tubes around parts of other tracings" in headings
