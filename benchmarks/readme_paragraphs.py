"""Paragraphs of README.md whose figures come from the results: a text for each, and a function that gives them."""

from __future__ import annotations

__all__ = ["PARAGRAPHS", "paragraph"]

import json
import math
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.shapes import SHAPES

WIDTH = 125  # characters of a line, as in the rest of README.md
OURS, PYGEL, WAVES = "lbskel", "PyGEL3D MSLS", "skeletor wavefront"

INSTALLATION = """
From a clone to the picture at the top takes {whole:.0f} s of processor time, {install:.0f} of them to install and
compile, and {run:.0f} for the skeleton and the picture. lbskel and all that it needs take {megabytes:.0f} MB
installed ({largest}); `[view]` adds {view:.0f} and `[preprocess]` {preprocess:.0f}. Without a compiler a wheel is
built in {zig:.0f} s in place of {compiler:.0f}, and the first command takes {command_zig:.1f} s in place of
{command:.1f}; uncompiled, it takes {uncompiled:.0f} s. The wheel takes {wheel} of the time of a build by each of
Python {pythons} on three sizes; of the {passed:,} tests of the source distribution with each of them, {failed} fail
([tests](benchmarks/results/installed_tests.md)). The wheel built on Debian 12 passes for manylinux2014.
"""
WAITS = """
Ctrl-C ends a skeleton of {faces:,} faces within {python} s in Python, and within {command} s on the command line
([waits](benchmarks/results/interrupts.md)).
"""
RESOLUTION = """
On the same shapes with {fewest:,} to {most:,} faces the default, which contracts a proxy, leaves {auto:.4f} radii to
the axis on average, and full resolution {full:.4f}; on no shape is it worse by more than {worse}
([resolution](benchmarks/results/resolution.md)).
"""
THIN = """
Thin and long shapes: `python -m benchmarks neurons vessels --peers` measures hemibrain neurons against their
tracings, tubes around parts of the tracings, and coils and trees of vessels whose thinnest radius is {thinnest} of
the diagonal. On the neurons ([results](benchmarks/results/neurons.md)) the F-score of the cable is {cable} (PyGEL3D
{cable_pygel}, skeletor's waves {cable_waves}), and {tips} of the tips are found ({tips_pygel}, {tips_waves}), in
{times:.1f} times PyGEL3D's time. Of the tips of the tubes lbskel finds {tubes}, PyGEL3D {tubes_pygel} and skeletor's
waves {tubes_waves}. On coils and trees ([results](benchmarks/results/vessels.md)) accuracy is at most {accuracy} and
coverage {coverage} radii, with {found} tips for {true}. PyGEL3D's accuracy is at most {coil} on coils and {tree} on
trees, and CGAL's coverage of the two longest coils {long:.0f} and {longest:.0f}.
"""
CLOUDS = """
Point clouds: `python -m benchmarks points --peers` measures 10,000 points of each of the thirteen shapes
([results](benchmarks/results/points.md)). Accuracy is {uniform:.3f} radii where they are even, {density:.3f} where
their density falls by ten along the shape, {noise:.3f} with noise of a tenth of a radius, {views:.3f} seen from three
sides, and {outliers:.3f} with 2 % outliers; {graphs} of {clouds} graphs and {tips} numbers of tips are right.
PyGEL3D's separators on the graph of neighbors, on four of the shapes, have {pygel}; on the knot pc-skeletor has
{pc:.2f} and skeletor on a Poisson surface {poisson:.2f}. `python -m benchmarks point_times` has processor times
([results](benchmarks/results/point_times.md)): {times}, with {gigabytes:.2f} GB; the mesh with the same vertices
takes {meshes}. In a process that goes on, clouds of seven shapes with 10,000 points take {ratios} times as long as
their meshes, with a median of {ratio:.2f}.
"""
CHANGES = """
Noise up to 3 % of the diagonal, about the radius of a limb, moves no skeleton by more than {noise} local radii on
average, a rotation by {turn}, a quarter to four times the vertices by {sampling}, and bending by 45 and 75 degrees by
{pose} ([robustness](benchmarks/results/robustness.md)). Of {meshes} broken meshes, {kinds} kinds of damage on three
shapes, lbskel makes {good} skeletons that pass and refuses {refused} in a sentence; skeletor makes {good_skeletor}
that pass and refuses {refused_skeletor}, PyGEL3D makes {good_pygel} and refuses {refused_pygel}. Of {files} damaged
files lbskel refuses {refused_files} ([broken meshes](benchmarks/results/corruption.md)). Simulated scans of the
thirteen shapes, with noise, holes and crumbs, have the skeleton of the clean shape within {scans:.3f} radii on
average, {worst_scan} on the worst shape ([preprocessing](benchmarks/results/preprocessing.md)).
"""

Rows = Sequence[dict[str, Any]]


def paragraph(name: str, results: Path) -> str:
    """Return a paragraph with its figures, in lines."""
    text, figures = PARAGRAPHS[name]
    filled = text.format(**figures(results))
    return textwrap.fill(" ".join(filled.split()), WIDTH, break_long_words=False, break_on_hyphens=False) + "\n"


def _rows(results: Path, name: str, key: str = "rows") -> Rows:
    rows: Rows = json.loads((results / f"{name}.json").read_text(encoding="utf-8"))[key]
    return rows


def _of(rows: Rows, **where: Any) -> Rows:
    return [row for row in rows if all(row[key] == value for key, value in where.items())]


def _values(rows: Rows, key: str) -> list[float]:
    return [row[key] for row in rows if row.get(key) is not None]


def _mean(rows: Rows, key: str) -> float:
    return float(np.mean(_values(rows, key)))


def _span(values: Sequence[float]) -> str:
    return f"{min(values):.3g} to {max(values):.3g}"


def _bound(values: Iterable[float], digits: int) -> str:
    """The largest, rounded up."""
    return f"{math.ceil(max(values) * 10**digits) / 10**digits:.{digits}f}"


def _installation(results: Path) -> Mapping[str, Any]:
    steps = {row["step"].split()[0]: row["processor seconds"] for row in _rows(results, "installation", "first_run")}
    sizes = [(row["package"], row["megabytes"]) for row in _rows(results, "installation", "packages")]
    added = {name.split()[0]: size for name, size in sizes if name.endswith(" adds")}
    builds = _values(_rows(results, "installation", "builds"), "seconds")
    command = _rows(results, "installation", "without_compiler")[0]
    pythons, tests = _rows(results, "installation", "pythons"), _rows(results, "installed_tests", "pythons")
    return {
        "whole": steps["in"],
        "install": steps["pip"],
        "run": steps["lbskel"],
        "megabytes": sizes[0][1],
        "largest": ", ".join(f"{name} {size:.0f}" for name, size in sizes[1:5]),
        "view": added["view"],
        "preprocess": added["preprocess"],
        "zig": builds[-1],
        "compiler": builds[-2],
        "command_zig": command["by zig"],
        "command": command["by the machine's compiler"],
        "uncompiled": command["as Python"],
        "wheel": _span([row[key] for row in pythons for key in row if key.endswith("wheel / source")]),
        "pythons": ", ".join(row["Python"] for row in pythons),
        "passed": min(row["passed"] for row in tests),
        "failed": sum(row["failed"] for row in tests),
    }


def _waits(results: Path) -> Mapping[str, Any]:
    python, command = _rows(results, "interrupts", "interrupts")
    waits = {"python": python, "command": command}
    return {"faces": python["faces"]} | {how: _bound([row["longest wait"]], 2) for how, row in waits.items()}


def _resolution(results: Path) -> Mapping[str, Any]:
    rows = _rows(results, "resolution")
    auto, full = (_of(rows, simplify=simplify) for simplify in ("auto", "none"))
    shapes = {row["shape"] for row in rows}
    worse = [_mean(_of(auto, shape=shape), "accuracy") - _mean(_of(full, shape=shape), "accuracy") for shape in shapes]
    return {
        "fewest": min(row["faces"] for row in rows),
        "most": max(row["faces"] for row in rows),
        "auto": _mean(auto, "accuracy"),
        "full": _mean(full, "accuracy"),
        "worse": _bound(worse, 4),
    }


def _thin(results: Path) -> Mapping[str, Any]:
    means = {row["tool"]: row for row in _rows(results, "neurons", "summary")}
    tubes, vessels = _rows(results, "neurons", "tubes"), _rows(results, "vessels")
    own, pygel = _of(vessels, tool=OURS), _of(vessels, tool=PYGEL)
    tips = np.array([row["tips"].split("/") for row in own]).astype(int).sum(axis=0)
    figures: dict[str, Any] = {
        "thinnest": _span(_values(own, "thinnest / diagonal")),
        "times": means[OURS]["cpu seconds"] / means[PYGEL]["cpu seconds"],
        "accuracy": _bound(_values(own, "accuracy"), 3),
        "coverage": _bound(_values(own, "coverage"), 3),
        "found": tips[0],
        "true": tips[1],
    }
    for end, tool in {"": OURS, "_pygel": PYGEL, "_waves": WAVES}.items():
        figures[f"cable{end}"] = f"{means[tool]['F']:.2f}"
        figures[f"tips{end}"] = f"{means[tool]['tips found']:.2f}"
        figures[f"tubes{end}"] = f"{_mean(_of(tubes, tool=tool), 'tips found'):.2f}"
    for what in ("coil", "tree"):
        figures[what] = _bound([row["accuracy"] for row in pygel if row["shape"].startswith(what)], 4)
    coils = [row["coverage"] for row in _of(vessels, tool="CGAL") if row["shape"].startswith("coil")]
    return figures | {"long": coils[-2], "longest": coils[-1]}


def _clouds(results: Path) -> Mapping[str, Any]:
    rows, times = _rows(results, "points", "clouds"), _rows(results, "point_times", "times")
    own, key = _of(rows, tool=OURS), "processor seconds"
    kinds = dict.fromkeys(row["kind"] for row in own)
    cloud = _of(times, kind="cloud")
    ratios = _values(_rows(results, "point_times", "shapes")[:-1], "ratio again")  # the last row is their median
    return {kind: _mean(_of(own, kind=kind), "accuracy") for kind in kinds} | {
        "graphs": sum(bool(row["is_topology_right"]) for row in own),
        "clouds": len(own),
        "tips": sum(row["n_tips"] == row["n_true_tips"] for row in own),
        "pygel": _span(_values(_of(rows, tool="PyGEL3D"), "accuracy")),
        "pc": _mean(_of(rows, tool="pc-skeletor"), "accuracy"),
        "poisson": _mean(_of(rows, tool="Poisson + skeletor"), "accuracy"),
        "times": ", ".join(f"{row[key]:.2g} s for {row['vertices']:,} points" for row in cloud),
        "gigabytes": cloud[-1]["GB at most"],
        "meshes": ", ".join(f"{row[key]:.2g} s" for row in _of(times, kind="mesh")),
        "ratios": _span(ratios),
        "ratio": float(np.median(ratios)),
    }


def _changes(results: Path) -> Mapping[str, Any]:
    rows, broken = _rows(results, "robustness"), _rows(results, "corruption")
    meshes, files = _of(broken, of="mesh"), _of(broken, of="file", tool=OURS)
    count = Counter((row["tool"].split(",")[0], row["outcome"]) for row in meshes)
    scans = [row for row in _rows(results, "preprocessing", "scans") if row["shape"] in SHAPES]
    moved = {
        kind: _bound(_values(_of(rows, kind=kind), "moved"), 3) for kind in dict.fromkeys(row["kind"] for row in rows)
    }
    outcomes = {
        f"{outcome}{end}": count[tool, outcome]
        for outcome in ("good", "refused")
        for end, tool in {"": OURS, "_skeletor": "skeletor", "_pygel": "PyGEL3D"}.items()
    }
    return {
        **moved,
        **outcomes,
        "meshes": len(_of(meshes, tool=OURS)),
        "kinds": len({row["damage"] for row in meshes}),
        "files": len(files),
        "refused_files": len(_of(files, outcome="refused")),
        "scans": _mean(scans, "mean, in radii"),
        "worst_scan": _bound(_values(scans, "mean, in radii"), 3),
    }


PARAGRAPHS: dict[str, tuple[str, Callable[[Path], Mapping[str, Any]]]] = {
    "installation": (INSTALLATION, _installation),
    "waits": (WAITS, _waits),
    "resolution": (RESOLUTION, _resolution),
    "thin": (THIN, _thin),
    "clouds": (CLOUDS, _clouds),
    "changes": (CHANGES, _changes),
}
