"""The table of branches: known shapes, the same numbers in every format, NeuroM's lengths, a round trip."""

import io
import json

import numpy as np
import pytest
from helpers import triangle_soup, with_reversed_faces, without_faces

import lbskel
from lbskel import Skeleton, as_mesh, branch_table, skeletonize, write_skeleton
from lbskel.shapes import capsule, make, torus, tube_mesh

FORK = Skeleton([[0, 0, 0], [0, 0, 9], [5, 0, 15], [-5, 0, 15]], [[0, 1], [1, 2], [1, 3]], [1.0, 0.9, 0.6, 0.7])


def test_a_rod_and_a_ring_are_measured_within_two_percent():
    rod, ring = capsule(4.0, 0.5), torus(1.0, 0.25, 96, 48)
    of_rod, of_ring = branch_table(skeletonize(rod), rod), branch_table(skeletonize(ring), ring)
    for table, length, radius, mesh in ((of_rod, 4.0, 0.5, rod), (of_ring, 2 * np.pi, 0.25, ring)):
        assert len(table) == 1
        assert table.length == pytest.approx([length], rel=0.02)
        for radii in (table.mean_radius, table.min_radius, table.max_radius, table.radius_profile[0]):
            assert radii == pytest.approx(np.full(len(radii), radius), rel=0.02)
        for areas in (table.section_area, table.section_area_profile[0]):
            assert areas == pytest.approx(np.full(len(areas), np.pi * radius**2), rel=0.02)
        assert table.volume == pytest.approx([mesh.volume], rel=0.01)  # triangles of nodes enclose a little in bends
        assert table.area == pytest.approx([mesh.area])
        assert (table.volume_share, table.area_share) == (1, 1)
    assert of_rod.tortuosity == pytest.approx([1.0], abs=1e-3)
    assert np.isnan(of_ring.tortuosity[0])


def test_orientation_holes_and_seams_do_not_change_the_sections_and_the_volume(rod):
    opened = without_faces(rod, [len(rod.faces) // 2])
    for mesh in (opened, triangle_soup(rod), rod):
        expected = branch_table(skeletonize(rod), rod)
        for every in (1, 2, len(mesh.faces)):
            turned = with_reversed_faces(mesh, np.arange(0, len(mesh.faces), every))
            table = branch_table(skeletonize(turned), turned)
            assert table.section_area == pytest.approx(expected.section_area, rel=0.01)
            assert table.volume == pytest.approx(expected.volume, rel=0.01)


def test_the_limbs_of_a_tripod_are_measured_within_two_percent():
    shape = make("tripod", n_vertices=1500)
    ours, truth = (branch_table(each, shape.mesh) for each in (skeletonize(shape.mesh), with_map(shape)))
    assert np.sort(ours.length) == pytest.approx(np.sort(truth.length), rel=0.02)
    assert ours.mean_radius == pytest.approx(np.full(3, 0.14), rel=0.02)
    assert ours.section_area == pytest.approx(np.full(3, np.pi * 0.14**2), rel=0.02)
    assert ours.volume.sum() == pytest.approx(shape.mesh.volume, rel=0.01)


def with_map(shape):
    """The true skeleton of a shape, with each vertex of the mesh mapped to the nearest node."""
    from helpers import nearest_rows

    truth = shape.truth
    return Skeleton(truth.nodes, truth.edges, truth.radii, nearest_rows(shape.mesh.vertices, truth.nodes))


def test_the_radii_of_a_skeleton_come_back_from_the_mesh_of_its_tubes():
    shape = tube_mesh(FORK)
    table, truth = branch_table(skeletonize(shape.mesh), shape.mesh), branch_table(shape.truth)
    rows = np.argsort(table.mean_radius), np.argsort(truth.mean_radius)
    assert table.mean_radius[rows[0]] == pytest.approx(truth.mean_radius[rows[1]], rel=0.02)
    assert table.length[rows[0]] == pytest.approx(truth.length[rows[1]], rel=0.02)


def test_without_a_mesh_a_branch_is_truncated_cones():
    table = branch_table(FORK)
    assert table.volume[0] == pytest.approx(np.pi / 3 * 9 * (1 + 0.9 + 0.81))
    assert table.area[0] == pytest.approx(np.pi * 1.9 * np.hypot(0.1, 9))
    assert np.isnan(table.section_area).all()
    assert table.radius_profile[0] == pytest.approx(np.linspace(1, 0.9, 11))


def test_lengths_and_volumes_are_those_of_neurom(tmp_path):
    neurom = pytest.importorskip("neurom")
    write_skeleton(tmp_path / "fork.swc", FORK)
    sections = list(neurom.iter_sections(neurom.load_morphology(tmp_path / "fork.swc")))
    table = branch_table(FORK)
    for name in ("length", "volume", "area"):  # NeuroM stores single precision
        assert sorted(getattr(table, name)) == pytest.approx(sorted(getattr(s, name) for s in sections), rel=1e-5)


# A trunk of 9, a limb of 6 with two twigs of 4, and a limb of 6: nodes 0 to 5
TREE = Skeleton(
    [[0, 0, 0], [0, 0, 9], [6, 0, 9], [-6, 0, 9], [6, 4, 9], [6, -4, 9]],
    [[0, 1], [1, 2], [1, 3], [2, 4], [2, 5]],
    [1.0, 1.0, 0.6, 0.5, 0.4, 0.4],
)


def test_ends_and_orders_of_a_tree_are_those_of_its_tubes():
    mesh = tube_mesh(TREE).mesh
    for root, start in (([0, 0, 0], 0), ([-6, 0, 9], 3), (None, 0)):  # without a root, the thickest tip
        table = branch_table(skeletonize(mesh, root=root), mesh)
        nearest = [np.linalg.norm(TREE.nodes[:, None] - ends, axis=2) for ends in (table.start_point, table.end_point)]
        assert all(distance.min(axis=0).max() < 0.3 for distance in nearest)  # half the smallest radius of a junction
        ends = np.stack([distance.argmin(axis=0) for distance in nearest], axis=1).tolist()
        below = {0: [[1, 2], [1, 3]], 3: [[1, 0], [1, 2]]}[start]
        assert sorted(ends) == sorted([[start, 1], *below, [2, 4], [2, 5]])
        row = {tuple(each): k for k, each in enumerate(ends)}
        assert table.centrifugal[[row[start, 1], row[1, 2], row[2, 4], row[2, 5]]].tolist() == [0, 1, 2, 2]
        assert table.strahler[[row[start, 1], row[1, 2], row[2, 4]]].tolist() == [2, 2, 1]
        assert table.parent[[row[start, 1], row[1, 2], row[2, 4], row[2, 5]]].tolist() == [
            *(-1, row[start, 1]),
            *(row[1, 2], row[1, 2]),
        ]
        assert table.length[row[1, 2]] == pytest.approx(6, rel=0.03)


@pytest.mark.parametrize("scale", [0.001, 25.4])
def test_a_scale_is_that_of_the_skeleton_and_the_mesh(scale):
    shape = make("tripod", n_vertices=500)
    truth = with_map(shape)
    table = branch_table(truth, shape.mesh, scale=scale, units="um, of the slide")
    scaled = Skeleton(scale * truth.nodes, truth.edges, scale * truth.radii, truth.node_of_vertex)
    expected = branch_table(scaled, lbskel.Mesh(scale * shape.mesh.vertices, shape.mesh.faces)).columns()
    columns = table.columns()
    assert columns.pop("units").tolist() == ["um, of the slide"] * 3
    assert list(columns) == list(expected)
    for name, values in columns.items():  # a section through a vertex may be another one after rounding
        np.testing.assert_allclose(values, expected[name], rtol=1e-6, atol=1e-12 * scale, err_msg=name)
    assert table.to_csv().splitlines()[1].endswith(',"um, of the slide"')
    assert json.loads(table.to_json())["units"] == "um, of the slide"


def test_what_is_no_skeleton_is_an_error():
    with pytest.raises(lbskel.MeshError, match="needs a Skeleton and its mesh, in this order, not str first"):
        branch_table("fork.swc")


@pytest.mark.parametrize("scale", [1e103, 1e-110])
def test_a_scale_whose_cube_is_no_number_is_refused(scale):
    with pytest.raises(lbskel.UnknownChoice, match="too large or too small for areas and volumes"):
        branch_table(Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1]), scale=scale)


def test_a_scale_that_is_not_positive_is_an_error():
    with pytest.raises(lbskel.UnknownChoice, match="scale must be a positive number"):
        branch_table(FORK, scale=-1)


def test_every_format_has_the_same_numbers():
    pandas = pytest.importorskip("pandas")
    table = branch_table(FORK)
    frame, rows = table.to_pandas(), json.loads(table.to_json())["branches"]
    read = pandas.read_csv(io.StringIO(table.to_csv()), float_precision="round_trip").set_index("branch")
    pandas.testing.assert_frame_equal(read, frame, check_exact=True)
    assert [row["length"] for row in rows] == table.length.tolist() == frame["length"].tolist()
    assert rows[0]["end_point"] == frame.loc[0, ["end_x", "end_y", "end_z"]].tolist() == [0, 0, 9]
    assert rows[0]["radius_profile"] == frame.filter(regex="^radius_at").iloc[0].tolist()
    assert rows[0]["section_area"] is None
    assert frame.notna().all(axis=0)["local_angle"] == False  # noqa: E712


def test_to_pandas_without_pandas_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(lbskel.MissingDependency, match="tables"):
        branch_table(FORK).to_pandas()


def test_what_has_no_branch_or_no_radius_gives_a_table():
    assert len(branch_table(Skeleton([[0, 0, 0]], [], [1.0]))) == 0
    assert branch_table(Skeleton([[0, 0, 0]], [], [1.0])).to_csv().count("\n") == 1
    flat = branch_table(Skeleton(np.zeros((2, 3)), [[0, 1]], [np.nan, 1.0]))
    assert flat.length == 0
    assert np.isnan(flat.volume_share).all()
    assert json.loads(flat.to_json())["branches"][0]["mean_radius"] is None
    thick = branch_table(Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [np.inf, 1.0]))
    assert np.isnan(thick.volume_share).all()
    row = json.loads(thick.to_json(), parse_constant=pytest.fail)["branches"][0]
    assert (row["length"], row["max_radius"]) == (1.0, None)


def test_equal_arms_of_a_coarse_part_have_equal_shares():
    """A plus of twelve corners, extruded: its long triangles have corners at both ends of an arm."""
    quarter = np.array([[0.5, 0.5], [0.5, 5], [-0.5, 5]])
    outline = np.concatenate([quarter @ np.array([[c, s], [-s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])
    vertices = np.concatenate([np.column_stack([outline, np.full(12, z)]) for z in (0.0, 1.0)])
    k = np.arange(12)
    sides = np.stack([k, (k + 1) % 12, (k + 1) % 12 + 12, k + 12], axis=1)
    plus = as_mesh((vertices, [k[::-1].tolist(), (k + 12).tolist(), *sides.tolist()]))
    table = branch_table(skeletonize(plus, preset="cad"), plus)
    assert table.volume_share == pytest.approx([0.25] * 4, abs=0.01)
    assert table.area_share == pytest.approx([0.25] * 4, abs=0.01)
    assert table.volume.sum() == pytest.approx(19, rel=0.03)
