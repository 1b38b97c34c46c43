"""``lbskel rig``: a glb with bones."""

import re

import trimesh
from helpers import joined, moved

from lbskel import write_mesh


def test_rig(here, folder):
    code, out, err = here("rig", "rod.off", "-o", "rod.glb", "--up", "z")
    assert (code, err) == (0, [])
    assert out[0].startswith("rod.glb: ")
    assert "root" in out[0]
    assert len(trimesh.load(folder / "rod.glb", force="mesh").vertices) == 152
    assert here("rig", "rod.off", "-o", "rod.glb")[2] == ["lbskel: rod.glb exists already; give --force to replace it"]
    assert here("rig", "rod.off", "-o", "rod.fbx")[2] == ["lbskel: rod.fbx: the name must end in .glb"]
    assert here("rig", "rod.off", "-o", "rod.glb", "--force", "--max-bones", "0")[0] == 2


def test_help_and_output_tell_what_a_rig_has_not(here, folder):
    assert "no images or materials" in " ".join(here("rig", "--help")[1])
    out = here("rig", "rod.off", "-o", "rod.glb", "--max-bones", "1")[1]
    assert (out[0], "1 limb got no bone" in out[1]) == ("rod.glb: 1 bone: root", True)


def test_texture_coordinates_of_an_obj_are_kept_or_told(here, folder, rod):
    write_mesh(folder / "rod.obj", rod)
    text = (folder / "rod.obj").read_text()
    for corner, is_kept in ((r"f \1/1 \2/2 \3/2", True), (r"f \1/1 \2/1 \3", False)):
        faces = re.sub(r"f (\d+) (\d+) (\d+)", corner, text)
        (folder / "uv.obj").write_text("vt 0 0.25\nvt 1 0.5\n" + faces)
        code, out, err = here("rig", "uv.obj", "-o", "uv.glb", "--force")
        assert (code, err) == (0, [])
        assert (b"TEXCOORD_0" in (folder / "uv.glb").read_bytes()) is is_kept
        assert ("no texture coordinates were written: line" in " ".join(out)) is not is_kept


def test_a_component_that_hangs_on_no_bone_is_told_and_join_hangs_it_on_one(here, folder, rod):
    """A long body, and beside it a garment of its own that is too long to belong to a bone of the body."""
    long = rod.with_vertices(rod.vertices * [0.5, 0.5, 1])
    write_mesh(folder / "dressed.off", joined(long, moved(long, 0.45)))
    code, out, err = here("rig", "dressed.off", "-o", "out.glb")
    assert (code, "root_2" in out[0]) == (0, True)
    assert "root_2 hangs on no bone" in err[0]
    code, out, err = here("rig", "dressed.off", "-o", "out.glb", "--join", "all", "--force")
    assert (code, "root_2" in out[0], err) == (0, False, [])
