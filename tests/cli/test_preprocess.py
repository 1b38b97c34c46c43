"""``lbskel preprocess``: the mesh, its vertex map and the report are written, or nothing is."""

import json

import numpy as np
import pytest

import lbskel
from lbskel.shapes import torus


def test_the_mesh_its_map_and_the_report_are_written(here, folder):
    arguments = (
        "rod.off",
        "-o",
        "fewer.ply",
        "--preprocess",
        "simplify:target_faces=120",
        "--map",
        "map.npy",
        "--report",
        "r.json",
    )
    code, out, err = here("preprocess", *arguments)
    assert (code, err) == (0, [])
    fewer = lbskel.read_mesh(folder / "fewer.ply")
    assert len(fewer.faces) <= 132
    assert out[-1] == f"fewer.ply: {len(fewer.vertices)} vertices, {len(fewer.faces)} faces"
    mapped = np.load(folder / "map.npy")
    assert (len(mapped), mapped.max()) == (152, len(fewer.vertices) - 1)
    assert json.loads((folder / "r.json").read_text())["pipeline"] == "simplify:target_faces=120"


def test_an_existing_file_is_kept(here, folder):
    (folder / "out.ply").write_text("mine")
    code, out, err = here("preprocess", "rod.off", "-o", "out.ply")
    assert (code, out) == (2, [])
    assert "out.ply exists already" in err[0]
    assert (folder / "out.ply").read_text() == "mine"


def test_two_outputs_of_one_name_are_refused(here, folder):
    np.savetxt(folder / "points.xyz", torus(1.0, 0.3).vertices)
    arguments = ("points.xyz", "-o", "a.npy", "--map", "./a.npy", "--preprocess", "voxel:cell=0.1")
    code, _, [line] = here("preprocess", *arguments)
    assert (code, line) == (2, "lbskel: a.npy: is named for two outputs; give each a name of its own")
    assert not (folder / "a.npy").exists()


@pytest.mark.parametrize("option", ["--map", "--report"])
def test_the_input_is_no_output_beside_the_mesh(here, folder, option):
    name = {"--map": "points.npy", "--report": "rod.json"}[option]
    np.save(folder / "points.npy", torus(1.0, 0.3).vertices)
    before = (folder / "points.npy").read_bytes()
    (folder / "rod.json").symlink_to(folder / "rod.off")
    mesh = {"--map": "points.npy", "--report": "rod.off"}[option]
    code, _, [line] = here("preprocess", mesh, "-o", "out.ply", option, name, "--force")
    assert (code, line) == (2, f"lbskel: {name}: is an input, and would be lost; give the output another name")
    assert (folder / "points.npy").read_bytes() == before
    assert not (folder / "out.ply").exists()


def test_an_unknown_step_is_named(here):
    code, _, err = here("preprocess", "rod.off", "-o", "out.ply", "--preprocess", "polish")
    assert code == 2
    assert "polish" in err[0]


def test_the_surface_of_a_point_cloud(here, folder):
    np.savetxt(folder / "cloud.xyz", torus(1.0, 0.3).vertices)
    code, out, err = here("preprocess", "cloud.xyz", "-o", "surface.ply", "--map", "map.npy")
    assert (code, err) == (0, [])
    assert out[0] == "cloud.xyz: 1,152 points"
    surface = lbskel.read_mesh(folder / "surface.ply")
    assert surface.genus == 1
    assert len(np.load(folder / "map.npy")) == 1152
    code, out, err = here("preprocess", "cloud.xyz", "-o", "surface.off", "--pipeline", "cad")
    assert (code, out) == (2, [])
    assert "auto, scan, none" in err[0]


def test_a_mesh_that_a_format_cannot_hold_names_its_file(here, folder, rod):
    lbskel.write_mesh(folder / "huge.off", rod.with_vertices(rod.vertices * 1e50))
    code, _, [line] = here("preprocess", "huge.off", "-o", "huge.stl", "--preprocess", "none")
    assert (code, line) == (
        2,
        "lbskel: huge.stl: coordinates overflow the single precision of STL; write obj, off or ply",
    )
