"""``lbskel quantize``: the reconstructed mesh is written, and its rate and errors are printed."""

import numpy as np
import pytest

import lbskel


def test_the_mesh_is_written_and_errors_are_printed(here, folder):
    code, out, err = here("quantize", "ring.obj", "-o", "out.ply", "--bits", "7", "--anchors", "5")
    assert (code, err) == (0, [])
    expected = lbskel.quantize_deltas(lbskel.read_mesh(folder / "ring.obj"), bits=7, n_anchors=5)
    assert np.array_equal(lbskel.read_mesh(folder / "out.ply").vertices, expected.mesh.vertices)
    assert out[1].startswith(f"out.ply: {expected.bits_per_vertex:.3g} bits per vertex, 5 anchors, error ")
    assert out[2].startswith("positions of 7 bits: error ")


def test_wrong_options_and_existing_files_are_refused(here):
    assert "bits must be" in here("quantize", "rod.off", "-o", "a.ply", "--bits", "0")[2][0]
    assert (
        "--anchors must be a whole number from 1 on, not 0"
        in here("quantize", "rod.off", "-o", "a.ply", "--anchors", "0")[2][0]
    )
    assert "exists already" in here("quantize", "rod.off", "-o", "ring.obj")[2][0]


@pytest.mark.parametrize("exponent", [-600, -332, 0, 332])
def test_the_unit_changes_neither_codes_nor_errors(here, folder, ring, exponent):
    lbskel.write_mesh("a.ply", ring.with_vertices(np.ldexp(ring.vertices, exponent)))
    code, [_, written, positions], err = here("quantize", "a.ply", "-o", "b.ply")
    assert (code, err) == (0, [])
    expected = lbskel.quantize_deltas(ring)
    assert np.array_equal(np.ldexp(lbskel.read_mesh("b.ply").vertices, -exponent), expected.mesh.vertices)
    _, [_, *of_ring], _ = here("quantize", "ring.obj", "-o", "c.ply")
    assert [written.replace("b.ply", "c.ply"), positions] == of_ring


def test_a_mesh_without_area_is_refused(here, folder):
    """Its errors would be NaN, which is no JSON."""
    (folder / "line.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n")
    code, out, [line] = here("quantize", "line.off", "-o", "out.ply", "--json")
    assert (code, out) == (2, [])
    assert line.startswith("lbskel: line.off: the mesh has no area")
    assert not (folder / "out.ply").exists()
