"""The whole way from a mesh to a checked skeleton: the stages in their order, and no arithmetic of its own."""

from __future__ import annotations

__all__ = ["skeletonize"]

import platform
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.contraction.flow import PRESETS, ContractionSettings
from lbskel.errors import MeshError, UnknownChoice, choose, first_few
from lbskel.evaluation.scoring import FEWEST_FACES, Score, score_on
from lbskel.geometry.components import components
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.io import as_mesh
from lbskel.operators import Operator
from lbskel.pipeline.component import Options, skeleton_of_component
from lbskel.pipeline.profiling import Progress, StageTimer
from lbskel.preprocess import Pipeline, preprocess_mesh, why_no_inside
from lbskel.refinement.anchors import nearest_node, reroot, resolve_anchor
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.skeleton import Skeleton


def skeletonize(
    mesh: Any,
    *,
    preset: str | ContractionSettings = "flow",
    operator: str | Operator | None = None,
    energy: str | None = None,
    solver: str | None = None,
    resolution: str = "auto",
    prune: float = 1.5,
    tips: str = "inside",
    anchors: Sequence[Any] = (),
    root: Any = None,
    n_nodes: int | None = None,
    preprocess: str | Pipeline | None = "auto",
    on_stage: Progress | None = None,
    time_limit: float | None = None,
    profile: bool = False,
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
        ``auto`` contracts a simplified copy of components of more than 16,000 faces, or more where they are long and
        thin all over, of as many as their thickness asks for, and refines against the full surface; ``full`` contracts
        every vertex.
    prune : float
        An end branch is kept where it stands out this many local radii from its junction.
    tips : str
        ``inside`` ends branches at the center of the last inscribed ball, ``surface`` on the surface.
    anchors : sequence of int or (3,) array_like
        Vertices, or points inside, at each of which there will be a node; they are in ``anchors`` of the result.
    root : int or (3,) array_like, optional
        A vertex or a point: the node that stands for it, or is nearest, comes first, and is the root in SWC.
    n_nodes : int, optional
        So many nodes, evenly spaced, in place of two for each local radius.
    preprocess : str, Pipeline or None
        What is done to the mesh first: ``auto`` only what it needs, None nothing; else a pipeline, its text, or its
        name in PIPELINES.
    on_stage : callable, optional
        Called with the name of each stage as it begins.
    time_limit : float, optional
        Seconds after which the best so far is taken: contraction ends at half of them, with a status that says so, and
        what would refine the skeleton is left out as far as no time is left, which the notes tell.
    profile : bool
        Whether the report is to have the peak of memory in each stage, beside the seconds; on Linux only.

    Returns
    -------
    Skeleton
        In the caller's coordinates, with inscribed radii; ``node_of_vertex`` has a node for each of the caller's
        vertices, and ``report`` tells what was done, what was checked, the :func:`lbskel.score` and how long it took.

    Raises
    ------
    MeshError
        If the input is no mesh, or encloses nothing, or an anchor is no vertex and no point inside.
    UnknownChoice
        If a name is in no table or a number is out of its range.

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
    options = Options(_settings(preset, operator, energy, solver), resolution, prune, tips)
    if time_limit is not None and not time_limit > 0:
        raise UnknownChoice(f"time_limit must be positive, not {time_limit}")
    clock = StageTimer(on_stage, time_limit, profile)
    given = clock("read", as_mesh, mesh)
    tidied = clock("preprocess", preprocess_mesh, given, preprocess)
    center, scale = tidied.mesh.centroid, tidied.mesh.diameter_bound
    if not scale > 0:
        raise MeshError("all vertices of the mesh lie at one point")
    unit = tidied.mesh.with_vertices((tidied.mesh.vertices - center) / scale)
    wanted = [resolve_anchor(anchor, given) for anchor in anchors]
    places = np.array([(point - center) / scale for _, point in wanted]).reshape(-1, 3)
    near = np.array([tidied.vertex_map.indices[vertex] for vertex, _ in wanted], dtype=np.int64)
    near = _filled(near, places, unit.vertices)
    parts, skipped, faults = [], [], []
    for number, part in enumerate(components(unit)):
        if len(part.mesh.faces) < FEWEST_FACES or not part.mesh.area > 0:
            skipped.append(part.mesh)
            continue
        if fault := why_no_inside(number, part, tidied.mesh):
            faults.append(fault)
            continue
        mine = np.isin(near, part.vertices)
        at = np.searchsorted(part.vertices, near[mine]), places[mine]
        parts.append((part, *skeleton_of_component(part.mesh, options, at, clock)))
    if faults and not parts:
        raise MeshError(f"nothing of the mesh has an inside: {first_few(faults, 2)}")
    if not parts:
        raise MeshError(
            f"no component of the mesh has {FEWEST_FACES} faces and an area, so there is nothing that a skeleton could "
            f"stand for: {len(given.faces)} faces in all; where they should hang together, let "
            "preprocess='merge_close:tolerance=1e-3' join their corners"
        )
    whole = _joined([skeleton for _, skeleton, *_ in parts])
    node_of = np.full(len(unit.vertices), -1)
    first = 0
    for part, skeleton, *_ in parts:
        node_of[part.vertices] = skeleton.node_of_vertex + first
        first += len(skeleton.nodes)
    whole = replace(whole, node_of_vertex=_filled(node_of, unit.vertices, whole.nodes))
    if n_nodes is not None:
        whole = resample(whole, n_nodes=n_nodes)
    surface = next((surface for part, _, surface, _ in parts if part.mesh is unit), Surface(unit))
    scored = clock("score", score_on, whole, surface)
    node_of_given = tidied.vertex_map.pull_back(whole.node_of_vertex)
    notes = [*given.notes, *tidied.notes]
    if faults:
        notes.append(f"no skeleton could be made of {first_few(faults, 2)}")
    if skipped:
        notes.append(f"{len(skipped)} components of too few faces or no area have no skeleton of their own")
    if clock.left_out:
        notes.append(f"the time allowed was over, so these stages were left out: {', '.join(clock.left_out)}")
    result = replace(
        whole,
        nodes=whole.nodes * scale + center,
        radii=whole.radii * scale,
        mean_radii=whole.mean_radii * scale,
        node_of_vertex=_filled(node_of_given, (given.vertices - center) / scale, whole.nodes),
        report=_report(given, options, [report for *_, report in parts], notes, scored, clock.seconds)
        | {"preprocess": tidied.report}
        | ({"megabytes": clock.megabytes} if profile else {}),
    )
    return result if root is None else reroot(result, nearest_node(result, root, given))


def _settings(
    preset: str | ContractionSettings, operator: str | Operator | None, energy: str | None, solver: str | None
) -> ContractionSettings:
    """The preset with what was asked for by name put in."""
    settings = preset if isinstance(preset, ContractionSettings) else choose(PRESETS, preset, "preset")
    asked: dict[str, Any] = {"operator": operator, "energy": energy, "solver": solver}
    if energy is not None and energy != settings.energy:
        asked["degenerate_rows"] = "none"
    return replace(settings, **{name: value for name, value in asked.items() if value is not None})


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
        mean_radii=np.concatenate([s.mean_radii for s in skeletons]),
        anchors=np.concatenate([s.anchors + offset for s, offset in zip(skeletons, first[:-1], strict=True)]),
    )


def _report(
    given: Mesh,
    options: Options,
    parts: list[dict[str, Any]],
    notes: list[str],
    scored: Score,
    seconds: dict[str, float],
) -> dict[str, Any]:
    """What was done, plain enough for JSON."""
    chosen = asdict(options.settings)
    if callable(chosen["operator"]):
        chosen["operator"] = getattr(chosen["operator"], "__name__", repr(chosen["operator"]))
    return {
        "input": {"vertices": len(given.vertices), "faces": len(given.faces), "components": given.n_components},
        "settings": chosen,
        "notes": notes,
        "components": parts,
        "passed": scored.passed and all(check is not False for part in parts for check in part["checks"].values()),
        "score": scored.report(),
        "seconds": seconds,
        "versions": dict(_versions()),
    }


@cache
def _versions() -> dict[str, str]:
    """Versions of what the result depends on, which are looked for in files."""
    found = {"python": platform.python_version()}
    for package in ("lbskel", "numpy", "scipy", "libigl", "robust-laplacian", "cvxopt"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
