"""Kinds of damage to meshes, each as a function that damages a sound one.

Each takes a closed mesh and a random generator. It returns vertices and faces, or the bytes of a file with its
extension, and the mesh on which a skeleton is scored, which is None if the only right answer is an error.
"""

from __future__ import annotations

__all__ = ["DAMAGE", "SHAPES", "Broken", "damaged", "undamaged"]

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.io.mesh_io import MESH_WRITERS
from lbskel.preprocess.degenerate_faces import corner_angles
from lbskel.shapes import chain_of_tori, make, torus

SHAPES: dict[str, Callable[[], Mesh]] = {
    "ring": lambda: torus(1.0, 0.3, 36, 18),
    "tripod": lambda: make("tripod", n_vertices=700).mesh,
    "two rings": lambda: chain_of_tori(2, step=0.2),
}


@dataclass(frozen=True, eq=False)
class Broken:
    """A damaged mesh, as arrays or as a file, and the mesh on which its skeleton is scored.

    Parameters
    ----------
    vertices, faces
        Arrays or lists; None for a file.
    data : bytes
        Content of the file; empty for arrays.
    extension : str
        Of the file, without the dot; empty for arrays.
    reference : Mesh or None
    """

    vertices: Any = None
    faces: Any = None
    data: bytes = b""
    extension: str = ""
    reference: Mesh | None = None


def damaged(kind: str, mesh: Mesh, seed: int = 0) -> Broken:
    """Return the mesh with one kind of damage, a name in DAMAGE."""
    return DAMAGE[kind](mesh, np.random.default_rng(seed))


def undamaged(mesh: Mesh) -> Broken:
    """Return the mesh as it is."""
    return _arrays(mesh.vertices, mesh.faces, mesh)


def _arrays(V: Any, F: Any, reference: Mesh | None = None) -> Broken:
    return Broken(np.asarray(V, dtype=np.float64), np.asarray(F, dtype=np.int64), reference=reference)


def _coordinate(value: float) -> Callable[[Mesh, np.random.Generator], Broken]:
    def set_one(mesh: Mesh, rng: np.random.Generator) -> Broken:
        V = np.array(mesh.vertices)
        V[rng.integers(len(V)), 1] = value
        return _arrays(V, mesh.faces)

    return set_one


def _index(value: int) -> Callable[[Mesh, np.random.Generator], Broken]:
    def set_one(mesh: Mesh, rng: np.random.Generator) -> Broken:
        F = np.array(mesh.faces)
        F[rng.integers(len(F)), 2] = value
        return _arrays(mesh.vertices, F)

    return set_one


def _moved(scale: Any, shift: float = 0.0, judged: bool = True) -> Callable[[Mesh, np.random.Generator], Broken]:
    def move(mesh: Mesh, rng: np.random.Generator) -> Broken:
        V = mesh.vertices * scale + shift
        return _arrays(V, mesh.faces, mesh.with_vertices(V) if judged else None)

    return move


def _needles(mesh: Mesh, rng: np.random.Generator) -> Broken:
    V = np.array(mesh.vertices)
    for i, j in mesh.edges[rng.choice(len(mesh.edges), 30, replace=False)]:
        V[i] = V[j] + 1e-9 * (V[i] - V[j])
    return _arrays(V, mesh.faces, mesh)


def _caps(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Split edges from one side only, and close the gap by a triangle of zero height."""
    V, F = mesh.vertices.tolist(), mesh.faces.tolist()
    for face in rng.choice(len(F), 40, replace=False):
        a, b, c = F[face]
        middle = len(V)
        V.append(((mesh.vertices[a] + mesh.vertices[b]) / 2).tolist())
        F[face] = [middle, b, c]
        F += [[a, middle, c], [a, b, middle]]
    return _arrays(V, F, mesh)


def _t_junctions(mesh: Mesh, rng: np.random.Generator) -> Broken:
    caps = _caps(mesh, rng)
    heights = np.pi - corner_angles(caps.vertices[caps.faces]).max(axis=1)
    return _arrays(caps.vertices, caps.faces[heights > 1e-3], mesh)


def _duplicate_vertices(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Cut the mesh into two parts that share no vertex, as along the seam of a texture."""
    n, is_right = len(mesh.vertices), mesh.vertices[mesh.faces].mean(axis=1)[:, 0] > np.median(mesh.vertices[:, 0])
    return _arrays(np.tile(mesh.vertices, (2, 1)), mesh.faces + n * is_right[:, None], mesh)


def _flipped(share: float) -> Callable[[Mesh, np.random.Generator], Broken]:
    def flip(mesh: Mesh, rng: np.random.Generator) -> Broken:
        F = np.array(mesh.faces)
        chosen = rng.random(len(F)) < share
        F[chosen] = F[chosen][:, ::-1]
        return _arrays(mesh.vertices, F, mesh)

    return flip


def _fin(mesh: Mesh, rng: np.random.Generator) -> Broken:
    a, b, c = mesh.faces[rng.integers(len(mesh.faces))]
    A, B, C = mesh.vertices[[a, b, c]]
    out = np.cross(B - A, C - A)
    tip = (A + B) / 2 + out / np.linalg.norm(out) * np.linalg.norm(B - A)
    return _arrays([*mesh.vertices, tip], [*mesh.faces, [a, b, len(mesh.vertices)]], mesh)


def _pinched(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Add a tetrahedron outside that shares one vertex with the surface: two bodies that touch."""
    vertex, n = int(mesh.vertices[:, 0].argmax()), len(mesh.vertices)
    step = 0.15 * mesh.diagonal
    more = mesh.vertices[vertex] + step * np.array([[1, 0, 0], [0.8, 0.5, 0], [0.8, 0, 0.5]])
    V = np.concatenate([mesh.vertices, more, mesh.vertices[[vertex]]])
    apart = np.array([[n + 3, n + 1, n], [n + 3, n, n + 2], [n + 3, n + 2, n + 1], [n, n + 1, n + 2]])
    touching = np.where(apart == n + 3, vertex, apart)
    bodies = Mesh(V, np.concatenate([mesh.faces, apart]))
    return _arrays(V[:-1], np.concatenate([mesh.faces, touching]), bodies)


def _holes(share: float, patches: int) -> Callable[[Mesh, np.random.Generator], Broken]:
    def cut(mesh: Mesh, rng: np.random.Generator) -> Broken:
        centers = mesh.vertices[mesh.faces].mean(axis=1)
        seeds = centers[rng.choice(len(centers), patches, replace=False)]
        near = np.linalg.norm(centers[:, None] - seeds, axis=2).min(axis=1)
        return _arrays(mesh.vertices, mesh.faces[near > np.quantile(near, share)], mesh)

    return cut


def _soup(noise: float) -> Callable[[Mesh, np.random.Generator], Broken]:
    def take_apart(mesh: Mesh, rng: np.random.Generator) -> Broken:
        V = mesh.vertices[mesh.faces].reshape(-1, 3)
        V = V + noise * mesh.diagonal * rng.standard_normal(V.shape)
        return _arrays(V, np.arange(len(V)).reshape(-1, 3), mesh)

    return take_apart


def _crossing(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Add a second copy that intersects the first; each is a body of its own."""
    V = np.concatenate([mesh.vertices, mesh.vertices + 0.35 * mesh.diagonal * np.array([1.0, 0.1, 0.1])])
    both = Mesh(V, np.concatenate([mesh.faces, mesh.faces + len(mesh.vertices)]))
    return _arrays(both.vertices, both.faces, both)


def _shells(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Add forty-nine small tori next to the shape."""
    spindle = torus(0.02 * mesh.diagonal, 0.008 * mesh.diagonal, 10, 6)
    step, n = 0.07 * mesh.diagonal, len(spindle.vertices)
    corner = mesh.vertices.max(axis=0)
    positions = corner + step * (1 + np.stack(np.divmod(np.arange(49), 7), axis=1) @ np.eye(2, 3))
    V = np.concatenate([mesh.vertices, *(spindle.vertices + position for position in positions)])
    F = np.concatenate([mesh.faces, *(spindle.faces + len(mesh.vertices) + k * n for k in range(49))])
    return _arrays(V, F, Mesh(V, F))


def _noise(mesh: Mesh, rng: np.random.Generator) -> Broken:
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1).mean()
    return _arrays(mesh.vertices + 0.15 * length * rng.standard_normal(mesh.vertices.shape), mesh.faces, mesh)


def _moebius(mesh: Mesh, rng: np.random.Generator) -> Broken:
    """Replace the shape by a Moebius strip."""
    k, width = 60, 6
    turn, across = np.meshgrid(2 * np.pi * np.arange(k) / k, np.linspace(-0.3, 0.3, width), indexing="ij")
    reach = 1 + across * np.cos(turn / 2)
    V = np.stack([reach * np.cos(turn), reach * np.sin(turn), across * np.sin(turn / 2)], axis=2).reshape(-1, 3)
    number = np.arange(k * width).reshape(k, width)
    after = np.concatenate([number[1:], number[:1, ::-1]])  # the last row is connected to the first in reverse order
    a, b, c, d = number[:, :-1].ravel(), after[:, :-1].ravel(), after[:, 1:].ravel(), number[:, 1:].ravel()
    F = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return _arrays(V, F)


def _line(mesh: Mesh, rng: np.random.Generator) -> Broken:
    return _arrays(mesh.vertices * [1, 0, 0], mesh.faces)


def _bytes_of(mesh: Mesh, name: str) -> bytes:
    """Return the content of a file with the mesh."""
    if name == "glb":
        import trimesh

        return bytes(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type="glb"))
    content = MESH_WRITERS[name](mesh)
    return content if isinstance(content, bytes) else content.encode()


def _truncated(name: str) -> Callable[[Mesh, np.random.Generator], Broken]:
    def cut(mesh: Mesh, rng: np.random.Generator) -> Broken:
        data = _bytes_of(mesh, name)
        return Broken(data=data[: int(0.3 * len(data))], extension=name)

    return cut


# By format: the bytes that are put in, and their position as a fraction of the file
_MALFORMED = {
    "obj": (b" x x x ", 0.2),
    "off": (b" x x x ", 0.2),
    "ply": (b"\xff" * 4, 0.9),
    "stl": (b"\xff" * 50, 0.5),
    "glb": (b'"":', 0.003),
}


def _malformed(name: str) -> Callable[[Mesh, np.random.Generator], Broken]:
    def spoil(mesh: Mesh, rng: np.random.Generator) -> Broken:
        data, (word, position) = _bytes_of(mesh, name), _MALFORMED[name]
        start = int(position * len(data))
        return Broken(data=data[:start] + word + data[start + len(word) :], extension=name)

    return spoil


def _gigabytes(name: str) -> Callable[[Mesh, np.random.Generator], Broken]:
    """Make a file of a kilobyte whose header announces about three gigabytes."""
    heads = {
        "off": b"OFF\n125000000 1 0\n",
        "ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 125000000\nproperty double x\nproperty double y\n"
        b"property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n",
        "stl": bytes(80) + (60_000_000).to_bytes(4, "little"),
        "glb": b"glTF" + (2).to_bytes(4, "little") + (3_000_000_000).to_bytes(4, "little") + b"\xf0\xff\xff\xb2JSON",
    }
    return lambda mesh, rng: Broken(data=heads[name].ljust(1024, b"0"), extension=name)


DAMAGE: dict[str, Callable[[Mesh, np.random.Generator], Broken]] = {
    "NaN coordinate": _coordinate(np.nan),
    "infinite coordinate": _coordinate(np.inf),
    "coordinate of 1e300": _coordinate(1e300),
    "index out of range": _index(10**6),
    "negative index": _index(-1),
    "no vertices": lambda mesh, rng: _arrays(np.empty((0, 3)), np.empty((0, 3))),
    "no faces": lambda mesh, rng: _arrays(mesh.vertices, np.empty((0, 3))),
    "one face": lambda mesh, rng: _arrays(mesh.vertices[mesh.faces[0]], [[0, 1, 2]]),
    "all on a line": _line,
    "all at one point": _moved(0.0, 1.0, judged=False),
    "needles": _needles,
    "caps": _caps,
    "T-junctions": _t_junctions,
    "duplicate faces": lambda mesh, rng: _arrays(mesh.vertices, np.tile(mesh.faces, (2, 1)), mesh),
    "both sides": lambda mesh, rng: _arrays(mesh.vertices, [*mesh.faces, *mesh.faces[:, ::-1]], mesh),
    "duplicate vertices": _duplicate_vertices,
    "faces with a corner twice": lambda mesh, rng: _arrays(
        mesh.vertices, [*mesh.faces, *mesh.faces[:9, [0, 1, 1]]], mesh
    ),
    "a third of the faces flipped": _flipped(0.33),
    "inside out": _flipped(1.0),
    "edge of three faces": _fin,
    "vertex of two surfaces": _pinched,
    "Moebius strip": _moebius,
    "20 small holes": _holes(0.05, 20),
    "a hole of a twentieth": _holes(0.05, 1),
    "a tenth of the faces missing": lambda mesh, rng: _arrays(
        mesh.vertices, mesh.faces[rng.random(len(mesh.faces)) > 0.1], mesh
    ),
    "soup": _soup(0.0),
    "soup, rounded differently": _soup(1e-9),
    "cuts through itself": _crossing,
    "50 shells": _shells,
    "isolated points": lambda mesh, rng: _arrays([*mesh.vertices, *rng.normal(0, 9, (50, 3))], mesh.faces, mesh),
    "noise": _noise,
    "scale 1e-6": _moved(1e-6),
    "scale 1e6": _moved(1e6),
    "scale 1e100": _moved(1e100, judged=False),
    "scale 1e-100": _moved(1e-100),
    "shift 1e6": _moved(1.0, 1e6),
    "a millionth as high": _moved(np.array([1, 1, 1e-6]), judged=False),
    "flat": _moved(np.array([1, 1, 0.0]), judged=False),
    **{f"truncated {name}": _truncated(name) for name in _MALFORMED},
    **{f"malformed {name}": _malformed(name) for name in _MALFORMED},
    **{f"3 GB promised in {name}": _gigabytes(name) for name in ("off", "ply", "stl", "glb")},
}
