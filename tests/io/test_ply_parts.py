"""Parts as PLY: trimesh reads the faces and their colors, lbskel the mesh."""

import numpy as np

from lbskel import read_mesh
from lbskel.io.ply_parts import encode_ply_parts, part_colors


def test_trimesh_reads_the_colors_and_lbskel_the_mesh(tmp_path, ring):
    import trimesh

    path, parts = tmp_path / "parts.ply", np.arange(len(ring.faces)) % 5
    path.write_bytes(encode_ply_parts(ring, parts))
    read = trimesh.load(path, process=False)
    assert np.array_equal(read.vertices, ring.vertices)
    assert np.array_equal(read.faces, ring.faces)
    assert np.array_equal(read.visual.face_colors[:, :3], part_colors(5)[parts])
    assert np.array_equal(read.metadata["_ply_raw"]["face"]["data"]["part"].ravel(), parts)
    assert np.array_equal(read_mesh(path).vertices, ring.vertices)


def test_the_colors_of_many_parts_differ():
    assert len(np.unique(part_colors(60), axis=0)) == 60
    assert part_colors(0).shape == (0, 3)
