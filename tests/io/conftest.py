"""What several tests of lbskel.io use: writing and reading a file, and a mesh and skeletons that need exact formats."""

import tracemalloc

import numpy as np
import pytest

from lbskel import Mesh, Skeleton
from lbskel.errors import FormatError
from lbskel.io import read_mesh

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]  # no face uses the last vertex
NODES = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 3, 0], [0.5, 3.5, 0], [1.5, 4, 0], [7, 7, 7], [8, 8, 8], [9, 9, 9]]
PEAK_BYTES = 2_000_000  # files of the size of a kilobyte, which declare a gigabyte or more


@pytest.fixture
def read(tmp_path, capfd):
    """Write a file and read it, as a mesh unless another reader is given; nothing may be printed."""

    def write_and_read(name, content, reader=read_mesh):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return reader(path)

    yield write_and_read
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def rejects(read, tmp_path):
    """Write a file and check that reading it raises an error that begins with its path."""

    def check(name, content, error, message, reader=read_mesh):
        with pytest.raises(error, match=message) as raised:
            read(name, content, reader)
        assert type(raised.value) is error
        assert str(raised.value).startswith(f"{tmp_path / name}: ")

    return check


@pytest.fixture
def rejects_without_allocating(read):
    """Write a small file that declares gigabytes and check that reading it fails without allocating them."""

    def check(name, content, reader=read_mesh):
        tracemalloc.start()
        try:
            with pytest.raises(FormatError):
                read(name, content, reader)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < PEAK_BYTES

    return check


@pytest.fixture(scope="session")
def check_square():
    """Check that a mesh is the unit square of one quad, triangulated, with an unused vertex at (9, 9, 9)."""

    def check(mesh):
        np.testing.assert_array_equal(mesh.vertices, SQUARE)
        np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
        assert mesh.notes == ("1 polygon was cut into triangles",)
        assert mesh.vertices.dtype == np.float64
        assert mesh.faces.dtype == np.int64

    return check


@pytest.fixture(scope="session")
def check_polygons():
    """Check that a mesh has the polygons 0 1 2, 0 1 2 3, 3 0 1 2 4 and 2 1 0 of the square, triangulated."""

    def check(mesh):
        expected = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 0, 1], [3, 1, 2], [3, 2, 4], [2, 1, 0]]
        np.testing.assert_array_equal(mesh.faces, expected)
        assert mesh.notes == ("2 polygons were cut into triangles",)

    return check


@pytest.fixture(scope="session")
def precise_fan():
    """A fan whose coordinates need all 17 digits, with a vertex that no face uses."""
    rng = np.random.default_rng(5)
    vertices = rng.normal(size=(9, 3)) * 10.0 ** rng.integers(-12, 12, size=(9, 1)) / 3
    return Mesh(vertices, [[0, i, i + 1] for i in range(1, 7)])


@pytest.fixture(scope="session")
def skeleton():
    """A triangle 0-1-2 with a tail to the end 5, an edge 6-7 and an isolated node 8; every field is set."""
    return Skeleton(
        np.array(NODES) / 3,
        [[0, 1], [0, 2], [1, 2], [2, 3], [3, 4], [4, 5], [6, 7]],
        np.arange(9) / 7,
        np.array([8, 0, 3, 3, 5, 1]),
        radius_kind="mean",
        mean_radii=np.arange(9) / 3,
        anchors=np.array([2, 7]),
        report={"stop": "volume", "steps": [1, 2.5, None], "fine": True, "nested": {"a": 0.1}},
    )


@pytest.fixture(scope="session")
def tree():
    """Two ends 0 and 1, a fork at 2, a tail 2-3-4-5."""
    return Skeleton(NODES[:6], [[0, 2], [1, 2], [2, 3], [3, 4], [4, 5]], [1, 2, 3, 4, 5, 6])


@pytest.fixture(scope="session")
def unordered():
    """Nodes and edges of a skeleton as sorted positions and radii, without the indices of the nodes."""

    def convert(skeleton):
        nodes = [tuple(row) for row in np.column_stack([skeleton.nodes, skeleton.radii]).tolist()]
        edges = sorted(tuple(sorted((nodes[start], nodes[end]))) for start, end in skeleton.edges)
        return sorted(nodes), edges

    return convert


@pytest.fixture(scope="session")
def check_round_trip(unordered):
    """Check that a skeleton was read back exactly, and that what its format loses is empty or NaN."""

    def check(back, skeleton, loses):
        assert back.cycle_rank == skeleton.cycle_rank
        assert back.n_components == skeleton.n_components
        if "radii" in loses:
            assert np.isnan(back.radii).all()
            assert len(back.radii) == len(back.nodes)
        if "order" in loses:
            assert unordered(back) == unordered(skeleton)
        else:
            np.testing.assert_array_equal(back.nodes, skeleton.nodes)
            np.testing.assert_array_equal(back.edges, skeleton.edges)
            if "radii" not in loses:
                np.testing.assert_array_equal(back.radii, skeleton.radii)
        if "node_of_vertex" in loses:
            assert len(back.node_of_vertex) == 0
        else:
            np.testing.assert_array_equal(back.node_of_vertex, skeleton.node_of_vertex)
        assert back.radius_kind == ("inscribed" if "radius_kind" in loses else skeleton.radius_kind)
        for name in ("mean_radii", "anchors"):
            np.testing.assert_array_equal(getattr(back, name), [] if "extras" in loses else getattr(skeleton, name))
        assert back.report == ({} if "report" in loses else skeleton.report)

    return check
