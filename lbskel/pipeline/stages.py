r"""From any mesh to a checked skeleton: the stages in their order.

::

    prepare -> contract -> collapse -> to_skeleton -> refine -> assemble -> join, open loops, prune, resample -> score
               \________________ for each body _______________/

:func:`skeletonize` runs these stages, without arithmetic of its own.
"""

from __future__ import annotations

__all__ = ["skeletonize"]

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from lbskel.contraction.settings import ContractionSettings
from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import as_shape
from lbskel.operators import Operator
from lbskel.pipeline.anchoring import resolve_anchors
from lbskel.pipeline.assembly import assemble, full_report, no_edits
from lbskel.pipeline.bodies import skeletonize_body
from lbskel.pipeline.clouds import skeletonize_cloud
from lbskel.pipeline.evaluation import score_prepared
from lbskel.pipeline.grouping import skeletonize_bodies
from lbskel.pipeline.memory import require_memory_options, simplify_within
from lbskel.pipeline.options import resolve_options, resolve_settings
from lbskel.pipeline.passes import refine
from lbskel.pipeline.point_contraction import is_of_points, skeletonize_points
from lbskel.pipeline.preparation import Body, PreparedMesh, prepare
from lbskel.pipeline.profiling import Progress, StageTimer
from lbskel.preprocess import Pipeline
from lbskel.refinement.anchors import nearest_node, resolve_root
from lbskel.refinement.open_ends import normals_of_cuts
from lbskel.skeleton.editing import reroot
from lbskel.skeleton.joining import join_components, join_pieces
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO, prune, without_stubs
from lbskel.skeleton.resampling import require_number_of_nodes, resample
from lbskel.skeleton.root import reroot_by_thickness, with_mean_radii
from lbskel.skeleton.short_loops import open_short_loops
from lbskel.skeleton.skeleton import Skeleton


def skeletonize(
    mesh: Any,
    *,
    preset: str | ContractionSettings = "curvature_flow",
    operator: str | Operator | None = None,
    energy: str | None = None,
    solver: str | None = None,
    simplify: str = "auto",
    min_branch_ratio: float | None = None,
    tip_position: str | None = None,
    join: str | None = None,
    min_loop: float | None = None,
    radius_kind: str | None = None,
    anchors: Sequence[Any] = (),
    root: Any = None,
    n_nodes: int | None = None,
    preprocess: str | Pipeline | None = "auto",
    on_stage: Progress | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    profile: bool = False,
) -> Skeleton:
    """Make the curve skeleton of a mesh or a point cloud, and score it.

    Parameters
    ----------
    mesh : Mesh, PointCloud, (vertices, faces), (n, 3) array, path, or mesh or cloud object
        A shape that :func:`lbskel.as_mesh` takes, closed or open, of one component or several, or points without faces.
        For points the skeleton is that of the surface by :func:`lbskel.reconstruct_surface`, and "vertices" below means
        the points.
    preset : str or ContractionSettings
        A name in PRESETS: ``curvature_flow`` measures best, the others reproduce published methods. Or one in DOMAINS:
        ``curvature_flow`` with the options that suit a kind of shape, where they are not given.
    operator, energy, solver : str, optional
        Names in OPERATORS, ENERGIES and SOLVERS in place of the preset's.
    simplify : str
        ``auto`` contracts a simplified proxy of bodies of more than 16,000 faces, or of more where they are long and
        thin all over, and refines the skeleton on the full surface; ``none`` contracts every vertex.
    min_branch_ratio : float, optional
        An end branch is kept where the surface it represents reaches this many local radii from its junction, 1.5 by
        default, and is no corner of a blunt end: it is longer than its own radius, or than a lower share of it for a
        lower ratio, or leads to an end that the surface tells, or to a cut. Values above 1.5 give what
        :func:`lbskel.prune` makes of the default skeleton, with the root chosen after pruning.
    tip_position : str, optional
        ``inside``, the default, ends branches at the center of the last inscribed ball, ``surface`` on the surface.
    join : str, optional
        Which parts get one graph: ``pieces``, the default, joins parts of open or non-manifold surface whose gap is at
        most ten times the radii at its ends and lies ahead of a branch, and such parts of a cloud whose points are
        neighbors; ``all`` joins all, ``none`` none.
    min_loop : float, optional
        Loops shorter than this many local radii are opened as by :func:`lbskel.open_short_loops`; 0 by default.
    radius_kind : str, optional
        ``inscribed``, the default, gives distances to the surface, ``mean`` the radii of the round tubes that fit it
        best, which noise hardly changes. The latter are in ``mean_radii`` in any case.
    anchors : sequence of int or (3,) array_like
        Vertices, or points inside, at each of which there will be a node; they are in ``anchors`` of the result. The
        node of a vertex that preprocessing moves, as smoothing does, is at its new place.
    root : int or (3,) array_like, optional
        A vertex or a point: the node that represents it, or is nearest, comes first, and is the root in SWC. By
        default it is the soma of a neuron, else the thickest tip.
    n_nodes : int, optional
        The number of nodes, evenly spaced, in place of two for each local radius; none between bodies that are joined.
    preprocess : str, Pipeline or None
        ``auto`` does what the mesh needs, None nothing; else a pipeline, its text, or its name in PIPELINES. Of a
        point cloud ``auto`` leaves out what is far from all else, ``scan`` also what is less far, and both thin more
        than 20,000 points, whatever ``simplify`` is; None keeps all points.
    on_stage : callable, optional
        Called with the name of each stage as it begins.
    time_limit : float, optional
        Seconds after which stages that are not needed are left out, also in the middle of a stage; the contraction of
        each body gets half of the time that is left when it begins. The notes list what was left out and what the
        result lacks. Reading and the repair of defects are not cut short, so meshes of a million faces take longer than
        a limit of a second (benchmarks/results/scaling.md, Time limits).
    memory_limit : float, optional
        Megabytes that the run may take, as estimated from the number of faces; by default those that the machine has
        free. A mesh that cannot be contracted in full is contracted by a proxy.
    profile : bool
        Whether the report has the peak memory of each stage beside the seconds; on Linux only.

    Returns
    -------
    Skeleton
        In the caller's coordinates, with radii of the kind ``radius_kind``; ``node_of_vertex`` has a node for each of
        the caller's vertices, and ``report`` holds the settings, the steps, the :func:`lbskel.score` and the seconds.

    Raises
    ------
    FormatError
        If the input is a path and no mesh or cloud can be read from it.
    MeshError
        If the input is no mesh, or encloses nothing, or an anchor is no vertex and no point inside.
    UnknownChoice
        If a name is in no table or a number is out of its range.
    OperatorError
        If a function given as the operator returns no Laplacian of the mesh, or one with the wrong sign.
    MemoryLimitError
        If the mesh takes more memory than the limit.

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
    given = {"min_branch_ratio": min_branch_ratio, "tip_position": tip_position, "join": join, "min_loop": min_loop}
    given["radius_kind"] = radius_kind
    options, settings = resolve_options(preset, given), resolve_settings(preset, operator, energy, solver)
    if time_limit is not None and not time_limit > 0:
        raise UnknownChoice(f"time_limit must be positive, not {time_limit}")
    require_memory_options(simplify, memory_limit)
    if n_nodes is not None:
        require_number_of_nodes(n_nodes)
    timer = StageTimer(on_stage, time_limit, profile)
    with timer("read"):
        shape = as_shape(mesh)
    limits: dict[str, Any]
    places: dict[str, Any] = {"anchors": anchors, "root": root, "preprocess": preprocess}
    if is_of_points(settings):
        skeleton = skeletonize_points(shape, settings, given, n_nodes=n_nodes, timer=timer, **places)
    elif isinstance(shape, PointCloud):
        of_mesh = partial(_skeletonize_mesh, settings=settings, options=options, is_scored=False)
        of_mesh = partial(of_mesh, simplify=simplify, n_nodes=None, memory_limit=memory_limit)
        edits = {"join": options["join"], "radius_kind": options["radius_kind"], "n_nodes": n_nodes}
        skeleton = skeletonize_cloud(shape, of_mesh, **places, **edits, timer=timer)
    else:
        limits = {"simplify": simplify, "n_nodes": n_nodes, "memory_limit": memory_limit}
        skeleton = _skeletonize_mesh(shape, settings=settings, options=options, **limits, **places, timer=timer)
    if options["radius_kind"] == "mean":
        return with_mean_radii(skeleton)
    return skeleton


def _skeletonize_mesh(
    shape: Mesh,
    *,
    settings: ContractionSettings,
    options: dict[str, Any],
    simplify: str,
    n_nodes: int | None,
    memory_limit: float | None,
    anchors: Sequence[Any],
    root: Any,
    preprocess: str | Pipeline | None,
    timer: StageTimer,
    is_scored: bool = True,
) -> Skeleton:
    """Make the skeleton of a mesh, and score it unless the caller scores it on points."""
    if root is not None:
        resolve_root(root, shape)  # before anything is computed
    simplify, memory_notes = simplify_within(shape, simplify, memory_limit)
    prepared = prepare(shape, preprocess=preprocess, simplify=simplify, timer=timer)
    prepared = replace(prepared, notes=(*prepared.notes, *memory_notes))
    located = resolve_anchors(anchors, prepared)
    ratio, where = options["min_branch_ratio"], options["tip_position"]

    def refined(skeleton: Skeleton, body: Body) -> Skeleton:
        within = located.within(body)
        return refine(skeleton, body, min_branch_ratio=ratio, tip_position=where, anchors=within, timer=timer)

    def of_body(body: Body) -> tuple[Skeleton, dict[str, Any]]:
        return skeletonize_body(body, settings, refined, timer)

    # a body with an anchor is one of its own, and whoever gives anchors looks at few bodies
    by_body = [of_body(body) for body in prepared.bodies] if len(located.vertices) else None
    results = by_body or skeletonize_bodies(prepared.bodies, of_body)
    skeletons, reports = [skeleton for skeleton, _ in results], [report for _, report in results]
    assembled = replace(assemble(skeletons, prepared), report=no_edits())
    skeleton = _joined(assembled, skeletons, prepared, options["join"])
    if options["min_loop"] > 0:
        with timer("open loops"):
            skeleton = open_short_loops(skeleton, options["min_loop"])
    if ratio > MIN_BRANCH_RATIO:
        with timer("prune"):
            skeleton = prune(skeleton, prepared.source, min_branch_ratio=ratio)
    if root is None:
        skeleton = reroot_by_thickness(skeleton, options["radius_kind"])
    else:
        skeleton = reroot(skeleton, nearest_node(skeleton, root, prepared.source))
    if n_nodes is not None:
        skeleton = resample(skeleton, n_nodes=n_nodes)
    scored = None
    if is_scored:
        scored = timer.optional(
            "score", lambda end: score_prepared(skeleton, prepared, deadline=end), None, is_needed=True
        )
    return replace(skeleton, report=full_report(prepared, settings, reports, scored, timer) | skeleton.report)


def _joined(skeleton: Skeleton, parts: Sequence[Skeleton], prepared: PreparedMesh, join: str) -> Skeleton:
    """Join the graphs of the bodies: all, or those of surfaces that were not closed, which may be pieces of one."""
    is_piece = np.array([body.is_piece for body in prepared.bodies])
    if join == "none" or len(parts) == 1 or (join == "pieces" and np.count_nonzero(is_piece) < 2):
        return skeleton
    if join == "all":
        return join_components(skeleton)
    first = prepared.frame.from_unit(np.array([part.nodes[0] for part in parts]))
    is_joinable = np.zeros(skeleton.n_components, dtype=bool)
    is_joinable[skeleton.component_of_node[cKDTree(skeleton.nodes).query(first)[1]]] = is_piece
    unit = replace(skeleton, nodes=prepared.frame.to_unit(skeleton.nodes))
    cuts = np.concatenate([body.open_ends for body in prepared.bodies])
    outwards = normals_of_cuts(unit, cuts) * prepared.frame.mirror
    return without_stubs(skeleton, join_pieces(skeleton, is_joinable, outwards))
