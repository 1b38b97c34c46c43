"""Paragraphs of README.md on operators, and on where others are better."""

from __future__ import annotations

__all__ = ["PARAGRAPHS"]

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.judge import BAD, GOOD
from benchmarks.readme_figures import Figures, bound, claim, lower_bound, mean, named, of, read, span
from benchmarks.readme_skeletons import OURS, PYGEL, WAVES
from lbskel.evaluation.medial_points import MAX_FLUX, MAX_UNCOVERED

OPERATORS = """
The discrete Laplacians: fitted orders of convergence on irregular meshes (theory predicts 2 for the cotangent family
and nothing for `graph` and the mean value weights), the properties that hold on every mesh of the set, and the time at
{faces:,} faces divided by that of libigl's `cotmatrix` and `massmatrix`. The heat kernel connects each vertex of an
even sphere to {neighbors:.0f} neighbors on average (`python -m benchmarks operators`;
[convergence](benchmarks/results/operators_convergence.md), [properties](benchmarks/results/operators_properties.md),
[cost](benchmarks/results/operators_speed.md), [spectrum](benchmarks/results/operators_spectrum.md)):
"""
LIMITS = """
- Of solids with many tunnels between thin walls, such as porous blocks, short parts of the skeleton can lie outside.
  The score says so.
- A curve skeleton has no sheets: a flat part gets a branch along its middle, and a plate without an inside gets none.
  The wall of a long pipe is a sheet, too, and the score says so; the outer surface alone has the axis of the pipe.
- Limbs of a cloud that are nearer to each other than twice the distance between its points may grow together, and
  noise joins more; a note tells the length, and the score does not see it. Limbs thinner than that distance have
  rough ends.
- On neurons PyGEL3D is {pygel:.1f} times as fast as lbskel, skeletor's waves {waves:.0f} times. On coarse tubes around
  their tracings lbskel finds {own_tips:.3f} of the tips, and its skeletons have {fewer:.0f} % fewer sections than the
  tracings ([neurons](benchmarks/results/neurons.md)).
- Of {creatures} random bodies with limbs lbskel makes the right graph of {creatures_right}
  ([refinement](benchmarks/results/refinement.md)).
- With Blender's automatic weights bent limbs keep more of their volume: at the worst joint of {posed} meshes {blender},
  with lbskel's {least}. Lbskel's change less from vertex to vertex on {even} of these
  ([rigs](benchmarks/results/rig.md)).
- On meshes of up to {small:,} faces CGAL takes {cgal} of lbskel's time, which includes the score; it is faster on some
  larger ones too, if lbskel contracts them at full resolution ([speed](benchmarks/results/speed.md)).
- On tubes made of regular rings of vertices, such as the coils, PyGEL3D's nodes are the centers of the rings: it is at
  most {pygel_coil} radii off the axis on average, lbskel {own_coil}
  ([vessels](benchmarks/results/vessels.md)).
- Contraction in other steps changes the tips of up to {steps} of {n_meshes} meshes
  ([stability](benchmarks/results/stability.md)). A rotation or a reflection changes none of these, but may change the
  graph of a shape with several corners that are equally far from its centroid, such as a box, or with several equally
  long edges at the farthest one, such as a body of voxels.
- Later geodesic queries are up to {later:.1f} times as fast in potpourri3d and libigl, and those from several sources
  up to {several:.1f} times, with {error} and more times the error
  ([geodesics](benchmarks/results/applications_geodesics.md)).
"""
JUDGE = """
Medial points lie one local radius under each vertex; refinement does not use them, so that the score is no echo of it.
{tools} tools made skeletons of {shapes} shapes with known axes: of the {bad} whose worst 5 % is over {limit} radii
off, {passed} pass in every measure, and {without} would without the medial ones; of the {good} below {best} radii,
{good_passed} pass, {good_warned} warn and {failed} fail. {found} of {cut} limbs cut off the true axes are told, and
{untrue} parts of whole ones ([judge](benchmarks/results/judge.md)).
"""
SMALL = 10_000  # faces below which README.md compares the times of small meshes
SECOND_ORDER = 1.9  # fitted order of convergence from which README.md tells of second order
SHOWN = {  # columns of the table of operators
    ("sphere spectrum", "eigenvalues"),
    ("torus spectrum", "eigenvalues"),
    ("sphere Poisson", "L2"),
    ("flipped Poisson", "L2"),
}


def _operators(results: Path) -> Figures:
    orders = [
        row["order"]
        for row in read(results, "operators_convergence")
        if row["operator"] == "robust" and (row["case"], row["error"]) in SHOWN
    ]
    claim(len(orders) == len(SHOWN) and min(orders) > SECOND_ORDER, "`robust` is of second order")
    speed = read(results, "operators_speed")
    faces = max(row["faces"] for row in speed)
    cost = {row["call"]: row["ratio to libigl"] for row in of(speed, faces=faces)}
    claim(cost["cotangent"] < cost["robust"], "take `cotangent` where the time counts")
    sphere = of(read(results, "operators_properties"), shape="good", operator="heat_kernel")[0]
    of_edges = 6 - 12 / sphere["vertices"]  # neighbors by an edge, of a vertex of a closed surface like a sphere
    return {
        "faces": faces,
        "neighbors": of_edges / (1 - sphere["nonlocal_fraction"]),
    }


def _judge(results: Path) -> Figures:
    every = of(read(results, "judge", "verdicts"), tool="all")[0]
    rows = read(results, "judge", "rows")
    low, high = f"below {GOOD}", f"over {BAD}"
    ends = next(
        row for row in read(results, "judge", "ends") if (row["farther than"], row["flux"]) == (MAX_UNCOVERED, MAX_FLUX)
    )
    counts = [str(value).split("/") for name, value in ends.items() if "/" in str(value)]
    return {
        "tools": len({row["tool"] for row in rows}),
        "shapes": len({(row["set"], row["shape"]) for row in rows}),
        "bad": every[high],
        "limit": BAD,
        "passed": every[f"{high}, pass"],
        "without": every[f"{high}, pass without medial"],
        "good": every[low],
        "best": GOOD,
        "good_passed": every[f"{low}, pass"],
        "good_warned": every[low] - every[f"{low}, pass"] - every[f"{low}, fail"],
        "failed": every[f"{low}, fail"],
        "found": sum(int(found) for found, _ in counts),
        "cut": sum(int(cut) for _, cut in counts),
        "untrue": ends["told of whole axes"],
    }


def _limits(results: Path) -> Figures:
    tubes = read(results, "neurons", "tubes")
    of_tubes = of(tubes, tool=OURS)
    sections = np.array([row["sections"].split("/") for row in of_tubes], dtype=float).sum(axis=0)
    claim(sections[0] < sections[1], "lbskel's skeletons of tubes have fewer sections than the tracings")
    seconds = {row["tool"]: row["cpu seconds"] for row in read(results, "neurons", "summary")}
    claim(max(seconds[PYGEL], seconds[WAVES]) < seconds[OURS], "PyGEL3D and skeletor's waves are faster on neurons")
    coils = [
        max(row["accuracy"] for row in of(read(results, "vessels"), tool=tool) if row["shape"].startswith("coil"))
        for tool in (PYGEL, OURS)
    ]
    claim(coils[0] < coils[1], "PyGEL3D is nearer to the axes of coils")
    ratios = [row for row in read(results, "speed", "ratios") if row["CGAL medial"]]
    small = [row for row in of(ratios, reference=OURS) if row["faces"] < SMALL]
    full = [row["CGAL medial"] for row in of(ratios, reference=f"{OURS} full") if row["faces"] >= SMALL]
    claim(max((row["CGAL medial"] for row in small), default=1) < 1, "CGAL is faster on small meshes")
    claim(min(full, default=1) < 1, "CGAL is faster on some larger meshes at full resolution")
    later, single = (_geodesics(results, *each) for each in (("speed", "later, s"), ("accuracy", "mean error")))
    several = read(results, "applications_geodesics", "several")
    times = [row["lbskel, s"] / row["potpourri3d, s"] for row in several]
    errors = [row["potpourri3d, mean error"] / row["lbskel, mean error"] for row in several]
    claim(max(later) > 1 and max(times) > 1, "geodesic queries are faster in potpourri3d and libigl")
    claim(min(errors + [1 / each for each in single]) > 1, "potpourri3d and libigl have larger errors of geodesics")
    [creatures] = of(read(results, "refinement", "summary"), set="creatures", tool=OURS)
    right, n_creatures = map(int, creatures["graphs right"].split("/"))
    pairs = [(row, of(read(results, "rig"), mesh=row["mesh"])[0]) for row in read(results, "rig", "weights")]
    pairs = [(blender, own) for blender, own in pairs if blender.get("Blender: least volume kept")]
    least = [(blender["Blender: least volume kept"], own["least"]) for blender, own in pairs]
    claim(all(blender > own for blender, own in least), "limbs keep more of their volume with Blender's weights")
    jumps = [(blender["Blender: jump"], own["largest jump of a weight"]) for blender, own in pairs]
    stability = read(results, "stability")
    others = {row["variant"]: row["meshes with other tips"] for row in stability}
    claim(others["turned"] == others["mirrored"] == 0, "a rotation and a reflection change no tips")
    return {
        "creatures": n_creatures,
        "creatures_right": right,
        "posed": named(len(pairs)),
        "blender": span((blender for blender, _ in least), ".2f"),
        "least": span((own for _, own in least), ".2f"),
        "even": named(sum(own < blender for blender, own in jumps)),
        "own_tips": mean(of_tubes, "tips found"),
        "fewer": 100 * (1 - sections[0] / sections[1]),
        "pygel": seconds[OURS] / seconds[PYGEL],
        "waves": seconds[OURS] / seconds[WAVES],
        "small": max(row["faces"] for row in small),
        "cgal": span(row["CGAL medial"] for row in small),
        "pygel_coil": bound(coils[:1], 4),
        "own_coil": bound(coils[1:], 4),
        "n_meshes": stability[0]["meshes"],
        "steps": max(count for name, count in others.items() if name.startswith("growth")),
        "later": max(later),
        "several": max(times),
        "error": lower_bound(errors + [1 / each for each in single], 1),
    }


def _geodesics(results: Path, key: str, what: str) -> list[float]:
    """What lbskel has over what potpourri3d and libigl have, on each mesh."""
    table = read(results, "applications_geodesics", key)
    mesh = "mesh" if "mesh" in table[0] else "faces"
    own = {row[mesh]: row[what] for row in of(table, tool=OURS)}
    return [own[row[mesh]] / row[what] for row in table if row["tool"] in ("potpourri3d", "libigl")]


PARAGRAPHS: dict[str, tuple[str, Callable[[Path], Figures]]] = {
    "laplacians": (OPERATORS, _operators),
    "judge": (JUDGE, _judge),
    "limits": (LIMITS, _limits),
}
