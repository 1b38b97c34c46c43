"""``lbskel rig``: a glb with bones."""

import trimesh


def test_rig(here, folder):
    code, out, err = here("rig", "rod.off", "-o", "rod.glb", "--up", "z")
    assert (code, err) == (0, [])
    assert out[0].startswith("rod.glb: ")
    assert "root" in out[0]
    assert len(trimesh.load(folder / "rod.glb", force="mesh").vertices) == 152
    assert here("rig", "rod.off", "-o", "rod.glb")[2] == ["lbskel: rod.glb exists already; give --force to replace it"]
    assert here("rig", "rod.off", "-o", "rod.fbx")[2] == ["lbskel: rod.fbx: the name must end in .glb"]
    assert here("rig", "rod.off", "-o", "rod.glb", "--force", "--max-bones", "0")[0] == 2
