"""Functions that several test files use."""

import base64
import io
import itertools
import json
import re
import zlib

import igl
import numpy as np
from scipy.ndimage import label

from lbskel import Mesh, Skeleton
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.refinement.radii import inscribed_radii
from lbskel.shapes.isosurface import marching_cubes, project
from lbskel.shapes.round_cones import solid_of


def inflated(letters):
    """Text that is packed in a page."""
    return zlib.decompress(base64.b64decode(letters)).decode()


def unpacked(page):
    """Text of a page, with its data and programs as they are when it is open."""
    packed = r"(?<= data-packed>)[^<]*"
    return re.sub(packed, lambda found: inflated(found[0]), page.decode())


def joined(*meshes):
    """Several meshes as one, their vertices one after the other."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, first[:-1], strict=True)]),
    )


def moved(mesh, by):
    """The mesh moved along x."""
    return mesh.with_vertices(mesh.vertices + [by, 0, 0])


def with_flat_triangle(mesh):
    """The mesh with a face in its middle along z divided, so that one part is a millionth as high as long."""
    faces, z = mesh.faces.copy(), mesh.vertices[:, 2]
    split = np.abs(z[faces].mean(axis=1) - z.mean()).argmin()
    a, b, c = faces[split]
    middle, n = (mesh.vertices[a] + mesh.vertices[b]) / 2, len(mesh.vertices)
    faces[split] = [n, b, c]
    return Mesh([*mesh.vertices, middle + 1e-6 * (mesh.vertices[c] - middle)], [*faces, [a, n, c], [a, b, n]])


def nearest_rows(points, targets):
    """For each point, the row of the nearest target."""
    return np.linalg.norm(points[:, None] - np.asarray(targets), axis=2).argmin(axis=1)


def path_in(mesh, points, radius=0.1):
    """A skeleton that is one path of nodes; each vertex of the mesh is mapped to the nearest node."""
    points = np.asarray(points, dtype=float)
    k = np.arange(len(points) - 1)
    nearest = nearest_rows(mesh.vertices, points)
    return Skeleton(points, np.stack([k, k + 1], axis=1), np.full(len(points), radius), nearest)


def loop_in(mesh, points, radius=0.1):
    """A skeleton that is one closed loop of nodes; each vertex of the mesh is mapped to the nearest node."""
    n = len(points)
    edges = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
    return Skeleton(points, edges, np.full(n, radius), nearest_rows(mesh.vertices, points))


def mesh_of_branches(branches, step=0.04):
    """The surface of a union of tubes, each a (points, radius) pair, by marching cubes."""
    solid = solid_of(branches)
    raw = marching_cubes(solid, step)
    return Mesh(project(solid, raw.vertices, step=step), raw.faces)


def straight_graph(mesh, positions, paths, spacing=0.07):
    """Straight, evenly sampled branches between named positions, with inscribed radii and the nearest-node map."""
    index = {name: k for k, name in enumerate(positions)}
    nodes, edges = [np.asarray(position, dtype=float) for position in positions.values()], []
    for a, b in paths:
        start, end = nodes[index[a]], nodes[index[b]]
        n_pieces = max(1, round(np.linalg.norm(end - start) / spacing))
        chain = [index[a], *range(len(nodes), len(nodes) + n_pieces - 1), index[b]]
        nodes += [start + (end - start) * k / n_pieces for k in range(1, n_pieces)]
        edges += list(itertools.pairwise(chain))
    nodes = np.array(nodes)
    skeleton = Skeleton(nodes, np.array(edges), np.zeros(len(nodes)), nearest_rows(mesh.vertices, nodes))
    return inscribed_radii(skeleton, Surface(mesh))


def file_names(folder):
    """Sorted names of the files in a folder."""
    return sorted(path.name for path in folder.iterdir())


def triangle_soup(mesh):
    """The mesh with three vertices of its own for every triangle, as in an STL file."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def without_faces(mesh, faces):
    """The mesh without some of its faces, on the same vertices."""
    return Mesh(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


def with_reversed_faces(mesh, faces):
    """The mesh with the orientation of some of its faces reversed."""
    F = np.array(mesh.faces)
    F[faces] = F[faces][:, ::-1]
    return Mesh(mesh.vertices, F)


def patches_are_connected(mesh, target):
    """Whether the vertices that are mapped to one target are connected by edges of the mesh."""
    same = mesh.edges[target[mesh.edges[:, 0]] == target[mesh.edges[:, 1]]]
    faces = np.concatenate([np.column_stack([same, same[:, 0]]), np.arange(len(target))[:, None].repeat(3, 1)])
    return len(np.unique(Mesh(mesh.vertices, faces).component_of_vertex)) == len(np.unique(target))


def fan(n):
    """Faces around the first of n vertices, so that all have one."""
    return [[0, k, k + 1] for k in range(1, n - 1)]


def star_skeleton(lengths, radius=0.5):
    """A junction with arms along the axes, a node every 0.25; and a mesh with a vertex at each node."""
    directions = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    nodes, edges = [np.zeros(3)], []
    for direction, length in zip(directions, lengths, strict=False):
        last = 0
        for s in np.arange(0.25, length + 1e-9, 0.25):
            nodes.append(direction * s)
            edges.append((last, len(nodes) - 1))
            last = len(nodes) - 1
    nodes = np.array(nodes)
    mesh = Mesh(nodes, fan(len(nodes)))
    return Skeleton(nodes, np.array(edges), np.full(len(nodes), radius), np.arange(len(nodes))), mesh


def theta_skeleton(lengths=(4, 4, 4)):
    """Two junctions joined by three paths, of so many edges each."""
    nodes, edges = [[0.0, 0, 0], [4.0, 0, 0]], []
    for number, n in enumerate(lengths):
        chain = [0]
        for k in range(1, n):
            nodes.append([4 * k / n, np.sin(np.pi * k / n) * (number - 1), 0.1 * number])
            chain.append(len(nodes) - 1)
        chain.append(1)
        edges += itertools.pairwise(chain)
    nodes = np.array(nodes)
    return Skeleton(nodes, np.array(edges), np.full(len(nodes), 0.1), np.arange(len(nodes)))


STAR_RADIUS = 0.12
STAR_ENDS = {f"end {k}": 1.2 * np.array([np.cos(a), np.sin(a), 0.3]) for k, a in enumerate(np.pi / 2 * np.arange(4))}
STAR_ENDS["foot"] = np.array([0, 0, -1.0])


def graph_of_star(mesh, center, other=None):
    """The arms of the fixture ``star`` from one junction, or two of them and the foot from one and two from another."""
    second = "center" if other is None else "other"
    positions = {"center": center, **({} if other is None else {"other": other}), **STAR_ENDS}
    paths = [("center", "end 0"), ("center", "end 1"), (second, "end 2"), (second, "end 3"), ("center", "foot")]
    return straight_graph(mesh, positions, paths + ([] if other is None else [("center", "other")]))


def reversed_proxy(mesh):
    """A surface whose proxy is the same mesh with its vertices in reverse order, so that maps to it matter."""
    order = np.arange(len(mesh.vertices))[::-1]
    proxy = Mesh(mesh.vertices[order], len(mesh.vertices) - 1 - mesh.faces)
    return Surface(mesh, Proxy(proxy, VertexMap(order), order, 0.0))


def box_mesh(sides, center=(0, 0, 0)):
    """A closed box of those side lengths around a center."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Mesh(corners * sides + center, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])


def slab(length, width, thickness, notch=0.0):
    """A fine box around the origin, along x; a wedge may be cut out of the middle of its end at +x."""
    x, y = length / 2, width / 2
    outline = np.array([[-x, -y], [x, -y], [x - notch, 0], [x, y], [-x, y]])
    V = np.concatenate([np.column_stack([outline, np.full(5, side * thickness / 2)]) for side in (-1, 1)])
    top = np.array([[0, 1, 2], [0, 2, 4], [2, 3, 4]]) + 5
    k, j = np.arange(5), np.roll(np.arange(5), -1)
    sides = np.concatenate([np.stack([k, j, j + 5], axis=1), np.stack([k, j + 5, k + 5], axis=1)])
    return Mesh(*igl.upsample(V, np.concatenate([top, top[:, ::-1] - 5, sides]), 4))


def flat_tube(n=24, length=4.0, radius=0.5):
    """A closed tube along x whose section is an ellipse, half as thick in z as in y."""
    around = np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.stack([np.zeros(n), radius * np.cos(around), 0.5 * radius * np.sin(around)], axis=1)
    V = np.concatenate([ring + np.array([x, 0, 0]) for x in np.linspace(0, length, n)] + [[[0, 0, 0], [length, 0, 0]]])
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n - 1), np.arange(n), indexing="ij"))
    a, b = i * n + j, i * n + (j + 1) % n
    j, k = np.arange(n), (np.arange(n) + 1) % n
    caps = [np.stack([np.full(n, n * n), k, j], 1), np.stack([np.full(n, n * n + 1), n * n - n + j, n * n - n + k], 1)]
    return Mesh(V, np.concatenate([np.stack([a, b, a + n], 1), np.stack([b, b + n, a + n], 1), *caps]))


def planar_fork():
    """A skeleton with one junction and three tips, in the plane z = 0 inside of flat_tube()."""
    nodes = [[0.3, 0, 0], [2, 0, 0], [3.6, 0.3, 0], [3.6, -0.3, 0]]
    return Skeleton(nodes, [[0, 1], [1, 2], [1, 3]], [0.2, 0.5, 0.3, 0.3])


LITTLE_SKELETONS = {
    "empty": Skeleton(np.empty((0, 3)), np.empty((0, 2)), []),
    "one node": Skeleton([[1, 2, 3]], np.empty((0, 2)), [0.5]),
    "no radii": Skeleton([[1, 2, 3], [2, 2, 3]], [[0, 1]], [np.nan, np.nan]),
    "one radius unknown": Skeleton([[1, 2, 3], [2, 2, 3], [2, 3, 3]], [[0, 1], [1, 2]], [0.5, np.nan, 0.5]),
}


def png_pixels(png):
    """(height, width, 3) integers in [0, 255] of the bytes of a PNG file."""
    from matplotlib.image import imread  # here, since most tests that use this file draw nothing

    return (imread(io.BytesIO(png), format="png")[:, :, :3] * 255).round().astype(int)


def count_spots(image, color):
    """The number of connected regions of exactly that color."""
    return label((image == color).all(axis=2))[1]


def vtk_polydata(kind):
    """VTK's closed cylinder of quads and hexagons: as ``polygons``, as triangle ``strips``, or one of each (``both``).

    A line, a vertex and data on points, cells and the whole must not disturb a reader.
    """
    import vtk

    cylinder = vtk.vtkCylinderSource()
    cylinder.SetResolution(6)
    triangles, stripper, both = vtk.vtkTriangleFilter(), vtk.vtkStripper(), vtk.vtkAppendPolyData()
    triangles.SetInputConnection(cylinder.GetOutputPort())
    stripper.SetInputConnection(triangles.GetOutputPort())
    both.AddInputConnection(cylinder.GetOutputPort())
    both.AddInputConnection(stripper.GetOutputPort())
    source = {"polygons": cylinder, "strips": stripper, "both": both}[kind]
    source.Update()
    data = source.GetOutput()
    lines, vertices = vtk.vtkCellArray(), vtk.vtkCellArray()
    lines.InsertNextCell(2, (0, 3))
    vertices.InsertNextCell(1, (2,))
    data.SetLines(lines)
    data.SetVerts(vertices)
    for attributes, n in ((data.GetPointData(), data.GetNumberOfPoints()), (data.GetFieldData(), 2)):
        array = vtk.vtkDoubleArray()
        array.SetName("values")
        array.SetNumberOfComponents(2)
        array.SetComponentName(0, "first")
        array.SetNumberOfTuples(n)
        array.Fill(0.5)
        attributes.AddArray(array)
    return data


def vtk_faces(data):
    """Points of polygonal data; its polygons, and the triangles that VTK cuts its strips into; smallest index first."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    only_strips, cut = vtk.vtkPolyData(), vtk.vtkTriangleFilter()
    only_strips.SetPoints(data.GetPoints())
    only_strips.SetStrips(data.GetStrips())
    cut.SetInputData(only_strips)
    cut.Update()
    faces = []
    for cells in (data.GetPolys(), cut.GetOutput().GetPolys()):
        offsets, corners = (vtk_to_numpy(a) for a in (cells.GetOffsetsArray(), cells.GetConnectivityArray()))
        faces += [corners[first:last].tolist() for first, last in itertools.pairwise(offsets.tolist())]
    return vtk_to_numpy(data.GetPoints().GetData()), sorted(map(smallest_first, faces))


def smallest_first(face):
    """A face as it is listed from its smallest index on."""
    first = face.index(min(face))
    return face[first:] + face[:first]


def soup_faces(soup):
    """The polygons of a PolygonSoup, as :func:`vtk_faces` lists them."""
    return sorted(smallest_first(face.tolist()) for face in np.split(soup.corners, np.cumsum(soup.sizes)[:-1]))


def is_whole(skeleton, mesh):
    """Whether every vertex has a node, every number is finite, and the report is ready for JSON."""
    mapped = skeleton.node_of_vertex
    assert mapped.shape == (len(mesh.vertices),)
    assert mapped.min() >= 0
    assert mapped.max() < len(skeleton.nodes)
    assert np.isfinite(skeleton.nodes).all()
    assert np.isfinite(skeleton.radii).all()
    assert json.loads(json.dumps(skeleton.report, allow_nan=False))["input"]["vertices"] == len(mesh.vertices)
    return True
