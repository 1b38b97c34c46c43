"""Convergence of every operator under refinement, on irregular meshes of well-shaped triangles.

Compared are the eigenvalues of the sphere, l (l + 1), of the flat torus, 4 pi^2 (m^2 + n^2), and of a rectangle,
pi^2 (m^2 / a^2 + n^2 / b^2); a Poisson problem on the sphere; the Laplacian of a harmonic at each vertex; and the mean
curvature of the sphere, a cylinder and a torus. Theory expects: for eigenvalues and solutions h^2, Dziuk 1988,
https://doi.org/10.1007/BFb0082865; at the vertices no convergence in general, Xu 2004,
https://doi.org/10.1016/j.cagd.2004.07.007, but convergence of a kernel that shrinks more slowly than the edges, Belkin,
Sun, Wang 2008, https://doi.org/10.1145/1377676.1377725.
"""

from __future__ import annotations

__all__ = ["measure", "picture", "tables"]

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import eigs, splu

from benchmarks.harness import fitted_order, markdown_table
from benchmarks.operators_properties import oriented_hull, uneven_square, with_flipped_edges
from lbskel import Mesh
from lbskel.applications import eigenpairs
from lbskel.operators import OPERATORS, Laplacian
from lbskel.operators.heat_kernel import heat_kernel
from lbskel.shapes import cylinder, flat_grid, sphere, torus

Values: TypeAlias = NDArray[np.float64]
Operator: TypeAlias = Callable[[Mesh], Laplacian]
Errors: TypeAlias = tuple[float, dict[str, float]]  # the edge length, and relative errors by name

N_EIGENVALUES = 9
FLIPPED = 0.15  # share of the edges that are flipped, of a mesh with thin triangles; a guess
SIDES = (1.0, 0.7)  # side lengths of the rectangle
# Blind to lengths: multiples of the Laplacian at best, so these are compared after the best factor.
SCALED = ("graph", "random_walk")


def edge_length(mesh: Mesh) -> float:
    """Return the mean edge length."""
    return float(np.linalg.norm(mesh.vertices[mesh.edges[:, 0]] - mesh.vertices[mesh.edges[:, 1]], axis=1).mean())


def slow_heat_kernel(mesh: Mesh) -> Laplacian:
    """The heat kernel with t ~ h, on the unit sphere 0.3 h: slower than h^2."""
    return heat_kernel(mesh, time=0.085 * np.sqrt(mesh.area) / edge_length(mesh), cut_off=4.0)


def uneven_sphere(level: int) -> Mesh:
    """The unit sphere with its points moved by up to a third of an edge, and the edges of their convex hull."""
    ball = sphere(level + 1)
    by = np.random.default_rng(level).uniform(-1, 1, ball.vertices.shape) * edge_length(ball) / 3
    return oriented_hull((ball.vertices + by) / np.linalg.norm(ball.vertices + by, axis=1, keepdims=True))


def flipped_sphere(level: int) -> Mesh:
    """The uneven sphere with 15 % of its edges flipped, which makes thin triangles and leaves the vertices."""
    return with_flipped_edges(uneven_sphere(level), FLIPPED, seed=level)


def uneven_rectangle(level: int) -> Mesh:
    """The rectangle with its inner vertices moved."""
    square = uneven_square(8 * 2**level + 1, by=0.25, seed=level)
    return square.with_vertices(square.vertices * [*SIDES, 1])


def _turned(angles: Values, n: int, seed: int) -> Values:
    """Angles moved by up to a quarter of their distance."""
    return angles + np.random.default_rng(seed).uniform(-0.25, 0.25, angles.shape) * 2 * np.pi / n


def uneven_torus(level: int) -> tuple[Mesh, Values]:
    """The torus of radii 1 and 0.4 with its vertices moved on it, and the vectors H n there."""
    n, m, R, r = 16 * 2**level, 8 * 2**level, 1.0, 0.4
    i, j = np.divmod(np.arange(n * m), m)
    s, t = _turned(2 * np.pi * i / n, n, level), _turned(2 * np.pi * j / m, m, level + 100)
    normals = np.column_stack([np.cos(t) * np.cos(s), np.cos(t) * np.sin(s), np.sin(t)])
    V = R * np.column_stack([np.cos(s), np.sin(s), 0 * s]) + r * normals
    H = (R + 2 * r * np.cos(t)) / (2 * r * (R + r * np.cos(t)))
    return torus(R, r, n, m).with_vertices(V), H[:, None] * normals


def uneven_cylinder(level: int) -> tuple[Mesh, Values]:
    """The side of a cylinder of radius 1/2 with its inner vertices moved on it, and the vectors H n there."""
    n, m = 12 * 2**level, 8 * 2**level + 1
    side = cylinder(0.5, 2.0, n, m)
    x, y, z = side.vertices.T
    s = _turned(np.arctan2(y, x), n, level)
    by = np.random.default_rng(level).uniform(-0.25, 0.25, len(z)) * 2 / (m - 1)
    normals = np.column_stack([np.cos(s), np.sin(s), 0 * s])
    moved = 0.5 * normals + np.column_stack([0 * s, 0 * s, np.where(np.abs(z) < 0.999, z + by, z)])
    return side.with_vertices(moved), normals


def folded(operator: Operator, n: int) -> tuple[Laplacian, float]:
    """An operator of the flat unit torus: the rows of the middle of 3 x 3 tiles, columns taken modulo the tile."""
    by = np.random.default_rng(n).uniform(-0.25, 0.25, (n, n, 2)) / n
    i, j = (index.ravel() for index in np.meshgrid(np.arange(3 * n + 1), np.arange(3 * n + 1), indexing="ij"))
    V = np.column_stack([np.column_stack([i, j]) / n + by[i % n, j % n], 0 * i])
    tiles = Mesh(V, flat_grid(3 * n + 1, 3 * n + 1).faces)
    L = operator(tiles)
    vertex, middle = i % n * n + j % n, (i // n == 1) & (j // n == 1)
    parts = []
    for matrix in (L.stiffness, L.mass):
        entries = matrix.tocoo()
        kept = middle[entries.row]
        positions = vertex[entries.row[kept]], vertex[entries.col[kept]]
        parts.append(csc_array(coo_array((entries.data[kept], positions), shape=(n * n, n * n))))
    return Laplacian(*parts), edge_length(tiles)


def eigenvalues(laplacian: Laplacian) -> Values:
    """The smallest, also of an operator that is not symmetric, whose imaginary parts are left out."""
    S, M = laplacian.stiffness, laplacian.mass
    if abs(S - S.T).max() <= 1e-9 * abs(S).max():  # folding adds rows of different tiles, rounded differently
        return eigenpairs(Laplacian(((S + S.T) / 2).tocsc(), M), N_EIGENVALUES)[0]
    shift = float(np.median(S.diagonal() / M.diagonal())) / S.shape[0]
    start = np.random.default_rng(0).uniform(0.5, 1.5, S.shape[0])
    return np.sort(eigs(S, N_EIGENVALUES, M, sigma=-shift, v0=start, return_eigenvectors=False).real)


def _spectral(h: float, found: Values, exact: Values, scaled: bool) -> Errors:
    """Largest relative error of the eigenvalues that are not zero."""
    ratio = found[exact > 0] / exact[exact > 0]
    return h, {"eigenvalues": float(np.abs(ratio / (ratio[0] if scaled else 1.0) - 1).max())}


def _pointwise(h: float, found: Values, exact: Values, areas: Values, scaled: bool) -> Errors:
    """L2 and largest error of (n, k) values, relative to the largest."""
    if scaled:
        found = found * (areas[:, None] * found * exact).sum() / (areas[:, None] * found**2).sum()
    error = np.linalg.norm(found - exact, axis=1)
    largest = float(np.linalg.norm(exact, axis=1).max())
    mean = float(np.sqrt((areas * error**2).sum() / areas.sum()))
    return h, {"L2": mean / largest, "maximum": float(error.max()) / largest}


def sphere_spectrum(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh, degree = uneven_sphere(level + 1), np.repeat([0, 1, 2], [1, 3, 5])
    return _spectral(edge_length(mesh), eigenvalues(operator(mesh)), degree * (degree + 1.0), scaled)


def torus_spectrum(operator: Operator, level: int, scaled: bool) -> Errors:
    L, h = folded(operator, 8 * 2**level)
    squares = np.add.outer(np.arange(-3, 4) ** 2, np.arange(-3, 4) ** 2)
    return _spectral(h, eigenvalues(L), 4 * np.pi**2 * np.sort(squares.ravel())[:N_EIGENVALUES], scaled)


def _rectangle_exact(first: int) -> Values:
    """Eigenvalues of the rectangle for wave numbers from 0 (Neumann) or from 1 (Dirichlet)."""
    waves = np.pi**2 * np.arange(first, first + N_EIGENVALUES) ** 2
    return np.sort(np.add.outer(waves / SIDES[0] ** 2, waves / SIDES[1] ** 2).ravel())[:N_EIGENVALUES]


def neumann_spectrum(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh = uneven_rectangle(level)
    return _spectral(edge_length(mesh), eigenvalues(operator(mesh)), _rectangle_exact(0), scaled)


def dirichlet_spectrum(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh = uneven_rectangle(level)
    L = operator(mesh)
    inner = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.edges[mesh.faces_per_edge == 1])
    held = Laplacian(*(matrix[inner][:, inner].tocsc() for matrix in (L.stiffness, L.mass)))
    return _spectral(edge_length(mesh), eigenvalues(held), _rectangle_exact(1), scaled)


def _harmonic(mesh: Mesh) -> Values:
    """(n, 1) values of a harmonic of degree 3, to the eigenvalue 12."""
    x, y, z = (mesh.vertices @ np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]).T
    return (x * y * z + x * (x**2 - 3 * y**2) / 4)[:, None]


def sphere_poisson(operator: Operator, level: int, scaled: bool) -> Errors:
    return _sphere_poisson(uneven_sphere(level), operator, scaled)


def flipped_poisson(operator: Operator, level: int, scaled: bool) -> Errors:
    return _sphere_poisson(flipped_sphere(level), operator, scaled)


def _sphere_poisson(mesh: Mesh, operator: Operator, scaled: bool) -> Errors:
    """S u = 12 M Y, solved with one vertex held and the mean taken out."""
    L, Y = operator(mesh), _harmonic(mesh)
    areas = L.mass.diagonal()
    right = 12 * areas * (Y[:, 0] - np.average(Y[:, 0], weights=areas))
    u = np.zeros_like(Y)
    u[1:, 0] = splu(L.stiffness[1:, 1:].tocsc()).solve(right[1:])
    return _pointwise(edge_length(mesh), u - np.average(u, weights=areas, axis=0), Y, areas, scaled)


def sphere_harmonic(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh = uneven_sphere(level)
    L, Y = operator(mesh), _harmonic(mesh)
    return _pointwise(edge_length(mesh), L.delta(Y), 12 * Y, L.mass.diagonal(), scaled)


def sphere_curvature(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh = uneven_sphere(level)
    L, V = operator(mesh), mesh.vertices
    return _pointwise(edge_length(mesh), L.delta(V) / 2, V, L.mass.diagonal(), scaled)


def torus_curvature(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh, exact = uneven_torus(level)
    L = operator(mesh)
    return _pointwise(edge_length(mesh), L.delta(mesh.vertices) / 2, exact, L.mass.diagonal(), scaled)


def cylinder_curvature(operator: Operator, level: int, scaled: bool) -> Errors:
    mesh, exact = uneven_cylinder(level)
    L = operator(mesh)
    inner = np.abs(mesh.vertices[:, 2]) < 0.5
    found, areas = L.delta(mesh.vertices)[inner] / 2, L.mass.diagonal()[inner]
    return _pointwise(edge_length(mesh), found, exact[inner], areas, scaled)


CASES: dict[str, tuple[str, Callable[[Operator, int, bool], Errors]]] = {
    "sphere spectrum": ("Eigenvalues of the sphere", sphere_spectrum),
    "torus spectrum": ("Eigenvalues of the flat torus", torus_spectrum),
    "Neumann spectrum": ("Neumann eigenvalues of a rectangle", neumann_spectrum),
    "Dirichlet spectrum": ("Dirichlet eigenvalues of a rectangle", dirichlet_spectrum),
    "sphere Poisson": ("Poisson problem on the sphere", sphere_poisson),
    "flipped Poisson": ("Poisson problem on the sphere, 15 % of the edges flipped", flipped_poisson),
    "sphere harmonic": ("Laplacian of a harmonic, at the vertices of the sphere", sphere_harmonic),
    "sphere curvature": ("Mean curvature normals of the sphere", sphere_curvature),
    "torus curvature": ("Mean curvature normals of a torus", torus_curvature),
    "cylinder curvature": ("Mean curvature normals of a cylinder, middle half", cylinder_curvature),
}
AT_VERTICES = ("sphere harmonic", "sphere curvature", "torus curvature", "cylinder curvature")


def measure(
    levels: Sequence[int], operators: Sequence[str] = tuple(OPERATORS), cases: Sequence[str] = tuple(CASES)
) -> list[dict[str, Any]]:
    """One row for each case, operator and kind of error: the edge lengths, the errors, and the order fitted."""
    rows = []
    for case in cases:
        errors_of = CASES[case][1]
        table: dict[str, Operator] = {name: OPERATORS[name] for name in operators}
        if case in AT_VERTICES:
            table["heat_kernel, t ~ h"] = slow_heat_kernel
        for name, operator in table.items():
            found = [errors_of(operator, level, name in SCALED) for level in levels]
            sizes = [h for h, _ in found]
            for kind in found[0][1]:
                errors = [error[kind] for _, error in found]
                order = fitted_order(sizes[1:], errors[1:])  # the coarsest mesh is not yet in the range of the order
                rows.append(
                    {"case": case, "operator": name, "error": kind, "h": sizes, "errors": errors, "order": order}
                )
    return rows


def tables(rows: list[dict[str, Any]]) -> dict[str, str]:
    """The orders of all operators in all cases, then a table for each case: errors by mean edge length."""
    orders: dict[str, dict[str, str]] = {}
    for row in rows:
        line = orders.setdefault(row["operator"], {"operator": row["operator"]})
        line[row["case"]] = " / ".join(filter(None, [line.get(row["case"]), f"{row['order']:.2f}"]))
    note = (
        "p of error ~ h^p, fitted without the coarsest mesh; in two norms: L2 / maximum. The anisotropic Laplacian has"
    )
    note += " other eigenvalues and normals by intent, except on a plane."
    sections = {"Orders": f"{markdown_table(list(orders.values()))}\n{note}\n"}
    for case, (title, _) in CASES.items():
        lines = [
            {
                "operator": row["operator"] + (" (best factor)" if row["operator"] in SCALED else ""),
                "error": row["error"],
                **{f"h = {h:.2g}": error for h, error in zip(row["h"], row["errors"], strict=True)},
                "order": f"{row['order']:.2f}",
            }
            for row in rows
            if row["case"] == case
        ]
        sections[title] = markdown_table(lines)
    return sections


def picture(rows: list[dict[str, Any]], figure: Any) -> None:
    """Errors against edge length, one drawing for each case; the largest error where there are two."""
    axes = figure.subplots(4, 3)
    names = list(dict.fromkeys(row["operator"] for row in rows))
    for (case, (title, _)), ax in zip(CASES.items(), axes.ravel(), strict=False):
        for row in rows:
            if row["case"] == case and row["error"] != "L2":
                number = names.index(row["operator"])
                style = ("-", "--", ":")[number // 10 if number < 10 else 1]
                ax.loglog(row["h"], row["errors"], style, color=f"C{number % 10}", marker=".", label=row["operator"])
        h = np.array(rows[0]["h"] if not ax.lines else ax.lines[0].get_xdata())
        ax.loglog(h, 0.5 * ax.get_ylim()[1] * (h / h.max()) ** 2, color="0.6", linewidth=4, alpha=0.4, zorder=0)
        ax.xaxis.set_minor_formatter("")
        ax.set_title(title, fontsize=9)
        ax.set_xlabel("mean edge length; gray: second order", fontsize=7)
    handles, labels = axes[2, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8)
