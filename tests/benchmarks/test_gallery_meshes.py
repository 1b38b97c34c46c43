"""Pictures of real meshes beside other tools: what is drawn and counted, and that the committed page has twelve."""

import json

import numpy as np
import pytest
from helpers import flat_tube, png_pixels

import lbskel
from benchmarks import gallery_meshes
from lbskel.shapes import tube_mesh

RESULTS = gallery_meshes.Path(gallery_meshes.__file__).parent / "results"


def test_a_mesh_of_the_folder_has_a_picture_from_two_sides_and_others_are_left_out(tmp_path):
    (tmp_path / "results").mkdir()
    paths = [tmp_path / "hand.off", tmp_path / "other.off"]
    for path in paths:
        lbskel.write_mesh(path, flat_tube())
    gallery_meshes.run(False, tmp_path / "results", meshes=paths)
    names = sorted(path.name for path in (tmp_path / "results").iterdir())
    assert names == ["gallery_meshes.json", "gallery_meshes.md", "gallery_meshes_hand.png"]
    [row] = json.loads((tmp_path / "results" / "gallery_meshes.json").read_text())["skeletons"]
    assert (row["tool"], row["tips"], row["cycles"]) == ("lbskel", 2, 0)
    image = png_pixels((tmp_path / "results" / "gallery_meshes_hand.png").read_bytes()).min(axis=2)
    front, side = ((half < 250).mean() for half in (image[: len(image) // 2], image[len(image) // 2 :]))
    assert min(front, side) > 0.01  # not blank
    assert abs(front - side) > 0.01  # the tube is flat, and is seen across and along its width


@pytest.mark.parametrize("angle", [0, 29, 31, 150])
def test_an_end_turns_by_the_angle_between_its_last_two_pieces(angle):
    """One end of two pieces of length 1 and one straight end; a third is shorter than two pieces, and turns by 90."""
    turn = np.radians(angle)
    nodes = [[0, 0, 0], [3, 0, 0], [3 + np.cos(turn), np.sin(turn), 0], [-5, 0, 0], [0, 1, 0], [0.5, 1, 0]]
    skeleton = lbskel.Skeleton(nodes, [[0, 1], [1, 2], [0, 3], [0, 4], [4, 5]], np.ones(6))
    turns = [gallery_meshes._turn(end) for end in gallery_meshes._last_pieces(skeleton, 1.0)]
    assert turns == pytest.approx([angle, 0], abs=1e-5)


@pytest.mark.parametrize("angle", [0, 50])
def test_a_limb_turns_by_the_angle_of_its_tube_however_its_skeleton_ends(angle):
    """Bands are shells around the end of a limb, so that their centroids are within a tenth of a piece of the axis."""
    turn = np.radians(angle)
    mesh, tip = _bent_tube(turn, 0.4), 4 * np.array([np.cos(turn), np.sin(turn), 0])
    straight, crooked = np.array([tip, [0, 0, 0], [-4, 0, 0]]), np.array([tip, [0, 0, 0], [0, -4, 0]])
    for end in (straight, crooked):
        assert gallery_meshes._turn_of_limb(end, mesh, 4.0) == pytest.approx(angle, abs=10)


def test_a_thick_limb_excuses_no_crooked_end():
    """Bands on the cap of a limb that is as thick as a piece is long are no rings: their centroids tell no turn."""
    end = np.array([[2.0, 3.46, 0], [0, 0, 0], [-4, 0, 0]])
    assert gallery_meshes._turn_of_limb(end, _bent_tube(np.pi / 3, 3.0), 4.0) == 0


def _bent_tube(turn, radius):
    """A tube along x to the origin, and on for four units at an angle."""
    along = 4.0 * np.linspace(0, 1, 9)[1:, None] * [np.cos(turn), np.sin(turn), 0]
    nodes = np.concatenate([[[-8.0, 0, 0], [0, 0, 0]], along])
    edges = np.stack([np.arange(9), np.arange(1, 10)], axis=1)
    return tube_mesh(lbskel.Skeleton(nodes, edges, np.full(10, radius))).mesh


def test_a_tool_that_fails_is_told(monkeypatch):
    monkeypatch.setitem(gallery_meshes.PEERS, "CGAL", _fails)
    row, skeleton = gallery_meshes._row("CGAL", "tube.off", flat_tube())
    assert "no such tool" in row["error"]
    assert skeleton is None
    assert gallery_meshes._from_two_sides(flat_tube(), [(row, skeleton)]).startswith(b"\x89PNG")


def _fails(vertices, faces):
    raise RuntimeError("no such tool")


def test_the_page_shows_twelve_meshes_by_three_tools():
    page = (RESULTS / "gallery_meshes.md").read_text(encoding="utf-8")
    for name in gallery_meshes.NAMES:
        assert f"(gallery_meshes_{name}.png)" in page
        assert (RESULTS / f"gallery_meshes_{name}.png").stat().st_size < 200_000
    rows = json.loads((RESULTS / "gallery_meshes.json").read_text(encoding="utf-8"))["skeletons"]
    assert len(rows) == 12 * len(gallery_meshes.TOOLS)
