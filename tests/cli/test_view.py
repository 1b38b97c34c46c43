"""``lbskel view``: a page of a mesh, a cloud, or a skeleton from a file."""

import pytest


def test_view(here, folder):
    assert here("view", "rod.off", "-o", "rod.html") == (0, ["rod.html: 16 nodes, 2 tips, 0 cycles"], [])
    text = (folder / "rod.html").read_text()
    assert "<h1>rod.off</h1>" in text
    assert 'id="step"' in text
    assert here("view", "rod.off", "-o", "rod.html")[2] == [
        "lbskel: rod.html exists already; give --force to replace it"
    ]
    assert here("view", "rod.off", "-o", "rod.htm")[2] == ["lbskel: rod.htm: the name must end in .html"]
    assert here("view", "rod.off", "-o", "rod.html", "--force", "--quiet") == (0, [], [])


@pytest.mark.parametrize("extension", ["npz", "swc"])
def test_a_skeleton_from_a_file_is_shown(here, folder, extension):
    here("skeletonize", "rod.off", "-o", f"rod.{extension}", "--quiet")
    assert here("view", "rod.off", "-o", "rod.html", "--skeleton", f"rod.{extension}")[0] == 0
    assert ('id="step"' in (folder / "rod.html").read_text()) == (extension == "npz")  # swc holds no report


def test_the_skeleton_of_another_mesh_is_refused(here, folder):
    here("skeletonize", "rod.off", "-o", "rod.npz", "--quiet")
    code, out, err = here("view", "ring.obj", "-o", "ring.html", "--skeleton", "rod.npz")
    assert (code, out) == (2, [])
    assert "map is for 152 vertices, but the mesh has 128" in err[0]
    assert not (folder / "ring.html").exists()


def test_a_point_cloud_is_shown(here, folder, rod):
    with open("rod.xyz", "w") as file:
        file.writelines(f"{x} {y} {z}\n" for x, y, z in rod.vertices)
    assert here("view", "rod.xyz", "-o", "cloud.html")[0] == 0
    assert "A point cloud of 152 points." in (folder / "cloud.html").read_text()
