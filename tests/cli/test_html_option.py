"""``--html`` of several commands."""

import sys

import pytest


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (["skeletonize", "rod.off", "-o", "rod.swc"], "Score: "),
        (["segment", "rod.off", "-o", "parts.ply"], "limbs and trunk"),
        (["rig", "rod.off", "-o", "rod.glb"], "parts by strongest bone"),
    ],
)
def test_a_page_is_written_beside_the_result(here, folder, arguments, shown):
    assert here(*arguments, "--html", "rod.html")[0] == 0
    assert shown in (folder / "rod.html").read_text()
    (folder / arguments[-1]).unlink()
    assert here(*arguments, "--html", "rod.html")[::2] == (
        2,
        ["lbskel: rod.html exists already; give --force to replace it"],
    )
    assert not (folder / arguments[-1]).exists()  # refused before anything is written
    assert here(*arguments, "--html", "rod.png")[0] == 2


def test_several_inputs_have_a_page_each(here, folder):
    (folder / "pages").mkdir()
    assert here("skeletonize", "rod.off", "ring.obj", "-o", ".", "--html", "pages")[0] == 0
    assert sorted(path.name for path in (folder / "pages").iterdir()) == ["ring.html", "rod.html"]


def test_without_plotly_nothing_is_begun(here, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.setattr("lbskel.visualization.interactive.find_spec", lambda name: None)
    code, _, err = here("segment", "rod.off", "-o", "parts.ply", "--html", "rod.html")
    assert code == 2
    assert "pip install 'lbskel[view]'" in err[0]
    assert not (folder / "parts.ply").exists()
