"""The data of a page: positions, simplification for display, and what is told of it."""

import base64

import numpy as np
import pytest
from helpers import flat_tube, planar_fork

from lbskel import Mesh, MeshError, PointCloud, Skeleton
from lbskel.shapes import torus
from lbskel.visualization import Scene
from lbskel.visualization.scene import MAX_FACES, MAX_STEP_FACES, MAX_STEPS, encode_scene


def numbers(encoded):
    """The numbers of an encoded array, in its units."""
    values = np.frombuffer(base64.b64decode(encoded["data"]), dtype=encoded["dtype"])
    return values.astype(float) / encoded.get("scale", 1)


def points(encoded):
    return numbers(encoded).reshape(-1, 3)


@pytest.mark.parametrize("shift", [0.0, 2.0**20])
def test_coordinates_are_those_of_the_view_divided_by_the_size(shift):
    """The tube of length 4 along x is centered and divided by its half length, wherever it is."""
    V, F = flat_tube().vertices.round(3) + [shift, 0, 0], flat_tube().faces
    nodes = planar_fork().nodes + [shift, 0, 0]
    data, notes = encode_scene(Scene(Mesh(V, F), Skeleton(nodes, planar_fork().edges, planar_fork().radii)))
    expected = (V - [shift + 2, 0, 0]) / 2
    np.testing.assert_allclose(points(data["mesh"]["vertices"])[:, :2], expected[:, :2], atol=0.6 / 32767)
    np.testing.assert_array_equal(points(data["mesh"]["faces"]), F)
    np.testing.assert_allclose(points(data["skeleton"]["nodes"])[:, 0], (nodes[:, 0] - shift - 2) / 2, atol=1e-6)
    np.testing.assert_allclose(numbers(data["skeleton"]["radii"]), planar_fork().radii / 2, rtol=1e-6)
    skeleton = data["skeleton"]
    places = skeleton["center"] + skeleton["size"] * points(skeleton["nodes"]) @ skeleton["axes"]
    np.testing.assert_allclose(places, nodes, atol=1e-6)
    assert notes == []


def test_the_skeleton_has_its_branches_tips_and_junctions():
    fork = planar_fork()
    data = encode_scene(Scene(skeleton=fork, off_center=np.array([2])))[0]["skeleton"]
    assert [branch.tolist() for branch in fork.branches] == data["branches"]
    assert (data["tips"], data["junctions"], data["off_center"]) == (fork.tips.tolist(), fork.junctions.tolist(), [2])
    assert data["low"] * data["size"] == pytest.approx(fork.radii.min())
    assert data["high"] * data["size"] == pytest.approx(fork.radii.max())


def test_what_is_simplified_is_told():
    mesh = torus(1.0, 0.3, 300, 100)
    n = MAX_STEPS + 10
    states = [mesh.vertices * (1 - k / (n + 1)) for k in range(1, n + 1)]
    ratios = [1 - k / (n + 1) for k in range(1, n + 1)]
    scene = Scene(
        mesh,
        part_of_face=np.arange(len(mesh.faces)) % 3,
        contracted=mesh,
        positions=states,
        area_ratios=ratios,
        volume_ratios=[float("nan")] * n,
    )
    data, notes = encode_scene(scene)
    assert len(data["mesh"]["faces"]["data"]) <= 8 * MAX_FACES
    assert "The mesh is simplified for display" in notes[0]
    assert "of its 60,000 faces are shown" in notes[0]
    assert "contracted surface is shown by" in notes[1]
    assert f"of the {n} steps" in notes[2]
    steps = data["steps"]
    assert len(numbers(steps["faces"])) <= 3 * MAX_STEP_FACES
    assert steps["numbers"][0] == 0
    assert steps["numbers"][-1] == n
    assert len(steps["positions"]) == len(steps["numbers"]) == MAX_STEPS + 1
    assert steps["volumes"] is None
    assert steps["labels"][-1] == f"step {n} of {n}: area {100 * ratios[-1]:.3g} %"
    first, last = points(steps["positions"][0]), points(steps["positions"][-1])
    np.testing.assert_allclose(last, first * ratios[-1], atol=1e-4)
    assert len(numbers(data["mesh"]["parts"])) == len(points(data["mesh"]["faces"]))


def test_a_cloud_has_points():
    data, _ = encode_scene(Scene(PointCloud(flat_tube().vertices)))
    assert len(points(data["cloud"])) == 578
    assert "mesh" not in data


def test_nothing_to_show_is_refused():
    with pytest.raises(MeshError, match="needs a mesh"):
        encode_scene(Scene())


@pytest.mark.parametrize(
    ("low", "high", "colors"), [(-5, -1, "Viridis"), (0, 0, "Viridis"), (1, 5, "Viridis"), (-1, 5, "RdBu")]
)
def test_the_colors_of_a_field_diverge_only_where_it_has_both_signs(low, high, colors):
    mesh = flat_tube()
    field = np.linspace(low, high, len(mesh.vertices))
    assert encode_scene(Scene(mesh, field=field))[0]["mesh"]["field"]["colors"] == colors
