"""``lbskel edit``: the edited mesh is written, regions are parsed, and the change of lengths is printed."""

import numpy as np
import pytest

import lbskel


def test_the_edited_mesh_is_written_and_the_change_is_printed(here, folder):
    arguments = ("--fix", "z:0:0.2", "--move", "z:0.8:1", "--axis", "0,1,0", "--angle", "30", "--translate", "0,0,0.1")
    code, out, err = here("edit", "rod.off", "-o", "out.ply", *arguments)
    assert (code, err) == (0, [])
    rod, result = lbskel.read_mesh(folder / "rod.off"), lbskel.read_mesh(folder / "out.ply")
    z = rod.vertices[:, 2]
    share = (z - z.min()) / np.ptp(z)
    assert result.vertices[share <= 0.2] == pytest.approx(rod.vertices[share <= 0.2], abs=1e-12)
    top = rod.vertices[share >= 0.8]
    motion = lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=30, center=top.mean(axis=0), translation=[0, 0, 0.1])
    expected = top @ motion[:3, :3].T + motion[:3, 3]
    assert result.vertices[share >= 0.8] == pytest.approx(expected, abs=1e-12)
    assert f"{(share <= 0.2).sum()} vertices fixed, {(share >= 0.8).sum()} moved; edge lengths changed by" in out[1]


def test_a_translation_of_everything_changes_no_length(here):
    _, out, _ = here("edit", "ring.obj", "-o", "out.ply", "--move", "x:0:0.1", "--translate", "1,2,3")
    assert "0 vertices fixed" in out[1]
    assert float(out[1].split(" % at most")[0].split()[-1]) < 1e-9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--move", "w:0:1"), "must be AXIS:LOW:HIGH"),
        (("--move", "z:0.9:1", "--fix", "xy:0:0.1"), "must be AXIS:LOW:HIGH"),
        (("--move", "z:0.9:1", "--fix", ":0:0.1"), "must be AXIS:LOW:HIGH"),
        (("--move", "z:0:1", "--axis", "1,2"), "must be X,Y,Z"),
        (("--move", "z:0:1", "--translate", "inf,0,0"), "argument --translate: must be X,Y,Z, three finite numbers"),
        (("--move", "z:0.4:1", "--fix", "x:0:1", "--fix", "z:0:0.1"), "in a region of --fix and in that of --move"),
        (("--move", "z:0.9:1", "--method", "harmonic", "--iterations", "3"), "the method harmonic solves once"),
        (("--move", "z:2:3"), "no vertex in the region z:2:3"),
        (("--move", "z:0.9:1", "--axis", "0,0,0"), "lbskel: a rotation needs an axis that is not zero"),
    ],
)
def test_wrong_options_are_named(here, arguments, message):
    code, _, err = here("edit", "rod.off", "-o", "out.ply", *arguments)
    assert code == 2
    assert message in err[0]


def test_the_iterations_are_those_of_the_editor(here, folder):
    region = ("--fix", "z:0:0.2", "--move", "z:0.8:1", "--axis", "0,1,0", "--angle", "90")
    written = {}
    for count in ((), ("--iterations", "10"), ("--iterations", "1")):
        assert here("edit", "rod.off", "-o", "out.ply", "--force", *region, *count)[0] == 0
        written[count] = lbskel.read_mesh(folder / "out.ply").vertices
    default, ten, one = written.values()
    assert np.array_equal(default, ten)
    assert not np.array_equal(default, one)


def test_edges_without_length_change_by_nothing(here, folder):
    (folder / "point.off").write_text("OFF\n4 2 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n3 1 2 3\n")
    move = ("--move", "x:0:1", "--translate", "1,0,0", "--method", "similarity")
    code, out, err = here("edit", "point.off", "-o", "out.ply", *move)
    assert (code, err) == (0, [])
    assert "edge lengths changed by 0 % on average, 0 % at most" in out[1]
