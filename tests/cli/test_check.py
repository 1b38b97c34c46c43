"""``lbskel check``: the report as text and as JSON, and exit code 1 where contraction is not advised."""

import json

import numpy as np

import lbskel
from lbskel.shapes import flat_grid


def test_a_sound_mesh_is_reported(here, rod):
    code, out, err = here("check", "rod.off")
    assert (code, err) == (0, [])
    assert out[0] == "rod.off: 152 vertices, 300 faces, 1 component: genus 0"


def test_json_has_every_measure(here, rod):
    code, out, _ = here("check", "rod.off", "--json")
    report = lbskel.check(rod).as_dict()
    assert code == 0
    assert json.loads(out[0])["faces"] == report["faces"] == 300


def test_contraction_of_a_flat_closed_surface_is_not_advised(here, folder):
    sheet = flat_grid(3, 3)
    faces = np.concatenate([sheet.faces, sheet.faces[:, ::-1]])
    lbskel.write_mesh(folder / "flat.off", lbskel.Mesh(sheet.vertices, faces))
    assert here("check", "flat.off")[0] == 1
