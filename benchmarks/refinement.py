"""Refinement: accuracy on shapes that are not tubes, beside other tools, and what each pass contributes.

Distances are exact, from points along one graph to the segments of the other, in true local radii. A graph is right if
its tips, cycles and components are those of the axis, and so are its junctions, once those are merged whose limbs
overlap. Nothing was tuned at the parameters of the second set of shapes, nor on the third one, of random creatures. In
the ablation each pass is left out in turn, or one of its bounds is replaced.
"""

from __future__ import annotations

__all__ = ["EXTENSIONS", "PASSES", "means_and_graphs", "measured", "n_tips_lost", "run"]

import itertools
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from benchmarks.peers import PEERS
from benchmarks.refinement_trials import TRIALS
from benchmarks.summaries import MEASURES, means
from lbskel.geometry.mirrors import Mirror
from lbskel.geometry.normals import normalized
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.branch_lines import BranchLines, branch_lines
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.extrema import GeodesicExtrema
from lbskel.refinement.mirror_symmetry import find_symmetries
from lbskel.refinement.uncovered_limbs import Limbs
from lbskel.shapes import SHAPES, Shape, creature, make, with_local_noise
from lbskel.shapes.hard import HARD_SHAPES
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.pruning import merge_junctions

MESHES = Path(__file__).parent.parent / "meshes"
TOOLS = ("lbskel", "PyGEL3D", "CGAL")
TIME_LIMIT = 120.0  # seconds for a tool on one mesh

TUNED: dict[str, dict[str, Any]] = {**{name: {} for name in HARD_SHAPES}, "vessels": {"n_forks": 20, "seed": 3}}
HELD_OUT: dict[str, dict[str, Any]] = {
    "twisted ellipse": {"ratio": 3.0, "twist": 2.0},
    "ribbon": {"ratio": 7.0, "length": 3.0},
    "leaf": {"ratio": 4.5, "width": 0.4},
    "zigzag": {"degrees": 42.0, "n_bends": 3},
    "acute fork": {"degrees": 20.0},
    "oblique cross": {"degrees": 50.0, "ratio": 0.45},
    "prongs": {"n": 3, "gap": 0.3},
    "torso": {"degrees": 12.0},
    "vessels": {"n_forks": 30, "seed": 8},
    "twigs": {"ratio": 0.2},
    "horn": {"ratio": 6.0},
    "tee": {"ratio": 0.6},
    "lattice": {"n": 4},
    "spring": {"gap": 0.8},
}
CREATURES = range(24)  # seeds; nothing was tuned on them
QUICK, QUICK_TUBES, QUICK_CREATURES = ("zigzag", "tee"), ("tripod",), range(1)
EXTENSIONS = ("off", "obj", "ply", "stl")
TIP_DISTANCE = 3.0  # within which two tips are the same, in the larger of their mean radii, since that of a sharp tip
# is nearly zero; a guess: an end has a cap of one radius

PIPELINE_PASSES = "lbskel.pipeline.passes"


def _unchanged(skeleton: lbskel.Skeleton, *_: Any, **__: Any) -> lbskel.Skeleton:
    """Stand in for a pass that is left out."""
    return skeleton


def _without_single_sections(
    skeleton: lbskel.Skeleton, centers: SectionCenters, *, with_single: bool = False
) -> BranchLines:
    """Find lines of branches, but for those through one section."""
    return branch_lines(skeleton, centers)


def _none_missed(extrema: GeodesicExtrema, *_: Any) -> NDArray[np.bool_]:
    """Stand in for the test of ends: none is missed."""
    return np.zeros(len(extrema.vertices), dtype=bool)


def _without_centerlines(mesh: lbskel.Mesh, limbs: Limbs) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Stand in for the centerlines of limbs: there are none, so that branches lead straight to the caps."""
    return [(np.empty((0, 3)), np.empty(0)) for _ in limbs.ends]


def _not_split(
    skeleton: lbskel.Skeleton, centers: SectionCenters, surface: Surface
) -> tuple[lbskel.Skeleton, SectionCenters]:
    """Stand in for the split of junctions along trunks: they stay as they are."""
    return skeleton, centers


def _not_judged(
    skeleton: lbskel.Skeleton,
    lines: BranchLines,
    inner: NDArray[np.int64],
    sines: NDArray[np.float64],
    surface: Surface,
) -> NDArray[np.float64]:
    """Stand in for the judgement of pairs of junctions by trunks: it stays that without a trunk."""
    return sines


# For each pass, what stands in for its function.
PASSES: dict[str, dict[str, Any]] = {
    "prune": {f"{PIPELINE_PASSES}.prune": _unchanged},
    "prune flat ends": {f"{PIPELINE_PASSES}.prune_flat_ends": _unchanged},
    "reroute through regions": {f"{PIPELINE_PASSES}.reroute_through_regions": _unchanged},
    "merge junctions by distance": {f"{PIPELINE_PASSES}.merge_junctions": _unchanged},
    "merge junctions by axes": {f"{PIPELINE_PASSES}._with_merged_junctions": _unchanged},
    "split junctions along trunks": {f"{PIPELINE_PASSES}.split_junctions_along_trunks": _not_split},
    "pairs judged by trunks": {"lbskel.refinement.junctions.judge_pairs": _not_judged},
    "recenter": {f"{PIPELINE_PASSES}.recenter": _unchanged},
    "place junctions": {"lbskel.refinement.centering.place_junctions": lambda skeleton, centers, surface: centers},
    "lines of single sections": {"lbskel.refinement.junctions.branch_lines": _without_single_sections},
    "bends of branches next to junctions": {"lbskel.refinement.branch_lines._share_of_bend": lambda *_: 0.0},
    "junctions towards the middle": {"lbskel.refinement.junctions._towards": lambda points, targets, limits: points},
    "straight across gaps": {
        "lbskel.refinement.centering._across_gaps": lambda skeleton, positions, is_gap, surface: positions
    },
    "contract corner spurs": {"lbskel.refinement.centering.contract_corner_spurs": _unchanged},
    "extend tips": {f"{PIPELINE_PASSES}.extend_tips": _unchanged},
    "centers of the ends of branches": {"lbskel.refinement.tips._with_centered_ends": _unchanged},
    "grow limbs": {f"{PIPELINE_PASSES}.grow_limbs": _unchanged},
    "limbs without tip, before centering": {f"{PIPELINE_PASSES}.grow_limbs_without_tip": _unchanged},
    "limbs at missed ends": {"lbskel.refinement.limb_growth.is_missed": _none_missed},
    "limbs out of the balls": {"lbskel.refinement.uncovered_limbs.MIN_BULGE": 1e9},
    "centerlines of limbs": {"lbskel.refinement.limb_growth.trace_limbs": _without_centerlines},
    "prune blunt ends": {f"{PIPELINE_PASSES}.prune_blunt_ends": _unchanged},
    "make mirror symmetric": {f"{PIPELINE_PASSES}.make_mirror_symmetric": _unchanged},
    "reroute inside": {f"{PIPELINE_PASSES}._rerouted_inside": _unchanged},
    "relax paths": {"lbskel.refinement.containment.relax_inside": lambda paths, surface: paths},
    "fit tubes": {f"{PIPELINE_PASSES}.fit_tubes": _unchanged},
}
# Bounds in place of those of the code: on gaps of lines of sight in flat ends, on places of junctions, on symmetry, and
# in the relaxation of paths that left the solid
BOUNDS: dict[str, dict[str, Any]] = {
    f"{name} {value}": {f"lbskel.refinement.{target}": value for target in targets.split()}
    for name, targets, values in (
        ("gap of", "flat_ends.MAX_GAP", (0.005, 0.01, 0.04, 0.08)),
        ("slope of", "inscribed_balls.MIN_SLOPE", (0.25, 0.7, 1.1)),
        ("sections next to a junction", "branch_lines.N_SECTIONS", (3, 4, 6, 8)),
        ("undetermined below", "branch_lines.MIN_SHARE", (0.001, 0.005, 0.01)),
        ("growth of", "centerlines.MAX_GROWTH", (1.1, 1.5)),
        ("merge length of", "junctions.MAX_MERGE_LENGTH", (2.0, 3.0, 6.0)),
        ("merged up to a sine of", "junctions.MAX_SINE", (0.3, 0.33, 0.4, 0.44)),
        ("growth of balls", "junctions.MIN_BALL_GROWTH", (-1.0, 0.05, 0.06, 0.07, 0.087)),
        ("ball ratio of", "junctions.MIN_BALL_RATIO trunks.MIN_BALL_RATIO", (0.0, 0.8, 0.95)),
        ("deviations of", "mirror_symmetry.TYPICAL_DEVIATION", (0.05, 0.2)),
        ("bulge of", "uncovered_limbs.MIN_BULGE", (0.55, 0.7, 0.85)),
        ("growth of rings", "limb_centerlines.MAX_GROWTH", (0.3, 0.7)),
        ("distance of rings", "limb_centerlines.SPACING", (0.25, 1.0)),
        ("shortest step of", "tips.MIN_STEP", (0.02, 0.125)),
        ("reach of a tip", "extrema.TIP_REACH", (2.0, 2.5, 4.0)),
        ("on the plane below", "mirror_symmetry.ON_PLANE", (0.25, 1.0)),
        ("power of", "relaxation.POWER", (1.0, 3.0)),
        ("smallest ball of", "relaxation.MIN_RATIO", (0.03, 0.3)),
        ("steps between spacings", "relaxation.STEPS_BETWEEN", (2, 8)),
        ("points of paths at", "relaxation.SPACINGS", ((0.9, 0.9, 0.9), (0.6, 0.6, 0.6, 0.6))),
        ("bending weight of centers", "centering.BENDING_WEIGHT tube_fit.BENDING_WEIGHT", (0.25, 1.0, 2.0)),
        ("bending weight of tubes", "tube_fit.COURSE_WEIGHT", (0.06, 0.125, 0.5, 1.0)),
        ("weight of gaps", "centering.POSITION_WEIGHT tube_fit.POSITION_WEIGHT", (1e-3, 1e-2, 3e-2)),
        ("deviation of", "tube_fit.MAX_DEVIATION", (0.1, 0.3, 0.5)),
        ("ball share of tubes", "tube_fit.MIN_BALL_SHARE", (0.0, 0.5, 0.7, 0.9)),
        ("tube steps of", "tube_fit.N_STEPS", (1, 2, 6)),
        ("nearest balls of", "tubes.N_NEAREST", (2, 8)),
        ("smallest radius of", "tubes.MIN_RADIUS", (1e-4, 0.1)),
    )
    for value in values
} | {
    f"levels of limbs {n}": {"lbskel.refinement.uncovered_limbs.LEVELS": np.geomspace(6.0, 1.05, n)}
    for n in (5, 10, 36)
}

NOISES = (0.1, 0.2, 0.3)  # standard deviation of noise along the normals, in local edge lengths
BULGES = (0.55, 0.62, 0.7, 0.85)  # lower bounds on the bulge of a limb; a hemisphere has 1


@contextmanager
def replaced(name: str) -> Iterator[None]:
    """Put the stand-ins of a name in place; a name that is in no table changes nothing."""
    patches = [mock.patch(target, stand_in) for target, stand_in in (PASSES | BOUNDS).get(name, {}).items()]
    for patch in patches:
        patch.start()
    try:
        yield
    finally:
        for patch in patches:
            patch.stop()


def hard_shapes(quick: bool) -> dict[tuple[str, str], Shape]:
    """Build the hard shapes of both parts."""
    return {
        (part, name): HARD_SHAPES[name](**given)
        for part, parameters in (("tuned", TUNED), ("held out", HELD_OUT))
        for name, given in parameters.items()
        if not quick or name in QUICK
    }


def real_meshes(more: Sequence[Path]) -> list[Path]:
    """List the files of meshes in the repository, and those of further ones."""
    return [path for path in (*sorted(MESHES.iterdir()), *more) if path.suffix.lstrip(".") in EXTENSIONS]


def creatures_of(quick: bool) -> dict[tuple[str, str], Shape]:
    """Build the random creatures."""
    return {("creatures", str(seed)): creature(seed) for seed in (QUICK_CREATURES if quick else CREATURES)}


def run(quick: bool, results: Path, peers: bool = False, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write refinement.json and refinement.md; ``meshes`` are more real ones for the ablation."""
    hard, creatures = hard_shapes(quick), creatures_of(quick)
    tools = TOOLS if peers else TOOLS[:1]
    rows = [
        {"set": part, "shape": name, "tool": tool, **_row(tool, shape)}
        for (part, name), shape in (hard | creatures).items()
        for tool in tools
    ]
    summary = [_summary(rows, part, tool) for part in ("tuned", "held out", "creatures") for tool in tools]
    paths = real_meshes(meshes)
    real = [lbskel.read_mesh(path) for path in paths[: 1 if quick else None]]
    title, ablation = replace_each(("none", *PASSES, *BOUNDS), quick, [*hard.values()], [*creatures.values()], real)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        noise = list(pool.map(partial(_noise_row, meshes=real), *zip(*itertools.product(NOISES, BULGES), strict=True)))
    save_json(
        results / "refinement.json",
        {"summary": summary, "rows": rows, "ablation": ablation, "noise": noise},
        packages=("PyGEL3D", "CGAL"),
        meshes=paths,
    )
    save_markdown(
        results / "refinement.md",
        "Refinement",
        {
            "Hard shapes and creatures, means": markdown_table(summary),
            "Each hard shape and creature": markdown_table(rows),
            title: markdown_table(ablation),
            f"Noise on real meshes, by the bulge of a limb: {len(real)} meshes": markdown_table(noise),
            "Tried and not kept, by hand": markdown_table(TRIALS),
        },
    )


def replace_each(
    names: Sequence[str], quick: bool, hard: Sequence[Shape], creatures: Sequence[Shape], real: Sequence[lbskel.Mesh]
) -> tuple[str, list[dict[str, Any]]]:
    """Measure with the stand-ins of each name in place.

    Returns
    -------
    str
        A title that says what was measured.
    list of dict
        A row for each name.
    """
    tubes = [make(name) for name in (QUICK_TUBES if quick else SHAPES)]
    baseline = [lbskel.skeletonize(lbskel.Mesh(mesh.vertices, mesh.faces)) for mesh in real]
    planes = [
        [symmetry.plane for symmetry in find_symmetries(skeleton, Surface(lbskel.Mesh(mesh.vertices, mesh.faces)))]
        for skeleton, mesh in zip(baseline, real, strict=True)
    ]  # of copies: a surface is kept with its mesh, and is not sent to other processes
    sets = {"tubes": tubes, "hard": hard, "creatures": creatures}
    replacing = partial(_ablation, sets=sets, real=real, baseline=baseline, planes=planes)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        rows = list(pool.map(replacing, names))
    title = (
        f"Passes left out or bounds replaced: {len(tubes)} tubes, {len(hard)} hard shapes, {len(creatures)} creatures, "
        f"{len(real)} meshes, {sum(map(bool, planes))} with a plane of symmetry"
    )
    return title, rows


def _row(tool: str, shape: Shape) -> dict[str, Any]:
    """Measure one tool on one shape."""
    answer = run_in_subprocess(
        PEERS[tool], np.array(shape.mesh.vertices), np.array(shape.mesh.faces), timeout=TIME_LIMIT
    )
    if "error" in answer:
        return {"error": answer["error"]}
    nodes, edges = answer["value"]
    return measured(lbskel.Skeleton(nodes, edges, np.zeros(len(nodes))), shape.truth)


def measured(skeleton: lbskel.Skeleton, truth: lbskel.Skeleton) -> dict[str, Any]:
    """Compare a skeleton with the axis: distances, tips, junctions, and whether the graph is right."""
    distances = lbskel.ground_truth_distances(skeleton, truth)
    junctions, true_junctions = _n_junctions(skeleton, truth), _n_junctions(truth, truth)
    is_right = distances.is_topology_right and distances.n_tips == distances.n_true_tips and junctions == true_junctions
    return {
        **{measure: getattr(distances, measure) for measure in MEASURES},
        "tips": f"{distances.n_tips}/{distances.n_true_tips}",
        "junctions": f"{junctions}/{true_junctions}",
        "graph right": is_right,
    }


def _n_junctions(skeleton: lbskel.Skeleton, truth: lbskel.Skeleton) -> int:
    """Count junctions, once those are merged whose limbs overlap by the true radii."""
    radii = nearest_on_edges(truth, skeleton.nodes)[2]
    return len(merge_junctions(lbskel.Skeleton(skeleton.nodes, skeleton.edges, radii)).junctions)


def means_and_graphs(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Compute means over the shapes that gave a skeleton, and count right graphs over all."""
    return {
        **means(rows),
        "graphs right": f"{sum(row.get('graph right', False) for row in rows)}/{len(rows)}",
    }


def _summary(rows: Sequence[dict[str, Any]], part: str, tool: str) -> dict[str, Any]:
    return {"set": part, "tool": tool} | means_and_graphs(
        [row for row in rows if (row["set"], row["tool"]) == (part, tool)]
    )


def _ablation(
    name: str,
    sets: Mapping[str, Sequence[Shape]],
    real: Sequence[lbskel.Mesh],
    baseline: Sequence[lbskel.Skeleton],
    planes: Sequence[Sequence[Mirror]],
) -> dict[str, Any]:
    """Measure what is left without one pass; tips of the whole refinement with none near are lost.

    On a mesh with planes of symmetry, a tip has a twin if its mirror image has a tip near. The turn of a mesh is the
    95th percentile of the angles between successive edges of its branches; a mean over the meshes tells crooked paths,
    and so does that of their distances from the medial points of the surface, in radii.
    """
    with replaced(name):
        found = {
            part: means_and_graphs([measured(lbskel.skeletonize(shape.mesh), shape.truth) for shape in shapes])
            for part, shapes in sets.items()
        }
        skeletons = [lbskel.skeletonize(mesh) for mesh in real]
    return {
        "replaced": name,
        **{f"{part}, {key}": of[key] for part, of in found.items() for key in ("accuracy", "coverage", "graphs right")},
        "extremities missed": sum(s.report["score"]["measures"]["extremities_missed"] for s in skeletons),
        "tunnels missed": sum(s.report["score"]["measures"]["tunnels_missed"] or 0 for s in skeletons),
        "tips lost": sum(map(n_tips_lost, skeletons, baseline)),
        "tips added": sum(map(n_tips_lost, baseline, skeletons)),
        "tips without a twin": sum(map(_n_without_twin, skeletons, planes)),
        "turn, degrees": float(np.mean([_turn(skeleton) for skeleton in skeletons])),
        "medial accuracy": float(np.mean([s.report["score"]["measures"]["medial_accuracy_95"] for s in skeletons])),
        **{verdict: sum(s.report["score"]["verdict"] == verdict for s in skeletons) for verdict in ("warn", "fail")},
    }


def _turn(skeleton: lbskel.Skeleton) -> float:
    """95th percentile of the angles between successive edges of branches, in degrees; 0 if there are none."""
    before, at, after = skeleton.triples
    if len(at) == 0:
        return 0.0
    first, second = (normalized(skeleton.nodes[j] - skeleton.nodes[i]) for i, j in ((before, at), (at, after)))
    return float(np.percentile(np.degrees(np.arccos(np.clip((first * second).sum(axis=1), -1, 1))), 95))


def n_tips_lost(skeleton: lbskel.Skeleton, reference: lbskel.Skeleton) -> int:
    """Count the tips of a reference that have no tip within TIP_DISTANCE of the larger of both mean radii."""
    tips, others = reference.tips, skeleton.tips
    if len(others) == 0:
        return len(tips)
    distances, nearest = cKDTree(skeleton.nodes[others]).query(reference.nodes[tips])
    radii = np.maximum(reference.mean_radii[tips], skeleton.mean_radii[others][nearest])
    return int((distances > TIP_DISTANCE * radii).sum())


def _n_without_twin(skeleton: lbskel.Skeleton, planes: Sequence[Mirror]) -> int:
    """Count the tips whose mirror image in a plane has no tip within TIP_DISTANCE of their mean radii."""
    images = [replace(skeleton, nodes=plane.mirrored(skeleton.nodes)) for plane in planes]
    return sum(n_tips_lost(skeleton, image) for image in images)


def _noise_row(deviation: float, bulge: float, meshes: Sequence[lbskel.Mesh]) -> dict[str, Any]:
    """Compare the tips of meshes with and without noise, with a lower bound on the bulge of limbs."""
    with mock.patch("lbskel.refinement.uncovered_limbs.MIN_BULGE", bulge):
        clean = [lbskel.skeletonize(mesh) for mesh in meshes]
        noisy = [lbskel.skeletonize(with_local_noise(mesh, deviation)) for mesh in meshes]
    return {
        "noise, edges": deviation,
        "bulge of limbs": bulge,
        "tips without noise": sum(len(skeleton.tips) for skeleton in clean),
        "tips with noise": sum(len(skeleton.tips) for skeleton in noisy),
        "tips lost": sum(map(n_tips_lost, noisy, clean)),
        "tips added": sum(map(n_tips_lost, clean, noisy)),
        "most tips added to one mesh": max(map(n_tips_lost, clean, noisy), default=0),
    }
