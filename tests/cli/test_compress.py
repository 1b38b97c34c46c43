"""``lbskel compress``: the decoded mesh, its rate and its error, and what is refused."""

import argparse

import numpy as np
import pytest

from lbskel import FormatError, compress, read_mesh
from lbskel.cli import compress as command
from lbskel.io import write_mesh
from lbskel.shapes import sphere


def run_command(*arguments):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    parsed = parser.parse_args(["compress", *map(str, arguments)])
    return parsed.run(parsed)


def test_the_decoded_mesh_is_written_and_its_rate_and_error_printed(tmp_path, capsys):
    path, out = tmp_path / "ball.off", tmp_path / "few.ply"
    write_mesh(path, sphere(3))
    assert run_command(path, "-o", out, "-k", 40, "--bits", 10, "--basis", "geometry_aware") == 0
    packed = compress(path, 40, bits=10, basis="geometry_aware")
    assert np.array_equal(read_mesh(out).faces, packed.faces)
    assert np.abs(read_mesh(out).vertices - packed.mesh.vertices).max() < 1e-6  # files hold single precision
    printed = capsys.readouterr().out
    assert "40 coefficients of 642 vertices" in printed
    assert f"{packed.bits_per_vertex:.3g} bits a vertex" in printed
    assert f"rms error {packed.rms_error(path):.3g}" in printed
    with pytest.raises(FormatError, match="exists"):
        run_command(path, "-o", out)


def test_a_small_mesh_has_a_function_for_each_vertex_at_most(tmp_path, capsys):
    path = tmp_path / "ball.off"
    write_mesh(path, sphere(1))
    assert run_command(path, "-o", tmp_path / "few.ply") == 0
    assert "42 coefficients of 42 vertices" in capsys.readouterr().out
