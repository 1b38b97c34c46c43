"""The whole way from a mesh to a checked skeleton: the stages in their order, and no arithmetic of its own."""

from __future__ import annotations

__all__ = ["skeletonize"]

import platform
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.contraction import PRESETS, ContractionSettings, Status, Step, contract
from lbskel.errors import MeshError, choose
from lbskel.files import as_mesh
from lbskel.inside import keep_inside, length_inside
from lbskel.junctions import gather_junctions
from lbskel.mapping import join_regions
from lbskel.mesh import Mesh
from lbskel.operators import Operator
from lbskel.preprocess import Preprocessed, components, simplify, tidy
from lbskel.pruning import cut_swallowed, merge_junctions, prune, resample
from lbskel.refinement import inscribed_radii, mean_radii, recenter, settle
from lbskel.scoring import FEWEST_FACES, Score, score
from lbskel.skeleton import Skeleton
from lbskel.surface import Surface
from lbskel.surgery import collapse
from lbskel.tips import extend_tips

PRUNE = 1.5  # an end branch must stand out this many radii from its junction
MERGE = 0.7  # junctions nearer than this many radii are one
SPACING = 0.5  # of the nodes along a branch, in radii
INSIDE = 0.995  # share of the length that must lie inside for the check to pass

MOST_FACES = 20_000  # of a component that is contracted as it is, unless in full

RESOLUTIONS = ("auto", "full")

Progress = Callable[[str], None]


@dataclass
class _Clock:
    """Seconds spent in each stage, and the caller told of each as it begins."""

    on_stage: Progress | None
    seconds: dict[str, float] = field(default_factory=dict)

    def __call__(self, stage: str, function: Callable, *arguments: Any, **options: Any) -> Any:
        if self.on_stage is not None:
            self.on_stage(stage)
        began = time.perf_counter()
        result = function(*arguments, **options)
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - began
        return result


def skeletonize(
    mesh: Any,
    *,
    preset: str | ContractionSettings = "flow",
    operator: str | Operator | None = None,
    energy: str | None = None,
    solver: str | None = None,
    resolution: str = "auto",
    on_stage: Progress | None = None,
) -> Skeleton:
    """The curve skeleton of a mesh, checked.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
        Whatever :func:`lbskel.as_mesh` takes: closed or open, of one component or several.
    preset : str or ContractionSettings
        A name in PRESETS: ``flow`` is what measures best, ``au2008`` keeps to the paper.
    operator, energy, solver : str, optional
        Names in OPERATORS, ENERGIES and SOLVERS in place of the preset's.
    resolution : str
        ``auto`` contracts a simplified copy of components of more than 20,000 faces, and refines against the full
        surface; ``full`` contracts every vertex.
    on_stage : callable, optional
        Called with the name of each stage as it begins.

    Returns
    -------
    Skeleton
        In the caller's coordinates, with inscribed radii; ``node_of_vertex`` has a node for each of the caller's
        vertices, and ``report`` tells what was done, what was checked, the :func:`lbskel.score` and how long it took.

    Raises
    ------
    MeshError
        If the input is no mesh, or encloses nothing.
    UnknownChoice
        If a name is in no table.

    References
    ----------
    Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
    https://doi.org/10.1145/1399504.1360643

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> skeleton = lbskel.skeletonize(torus(1.0, 0.2))
    >>> skeleton.cycle_rank, len(skeleton.tips), skeleton.report["passed"]
    (1, 0, True)
    """
    settings = _settings(preset, operator, energy, solver)
    choose(dict.fromkeys(RESOLUTIONS), resolution, "resolution")
    clock = _Clock(on_stage)
    given = clock("read", as_mesh, mesh)
    tidied = clock("check", tidy, given)
    centre, scale = tidied.mesh.centroid, tidied.mesh.extent
    if not scale > 0:
        raise MeshError("all vertices of the mesh lie at one point")
    unit = tidied.mesh.with_vertices((tidied.mesh.vertices - centre) / scale)
    parts, skipped = [], []
    for part in components(unit):
        if len(part.mesh.faces) < FEWEST_FACES or not part.mesh.area > 0:
            skipped.append(part.mesh)
            continue
        parts.append((part, *_skeleton_of_component(part.mesh, settings, resolution, clock)))
    if not parts:
        raise MeshError(
            f"no component of the mesh has {FEWEST_FACES} faces and an area, so there is nothing that a skeleton could "
            f"stand for: {len(given.faces)} faces in all"
        )
    whole = _joined([skeleton for _, skeleton, _ in parts])
    node_of = np.full(len(unit.vertices), -1)
    first = 0
    for part, skeleton, _ in parts:
        mine = part.vertex_map >= 0
        node_of[mine] = skeleton.node_of_vertex[part.vertex_map[mine]] + first
        first += len(skeleton.nodes)
    whole = replace(whole, node_of_vertex=_filled(node_of, unit.vertices, whole.nodes))
    scored = clock("score", score, whole, unit)
    node_of_given = np.where(tidied.vertex_map >= 0, whole.node_of_vertex[tidied.vertex_map], -1)
    notes = [*given.notes, *tidied.notes]
    if skipped:
        notes.append(f"{len(skipped)} components of too few faces or no area have no skeleton of their own")
    return replace(
        whole,
        nodes=whole.nodes * scale + centre,
        radii=whole.radii * scale,
        node_of_vertex=_filled(node_of_given, (given.vertices - centre) / scale, whole.nodes),
        report=_report(given, settings, [report for _, _, report in parts], notes, scored, clock.seconds),
    )


def _settings(
    preset: str | ContractionSettings, operator: str | Operator | None, energy: str | None, solver: str | None
) -> ContractionSettings:
    """The preset with what was asked for by name put in."""
    settings = preset if isinstance(preset, ContractionSettings) else choose(PRESETS, preset, "preset")
    asked: dict[str, Any] = {"operator": operator, "energy": energy, "solver": solver}
    if energy is not None and energy != settings.energy:
        asked["degenerate"] = "none"
    return replace(settings, **{name: value for name, value in asked.items() if value is not None})


def _skeleton_of_component(
    mesh: Mesh, settings: ContractionSettings, resolution: str, clock: _Clock
) -> tuple[Skeleton, dict[str, Any]]:
    """Contract, collapse, prune, refine and check one connected surface."""
    proxy = Preprocessed(mesh, np.arange(len(mesh.vertices)))
    if resolution == "auto":
        proxy = clock("simplify", simplify, mesh, target_faces=MOST_FACES)
    contraction = clock("contract", contract, proxy.mesh, settings)
    graph = clock("collapse", collapse, contraction.mesh, proxy.mesh)
    skeleton = Skeleton(
        contraction.mesh.vertices[graph.kept],
        graph.edges,
        np.zeros(len(graph.kept)),
        graph.node_of_vertex[proxy.vertex_map],
    )
    surface = Surface(mesh)
    skeleton = clock("prune", _pruned, skeleton, surface)
    skeleton = clock("gather", _gathered, skeleton, surface)
    skeleton = clock("recentre", recenter, skeleton, surface)
    skeleton = clock("extend", extend_tips, skeleton, surface)
    skeleton = clock("lead inside", _led_inside, skeleton, surface)
    skeleton = clock("map", settle, inscribed_radii(skeleton, surface), mesh)
    skeleton = clock("map", join_regions, skeleton, mesh)
    inside = clock("check", length_inside, skeleton, surface)
    genus = mesh.genus
    checks = {
        "is_topology_right": None if genus is None else (skeleton.n_components, skeleton.cycle_rank) == (1, genus),
        "is_inside": inside >= INSIDE if mesh.is_closed else None,
        "is_contracted": contraction.status in (Status.VOLUME, Status.AREA, Status.STALLED),
    }
    return skeleton, {
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "notes": list(proxy.notes),
        "is_closed_manifold": mesh.is_closed_manifold,
        "genus": genus,
        "status": contraction.status.value,
        "steps": [_record(step) for step in contraction.steps],
        "are_tunnels_guarded": graph.is_guarded,
        "loops_cut": graph.n_loops_cut,
        "cycle_rank": skeleton.cycle_rank,
        "tips": len(skeleton.tips),
        "junctions": len(skeleton.junctions),
        "length_inside": inside,
        "checks": checks,
    }


def _record(step: Step) -> dict[str, Any]:
    """A step as JSON can hold it, which has no NaN: an open mesh has None for a volume."""
    return {name: None if value != value else value for name, value in asdict(step).items()}


def _pruned(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Spurs cut, near junctions merged, nodes evenly spaced."""
    skeleton = prune(mean_radii(skeleton, surface.mesh), surface.mesh, ratio=PRUNE)
    return _spaced(merge_junctions(inscribed_radii(skeleton, surface), ratio=MERGE), surface)


def _gathered(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Junctions that are one made one, and the branches that lead there evenly spaced again."""
    gathered = gather_junctions(inscribed_radii(skeleton, surface), surface)
    return skeleton if len(gathered.nodes) == len(skeleton.nodes) else _spaced(gathered, surface)


def _led_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Every branch inside a closed surface and evenly spaced; what lies within a junction's ball is no branch."""
    if surface.mesh.is_closed:
        skeleton = keep_inside(skeleton, surface)
    skeleton = _spaced(cut_swallowed(inscribed_radii(skeleton, surface)), surface)
    return keep_inside(skeleton, surface) if surface.mesh.is_closed else skeleton  # where even spacing cut a corner


def _spaced(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Nodes evenly spaced by mean radii: by inscribed ones what is flat would have a node for every thickness."""
    return resample(mean_radii(skeleton, surface.mesh), spacing=SPACING)


def _filled(node_of: NDArray[np.int64], vertices: NDArray[np.float64], nodes: NDArray[np.float64]) -> NDArray[np.int64]:
    """The map with the nearest node for the vertices that have none."""
    lost = node_of < 0
    return np.where(lost, cKDTree(nodes).query(vertices)[1], node_of) if lost.any() else node_of


def _joined(skeletons: list[Skeleton]) -> Skeleton:
    """Several skeletons as one graph, without maps."""
    first = np.cumsum([0, *(len(s.nodes) for s in skeletons)])
    return Skeleton(
        np.concatenate([s.nodes for s in skeletons]),
        np.concatenate([s.edges + offset for s, offset in zip(skeletons, first[:-1], strict=True)]),
        np.concatenate([s.radii for s in skeletons]),
        radius_kind=skeletons[0].radius_kind,
    )


def _report(
    given: Mesh,
    settings: ContractionSettings,
    parts: list[dict[str, Any]],
    notes: list[str],
    scored: Score,
    seconds: dict[str, float],
) -> dict[str, Any]:
    """What was done, plain enough for JSON."""
    chosen = asdict(settings)
    if callable(chosen["operator"]):
        chosen["operator"] = getattr(chosen["operator"], "__name__", repr(chosen["operator"]))
    return {
        "input": {"vertices": len(given.vertices), "faces": len(given.faces), "components": given.n_components},
        "settings": chosen,
        "notes": notes,
        "components": parts,
        "passed": all(check is not False for part in parts for check in part["checks"].values()),
        "score": scored.report(),
        "seconds": seconds,
        "versions": _versions(),
    }


def _versions() -> dict[str, str]:
    """Versions of what the result depends on."""
    found = {"python": platform.python_version()}
    for package in ("lbskel", "numpy", "scipy", "libigl", "robust-laplacian", "cvxopt"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
