"""How good a skeleton is where no truth is known: measured on its mesh, with a verdict for each measure.

The measures follow the properties of Cornea, Silver, Min 2007, https://doi.org/10.1109/TVCG.2007.1002: homotopic to the
shape, inside, centered, reaching every part, smooth, and standing part by part for the shape. Lengths are in units of
the local radius, the distance from a node to the surface of its body, whatever radii the skeleton came with.
"""

from __future__ import annotations

__all__ = ["MEASURES", "Measure", "Score", "require_scorable", "score_on"]

from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lbskel.errors import MeshError, first_few
from lbskel.geometry.components import MIN_FACES
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import inscribed_radii, mean_radii, own_radii
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import inside_fraction
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.vertex_map import edges_with_disjoint_regions, is_in_largest_piece, nearest_balls
from lbskel.skeleton.skeleton import Skeleton

COVERED = 2.0  # radii of its node within which a vertex is covered
LIMB = 0.05  # of the extent: shorter ends may be too small for the skeleton of the whole shape
PRESSED = 0.2  # of the mean distance of its vertices: nearer, a node is at the wall; in a flat limb it has 0.3
ON = 1e-6  # of the extent: so near a node is on the surface, where tips may be asked for and rays put them within 1e-8
SPUR = 1.2  # radii of its junction that all balls of a spur stay within
MOST_SECTIONS = 60  # cutting takes long: of more nodes than that as many are taken, evenly
FEWEST_SECTIONS = 5  # that tell whether a branch is off its axis


class Measure(NamedTuple):
    """What a measure tells and what its verdict is.

    Parameters
    ----------
    text : str
    passes, fails : float
        Sizes up to which it passes and from which on it fails; between them it warns. Chosen so that the 39 shapes of
        the catalog pass or warn, and that skeletons of them spoilt in one respect fail.
    """

    text: str
    passes: float
    fails: float

    def verdict(self, value: float | None) -> str:
        """``pass``, ``warn`` or ``fail``; ``not measured`` for None."""
        if value is None:
            return "not measured"
        sign = 1 if self.passes < self.fails else -1
        past, lost = sign * (abs(value) - self.passes), sign * (abs(value) - self.fails)
        return "pass" if past <= 0 else "fail" if lost >= 0 else "warn"


MEASURES = {
    "nodes_inside_fraction": Measure("share of the nodes inside the surface or on it", 0.995, 0.97),
    "inside_fraction": Measure("share of the length inside the surface", 0.995, 0.97),
    "centeredness_error": Measure("mean distance from the middle of the section, in radii", 0.1, 0.25),
    "centeredness_error_worst_branch": Measure("the same, median over the worst branch", 0.2, 0.4),
    "near_surface_fraction": Measure("share of the length that runs close under the surface", 0.05, 0.25),
    "coverage": Measure("share of the surface within two radii of its node", 0.9, 0.3),
    "extremities_missed": Measure("ends of the shape that no tip reaches", 0, np.inf),
    "limb_extremities_missed": Measure(
        "those of them that are ends of limbs longer than a twentieth of the shape", 0, 1
    ),
    "rms_curvature": Measure("root mean square curvature, in turns by 1 radian per radius", 1.0, 5.0),
    "extra_components": Measure("components, more or less than the surface has", 0, 1),
    "extra_cycles": Measure("cycles, more or less than the surface has handles", 0, 1),
    "connected_regions": Measure("share of the vertices in the largest piece of their node's region", 0.98, 0.6),
    "adjacent_regions": Measure("share of the edges that join regions that touch", 0.9, 0.6),
    "shortcut_edges": Measure("edges that cross to a part of the surface far away", 0, 1),
    "spurs": Measure("end branches that stay within their junction's ball", 0, 6),
}


@dataclass(frozen=True)
class Score:
    """What :func:`score` measured; :data:`MEASURES` says what each is. None where it could not be told.

    Parameters
    ----------
    nodes_inside_fraction, inside_fraction, centeredness_error, centeredness_error_worst_branch, near_surface_fraction, coverage : float
    extremities : int
        Ends of the shape, found on its surface.
    extremities_missed, limb_extremities_missed : int
        Of small ends, as fingers are on a man, not all may have a tip; a limb has to.
    rms_curvature : float
    extra_components, extra_cycles : int
    connected_regions, adjacent_regions : float
    shortcut_edges, spurs : int
    """

    nodes_inside_fraction: float
    inside_fraction: float
    centeredness_error: float | None
    centeredness_error_worst_branch: float | None
    near_surface_fraction: float
    coverage: float
    extremities: int
    extremities_missed: int
    limb_extremities_missed: int
    rms_curvature: float
    extra_components: int
    extra_cycles: int | None
    connected_regions: float | None
    adjacent_regions: float | None
    shortcut_edges: int
    spurs: int

    @property
    def verdicts(self) -> dict[str, str]:
        """``pass``, ``warn``, ``fail`` or ``not measured`` for each measure."""
        values = asdict(self)
        return {name: measure.verdict(values[name]) for name, measure in MEASURES.items()}

    @property
    def verdict(self) -> str:
        """The worst of the verdicts."""
        found = self.verdicts.values()
        return next((verdict for verdict in ("fail", "warn") if verdict in found), "pass")

    @property
    def passed(self) -> bool:
        """Whether no measure fails; some may warn."""
        return self.verdict != "fail"

    @property
    def not_measured(self) -> tuple[str, ...]:
        """Names of the measures that could not be taken, such as those of the map of a skeleton without one."""
        return tuple(name for name, verdict in self.verdicts.items() if verdict == "not measured")

    def __str__(self) -> str:
        """A table of the measures with their thresholds, and the verdict."""
        values = asdict(self)
        rows = [("measure", "value", "verdict", "passes", "fails", "")]
        for name, measure in MEASURES.items():
            sign = ">=" if measure.passes > measure.fails else "<="
            fails = "never" if not np.isfinite(measure.fails) else f"{'<=' if sign == '>=' else '>='} {measure.fails:g}"
            value, verdict = values[name], measure.verdict(values[name])
            shown = "-" if value is None else f"{value:d}" if isinstance(value, int) else f"{value:.3f}"
            rows.append((name.replace("_", " "), shown, verdict, f"{sign} {measure.passes:g}", fails, measure.text))
        lines = [f"{a:33} {b:>7}  {c:12}  {d:>9}  {e:>9}  {f}".rstrip() for a, b, c, d, e, f in rows]
        if self.not_measured:
            names = ", ".join(name.replace("_", " ") for name in self.not_measured)
            cause = ", since the skeleton has no vertex map" if self.connected_regions is None else ""
            lines.append(f"not measured{cause}: {names}")
        return "\n".join([*lines, f"verdict: {self.verdict}; the shape has {self.extremities} extremities"])

    def report(self) -> dict[str, Any]:
        """The verdict, the measures and their verdicts, ready for JSON."""
        return {"verdict": self.verdict, "measures": asdict(self), "verdicts": self.verdicts}


def score_on(skeleton: Skeleton, surface: Surface) -> Score:
    """Measure a skeleton on a surface of extent 1 about the origin, in whose coordinates it is."""
    unit, has_map = surface.mesh, len(skeleton.node_of_vertex) > 0
    skeleton = inscribed_radii(skeleton, surface)
    if not has_map:
        skeleton = replace(skeleton, node_of_vertex=nearest_balls(skeleton, unit))
    if unit.n_components > 1:
        skeleton = own_radii(skeleton, unit)
    node = skeleton.node_of_vertex
    far = np.linalg.norm(unit.vertices - skeleton.nodes[node], axis=1)
    area = np.bincount(unit.faces.ravel(), weights=np.repeat(unit.face_areas, 3), minlength=len(unit.vertices))
    ends = find_extrema(surface.proxy.mesh)
    missed = is_missed(ends, surface.proxy.mesh, skeleton)
    widths = mean_radii(skeleton, unit).radii
    centeredness_error, centeredness_error_worst_branch = _off_center(skeleton, widths, surface)
    parted = edges_with_disjoint_regions(skeleton, unit)
    return Score(
        nodes_inside_fraction=float((surface.contains(skeleton.nodes) | (skeleton.radii <= ON)).mean()),
        inside_fraction=inside_fraction(skeleton, surface),
        centeredness_error=centeredness_error,
        centeredness_error_worst_branch=centeredness_error_worst_branch,
        near_surface_fraction=_share_of_length(skeleton, skeleton.radii < PRESSED * widths),
        coverage=float(area[far <= COVERED * skeleton.radii[node]].sum() / area.sum()),
        extremities=len(missed),
        extremities_missed=int(missed.sum()),
        limb_extremities_missed=int((missed & (ends.lengths > LIMB)).sum()),
        rms_curvature=_bending(skeleton),
        extra_components=skeleton.n_components - _n_bodies(unit),
        extra_cycles=_extra_cycles(skeleton, unit),
        connected_regions=float(is_in_largest_piece(node, unit)[unit.used_vertices].mean()) if has_map else None,
        adjacent_regions=1 - len(parted) / max(1, len(skeleton.edges)) if has_map else None,
        shortcut_edges=_bridges(skeleton, widths, parted),
        spurs=_spurs(skeleton),
    )


def require_scorable(skeleton: Skeleton, mesh: Mesh) -> None:
    """Refuse a skeleton that cannot be measured, or has a map for another mesh."""
    if len(skeleton.nodes) == 0:
        raise MeshError("the skeleton has no nodes, so there is nothing to score")
    bad = np.flatnonzero(~np.isfinite(skeleton.nodes).all(axis=1))
    if len(bad):
        raise MeshError(f"nodes {first_few(bad)} of the skeleton have NaN or infinite coordinates")
    n_mapped = len(skeleton.node_of_vertex)
    if n_mapped not in (0, len(mesh.vertices)):
        raise MeshError(
            f"the skeleton's map is for {n_mapped} vertices, but the mesh has {len(mesh.vertices)}: give the mesh that "
            "it was made from, or a skeleton without a map"
        )


def _share_of_length(skeleton: Skeleton, is_chosen: NDArray[np.bool_]) -> float:
    """How much of the length of all edges belongs to some nodes, half an edge to each end; of nodes without any."""
    length = np.bincount(skeleton.edges.ravel(), weights=np.repeat(skeleton.edge_lengths, 2), minlength=len(is_chosen))
    return float(np.average(is_chosen, weights=length if length.any() else None))


def _off_center(skeleton: Skeleton, widths: NDArray[np.float64], surface: Surface) -> tuple[float | None, float | None]:
    """Distances of nodes from the centroids of their own sections, in radii: the mean, and the worst branch's median.

    The radius is the mean distance of the node's vertices, or that from the centroid to the surface if it is larger.
    """
    inner = np.flatnonzero(skeleton.degrees == 2)
    if len(inner) > MOST_SECTIONS:
        inner = inner[np.linspace(0, len(inner) - 1, MOST_SECTIONS).astype(np.int64)]
    axes = find_section_centers(skeleton, surface, inner)
    at = inner[axes.is_known[inner]]
    if len(at) == 0:
        return None, None
    radii = np.maximum(surface.distance(axes.places[at]), widths[at])
    off = np.full(len(skeleton.nodes), np.nan)
    off[at] = np.linalg.norm(axes.places[at] - skeleton.nodes[at], axis=1) / radii
    known = [off[branch][~np.isnan(off[branch])] for branch in skeleton.branches]
    medians = [float(np.median(values)) for values in known if len(values) >= FEWEST_SECTIONS]
    return float(off[at].mean()), max(medians, default=None)


def _bending(skeleton: Skeleton) -> float:
    """Root of the mean square, along the length, of the turn at each node per length of one radius."""
    turns, weights = [0.0], [0.0]
    for branch in skeleton.branches:
        closed = branch[0] == branch[-1] and skeleton.degrees[branch[0]] == 2
        walk = np.concatenate([branch[-2:-1], branch]) if closed else branch
        steps = np.diff(skeleton.nodes[walk], axis=0)
        length = np.linalg.norm(steps, axis=1)
        apart = (length[1:] + length[:-1]) / 2
        cosine = np.einsum("ij,ij->i", steps[1:], steps[:-1])
        sine = np.linalg.norm(np.cross(steps[1:], steps[:-1]), axis=1)
        is_long = apart > 0
        turn = np.arctan2(sine, cosine)[is_long] * skeleton.radii[walk[1:-1]][is_long] / apart[is_long]
        turns.extend(turn)
        weights.extend(apart[is_long])
    return float(np.sqrt(np.average(np.square(turns), weights=weights))) if any(weights) else 0.0


def _n_bodies(mesh: Mesh) -> int:
    """Components that a skeleton can stand for: crumbs of a few faces or without area are none."""
    component = mesh.component_of_vertex[mesh.faces[:, 0]]
    return int(((np.bincount(component) >= MIN_FACES) & (np.bincount(component, mesh.face_areas) > 0)).sum())


def _extra_cycles(skeleton: Skeleton, mesh: Mesh) -> int | None:
    """Cycles less handles, with holes closed; None where more than two faces meet at an edge.

    Each component of the skeleton is compared with the components of the mesh that it represents: a cycle too many in
    one does not make up for a cycle lost in another.
    """
    if not mesh.is_edge_manifold:
        return None
    edges, vertices = mesh.edges, mesh.used_vertices
    component = mesh.component_of_vertex
    euler = (
        np.bincount(component[vertices], minlength=mesh.n_components)
        - np.bincount(component[edges[:, 0]], minlength=mesh.n_components)
        + np.bincount(component[mesh.faces[:, 0]], minlength=mesh.n_components)
    )
    border = edges[mesh.faces_per_edge == 1]
    if len(border):
        rim, ends = np.unique(border, return_inverse=True)
        graph = weighted_graph(ends.reshape(-1, 2), np.ones(len(border), dtype=np.int8), len(rim))
        first_of_hole = np.unique(connected_components(graph, directed=False)[1], return_index=True)[1]
        euler += np.bincount(component[rim[first_of_hole]], minlength=mesh.n_components)
    handles = 1 - euler // 2
    part = skeleton.component_of_node
    votes = part[skeleton.node_of_vertex[vertices]], component[vertices]
    shape = (skeleton.n_components, mesh.n_components)
    represents = coo_array((np.ones(len(vertices), dtype=np.int64), votes), shape=shape).tocsc().argmax(axis=0)
    expected = np.bincount(np.asarray(represents).ravel(), handles, minlength=skeleton.n_components)
    cycles = (
        np.bincount(part[skeleton.edges[:, 0]], minlength=skeleton.n_components)
        - np.bincount(part, minlength=skeleton.n_components)
        + 1
    )
    surplus = cycles - expected
    total, spread = int(surplus.sum()), int(np.abs(surplus).sum())
    return total if abs(total) == spread else spread


def _bridges(skeleton: Skeleton, widths: NDArray[np.float64], parted: NDArray[np.int64]) -> int:
    """Of the edges between regions that do not touch, those that are longer than the regions are wide."""
    length = np.linalg.norm(skeleton.nodes[parted[:, 0]] - skeleton.nodes[parted[:, 1]], axis=1)
    return int((length > widths[parted].sum(axis=1)).sum())


def _spurs(skeleton: Skeleton) -> int:
    """End branches whose balls hardly leave the ball of their junction."""
    ends = skeleton.end_branches
    reached = [np.linalg.norm(skeleton.nodes[b] - skeleton.nodes[b[0]], axis=1) + skeleton.radii[b] for b in ends]
    return sum(float(r.max()) < SPUR * float(skeleton.radii[b[0]]) for r, b in zip(reached, ends, strict=True))
