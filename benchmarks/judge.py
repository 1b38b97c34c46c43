"""The verdict against the truth: scores of skeletons by several tools, of shapes whose axes are known.

The true error of a skeleton is the larger one of the 95th percentiles of its accuracy and its coverage, in true local
radii. Limbs are cut off the true axes, one at a time, to see which of them the medial points tell. Branches are moved
aside, one at a time, to see which of them their cross-sections tell; neurons that navis ships, numbered in several
orders, tell how many skeletons without such a branch the same cross-sections fail.
"""

from __future__ import annotations

__all__ = ["run"]

from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.neurons import hemibrain_neurons
from benchmarks.refinement import HELD_OUT, TUNED
from benchmarks.thin_tools import OURS, TOOLS, Answer, ask
from lbskel.evaluation import medial_points, skeleton_shape
from lbskel.evaluation.measures import MEASURES
from lbskel.evaluation.scoring import centeredness_errors
from lbskel.shapes import SHAPES, VARIANTS, Shape, make
from lbskel.shapes.hard import HARD_SHAPES
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.editing import contract_branches

GOOD, BAD = 0.15, 0.3  # true errors below which a skeleton is good, and above which it is bad
CLASSES = {f"below {GOOD}": (0.0, GOOD), "between": (GOOD, BAD), f"over {BAD}": (BAD, np.inf)}
# measures by medial points, which refinement does not use, and by extrema, with which it grows limbs
FAMILIES = {
    "medial": {"medial_accuracy_95", "medial_coverage_98", "uncovered_parts"},
    "extrema": {"extremities_missed", "missed_limb_fraction"},
}
ACCURACIES, COVERAGES = (0.15, 0.2, 0.25, 0.3), (0.25, 0.3, 0.35, 0.4, 0.5)  # bounds up to which they pass
UNCOVERED, FLUXES = (0.75, 1.0, 1.5), (0.4, 0.5, 1.0)  # bounds on uncovered parts
LENGTHS = (2.0, 4.0, 6.0, 10.0)  # by which limbs stand out, in radii of the limb
KNOWN, KNOWN_SHARES = (1, 4, 6), (0.0, 0.4, 0.5, 0.6)  # lower bounds on the cross-sections of a branch that are known
ORDERS = 5  # in which vertices and faces of neurons are numbered
ASIDE = (0.0, 0.3, 0.6)  # by which branches are moved aside, in inscribed radii
QUICK = (("catalog clean", "tripod"), ("hard tuned", "tee"))


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write judge.json and judge.md."""
    shapes = dict(_shapes(quick))
    tools = list(TOOLS) if peers else list(OURS)
    answers = {(key, tool): ask(tool, shape.mesh) for key, shape in shapes.items() for tool in tools}
    rows = [row(*key, tool, shapes[key], answer) for (key, tool), answer in answers.items()]
    scored = [each for each in rows if "error" not in each]
    verdicts = [_verdicts(scored, tool) for tool in (*tools, "all")]
    thresholds = [_thresholds(scored, *bounds) for bounds in product(ACCURACIES, COVERAGES)]
    ends = [_ends(list(shapes.values()), *bounds) for bounds in product(UNCOVERED, FLUXES)]
    own = [(shapes[key].mesh, answer) for (key, tool), answer in answers.items() if tool in OURS]
    solved = [(mesh, answer.skeleton) for mesh, answer in own if isinstance(answer, Answer)]
    aside = _aside(solved, _renumbered_neurons(1 if quick else 5, 1 if quick else ORDERS))
    save_json(
        results / "judge.json",
        {"rows": rows, "verdicts": verdicts, "thresholds": thresholds, "ends": ends, "aside": aside},
        packages=("navis", "skeletor", "PyGEL3D", "CGAL"),
    )
    save_markdown(
        results / "judge.md",
        "Judge",
        {
            "Verdicts by the true error": markdown_table(verdicts),
            "Bounds up to which medial distances pass, and what passes in all measures": markdown_table(thresholds),
            "Ends that are cut off": markdown_table(ends),
            "Shares of branches that warn or fail, moved aside one at a time": markdown_table(aside),
            "Each skeleton": markdown_table(rows),
        },
    )


def _shapes(quick: bool) -> list[tuple[tuple[str, str], Shape]]:
    """List the shapes of the catalog in all variants, and the hard shapes with both sets of parameters."""
    makers = {
        (f"catalog {variant}", name): (make, {"name": name, **given})
        for variant, given in VARIANTS.items()
        for name in SHAPES
    } | {
        (f"hard {part}", name): (HARD_SHAPES[name], given)
        for part, parameters in (("tuned", TUNED), ("held out", HELD_OUT))
        for name, given in parameters.items()
    }
    return [(key, make(**given)) for key, (make, given) in makers.items() if not quick or key in QUICK]


def row(part: str, name: str, tool: str, shape: Shape, answer: Answer | str) -> dict[str, Any]:
    """Compare the score of an answer with its distance from the true axis."""
    found: dict[str, Any] = {"set": part, "shape": name, "tool": tool}
    if isinstance(answer, str):
        return {**found, "error": answer}
    truth = lbskel.ground_truth_distances(answer.skeleton, shape.truth)
    score = lbskel.score(answer.skeleton, shape.mesh)
    flagged = {measure: verdict for measure, verdict in score.verdicts.items() if verdict in ("warn", "fail")}
    return {
        **found,
        "true error": max(truth.accuracy_95, truth.coverage_95),
        "medial accuracy": score.medial_accuracy_95,
        "medial coverage": score.medial_coverage_98,
        "uncovered parts": score.uncovered_parts,
        "verdict": score.verdict,
        "flagged": " ".join(flagged),
        **{f"passes without {family}": not set(flagged) - names for family, names in FAMILIES.items()},
    }


def _of(rows: list[dict[str, Any]], low: float, high: float) -> list[dict[str, Any]]:
    return [each for each in rows if low <= each["true error"] < high]


def _verdicts(rows: list[dict[str, Any]], tool: str) -> dict[str, Any]:
    """Count the verdicts on a tool's skeletons in each class of true errors."""
    own = [each for each in rows if tool in (each["tool"], "all")]
    counts: dict[str, Any] = {"tool": tool}
    for name, bounds in CLASSES.items():
        within = _of(own, *bounds)
        counts[name] = len(within)
        for verdict in ("pass", "fail"):
            counts[f"{name}, {verdict}"] = sum(each["verdict"] == verdict for each in within)
        for family in FAMILIES:
            counts[f"{name}, pass without {family}"] = sum(each[f"passes without {family}"] for each in within)
    return counts


def _thresholds(rows: list[dict[str, Any]], accuracy: float, coverage: float) -> dict[str, Any]:
    """Find the shares that pass in each class with other bounds on the medial distances."""
    shares: dict[str, Any] = {"accuracy": accuracy, "coverage": coverage}
    for name, bounds in CLASSES.items():
        within = _of(rows, *bounds)
        passes = [
            each["passes without medial"]
            and not each["uncovered parts"]
            and each["medial accuracy"] <= accuracy
            and each["medial coverage"] <= coverage
            for each in within
        ]
        shares[f"{name}, pass"] = float(np.mean(passes)) if passes else None
    return shares


def _ends(shapes: list[Shape], uncovered: float, flux: float) -> dict[str, Any]:
    """Cut each end branch off the true axes: which are told, by how far they stand out, and what is told untruly."""
    found: dict[float, list[bool]] = {length: [] for length in LENGTHS}  # by the least length of each class
    n_false = 0
    with (
        mock.patch.object(medial_points, "MAX_UNCOVERED", uncovered),
        mock.patch.object(medial_points, "MAX_FLUX", flux),
    ):
        for shape in shapes:
            truth = lbskel.Skeleton(shape.truth.nodes, shape.truth.edges, shape.truth.radii)
            prepared = lbskel.prepare(shape.mesh)
            n_whole = _n_uncovered(truth, prepared)
            n_false += n_whole
            for branch in truth.end_branches:
                rest = contract_branches(truth, [branch])
                if len(rest.edges) and (standing := _standing_out(rest, truth, branch)) >= LENGTHS[0]:
                    length = max(each for each in LENGTHS if each <= standing)
                    found[length].append(_n_uncovered(rest, prepared) > n_whole)
    names = [*(f"{low:g} to {high:g}" for low, high in pairwise(LENGTHS)), f"from {LENGTHS[-1]:g}"]
    told = {name: f"{sum(found[length])}/{len(found[length])}" for name, length in zip(names, LENGTHS, strict=True)}
    every = [each for values in found.values() for each in values]
    precision = sum(every) / max(sum(every) + n_false, 1)
    return {
        "farther than": uncovered,
        "flux": flux,
        **told,
        "recall": float(np.mean(every)) if every else None,
        "told of whole axes": n_false,
        "precision": precision,
    }


def _n_uncovered(skeleton: lbskel.Skeleton, prepared: lbskel.PreparedMesh) -> int:
    return lbskel.score(skeleton, prepared).uncovered_parts or 0


def _standing_out(rest: lbskel.Skeleton, skeleton: lbskel.Skeleton, branch: NDArray[np.int64]) -> float:
    """Measure how far the end of a limb stands out of the tubes around the rest, in radii of the limb."""
    distances, _, radii = nearest_on_edges(rest, skeleton.nodes[branch[-1:]])
    end = distances[0] - radii[0] + skeleton.radii[branch[-1]]
    return float(end / np.median(skeleton.radii[branch[1:]]))


def _aside(
    skeletons: list[tuple[lbskel.Mesh, lbskel.Skeleton]], neurons: list[tuple[lbskel.Mesh, lbskel.Skeleton]]
) -> list[dict[str, Any]]:
    """Find the shares of branches moved aside that their known cross-sections tell, and the neurons that these fail."""
    errors = {distance: [each for pair in skeletons for each in _errors_aside(*pair, distance)] for distance in ASIDE}
    of_neurons = [_errors(*pair) for pair in neurons]
    measure, rows = MEASURES["centeredness_error_worst_branch"], []
    for n_known, share in product(KNOWN, KNOWN_SHARES):
        found: dict[str, Any] = {"known at least": n_known, "share at least": share}
        with mock.patch.multiple(skeleton_shape, MIN_KNOWN=n_known, MIN_KNOWN_SHARE=share):
            for distance, branches in errors.items():
                verdicts = [measure.verdict(skeleton_shape.median_of_known(each)) for each in branches]
                for verdict in ("warn", "fail"):
                    found[f"by {distance:g} radii, {verdict}"] = verdicts.count(verdict) / len(branches)
            fails = [
                any(measure.verdict(skeleton_shape.median_of_known(each)) == "fail" for each in branches)
                for branches in of_neurons
            ]
        rows.append(found | {"neurons that fail": f"{sum(fails)}/{len(fails)}"})
    return rows


def _renumbered_neurons(n: int, n_orders: int) -> list[tuple[lbskel.Mesh, lbskel.Skeleton]]:
    """Compute skeletons of the first n hemibrain neurons, their vertices and faces numbered in several orders."""
    found = []
    for seed, (_, mesh, _) in product(range(n_orders), list(hemibrain_neurons(n))):
        rng = np.random.default_rng(seed)
        order = rng.permutation(len(mesh.vertices))
        faces = rng.permutation(np.argsort(order)[mesh.faces])
        renumbered = lbskel.Mesh(mesh.vertices[order], faces)
        found.append((renumbered, lbskel.skeletonize(renumbered)))
    return found


def _errors_aside(mesh: lbskel.Mesh, skeleton: lbskel.Skeleton, distance: float) -> list[NDArray[np.float64]]:
    """List the errors of each branch after its inner nodes are moved, across the line between its ends."""
    prepared, rng, found = lbskel.prepare(mesh), np.random.default_rng(0), []
    skeleton = prepared.skeleton_to_unit(skeleton)
    for branch in skeleton.branches:
        inner, course = branch[skeleton.degrees[branch] == 2], skeleton.nodes[branch[-1]] - skeleton.nodes[branch[0]]
        if len(inner):
            across = np.cross(course, rng.normal(size=3)) if course.any() else rng.normal(size=3)
            nodes = np.array(skeleton.nodes)
            nodes[inner] += distance * skeleton.radii[inner, None] * across / np.linalg.norm(across)
            found.append(centeredness_errors(replace(skeleton, nodes=nodes), prepared.surface)[branch])
    return found


def _errors(mesh: lbskel.Mesh, skeleton: lbskel.Skeleton) -> list[NDArray[np.float64]]:
    """List the errors of each branch; NaN at nodes where they are not known."""
    prepared = lbskel.prepare(mesh)
    errors = centeredness_errors(prepared.skeleton_to_unit(skeleton), prepared.surface)
    return [errors[branch] for branch in skeleton.branches]
