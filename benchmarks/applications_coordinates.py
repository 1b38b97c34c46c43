"""Differential coordinates: reconstruction beside libigl and scipy, rate and error of rounded deltas and positions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import igl
import numpy as np
from scipy.linalg import lstsq
from scipy.sparse import csc_matrix

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown, save_picture
from lbskel.applications.quantization import round_to_bits
from lbskel.shapes import make
from lbskel.visualization import Panel, render

SHAPES = ("dinosaur", "knot", "hand")
BITS = (4, 5, 6, 7, 8, 10, 12)
ANCHORS = (1, 10, 100)
MOST_DENSE = 3000  # vertices, up to which scipy's lstsq takes the dense system in a minute


def reconstruction(quick: bool) -> list[dict[str, Any]]:
    """Largest differences over the largest coordinate: hard anchors from libigl, soft ones from scipy's lstsq."""
    rows = []
    for name, n in (("dinosaur", 1000), *(() if quick else (("dinosaur", 5000), ("knot", 5000)))):
        mesh = make(name, n_vertices=n).mesh
        rng = np.random.default_rng(0)
        V = mesh.vertices
        for operator in ("graph", "cotangent"):
            S = lbskel.laplacian(mesh, operator=operator).stiffness
            deltas = S @ V + 1e-3 * mesh.diagonal * rng.standard_normal(V.shape)
            for k in ANCHORS:
                anchors = rng.choice(len(V), k, replace=False)
                hard = lbskel.reconstruct(mesh, deltas, anchors, operator=operator).vertices
                none = csc_matrix((0, len(V)))
                theirs = igl.min_quad_with_fixed(
                    csc_matrix(S), -deltas, anchors, V[anchors], none, np.empty((0, 3)), True
                )
                row = {"shape": name, "vertices": len(V), "operator": operator, "anchors": k}
                size = np.abs(hard).max()
                row["hard: from libigl's"] = float(np.abs(hard - theirs).max() / size)
                if len(V) <= MOST_DENSE:
                    soft = lbskel.reconstruct(mesh, deltas, anchors, operator=operator, anchor_weight=1.0).vertices
                    center = V[anchors].mean(axis=0)
                    rows_of_anchors = np.eye(len(V))[anchors]
                    theirs = lstsq(
                        np.concatenate([S.toarray(), rows_of_anchors]),
                        np.concatenate([deltas, V[anchors] - center]),
                        lapack_driver="gelsy",
                    )[0]
                    row["soft: from scipy's lstsq"] = float(np.abs(soft - center - theirs).max() / size)
                rows.append(row)
    return rows


def _errors(mesh: lbskel.Mesh, given: lbskel.Mesh) -> dict[str, float]:
    cosines = np.einsum("mx,mx->m", mesh.face_normals, given.face_normals).clip(-1, 1)
    return {
        "error": float(np.sqrt(((mesh.vertices - given.vertices) ** 2).sum(axis=1).mean()) / given.diagonal),
        "normals": float(np.degrees(np.arccos(cosines)).mean()),
    }


def _entropy(codes: Any) -> float:
    """Bits of a row if each column is coded by its frequencies, without their table: fewer than any coder takes."""
    shares = [np.unique(column, return_counts=True)[1] / len(column) for column in codes.T]
    return -float(sum(share @ np.log2(share) for share in shares))


def rates(quick: bool) -> list[dict[str, Any]]:
    """Bits per vertex, error of positions and of normals, for each shape, number of bits and of anchors."""
    rows = []
    for name in SHAPES[:1] if quick else SHAPES:
        mesh = make(name).mesh
        for bits in BITS[::3] if quick else BITS:
            codes, rounded = round_to_bits(mesh.vertices, bits)
            row = {"shape": name, "bits": bits}
            rows.append(
                {
                    **row,
                    "what": "positions",
                    "rate": _entropy(codes),
                    **_errors(mesh.with_vertices(rounded), mesh),
                }
            )
            for k in ANCHORS:
                result = lbskel.quantize_deltas(mesh, bits=bits, n_anchors=k)
                what = f"deltas, {k} anchors"
                rows.append({**row, "what": what, "rate": result.bits_per_vertex, **_errors(result.mesh, mesh)})
    return rows


def _means(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Means over the shapes; geometric ones of errors."""
    table = []
    for bits, what in dict.fromkeys((row["bits"], row["what"]) for row in rows):
        found = [row for row in rows if (row["bits"], row["what"]) == (bits, what)]
        table.append(
            {
                "bits": bits,
                "what": what,
                "bits per vertex": float(np.mean([row["rate"] for row in found])),
                "error / diagonal": float(np.exp(np.mean(np.log([row["error"] for row in found])))),
                "normals off by degrees": float(np.exp(np.mean(np.log([row["normals"] for row in found])))),
            }
        )
    return table


def _draw_rates(table: list[dict[str, Any]], figure: Any) -> None:
    axes = figure.subplots(1, 2)
    for ax, measure in zip(axes, ("error / diagonal", "normals off by degrees"), strict=True):
        for what in dict.fromkeys(row["what"] for row in table):
            found = [row for row in table if row["what"] == what]
            ax.semilogy([row["bits per vertex"] for row in found], [row[measure] for row in found], "o-", label=what)
        ax.set_xlabel("bits per vertex")
        ax.set_ylabel(measure)
        ax.grid(alpha=0.3)
    axes[0].legend()


def least_squares_meshes(quick: bool) -> list[dict[str, Any]]:
    """Error of least-squares meshes with more and more anchors."""
    mesh = make("hand", n_vertices=1000 if quick else 5000).mesh
    rows = []
    for n in (10, 50, 100) if quick else (10, 50, 100, 500):
        surface, _ = lbskel.least_squares_mesh(mesh, n)
        distances = np.linalg.norm(surface.vertices - mesh.vertices, axis=1) / mesh.diagonal
        rms = float(np.sqrt((distances**2).mean()))
        rows.append({"anchors": n, "error / diagonal": rms, "largest": float(distances.max())})
    return rows


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write applications_coordinates.json, .md and pictures; libigl is always there."""
    exact, rows, surfaces = reconstruction(quick), rates(quick), least_squares_meshes(quick)
    table, name = _means(rows), "applications_coordinates"
    save_json(results / f"{name}.json", {"reconstruction": exact, "rates": rows, "least_squares_meshes": surfaces})
    save_markdown(
        results / f"{name}.md",
        "Differential coordinates",
        {
            "Reconstruction": "Largest difference of a coordinate, relative to the largest coordinate.\n\n"
            + markdown_table(exact),
            "Rounded deltas and positions": f"Means over {', '.join(SHAPES)} of about 5,000 vertices. Bits per vertex: "
            "those of the codes, and the anchors; of positions their entropy, which is less; without the faces.\n\n"
            + markdown_table(table),
            "Least-squares meshes": "A hand from its connectivity and the positions of some vertices.\n\n"
            + markdown_table(surfaces),
        },
    )
    save_picture(results / f"{name}_rates.png", lambda figure: _draw_rates(table, figure), size=(11, 4.5))
    mesh = make("hand").mesh
    encoded = lbskel.quantize_deltas(mesh, bits=6, n_anchors=20)
    positions = mesh.with_vertices(round_to_bits(mesh.vertices, 6)[1])
    panels = [
        Panel(mesh, title="given"),
        Panel(positions, title="positions of 6 bits"),
        Panel(encoded.mesh, title="deltas of 6 bits, 20 anchors"),
        Panel(lbskel.least_squares_mesh(mesh, 100)[0], title="least-squares mesh, 100 anchors"),
    ]
    render(panels, results / f"{name}.png", size=(1600, 560), force=True)
