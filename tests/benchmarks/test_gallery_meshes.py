"""Pictures of real meshes beside other tools: what is drawn and counted, and that the committed page has twelve."""

import json

import numpy as np
import pytest
from helpers import flat_tube, png_pixels

import lbskel
from benchmarks import gallery_meshes

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
    assert gallery_meshes._turns_at_tips(skeleton, 1.0) == pytest.approx([angle, 0], abs=1e-5)


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
