"""Paragraphs of README.md on skeletons: where they lie, thin shapes, point clouds, changes of the input."""

from __future__ import annotations

__all__ = ["OURS", "PARAGRAPHS", "PYGEL", "WAVES"]

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.readme_figures import Figures, bound, claim, mean, named, of, read, span, values
from lbskel.shapes import SHAPES

OURS, PYGEL, WAVES = "lbskel", "PyGEL3D MSLS", "skeletor wavefront"

INSIDE = """
The skeletons of lbskel lie inside the surface over their whole length. `python -m benchmarks skeletons --peers` repeats
the measurement ([results](benchmarks/results/skeletons.md); `pip install '.[peers]'` installs the other tools, CGAL
needs its headers and a compiler).
"""
RESOLUTION = """
On the same shapes with {fewest:,} to {most:,} faces the default, which contracts a proxy, leaves {auto:.4f} radii to
the axis on average, and full resolution {full:.4f}; on no shape is it worse by more than {worse}
([resolution](benchmarks/results/resolution.md)).
"""
THIN = """
Thin and long shapes: `python -m benchmarks neurons vessels --peers` measures hemibrain neurons against their tracings,
tubes around parts of the tracings, and coils and trees of vessels whose thinnest radius is {thinnest} of the diagonal.
On the neurons ([results](benchmarks/results/neurons.md)) the F-score of the cable, which counts within 400 nm, is
{cable} (PyGEL3D {cable_pygel}, skeletor's waves {cable_waves}), and {tips} of the tips are found ({tips_pygel},
{tips_waves}), in {times:.1f} times PyGEL3D's time. The skeletons are {length} of the length of the tracings, and have
{loops} loops each, where neurites touch; SWC cuts them. Of the tips of the tubes lbskel finds {tubes}, PyGEL3D
{tubes_pygel} and skeletor's waves {tubes_waves}. The tubes are rough: their mean radii are {mean_radii} off, inscribed
ones {inscribed}. On meshes of the voxels in these tubes, of half a median radius, as a segmented image volume has
them, lbskel finds {voxel_tips} of the tips, its accuracy is {voxel_accuracy} radii, lengths are {voxel_length} % and
sections {voxel_sections} % off (PyGEL3D: {voxel_tips_pygel}, {voxel_accuracy_pygel}, {voxel_length_pygel} %,
{voxel_sections_pygel} %, in {voxel_times:.0f} times the processor time), and {voxel_right} of {voxel_graphs} graphs
have the right topology ({voxel_right_pygel}). On tubes around parts of {others} other public tracings, thinner and
with fewer tips, lbskel finds {others_found} of {others_true} tips, and lengths are {others_length:.1f} % off on
average. On coils and trees ([results](benchmarks/results/vessels.md)) accuracy is at most {accuracy} and coverage
{coverage} radii, with {found} tips for {true}. PyGEL3D's accuracy is at most {coil} on coils and {tree} on trees, and
CGAL's coverage of the two longest coils {long:.0f} and {longest:.0f}.
"""
CLOUDS = """
Point clouds: `python -m benchmarks points --peers` measures 10,000 points of each of the thirteen shapes
([results](benchmarks/results/points.md)). Accuracy is {uniform:.3f} radii where they are even, {density:.3f} where
their density falls by ten along the shape, {noise:.3f} with noise of a tenth of a radius, {views:.3f} seen from three
sides, and {outliers:.3f} with 2 % outliers; {graphs} of {clouds} graphs and {tips} numbers of tips are right.
PyGEL3D's separators on the graph of neighbors, on {pygel_shapes} of the shapes, have {pygel}; on the knot
pc-skeletor has {pc:.2f} and skeletor on a Poisson surface {poisson:.2f}. `python -m benchmarks point_times` has
processor times ([results](benchmarks/results/point_times.md)): {times}, with {gigabytes:.2f} GB; the mesh with the
same vertices takes {meshes}. In a process that goes on, clouds of {shapes} shapes with 10,000 points take {ratios}
times as long as their meshes, with a median of {ratio:.2f}.
"""
CHANGES = """
A rotation moves none of these skeletons but for rounding. Noise up to 3 % of the diagonal, about the radius of a
limb, moves none by more than {noise} local radii on average, a quarter to four times the vertices by {sampling}, and
bending by 45 and 75 degrees by {pose} ([robustness](benchmarks/results/robustness.md)). Of {meshes} broken meshes,
{kinds} kinds of damage on three shapes, lbskel makes {good} skeletons that pass and refuses {refused} in a sentence;
skeletor makes {good_skeletor} that pass and refuses {refused_skeletor}, PyGEL3D makes {good_pygel} and refuses
{refused_pygel}. Of {files} damaged files lbskel refuses {refused_files} ([broken
meshes](benchmarks/results/corruption.md)). Simulated scans of the thirteen shapes, with noise, holes and crumbs,
have the skeleton of the clean shape within {scans:.3f} radii on average, {worst_scan} on the worst shape
([preprocessing](benchmarks/results/preprocessing.md)).
"""


def _inside(results: Path) -> Figures:
    shapes = read(results, "skeletons", "shapes")
    inside = values([row for row in shapes if row["tool"].split()[0] == OURS], "inside_fraction")
    claim(min(inside) == 1, "the skeletons of lbskel lie inside the surface over their whole length")
    return {}


def _resolution(results: Path) -> Figures:
    rows = read(results, "resolution")
    auto, full = (of(rows, simplify=simplify) for simplify in ("auto", "none"))
    shapes = {row["shape"] for row in rows}
    worse = [mean(of(auto, shape=shape), "accuracy") - mean(of(full, shape=shape), "accuracy") for shape in shapes]
    return {
        "fewest": min(row["faces"] for row in rows),
        "most": max(row["faces"] for row in rows),
        "auto": mean(auto, "accuracy"),
        "full": mean(full, "accuracy"),
        "worse": bound(worse, 4),
    }


def _thin(results: Path) -> Figures:
    means = {row["tool"]: row for row in read(results, "neurons", "summary")}
    tubes, voxels = read(results, "neurons", "tubes"), read(results, "neurons", "voxels")
    vessels = read(results, "vessels")
    own, pygel = of(vessels, tool=OURS), of(vessels, tool=PYGEL)
    tips = np.array([row["tips"].split("/") for row in own]).astype(int).sum(axis=0)
    others = of(read(results, "neurons", "other tubes"), tool=OURS)
    hemibrain = of(read(results, "neurons", "hemibrain"), tool=OURS)
    true = np.array([row["tips"].split("/")[1] for row in others]).astype(int)
    figures: dict[str, Any] = {
        "others": len(others),
        "others_found": round(float(np.array(values(others, "tips found")) @ true)),
        "others_true": true.sum(),
        "others_length": 100 * float(np.abs(values(others, "length error")).mean()),
        "thinnest": span(values(own, "thinnest / diagonal")),
        "times": means[OURS]["cpu seconds"] / means[PYGEL]["cpu seconds"],
        "accuracy": bound(values(own, "accuracy"), 3),
        "coverage": bound(values(own, "coverage"), 3),
        "found": tips[0],
        "true": tips[1],
        "length": span(values(hemibrain, "length / true length")),
        "loops": span(values(hemibrain, "cycles")),
        "voxel_graphs": len(of(voxels, tool=OURS)),
        "mean_radii": f"{100 * mean(of(tubes, tool=OURS), 'mean radius error'):.0f} %",
        "inscribed": f"{100 * mean(of(tubes, tool=OURS), 'radius error'):.0f} %",
    }
    for end, tool in {"": OURS, "_pygel": PYGEL, "_waves": WAVES}.items():
        figures[f"cable{end}"] = f"{means[tool]['F']:.2f}"
        figures[f"tips{end}"] = f"{means[tool]['tips found']:.2f}"
        figures[f"tubes{end}"] = f"{mean(of(tubes, tool=tool), 'tips found'):.2f}"
        own_voxels = of(voxels, tool=tool)
        figures[f"voxel_tips{end}"] = f"{mean(own_voxels, 'tips found'):.2f}"
        figures[f"voxel_right{end}"] = sum(row["topology right"] for row in own_voxels)
        figures[f"voxel_accuracy{end}"] = f"{mean(own_voxels, 'accuracy'):.2f}"
        figures[f"voxel_length{end}"] = f"{100 * float(np.abs(values(own_voxels, 'length error')).mean()):.0f}"
        sections = np.array([row["sections"].split("/") for row in own_voxels]).astype(int)
        figures[f"voxel_sections{end}"] = f"{100 * float(np.abs(sections[:, 0] / sections[:, 1] - 1).mean()):.0f}"
    seconds = [mean(of(voxels, tool=tool), "cpu seconds") for tool in (PYGEL, OURS)]
    figures["voxel_times"] = seconds[0] / seconds[1]
    for what in ("coil", "tree"):
        figures[what] = bound([row["accuracy"] for row in pygel if row["shape"].startswith(what)], 4)
    coils = [row["coverage"] for row in of(vessels, tool="CGAL") if row["shape"].startswith("coil")]
    return figures | {"long": coils[-2], "longest": coils[-1]}


def _clouds(results: Path) -> Figures:
    rows, times = read(results, "points", "clouds"), read(results, "point_times", "times")
    own, key = of(rows, tool=OURS), "processor seconds"
    kinds = dict.fromkeys(row["kind"] for row in own)
    cloud = of(times, kind="cloud")
    ratios = values(read(results, "point_times", "shapes")[:-1], "ratio again")  # the last row is their median
    pygel = of(rows, tool="PyGEL3D")
    return {kind: mean(of(own, kind=kind), "accuracy") for kind in kinds} | {
        "graphs": sum(bool(row["is_topology_right"]) for row in own),
        "clouds": len(own),
        "tips": sum(row["n_tips"] == row["n_true_tips"] for row in own),
        "pygel_shapes": named(len({row["shape"] for row in pygel})),
        "pygel": span(values(pygel, "accuracy")),
        "pc": mean(of(rows, tool="pc-skeletor"), "accuracy"),
        "poisson": mean(of(rows, tool="Poisson + skeletor"), "accuracy"),
        "times": ", ".join(f"{row[key]:.2g} s for {row['vertices']:,} points" for row in cloud),
        "gigabytes": cloud[-1]["GB at most"],
        "meshes": ", ".join(f"{row[key]:.2g} s" for row in of(times, kind="mesh")),
        "shapes": named(len(ratios)),
        "ratios": span(ratios),
        "ratio": float(np.median(ratios)),
    }


def _changes(results: Path) -> Figures:
    rows, broken = read(results, "robustness"), read(results, "corruption")
    meshes, files = of(broken, of="mesh"), of(broken, of="file", tool=OURS)
    count = Counter((row["tool"].split(",")[0], row["outcome"]) for row in meshes)
    claim(max(values(of(rows, kind="turn"), "moved, 95 %")) < 1e-12, "a rotation moves no skeleton but for rounding")
    scans = [row for row in read(results, "preprocessing", "scans") if row["shape"] in SHAPES]
    moved = {
        kind: bound(values(of(rows, kind=kind), "moved"), 3) for kind in dict.fromkeys(row["kind"] for row in rows)
    }
    outcomes = {
        f"{outcome}{end}": count[tool, outcome]
        for outcome in ("good", "refused")
        for end, tool in {"": OURS, "_skeletor": "skeletor", "_pygel": "PyGEL3D"}.items()
    }
    return {
        **moved,
        **outcomes,
        "meshes": len(of(meshes, tool=OURS)),
        "kinds": len({row["damage"] for row in meshes}),
        "files": len(files),
        "refused_files": len(of(files, outcome="refused")),
        "scans": mean(scans, "mean, in radii"),
        "worst_scan": bound(values(scans, "mean, in radii"), 3),
    }


PARAGRAPHS: dict[str, tuple[str, Callable[[Path], Figures]]] = {
    "inside": (INSIDE, _inside),
    "resolution": (RESOLUTION, _resolution),
    "thin": (THIN, _thin),
    "clouds": (CLOUDS, _clouds),
    "changes": (CHANGES, _changes),
}
