"""Skeletons of neurons: hemibrain meshes against their tracings, and tubes made of the tracings, with noise, remeshed.

The five meshes and tracings are those that navis ships, in units of 8 nm; the tracings were made of voxels, by others.
Cable counts as found within 400 nm, a tip within 800 nm. The tubes are of parts of the same tracings, so their truth is
exact: a tip is found within two local radii. The voxels in these tubes, of half a median radius, are meshed as those of
a segmented image volume are; tips thinner than a voxel are lost.
``--meshes FOLDER`` takes more tracings (SWC), for lbskel alone: the committed ones are all of over 30 kB in the source
distributions of bmtk 1.1.0, morphology-workflows 0.12.1 (examples/morphologies), pyneuroml 1.3.22 and tmd 2.4.3, and
NeuroM's Neuron.swc, which morph-tool 2.9.1 has. Where such an axis turns back within its tube, the tube has a bump and
the truth no tip.
"""

from __future__ import annotations

__all__ = ["hemibrain_neurons", "hemibrain_row", "part_of", "remeshed", "run", "tube_row", "tubes_around"]

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

import numpy as np
from scipy.sparse.csgraph import depth_first_order

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.thin_tools import OURS, TOOLS, Answer, ask
from benchmarks.vessels import tips_found
from benchmarks.voxels import voxel_body
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.surface_queries import Surface
from lbskel.preprocess import simplify, subdivision
from lbskel.refinement import surface_cells, uncovered_limbs
from lbskel.refinement.region_map import nearest_balls
from lbskel.refinement.tube_fit import tube_radii
from lbskel.shapes import Shape, tube_mesh, with_local_noise
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.edge_sampling import sample_edges
from lbskel.skeleton.pruning import merge_junctions

CABLE, TIP = 50.0, 100.0  # distances within which cable and tips are found, in units of 8 nm
SPACING = 5.0  # of the samples along skeletons, in the same units
MEANS = ("F", "recall", "precision", "to axis", "to axis, median", "tips found", "tip precision", "cpu seconds")

PART_TIPS, QUICK_TIPS = 60, 4  # at most so many tips in a part of a tracing
MAX_LENGTH = 3000.0  # of a part, in its radii: thinner neurites than those of navis take minutes to mesh
# Swept: lower bounds on the bulge of a limb without a branch, where a hemisphere has 1
BULGES = (0.55, 0.6, 0.62, 0.65, 0.7, 0.85)
# Swept: faces that refinement of coarse meshes aims at, area of the cells in which ends are found
FACES = (17_000, 18_000, 18_500, 19_000, 20_000, 22_000, 23_000, 24_000, 26_000, 28_000, 32_000, 40_000, 80_000)
CELL_AREAS = (4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0)
VOXEL = 0.5  # in median radii
CALLS = 3  # of a tool on each neuron, of which the fastest is timed
EDGE_LENGTH, NOISE, KEPT = 0.6, 0.1, 0.5  # of tubes: edges in radii, noise in edges, share of faces after remeshing


def run(quick: bool, results: Path, peers: bool = False, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write neurons.json and neurons.md; ``meshes`` are more tracings, of which tubes are made."""
    tools = list(TOOLS) if peers else list(OURS)
    neurons = list(hemibrain_neurons(1 if quick else 5))
    rows = [
        hemibrain_row(name, tool, truth, ask(tool, mesh, n_calls=CALLS), len(mesh.faces))
        for name, mesh, truth in neurons
        for tool in tools
    ]
    shapes = [remeshed(tubes_around(tracing, QUICK_TIPS if quick else PART_TIPS)) for _, _, tracing in neurons]
    tubes = [
        tube_row(name, tool, shape, ask(tool, shape.mesh))
        for (name, _, _), shape in zip(neurons, shapes, strict=True)
        for tool in tools
    ]
    bodies = [voxel_body(shape, VOXEL) for shape in shapes]
    voxels = [
        tube_row(name, tool, body, ask(tool, body.mesh))
        for (name, _, _), body in zip(neurons, bodies, strict=True)
        for tool in tools
    ]
    others = []
    for path in meshes:
        shape = remeshed(tubes_around(lbskel.read_skeleton(path), PART_TIPS))
        others += [tube_row(path.stem, tool, shape, ask(tool, shape.mesh)) for tool in OURS]
    last = 1 if quick else None
    limbs = [limb_row(neurons, shapes, bulge) for bulge in BULGES[:last]]
    sizes = [setting_row(neurons, subdivision, "MAX_FACES", n_faces) for n_faces in FACES[:last]]
    cells = [setting_row(neurons, surface_cells, "CELL_AREA", area) for area in CELL_AREAS[:last]]
    summary = [_summary(rows, tool) for tool in tools]
    save_json(
        results / "neurons.json",
        {
            "summary": summary,
            "hemibrain": rows,
            "tubes": tubes,
            "voxels": voxels,
            "other tubes": others,
            "limbs": limbs,
            "refined to": sizes,
            "cells": cells,
        },
        packages=("navis", "skeletor", "PyGEL3D", "CGAL"),
        meshes=[*(path for name, _, _ in neurons for path in _files(name)), *meshes],
    )
    save_markdown(
        results / "neurons.md",
        "Neurons",
        {
            "Hemibrain neurons, means": markdown_table(summary),
            "Each neuron": markdown_table(rows),
            "Tubes around parts of the tracings": markdown_table(tubes),
            "Voxels in the same tubes": markdown_table(voxels),
            **({"Tubes around parts of other tracings": markdown_table(others)} if others else {}),
            "Bulge of limbs that are grown, means of the neurons and of the tubes": markdown_table(limbs),
            "Faces that the refinement of coarse meshes aims at, means": markdown_table(sizes),
            "Cells of a surface, area in squared local radii, means": markdown_table(cells),
        },
    )


def _files(name: str) -> list[Path]:
    """The files of a mesh and of its tracing, of navis."""
    import navis

    return [Path(navis.__file__).parent / "data" / kind / f"{name}.{kind}" for kind in ("obj", "swc")]


def hemibrain_neurons(n: int) -> Iterator[tuple[str, lbskel.Mesh, lbskel.Skeleton]]:
    """List the identifiers, meshes and tracings of the first neurons that navis ships."""
    import navis

    meshes = navis.NeuronList(navis.example_neurons(n, kind="mesh"))
    tracings = navis.NeuronList(navis.example_neurons(n, kind="skeleton"))
    for mesh, tracing in zip(meshes, tracings, strict=True):
        table = tracing.nodes
        ids, parents = table["node_id"].to_numpy(), table["parent_id"].to_numpy()
        order = np.argsort(ids)
        child = np.flatnonzero(parents >= 0)
        edges = np.stack([child, order[np.searchsorted(ids[order], parents[child])]], axis=1)
        truth = lbskel.Skeleton(table[["x", "y", "z"]].to_numpy(float), edges, table["radius"].to_numpy(float))
        yield str(mesh.id), lbskel.Mesh(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces)), truth


def hemibrain_row(name: str, tool: str, truth: lbskel.Skeleton, answer: Answer | str, faces: int) -> dict[str, Any]:
    """Compare an answer with a tracing of the same neuron: shares of the cable and of the tips that agree."""
    row: dict[str, Any] = {"neuron": name, "tool": tool, "faces": faces}
    if isinstance(answer, str):
        return {**row, "error": answer}
    skeleton = answer.skeleton
    points, traced = sample_edges(skeleton, SPACING)[0], sample_edges(truth, SPACING)[0]
    to_truth, _, radii = nearest_on_edges(truth, points)
    precision = float((to_truth <= CABLE).mean())
    recall = float((nearest_on_edges(skeleton, traced)[0] <= CABLE).mean())
    return {
        **row,
        "F": 2 * precision * recall / max(precision + recall, 1e-12),
        "recall": recall,
        "precision": precision,
        "to axis": float((to_truth / radii).mean()),
        "to axis, median": float(np.median(to_truth / radii)),
        "tips found": tips_found(skeleton, truth, TIP),
        "tip precision": tips_found(truth, skeleton, TIP),
        "tips": f"{len(skeleton.tips)}/{len(truth.tips)}",
        "components": skeleton.n_components,
        "cycles": skeleton.cycle_rank,
        "length / true length": skeleton.length / truth.length,
        "verdict": answer.verdict,
        "cpu seconds": answer.seconds,
    }


def limb_row(
    neurons: list[tuple[str, lbskel.Mesh, lbskel.Skeleton]], shapes: list[Shape], bulge: float
) -> dict[str, Any]:
    """Measure skeletons of neurons and of tubes with another lower bound on the bulge of limbs."""
    on_neurons = setting_row(neurons, uncovered_limbs, "MIN_BULGE", bulge)
    with mock.patch.object(uncovered_limbs, "MIN_BULGE", bulge):
        rows = [tube_row("", "lbskel", shape, Answer(lbskel.skeletonize(shape.mesh), 0.0)) for shape in shapes]
    tubes = {f"{key} of tubes": float(np.mean([row[key] for row in rows])) for key in ("tips found", "accuracy")}
    length_error = float(np.mean([abs(row["length error"]) for row in rows]))
    n_tips = [tuple(map(int, row["tips"].split("/"))) for row in rows]
    counted = {"tips of tubes": "/".join(str(sum(each)) for each in zip(*n_tips, strict=True))}
    return on_neurons | tubes | counted | {"length error of tubes": length_error}


def setting_row(
    neurons: list[tuple[str, lbskel.Mesh, lbskel.Skeleton]], module: ModuleType, name: str, value: float
) -> dict[str, Any]:
    """Measure skeletons, and their time, with another value of a constant of a module."""
    rows = []
    with mock.patch.object(module, name, value):
        for neuron, mesh, truth in neurons:
            began = time.process_time()
            skeleton = lbskel.skeletonize((mesh.vertices, mesh.faces))
            answer = Answer(skeleton, time.process_time() - began)
            rows.append(hemibrain_row(neuron, "lbskel", truth, answer, len(mesh.faces)))
    measures = ("F", "tips found", "tip precision", "to axis", "cpu seconds")
    return {name: value, **{key: float(np.mean([row[key] for row in rows])) for key in measures}}


def _summary(rows: list[dict[str, Any]], tool: str) -> dict[str, Any]:
    """Compute means over the neurons with a skeleton."""
    own = [row for row in rows if row["tool"] == tool]
    done = [row for row in own if "error" not in row]
    means = {key: float(np.mean([row[key] for row in done])) if done else None for key in MEANS}
    one = sum(row.get("components") == 1 for row in own)
    return {"tool": tool, **means, "one component": f"{one}/{len(own)}", "failed": len(own) - len(done)}


def tubes_around(tracing: lbskel.Skeleton, n_tips: int) -> Shape:
    """Mesh the tubes of a part of a tracing; of a smaller part where tubes touch that should not."""
    try:
        return tube_mesh(part_of(tracing, n_tips), edge_length=EDGE_LENGTH)
    except lbskel.MeshError:
        return tubes_around(tracing, n_tips * 3 // 4)


def part_of(tracing: lbskel.Skeleton, n_tips: int) -> lbskel.Skeleton:
    """Cut out the subtree with the most tips, up to so many and up to MAX_LENGTH; the root is the thickest node."""
    graph = weighted_graph(tracing.edges, np.ones(len(tracing.edges)), len(tracing.nodes))
    order, parents = depth_first_order(graph, int(np.argmax(tracing.radii)), directed=False)
    tips, lengths = np.zeros(len(tracing.nodes), dtype=np.int64), np.zeros(len(tracing.nodes))
    for node in order[::-1].tolist():
        tips[node] += tracing.degrees[node] == 1
        if (parent := parents[node]) >= 0:
            step = np.linalg.norm(tracing.nodes[node] - tracing.nodes[parent])
            tips[parent] += tips[node]
            lengths[parent] += lengths[node] + step / tracing.radii[[node, parent]].mean()
    allowed = np.where((tips <= n_tips) & (lengths <= MAX_LENGTH), tips, -1)
    top = next(node for node in order.tolist() if allowed[node] == allowed.max())
    below = np.zeros(len(tracing.nodes), dtype=bool)
    for node in order.tolist():
        below[node] = node == top or (parents[node] >= 0 and below[parents[node]])
    row = np.cumsum(below) - 1
    edges = row[tracing.edges[below[tracing.edges].all(axis=1)]]
    return lbskel.Skeleton(tracing.nodes[below], edges, tracing.radii[below])


def remeshed(shape: Shape) -> Shape:
    """Roughen a mesh and collapse its edges, so that its triangles are uneven as those of a scan."""
    rough = with_local_noise(shape.mesh, NOISE)
    coarse = simplify(rough, target_faces=int(KEPT * len(rough.faces))).mesh
    return Shape(coarse, shape.truth, shape.name)


def tube_row(name: str, tool: str, shape: Shape, answer: Answer | str) -> dict[str, Any]:
    """Compare an answer with the axis of tubes: length, sections, radii and tips."""
    row: dict[str, Any] = {"neuron": name, "tool": tool, "faces": len(shape.mesh.faces)}
    if isinstance(answer, str):
        return {**row, "error": answer}
    compared = lbskel.ground_truth_distances(answer.skeleton, shape.truth)
    return {
        **row,
        "length error": compared.length_error,
        "sections": f"{_sections(answer.skeleton, shape.truth)}/{_sections(shape.truth, shape.truth)}",
        "radius error": _known(compared.radius_error),
        "mean radius error": _mean_radius_error(answer.skeleton, shape.truth),
        "mean radius error to the mesh": _mean_radius_error(answer.skeleton, _with_radii_of_mesh(shape)),
        "tips": f"{compared.n_tips}/{compared.n_true_tips}",
        "tips found": tips_found(answer.skeleton, shape.truth),
        "accuracy": compared.accuracy,
        "coverage": compared.coverage,
        "topology right": compared.is_topology_right,
        "verdict": answer.verdict,
        "cpu seconds": answer.seconds,
    }


def _mean_radius_error(skeleton: lbskel.Skeleton, truth: lbskel.Skeleton) -> float | None:
    """Compute the error of the mean radii; None for a tool that has none."""
    if len(skeleton.mean_radii) == 0:
        return None
    return _known(lbskel.ground_truth_distances(replace(skeleton, radii=skeleton.mean_radii), truth).radius_error)


def _with_radii_of_mesh(shape: Shape) -> lbskel.Skeleton:
    """Replace the radii of the truth by those of the round tubes around its own axis that fit the mesh.

    A tracing's radii differ from node to node by more than the union of its tubes can show.
    """
    axis = replace(shape.truth, node_of_vertex=nearest_balls(shape.truth, shape.mesh.vertices))
    return replace(shape.truth, radii=tube_radii(axis, Surface(shape.mesh)))


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _sections(skeleton: lbskel.Skeleton, truth: lbskel.Skeleton) -> int:
    """Count branches, once junctions are merged whose limbs overlap by the true radii."""
    radii = nearest_on_edges(truth, skeleton.nodes)[2]
    return len(merge_junctions(lbskel.Skeleton(skeleton.nodes, skeleton.edges, radii)).branches)
