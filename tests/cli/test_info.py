"""``lbskel info``: the measures of a mesh, as text and as JSON."""

import json
import re

import numpy as np
import pytest

import lbskel
from lbskel import _kernels


def test_info(here, rod):
    code, out, err = here("info", "rod.off")
    assert (code, err) == (0, [])
    facts = dict(re.split(r"\s{2,}", line, maxsplit=1) for line in out)
    assert facts["vertices"] == "152"
    assert facts["closed manifold"] == "yes"
    assert facts["genus"] == "0"
    assert float(facts["volume"]) == pytest.approx(rod.volume, rel=1e-5)  # six digits are printed
    assert facts["notes"] == "none"
    corners = [[float(x) for x in corner.split(", ")] for corner in facts["bounding box"].split(" to ")]
    assert np.array(corners) == pytest.approx(np.array([rod.vertices.min(axis=0), rod.vertices.max(axis=0)]), rel=1e-5)


def test_info_as_json_of_an_open_mesh_with_faults(here, folder):
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "v 2 0 0", "v 9 9 9", "f 1 2 3 4", "f 1 2 5"]
    (folder / "faults.obj").write_text("\n".join(lines) + "\n")
    code, out, err = here("info", "faults.obj", "--json")
    assert (code, err, len(out)) == (0, [], 1)
    facts = json.loads(out[0])
    assert facts["vertices"] == 6
    assert facts["faces"] == 3
    assert facts["closed_manifold"] is False
    assert (facts["genus"], facts["volume"]) == (None, None)
    assert facts["zero_area_faces"] == 1
    assert facts["unused_vertices"] == 1
    assert facts["area"] == pytest.approx(1.0)
    assert facts["bounding_box"] == [[0, 0, 0], [2, 1, 0]]  # as the diagonal, without the unused vertex
    assert facts["diagonal"] == pytest.approx(np.sqrt(5))
    assert facts["notes"] == ["1 polygon was cut into triangles"]


def test_system(here, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    code, out, err = here("info", "--system")
    facts = dict(re.split(r"\s{2,}", line, maxsplit=1) for line in out)
    assert (code, err) == (0, [])
    assert facts["lbskel"] == lbskel.__version__
    assert facts["numpy"] == np.__version__
    assert facts["kernels compiled"] == ("no" if _kernels.is_slow() else "yes")
    assert facts["threads"] == "OMP_NUM_THREADS is 3"


@pytest.mark.parametrize("arguments", [("info",), ("info", "rod.off", "--system")])
def test_a_mesh_or_the_system(here, arguments):
    code, out, err = here(*arguments)
    assert (code, out, len(err)) == (2, [], 1)


def test_info_of_a_point_cloud(here, folder):
    (folder / "cloud.xyz").write_text("0 0 0\n1 0 0\n0 0 0\n0 2 0\n")
    code, out, err = here("info", "cloud.xyz", "--json")
    assert (code, err, len(out)) == (0, [], 1)
    facts = json.loads(out[0])
    assert (facts["points"], facts["duplicates"]) == (4, 1)
    assert facts["bounding_box"] == [[0, 0, 0], [1, 2, 0]]
    assert facts["mean_distance_of_neighbors"] == pytest.approx((1 + 1 + 2) / 3)
