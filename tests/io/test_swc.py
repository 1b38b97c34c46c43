"""SWC: parents before children, cycles broken and restored, files of other programs."""

import re
from collections import Counter

import numpy as np
import pytest

from lbskel import Skeleton, skeletonize, to_tree
from lbskel.errors import FormatError
from lbskel.io import read_skeleton, write_skeleton
from lbskel.skeleton.editing import concatenate
from lbskel.skeleton.root import find_soma, reroot_by_thickness


@pytest.fixture(scope="module")
def neuron():
    """A soma of radius 5 at the first node, with three neurites of five nodes of radius 0.5."""
    directions = np.array([[1.0, 0.2, 0.3], [-1.0, 1.0, 0.1], [-1.0, -1.0, 0.7]])
    neurites = (np.arange(3.0, 28.0, 5.0)[:, None, None] * directions).transpose(1, 0, 2)
    edges = [[start - 1 if start % 5 != 1 else 0, start] for start in range(1, 16)]
    return Skeleton(np.concatenate([np.zeros((1, 3)), *neurites]), edges, [5.0] + 15 * [0.5])


def swc_rows(path):
    """The rows of a file, each with id, type, position, radius and parent; checks the order of the ids."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    rows = [(int(i), int(kind), [float(c) for c in xyz], float(r), int(parent)) for i, kind, *xyz, r, parent in lines]
    assert [row[0] for row in rows] == list(range(1, len(rows) + 1))
    assert all(row[4] == -1 or 1 <= row[4] < row[0] for row in rows)
    return rows


def test_a_written_tree_line_by_line(tmp_path, tree):
    write_skeleton(tmp_path / "a.swc", tree)
    assert (tmp_path / "a.swc").read_text() == (
        "# radius_kind inscribed\n"
        "# id type x y z radius parent\n"
        "1 0 0.0 0.0 0.0 1.0 -1\n"
        "2 0 0.5 1.0 0.0 3.0 1\n"
        "3 0 1.0 0.0 0.0 2.0 2\n"
        "4 0 0.5 3.0 0.0 4.0 2\n"
        "5 0 0.5 3.5 0.0 5.0 4\n"
        "6 0 1.5 4.0 0.0 6.0 5\n"
    )


def test_the_given_node_comes_first_and_other_components_begin_at_their_thickest_tip(tmp_path, skeleton):
    write_skeleton(tmp_path / "a.swc", skeleton, root=4)
    roots = [row[2] for row in swc_rows(tmp_path / "a.swc") if row[4] == -1]
    assert roots[0] == skeleton.nodes[4].tolist()
    assert sorted(roots) == [skeleton.nodes[node].tolist() for node in (4, 7, 8)]  # 7 is thicker than 6
    write_skeleton(tmp_path / "b.swc", skeleton, root=8)  # of the last component
    assert swc_rows(tmp_path / "b.swc")[0][2] == skeleton.nodes[8].tolist()


def test_a_soma_has_type_1_where_it_is_the_root(tmp_path, neuron):
    for root, types in ((0, {1: 1, 0: 15}), (1, {1: 1, 0: 15}), (4, {0: 16})):  # 1 is in the ball of 0
        write_skeleton(tmp_path / "a.swc", neuron, root=root, force=True)
        assert swc_rows(tmp_path / "a.swc")[0][1] == (root != 4)
        assert Counter(row[1] for row in swc_rows(tmp_path / "a.swc")) == types


@pytest.mark.parametrize("scale", [0.001, 8, 1e30])
def test_a_scale_and_units_are_in_the_header_and_the_mesh_s_coordinates_come_back(tmp_path, neuron, scale):
    write_skeleton(tmp_path / "a.swc", neuron, scale=scale, units="um")
    text = (tmp_path / "a.swc").read_text()
    assert '# Meta: {"units": "um"}\n' in text
    assert f"# positions and radii are multiplied by {float(scale)!r}\n" in text
    rows = swc_rows(tmp_path / "a.swc")
    assert (rows[0][2], rows[0][3]) == ((neuron.nodes[0] * scale).tolist(), neuron.radii[0] * scale)
    back = read_skeleton(tmp_path / "a.swc")
    rounding = 4 * np.finfo(float).eps  # a product and a quotient
    back_nodes, nodes = (each.nodes[np.lexsort(each.nodes.round(6).T)] for each in (back, neuron))
    np.testing.assert_allclose(back_nodes, nodes, rtol=rounding, atol=0)
    np.testing.assert_allclose(np.sort(back.radii), np.sort(neuron.radii), rtol=rounding)
    assert len(back.edges) == len(neuron.edges)


@pytest.mark.parametrize("scale", [0, -1, np.inf, np.nan])
def test_a_scale_that_is_no_factor_is_an_error(tmp_path, neuron, scale):
    with pytest.raises(FormatError, match="the scale must be a positive number"):
        write_skeleton(tmp_path / "a.swc", neuron, scale=scale)
    with pytest.raises(FormatError, match="gives infinite coordinates"):
        write_skeleton(tmp_path / "a.swc", Skeleton([[1e300, 0, 0]], np.empty((0, 2)), [1]), scale=1e300)
    with pytest.raises(FormatError, match=r"a scale of 100\.0 gives infinite radii; give a smaller one"):
        write_skeleton(tmp_path / "a.swc", Skeleton([[1, 0, 0]], np.empty((0, 2)), [1e307]), scale=100.0)
    with pytest.raises(FormatError, match=r"a\.json: a scale and units are stored by swc only"):
        write_skeleton(tmp_path / "a.json", neuron, units="um")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("root", [-1, 9])
def test_a_root_that_is_not_a_node_is_an_error(tmp_path, skeleton, root):
    with pytest.raises(FormatError, match=f"the root {root} is not a node; the nodes are 0 to 8"):
        write_skeleton(tmp_path / "a.swc", skeleton, root=root)


def test_each_cycle_is_cut_where_it_is_thinnest_and_restored_on_reading(tmp_path, unordered):
    # A ladder: squares 0-1-3-2 and 2-3-5-4, thinnest at nodes 1 and 4; the bridge 5-6 is thinner and must be kept
    nodes = [[0, 0, 0], [1.3, 0, 0], [0, 1, 0], [1.1, 1, 0], [0, 2, 0], [1.2, 2, 0], [50, 2, 0]]
    edges = [[0, 1], [0, 2], [1, 3], [2, 3], [2, 4], [3, 5], [4, 5], [5, 6]]
    radii = [9, 2, 8, 7, 3, 6, 1]
    ladder = Skeleton(nodes, edges, radii)
    write_skeleton(tmp_path / "a.swc", ladder)
    rows = swc_rows(tmp_path / "a.swc")
    node_of_id = {row[0]: nodes.index(row[2]) for row in rows}
    text = (tmp_path / "a.swc").read_text()
    cuts = re.findall(r"^# cut edge (\d+) (\d+)$", text, re.M)
    assert {frozenset(node_of_id[int(end)] for end in cut) for cut in cuts} == {frozenset({0, 1}), frozenset({4, 5})}
    assert "#" not in text[re.search("^1 ", text, re.M).start() :]  # no comment after the first node
    assert [row[3] for row in rows] == [radii[node_of_id[row[0]]] for row in rows]
    assert unordered(read_skeleton(tmp_path / "a.swc")) == unordered(ladder)


# --- other programs' readers: each returns the number of sections, the length of the cable, and the sorted radii


def in_morphio(path):
    morphio = pytest.importorskip("morphio")
    morphio.set_maximum_warnings(0)
    sections = morphio.Morphology(path).sections
    return counted([section.points for section in sections], [section.diameters / 2 for section in sections])


def in_neurom(path):
    neurom = pytest.importorskip("neurom")
    sections = list(neurom.iter_sections(neurom.load_morphology(path)))
    return counted([section.points[:, :3] for section in sections], [section.points[:, 3] for section in sections])


def counted(points, radii):
    """Sections that begin at a junction repeat its point, which counts once."""
    length = sum(np.linalg.norm(np.diff(each, axis=0), axis=1).sum() for each in points)
    rows = np.column_stack([np.concatenate(points), np.concatenate(radii)])
    return len(points), length, np.sort(np.unique(rows, axis=0)[:, 3])


def in_navis(path):
    navis = pytest.importorskip("navis")
    neuron = navis.read_swc(path)
    return None, neuron.cable_length, np.sort(neuron.nodes.radius)


def in_osteoid(path):
    osteoid = pytest.importorskip("osteoid")
    read = osteoid.Skeleton.from_swc(path.read_text())
    return None, read.cable_length(), np.sort(read.radius)


@pytest.fixture(scope="module")
def drawn(neuron, tree, tripod, two_rings):
    """Skeletons by name."""
    line = Skeleton(np.arange(12.0).reshape(4, 3), [[0, 1], [1, 2], [2, 3]], [1, 2, 3, 2.5])
    moved = Skeleton(tree.nodes + 20, tree.edges, tree.radii)
    ring_with_tails = Skeleton(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, -1, 0], [2, 2, 0]],
        [[0, 1], [1, 2], [2, 3], [0, 3], [0, 4], [2, 5]],
        [3, 2, 3, 1, 5, 4],
    )
    return {
        "line": line,
        "fork": tree,
        "soma": neuron,
        "components": concatenate([line, moved]),
        "cycle": ring_with_tails,
        "tripod": skeletonize(tripod),
        "two rings": skeletonize(two_rings),
    }


@pytest.mark.parametrize("scale", [1, 0.001])
@pytest.mark.parametrize("read_by", [in_morphio, in_neurom, in_navis, in_osteoid])
@pytest.mark.parametrize("name", ["line", "fork", "soma", "components", "cycle", "tripod", "two rings"])
def test_other_programs_read_the_sections_lengths_and_radii(tmp_path, drawn, name, read_by, scale):
    skeleton = reroot_by_thickness(drawn[name])  # as skeletonize does
    write_skeleton(tmp_path / "a.swc", skeleton, scale=scale, units="um")
    n_sections, length, radii = read_by(tmp_path / "a.swc")
    tree = to_tree(skeleton)
    is_soma = np.arange(len(tree.nodes)) == find_soma(tree)
    leaves_soma = is_soma[tree.edges].any(axis=1)
    single = 4e-7  # the programs keep numbers in single precision: a few units in the last place
    if n_sections is None:  # the soma is a node as any other
        assert length == pytest.approx(scale * tree.length, rel=single * len(tree.edges))
        np.testing.assert_allclose(radii, scale * np.sort(tree.radii), rtol=single)
    else:  # the soma is none of a section's points
        root_is_junction = tree.degrees[0] >= 3 and not is_soma[0]  # a section of one point
        assert n_sections == len(tree.branches) + root_is_junction
        assert length == pytest.approx(scale * tree.edge_lengths[~leaves_soma].sum(), rel=single * len(tree.edges))
        np.testing.assert_allclose(radii, scale * np.sort(tree.radii[~is_soma]), rtol=single)


def test_the_soma_is_one_sphere_in_other_programs(tmp_path, neuron):
    morphio, neurom = pytest.importorskip("morphio"), pytest.importorskip("neurom")
    write_skeleton(tmp_path / "a.swc", neuron)
    read = morphio.Morphology(tmp_path / "a.swc")
    assert read.soma_type == morphio.SomaType.SOMA_SINGLE_POINT
    assert (read.soma.points.tolist(), read.soma.diameters.tolist()) == ([neuron.nodes[0].tolist()], [10])
    assert neurom.load_morphology(tmp_path / "a.swc").soma.radius == 5
    assert len(read.root_sections) == 3


def test_navis_reads_the_soma_and_the_units(tmp_path, neuron):
    navis = pytest.importorskip("navis")
    write_skeleton(tmp_path / "a.swc", neuron, units="um")
    read = navis.read_swc(tmp_path / "a.swc")
    assert (int(read.soma), str(read.units)) == (1, "1 micrometer")


def test_an_unknown_radius_is_0_for_other_programs(tmp_path):
    write_skeleton(tmp_path / "a.swc", Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [np.nan, np.nan]))
    for read_by in (in_morphio, in_neurom, in_navis, in_osteoid):
        assert read_by(tmp_path / "a.swc")[2].tolist() == [0, 0]


def test_a_file_of_another_program(read):
    skeleton = read(
        "a.swc",
        "# ORIGINAL_SOURCE unknown\n# a comment on a cut edge 3 4 that is none\n"
        " 30 3 0 0 2 .5 10 # late\n10 1 0 0 0 1 -1\n20 3 0 0 1 0.75 10 extra\n\n5 2 9 9 9 1 -1\n",
        read_skeleton,
    )
    np.testing.assert_array_equal(skeleton.nodes, [[0, 0, 2], [0, 0, 0], [0, 0, 1], [9, 9, 9]])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(skeleton.radii, [0.5, 1, 0.75, 1])
    assert skeleton.radius_kind == "inscribed"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty"),
        ("# nothing\n", "the skeleton has no nodes"),
        ("Dear reader,\n", "line 1: id, type, x, y, z, radius and parent expected, found 'Dear reader,'"),
        ("1 0 0 0 0 1 -1\n2 0 0 0 1\n", "line 2: id, type"),
        ("1 0 0 0 0 1 -1\n# c\n2 0 0 0 1 1 7\n", "line 3: its parent 7 does not exist"),
        ("1 0 0 0 0 1 -1\n1 0 0 0 1 1 1\n", "line 2: the id 1 occurs twice"),
        ("1.5 0 0 0 0 1 -1\n", "line 1: ids must be whole numbers"),
        ("1 0 0 0 0 1 nan\n", "line 1: parents must be whole numbers"),
        ("# positions and radii are multiplied by -2\n1 0 0 0 0 1 -1\n", "the scale must be a positive number, not -2"),
        ("# positions and radii are multiplied by x\n1 0 0 0 0 1 -1\n", "the scale must be a positive number, not x"),
        ("1 0 0 0 0 1 -1\n# cut edge 1 3\n", "a cut edge: its node 3 does not exist"),
        ("1 0 0 0 0 1 -1\n2 0 0 nan 0 1 1\n", "nodes 1 of the skeleton have NaN"),
    ],
)
def test_errors_name_the_line(rejects, content, message):
    rejects("a.swc", content, FormatError, message, read_skeleton)
