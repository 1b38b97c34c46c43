"""``lbskel segment``: a ply and a table of parts."""

import pytest
import trimesh


def test_segment(here, folder):
    code, out, err = here("segment", "rod.off", "-o", "parts.ply", "--table", "parts.csv")
    assert (code, out, err) == (0, ["parts.ply: 1 part"], [])
    assert len(trimesh.load(folder / "parts.ply", process=False).visual.face_colors) > 100
    table = pytest.importorskip("pandas").read_csv(folder / "parts.csv")
    assert table["n_faces"].tolist() == [len(trimesh.load(folder / "rod.off", process=False).faces)]
    assert here("segment", "rod.off", "-o", "parts.ply")[2] == [
        "lbskel: parts.ply exists already; give --force to replace it"
    ]
    assert here("segment", "rod.off", "-o", "parts.off")[2] == ["lbskel: parts.off: the name must end in .ply"]
