"""``lbskel smooth``: the mesh is written, and what has changed is printed."""

import numpy as np
import pytest

import lbskel


def test_the_smoothed_mesh_is_written_and_the_change_is_printed(here, folder):
    code, out, err = here("smooth", "ring.obj", "-o", "out.ply", "--method", "implicit", "--keep-volume")
    assert (code, err) == (0, [])
    ring = lbskel.read_mesh(folder / "ring.obj")
    expected = lbskel.smooth(ring, method="implicit", keep_volume=True)
    assert np.array_equal(lbskel.read_mesh(folder / "out.ply").vertices, expected.vertices)
    assert out[0] == "ring.obj: 128 vertices, 256 faces"
    assert "128 vertices moved by" in out[1]
    volume = float(out[1].split("volume ")[1].split()[0])
    assert volume == pytest.approx(0, abs=1e-8)


def test_the_boundary_stays_unless_it_is_free(here, folder):
    assert here("smooth", "pipe.ply", "-o", "held.ply")[0] == 0
    assert here("smooth", "pipe.ply", "-o", "freed.ply", "--free-boundary", "--time-step", "0.01")[0] == 0
    pipe, held, freed = (lbskel.read_mesh(folder / f"{name}.ply") for name in ("pipe", "held", "freed"))
    boundary = np.unique(pipe.edges[pipe.faces_per_edge == 1])
    assert (held.vertices[boundary] == pipe.vertices[boundary]).all()
    assert (freed.vertices[boundary] != pipe.vertices[boundary]).any(axis=1).all()


def test_wrong_options_and_existing_files_are_refused(here):
    assert "stable up to" in here("smooth", "rod.off", "-o", "a.ply", "--method", "explicit", "--time-step", "9")[2][0]
    assert "exists already" in here("smooth", "rod.off", "-o", "ring.obj")[2][0]
    assert here("smooth", "rod.off", "-o", "a.xyz")[0] == 2


def test_shares_are_printed_of_meshes_whose_areas_vanish(here, folder):
    rod = lbskel.read_mesh(folder / "rod.off")
    lbskel.write_mesh(folder / "tiny.off", rod.with_vertices(2.0**-400 * rod.vertices))
    whole, tiny = (here("smooth", name, "-o", f"{name}.ply") for name in ("rod.off", "tiny.off"))
    assert tiny[0] == 0
    assert tiny[1][1].split(":")[1] == whole[1][1].split(":")[1]


@pytest.mark.parametrize("x", [0.0, 1.0])
def test_meshes_without_an_area_have_no_share_of_it(here, folder, x):
    """All at one point, or on a line: the mean of the neighbors needs no area."""
    (folder / "line.off").write_text(
        f"OFF\n4 4 0\n0 0 0\n{x} 0 0\n{3 * x} 0 0\n{7 * x} 0 0\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
    )
    code, out, _ = here("smooth", "line.off", "-o", "out.off", "--method", "taubin", "--operator", "random_walk")
    assert code == 0
    assert "area" not in out[1]
    assert f"{4 * int(x)} vertices moved" in out[1]
