"""The no-free-lunch table: the properties of every operator on a fixed set of shapes, next to what theory says.

Wardetzky, Mathur, Kaelberer, Grinspun 2007, https://doi.org/10.2312/SGP/SGP07/033-037. A property counts as kept when
it holds on every shape where it is defined.
"""

from __future__ import annotations

__all__ = ["measure", "shapes", "tables", "with_flipped_edges"]

import os
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from benchmarks.harness import markdown_table
from lbskel import Mesh, MeshError, laplacian
from lbskel.evaluation.operator_health import laplacian_diagnostics
from lbskel.io import read_mesh
from lbskel.operators import OPERATORS
from lbskel.shapes import flat_grid, make, schwarz_lantern, sphere

PROPERTIES = ("symmetric", "local", "constants", "linear", "positive", "semidefinite", "null space", "maximum")
KEEPS = set(PROPERTIES)
# Rows of the table of properties in the literature: what cannot be lost on any mesh.
THEORY: dict[str, set[str]] = {
    "graph": KEEPS - {"linear"},
    "random_walk": KEEPS - {"linear"},
    "inverse_distance": KEEPS - {"linear"},
    "cotangent": KEEPS - {"positive", "maximum"},
    "clamped_cotangent": {"symmetric", "local", "constants"},
    "cotangent_identity": {"local"},
    "mean_value": {"local", "constants", "linear", "positive", "maximum"},
    "mean_value_symmetric": KEEPS - {"linear"},
    "mollified": KEEPS - {"linear", "positive", "maximum"},
    "intrinsic_delaunay": KEEPS - {"local"},
    "robust": KEEPS - {"local"},
    "heat_kernel": KEEPS - {"local", "linear"},
    "anisotropic": KEEPS - {"positive", "maximum"},
}
# Why a measurement differs from that row.
EXPLAINED: dict[tuple[str, str], str] = {
    (
        "intrinsic_delaunay",
        "positive",
    ): "edges of a boundary are not flipped, and those see obtuse angles",
    ("intrinsic_delaunay", "maximum"): "as for its weights",
    (
        "robust",
        "linear",
    ): "next to a boundary that sees obtuse angles its cover's edges reach round to the back",
    ("anisotropic", "linear"): "the plane ends at a fold, where the vertex normals lean",
}


def oriented_hull(points: np.ndarray) -> Mesh:
    """The convex hull of points around the origin, faces outwards."""
    F = ConvexHull(points).simplices.astype(np.int64)
    A, B, C = points[F].transpose(1, 0, 2)
    inwards = np.einsum("fx,fx->f", np.cross(B - A, C - A), A) < 0
    F[inwards] = F[inwards][:, ::-1]
    return Mesh(points, F)


def uneven_square(n: int, by: float = 0.3, seed: int = 0) -> Mesh:
    """Triangulate the unit square, with inner vertices displaced by up to a fraction of the grid spacing."""
    grid = flat_grid(n, n)
    V = grid.vertices.copy()
    inner = ((V[:, :2] > 0) & (V[:, :2] < 1)).all(axis=1)
    V[inner, :2] += np.random.default_rng(seed).uniform(-by, by, (int(inner.sum()), 2)) / (n - 1)
    return grid.with_vertices(V)


def with_flipped_edges(mesh: Mesh, share: float, seed: int) -> Mesh:
    """A closed mesh with a share of its edges flipped, in random order, where no face folds over; vertices stay."""
    F = np.array(mesh.faces)
    faces_of: dict[frozenset[int], set[int]] = {}
    for number, face in enumerate(F.tolist()):
        for side in range(3):
            faces_of.setdefault(frozenset((face[side], face[side - 1])), set()).add(number)
    left = round(share * len(faces_of))
    for edge in map(frozenset, np.random.default_rng(seed).permutation(mesh.edges).tolist()):
        one, other = faces_of[edge]
        (tip,), (across,) = ({*F[number].tolist()} - edge for number in (one, other))
        corner = F[one].tolist().index(tip)
        a, b = F[one][[corner - 2, corner - 1]].tolist()  # the direction of the edge in the first face
        new = np.array([[tip, a, across], [across, b, tip]])
        outwards = _normals(mesh, F[[one, other]]).sum(axis=0)
        if left == 0 or frozenset((tip, across)) in faces_of or (_normals(mesh, new) @ outwards <= 0).any():
            continue
        F[[one, other]] = new
        del faces_of[edge]
        faces_of[frozenset((tip, across))] = {one, other}
        faces_of[frozenset((a, across))] ^= {one, other}
        faces_of[frozenset((b, tip))] ^= {one, other}
        left -= 1
    return Mesh(mesh.vertices, F)


def _normals(mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    """(m, 3) normals of faces, as long as twice their areas."""
    a, b, c = np.swapaxes(mesh.vertices[faces], 0, 1)
    return np.cross(b - a, c - a)


def book(pages: int = 3, n: int = 8) -> Mesh:
    """Sheets that share an edge of the first: not a manifold there."""
    grid = flat_grid(n, n)
    spine = np.arange(n)
    V, F = [grid.vertices[:n]], []
    for page in range(pages):
        angle = 2 * np.pi * page / pages
        index = np.concatenate([spine, n + page * (n - 1) * n + np.arange((n - 1) * n)])
        x, y = grid.vertices[n:, 0], grid.vertices[n:, 1]
        V.append(np.column_stack([x * np.cos(angle), y, x * np.sin(angle)]))
        F.append(index[grid.faces])
    return Mesh(np.concatenate(V), np.concatenate(F))


def shapes() -> dict[str, Mesh]:
    """Return the fixed set of shapes, and the mesh that the environment variable BENCHMARK_MESH names."""
    random = np.random.default_rng(0)
    points = random.normal(size=(1500, 3))
    shear = np.array([[1, 0, 0], [1.4, 1, 0], [0, 0, 1]])
    found = {
        "good": sphere(3),
        "anisotropic": uneven_square(20).with_vertices(uneven_square(20).vertices * [60, 1, 1]),
        "obtuse": flat_grid(20, 20).with_vertices(flat_grid(20, 20).vertices @ shear),
        "irregular": oriented_hull(points / np.linalg.norm(points, axis=1, keepdims=True)),
        "lantern": schwarz_lantern(16, 60),
        "open": uneven_square(20),
        "non-manifold": book(),
        "dinosaur": make("dinosaur", n_vertices=3000).mesh,
    }
    real = os.environ.get("BENCHMARK_MESH")
    if real:
        found[f"real ({Path(real).stem})"] = read_mesh(real)
    return found


def measure(names: Iterable[str] | None = None) -> list[dict[str, Any]]:
    """Measure each operator on each shape, one row each; on all shapes, or on those named."""
    rows: list[dict[str, Any]] = []
    chosen = {name: mesh for name, mesh in shapes().items() if names is None or name in names}
    for name, mesh in chosen.items():
        for operator in OPERATORS:
            row: dict[str, Any] = {"shape": name, "vertices": len(mesh.vertices), "operator": operator}
            try:
                sheet = laplacian_diagnostics(laplacian(mesh, operator=operator), mesh)
                rows.append({**row, **asdict(sheet), "passed": sheet.passed})
            except MeshError as error:
                rows.append({**row, "refused": str(error)})
    return rows


def _kept(rows: list[dict[str, Any]], key: str) -> list[str]:
    """List the shapes on which a property fails."""
    return [row["shape"] for row in rows if "passed" in row and row["passed"][key] is False]


def tables(rows: list[dict[str, Any]]) -> dict[str, str]:
    """The summary against theory, the deviations, and the measures shape by shape, in Markdown."""
    summary, deviations = [], []
    for operator, expected in THEORY.items():
        own = [row for row in rows if row["operator"] == operator]
        line = {"operator": operator}
        for key in PROPERTIES:
            failing = _kept(own, key)
            is_measured = any("passed" in row and row["passed"][key] is not None for row in own)
            line[key] = f"lost on {len(failing)}" if failing else "kept" if is_measured else "-"
            if failing and key in expected:
                why = EXPLAINED.get((operator, key), "not explained")
                deviations.append(f"- `{operator}` loses *{key}* on {', '.join(failing)}: {why}.")
            if is_measured and not failing and key not in expected:
                line[key] = "kept here"
        summary.append(line)
    text = markdown_table(summary)
    text += "\nKept: on every shape, as theory says; kept here: no shape of the set takes it away. Deviations:\n\n"
    text += "\n".join(deviations or ["- none."]) + "\n"
    columns = ["operator", "asymmetry", "nonlocal_fraction", "linear_precision_error", "negative_fraction"]
    columns += ["most_negative_weight", "smallest_eigenvalue", "n_zero_eigenvalues", "overshoot", "condition_number"]
    columns += ["n_fallback_rows", "area_ratio"]
    sections = {"Properties kept, over all shapes": text}
    for shape in dict.fromkeys(row["shape"] for row in rows):
        own = [row for row in rows if row["shape"] == shape]
        sections[f"Measures: {shape}, {own[0]['vertices']:,} vertices"] = markdown_table(own, columns)
    return sections
