"""Which operator smooths best: noise, drift along the surface, and a step of mean curvature on bad triangles."""

from __future__ import annotations

__all__ = ["distance", "irregular_sphere", "noisy_copy", "operators"]

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.damage import damaged
from lbskel.shapes import flat_grid, make, sphere

NOISE = 0.25  # standard deviation of the displacement along the normals, in mean edge lengths
GRID = 24  # vertices along a side of the flat mesh
JITTER = 0.3  # largest displacement of an inner vertex of the flat mesh, in edge lengths
TIME = 0.02  # of the step on the sphere of radius 1


def noisy_copy(mesh: lbskel.Mesh) -> lbskel.Mesh:
    """Displace the vertices along their normals."""
    heights = NOISE * mesh.edge_lengths.mean() * np.random.default_rng(0).standard_normal((len(mesh.vertices), 1))
    return mesh.with_vertices(mesh.vertices + heights * igl.per_vertex_normals(mesh.vertices, mesh.faces))


def distance(vertices: NDArray[np.float64], clean: lbskel.Mesh) -> float:
    """Root mean square distance of vertices to the clean surface, in mean edge lengths."""
    squares = igl.point_mesh_squared_distance(np.ascontiguousarray(vertices), clean.vertices, clean.faces)[0]
    return float(np.sqrt(squares.mean())) / clean.edge_lengths.mean()


def irregular_sphere(subdivisions: int) -> lbskel.Mesh:
    """A sphere of radius 1 whose vertices were displaced by 0.4 mean edge lengths and put back on it."""
    ball = sphere(subdivisions)
    normals = np.random.default_rng(0).standard_normal(ball.vertices.shape)
    shifted = ball.vertices + 0.4 * np.sqrt(4 * np.pi / len(ball.vertices)) * normals
    return ball.with_vertices(shifted / np.linalg.norm(shifted, axis=1, keepdims=True))


def operators(shapes: Sequence[str]) -> list[dict[str, Any]]:
    """A row for each operator, with the measures of every case; an error is named."""
    cases = _cases(shapes)
    rows = []
    for operator in lbskel.OPERATORS:
        row: dict[str, Any] = {"operator": f"`{operator}`"}
        for name, measure in cases.items():
            try:
                row[name] = measure(operator)
            except lbskel.LbskelError as error:
                row[name] = type(error).__name__
        rows.append(row)
    return rows


def _cases(shapes: Sequence[str]) -> dict[str, Callable[[str], float]]:
    """By name, the error of an operator."""
    pairs = [(clean, noisy_copy(clean)) for clean in (make(name).mesh for name in shapes)]
    ball = irregular_sphere(4)
    bad = {kind: damaged(kind, ball) for kind in ("needles", "caps")}
    balls = {"sphere": ball, **{kind: lbskel.Mesh(each.vertices, each.faces) for kind, each in bad.items()}}
    plane = _irregular_plane()

    def noise(operator: str) -> float:
        return float(
            np.mean([distance(lbskel.smooth(noisy, operator=operator).vertices, clean) for clean, noisy in pairs])
        )

    def drift(operator: str) -> float:
        result = lbskel.smooth(plane, method="implicit", operator=operator)
        return _rms(result.vertices - plane.vertices) / plane.edge_lengths.mean()

    def step(mesh: lbskel.Mesh, operator: str) -> float:
        result = lbskel.smooth(mesh, method="implicit", time_step=TIME, iterations=1, operator=operator)
        exact = mesh.vertices / (1 + 2 * TIME)
        return _rms(result.vertices - exact) / _rms(mesh.vertices - exact)

    steps = {f"step, {name}": partial(step, mesh) for name, mesh in balls.items()}
    return {"noise": noise, "drift": drift, **steps}


def _irregular_plane() -> lbskel.Mesh:
    """A square in a plane, whose inner vertices are displaced in it."""
    flat = flat_grid(GRID, GRID)
    shift = JITTER / (GRID - 1) * np.random.default_rng(0).uniform(-1, 1, (len(flat.vertices), 3))
    shift[flat.edges[flat.faces_per_edge == 1]] = 0.0
    shift[:, 2] = 0.0
    return flat.with_vertices(flat.vertices + shift)


def _rms(offsets: NDArray[np.float64]) -> float:
    return float(np.sqrt((offsets**2).sum(axis=1).mean()))
