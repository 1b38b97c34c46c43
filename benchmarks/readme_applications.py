"""Paragraphs of README.md on the applications."""

from __future__ import annotations

__all__ = ["PARAGRAPHS"]

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.readme_figures import (
    Figures,
    Rows,
    bound,
    claim,
    lower_bound,
    mean,
    named,
    of,
    percent,
    read,
    small_bound,
    span,
    values,
)

SMOOTHING = """
After noise of a quarter of the edge length on {shapes} shapes, `polynomial` with `operator="random_walk"` leaves
{error:.3f} edge lengths to the clean surface on average, in {milliseconds:.1f} ms of processor time for 5,000
vertices, less time than any filter of trimesh, MeshLab or libigl, of which none is as close in any time: the fastest,
{fast}, leaves {fast_error:.3f} in {fast_milliseconds:.1f} ms, the closest, {close}, {close_error:.3f} in
{close_milliseconds:.1f}. One implicit step of {faces:,} faces takes {implicit:.1f} s, by libigl {libigl:.1f} s, by
trimesh {trimesh:.0f} s
([smoothing](benchmarks/results/applications_smoothing.md)).
"""
COORDINATES = """
Surfaces reconstructed with hard anchors are libigl's to {hard} of the largest coordinate, and with soft ones scipy's
least squares to {soft}. Deltas rounded to 8 bits, with 10 anchors, take {rate:.0f} bits per vertex and leave an error
of {error:.2g} of the diagonal and {normals:.2g} degrees in the normals; positions of 8 bits take {rate_positions:.0f}
and leave {error_positions:.2g} and {normals_positions:.2g} degrees
([coordinates](benchmarks/results/applications_coordinates.md)).
"""
EDITING = """
Regions move rigidly, hard or soft; a rotation of all of them is exact with `arap`, `similarity` and `rotated`, to
{exact} of the diagonal. With the same weights, harmonic and biharmonic displacements are libigl's to {displacements} of
the diagonal; as-rigid-as-possible energies agree with those of libigl's rotations in double precision to {double}, and
with `igl.arap_solve`, which fits them in single precision, to {single}. At {faces:,} faces an iteration takes
{own:.0f} ms of processor time, libigl's {libigl:.0f} ([editing](benchmarks/results/applications_editing.md)). The
default weights are those of `robust`: cotangents throw a surface off where triangles are thin. A fine surface buckles
under many iterations of `arap`, and `similarity` lets limbs grow.
"""
SPECTRA = """
Eigenvalues are LaPy's to {eigenvalues} and heat and wave kernel signatures LaPy's and pyFM's to {signatures}; {pairs}
eigenpairs of {faces:,} faces take {seconds:.0f} s of processor time, LaPy's {lapy:.0f} s, and {pairs_first} pairs of
{faces_first:,} faces {seconds_first:.1f} and {lapy_first:.1f} s. A dinosaur of 3,449 vertices from 400 coefficients of
12 bits takes {rate:.1f} bits per vertex, without the faces, with an error of {error:.2f} % of the diameter bound, less
than positions of 8 bits have ([spectra](benchmarks/results/applications_spectrum.md)).
"""
GEODESICS = """
By the heat method, one factorization for all queries, on open and non-manifold meshes too: in the order of the heat,
distances are carried across unfolded triangles, from each of several sources in its own region. The mean error is
{own} % of the largest distance on {meshes} meshes of {fewest:,} to {most:,} vertices, that of potpourri3d and of
`unfolded=False`, the method as published, {published} % (exact: pygeodesic); with {sources} sources at once {several}
%, potpourri3d's {several_potpourri} %, in {times} times its time. LaPy's formula, by the matrices here, gives the
value of LaPy's own test to {lapy}. At {faces:,} faces the first query takes {first:.1f} s of processor time,
potpourri3d's {first_potpourri:.1f} s; later ones {later:.2f} s, or {later_published:.2f} s as published, potpourri3d's
{later_potpourri:.2f} s ([geodesics](benchmarks/results/applications_geodesics.md), [which
operator](benchmarks/results/applications_study.md)).
"""
PARTS = """
On {shapes} shapes with known limbs the Rand index is {rand}, where CGAL's segmentation by shape diameters has
{rand_cgal}. Boundaries are {boundaries} times as long as smooth curves, those of CGAL {boundaries_cgal}; a straight
line along the edges of equilateral triangles has up to 1.155: [parts.md](benchmarks/results/parts.md), with {others}
other meshes in its picture.
"""
RIG = """
three.js and Blender find the same bones in the file and move the vertices as linear blend skinning says, to {programs}
of the diagonal; the Khronos validator finds no error and no warning. On characters with known joints, elbows and knees
are found within {joints} radii on average. Bent by 90 degrees, elbows, knees and the like keep {kept} % of the limb's
volume or more on the {bent} of {meshes} meshes that have any, {kept_characters} % on the characters. Short bones keep
less, since the weights change over more of their length: bones of two radii on a cylinder {two:.0f} %, of three
{three:.0f} %, fingers of a scanned human {fingers:.0f} %. Weights differ from Blender's automatic ones by {weights} in
sum over the bones on {compared} meshes, since a vertex follows, of its bone and those that meet it, the nearest,
measured as there{none} ([rigs](benchmarks/results/rig.md)).
"""
FASTEST = "lbskel polynomial, operator random_walk"


def _smoothing(results: Path) -> Figures:
    table, large = read(results, "applications_smoothing"), read(results, "applications_smoothing", "large")
    shapes = {row["shape"] for row in table}
    means = {}
    for key in dict.fromkeys((row["tool"], row["setting"]) for row in table):
        found = [row for row in table if (row["tool"], row["setting"]) == key and "error" in row]
        if len(found) == len(shapes) and "seconds" in found[0]:
            means[key] = mean(found, "error"), 1000 * mean(found, "seconds")
    own = means[FASTEST, "1 iterations"]
    others = {key: each for key, each in means.items() if not key[0].startswith("lbskel")}
    fast, close = min(others, key=lambda key: others[key][1]), min(others, key=lambda key: others[key][0])
    claim(own[1] < others[fast][1], f"{FASTEST} takes less time than any filter of trimesh, MeshLab or libigl")
    claim(own[0] < others[close][0], f"no filter of trimesh, MeshLab or libigl is as close as {FASTEST}")
    best = min(means, key=lambda key: means[key][0])[0]
    claim(best.startswith(FASTEST), "random_walk with polynomial is the closest to the clean surface on average")
    claim(own[1] == min(each[1] for each in means.values()), "random_walk with polynomial is the fastest")

    figures: dict[str, object] = {}
    for which, key in {"fast": fast, "close": close}.items():
        library, name = key[0].split(" ", 1)
        figures[which] = f"{library}'s `{name}`"
        figures[f"{which}_error"], figures[f"{which}_milliseconds"] = others[key]
    seconds = {row["tool"].split()[0]: row["seconds"] for row in large if "implicit" in row["tool"]}
    return figures | {
        "shapes": named(len(shapes)),
        "error": own[0],
        "milliseconds": own[1],
        "faces": large[0]["faces"],
        "implicit": seconds["lbskel"],
        "libigl": seconds["libigl"],
        "trimesh": seconds["trimesh"],
    }


def _coordinates(results: Path) -> Figures:
    table = read(results, "applications_coordinates", "reconstruction")
    rates = of(read(results, "applications_coordinates", "rates"), bits=8)
    figures: dict[str, object] = {
        "hard": small_bound(values(table, "hard: from libigl's")),
        "soft": small_bound(values(table, "soft: from scipy's lstsq")),
    }
    for end, what in {"": "deltas, 10 anchors", "_positions": "positions"}.items():
        found = of(rates, what=what)
        figures[f"rate{end}"] = mean(found, "rate")
        for key in ("error", "normals"):  # geometric means, as in the table
            figures[f"{key}{end}"] = float(np.exp(np.mean(np.log(values(found, key)))))
    return figures


def _editing(results: Path) -> Figures:
    tables = {key: read(results, "applications_editing", key) for key in ("exactness", "energies", "seconds")}
    exact = [row for row in tables["exactness"] if row["method"] in ("arap", "similarity", "rotated")]
    exact_to = values(exact, "rotation by 120 degrees")
    claim(max(exact_to) < 1e-12, "a rotation of all regions is exact with arap, similarity and rotated")
    thin = {row["operator"]: row["needles"] for row in read(results, "applications_editing", "operators")}
    claim(thin["`cotangent`"] > 10 * thin["`robust`"], "cotangents throw a surface off where triangles are thin")
    seconds = {row["tool"]: row for row in tables["seconds"]}
    displacements = read(results, "applications_editing", "displacements")
    return {
        "exact": small_bound(exact_to),
        "displacements": small_bound(values(displacements, "difference from libigl")),
        "double": small_bound(values(tables["energies"], "relative to libigl, double precision, minus 1")),
        "single": small_bound(values(tables["energies"], "relative to `igl.arap_solve`, minus 1")),
        "faces": seconds["lbskel"]["faces"],
        "own": seconds["lbskel"]["iteration, ms"],
        "libigl": seconds["libigl"]["iteration, ms"],
    }


def _spectra(results: Path) -> Figures:
    tables = {key: read(results, "applications_spectrum", key) for key in ("eigenvalues", "signatures", "compression")}
    kernels = [row for row in tables["signatures"] if row["what"].endswith("kernel")]
    first, last = tables["eigenvalues"][0], tables["eigenvalues"][-1]
    packed = of([row for row in tables["compression"] if "functions" in row], basis="spectral", functions=400, bits=12)
    rounded = of(tables["compression"], basis="positions", bits=8)
    claim(
        packed[0]["rms error"] < rounded[0]["rms error"],
        "400 coefficients of 12 bits have a smaller error than positions of 8 bits",
    )
    return {
        "eigenvalues": small_bound(values(tables["eigenvalues"], "difference")),
        "signatures": small_bound(values(kernels, "difference")),
        "pairs": last["pairs"],
        "faces": last["faces"],
        "seconds": last["lbskel, s"],
        "lapy": last["LaPy, s"],
        "pairs_first": first["pairs"],
        "faces_first": first["faces"],
        "seconds_first": first["lbskel, s"],
        "lapy_first": first["LaPy, s"],
        "rate": packed[0]["bits a vertex"],
        "error": 100 * packed[0]["rms error"],
    }


def _geodesics(results: Path) -> Figures:
    tables = {key: read(results, "applications_geodesics", key) for key in ("accuracy", "speed", "several")}
    accuracy, several = tables["accuracy"], tables["several"]
    largest = of(tables["speed"], faces=max(row["faces"] for row in tables["speed"]))
    own, published, theirs = (of(largest, tool=tool)[0] for tool in ("lbskel", "lbskel, integrated", "potpourri3d"))
    formula = of(read(results, "applications_geodesics", "published"), tool="LaPy's formula by lbskel's matrices")
    sources = [str(count) for count in dict.fromkeys(row["sources"] for row in several)]
    as_published = [row for row in accuracy if row["tool"] in ("lbskel, integrated", "potpourri3d")]
    return {
        "own": percent(values(of(accuracy, tool="lbskel"), "mean error")),
        "meshes": named(len({row["mesh"] for row in accuracy})),
        "fewest": min(row["vertices"] for row in accuracy),
        "most": max(row["vertices"] for row in accuracy),
        "published": percent(values(as_published, "mean error")),
        "sources": f"{', '.join(sources[:-1])} and {sources[-1]}",
        "several": percent(values(several, "lbskel, mean error")),
        "several_potpourri": percent(values(several, "potpourri3d, mean error")),
        "times": span((row["lbskel, s"] / row["potpourri3d, s"] for row in several), ".1f"),
        "lapy": small_bound([float(formula[0]["from LaPy's"])]),
        "faces": own["faces"],
        "first": own["first query, s"],
        "first_potpourri": theirs["first query, s"],
        "later": own["later, s"],
        "later_published": published["later, s"],
        "later_potpourri": theirs["later, s"],
    }


def _parts(results: Path) -> Figures:
    shapes, boundaries = read(results, "parts", "parts"), read(results, "parts", "boundaries")
    claim(not any(values(boundaries, "parts in pieces")), "every part is connected")
    return {
        "shapes": named(len(shapes)),
        "rand": span(values(shapes, "inscribed, Rand index"), ".2f"),
        "rand_cgal": span(values(shapes, "CGAL, Rand index"), ".2f"),
        "boundaries": span(values(boundaries, "raggedness"), ".2f"),
        "boundaries_cgal": span(values(boundaries, "CGAL: raggedness"), ".2f"),
        "others": named(len(boundaries) - len(shapes)),
    }


def _rig(results: Path) -> Figures:
    rigs, programs = read(results, "rig"), read(results, "rig", "programs")
    for program in ("three.js", "Blender"):
        same = [row[f"{program}: same bones"] for row in programs]
        claim(set(same) == {"yes"}, f"{program} finds the same bones in the file")
    faults = [row[key] for row in programs for key in ("validator's errors", "warnings")]
    claim(not any(faults), "the Khronos validator finds no error and no warning")
    differences = [row[f"{program}: difference"] for row in programs for program in ("three.js", "Blender")]
    bent = [row for row in rigs if row["least of arms and legs"] is not None]
    characters = [row for row in bent if row["mesh"].endswith(", with joints")]
    weights = values(read(results, "rig", "weights"), "Blender: difference")
    compared = [each for each in weights if isinstance(each, float)]
    none = len(weights) - len(compared)
    claim(set(weights) - set(compared) <= {"found none"}, "where weights are not compared, Blender finds none")
    cylinders = {row["in radii"]: 100 * row["bone heat"] for row in read(results, "rig", "cylinders")}
    return {
        "programs": small_bound(differences),
        "joints": bound(values(of(read(results, "rig", "constants"), factor=1.0), "of elbows and knees"), 2),
        "kept": _whole(bent),
        "bent": named(len(bent)),
        "meshes": named(len(rigs)),
        "kept_characters": _whole(characters),
        "two": cylinders[2.0],
        "three": cylinders[3.0],
        "fingers": 100 * of(rigs, mesh="human_neutral")[0]["least"],
        "weights": span(compared, ".2f"),
        "compared": named(len(compared)),
        "none": f"; on {named(none)} Blender finds none" if none else "",
    }


def _whole(rigs: Rows) -> str:
    """The least volume kept by arms and legs, in percent, rounded down."""
    return lower_bound([100 * row["least of arms and legs"] for row in rigs], 0)


PARAGRAPHS: dict[str, tuple[str, Callable[[Path], Figures]]] = {
    "smoothing": (SMOOTHING, _smoothing),
    "coordinates": (COORDINATES, _coordinates),
    "editing": (EDITING, _editing),
    "spectra": (SPECTRA, _spectra),
    "geodesics": (GEODESICS, _geodesics),
    "parts": (PARTS, _parts),
    "rig": (RIG, _rig),
}
