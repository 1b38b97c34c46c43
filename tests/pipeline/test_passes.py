"""The passes on one body, and what is left of them where their time is over."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers import is_whole, joined, moved

from lbskel import (
    MeshError,
    Skeleton,
    UnknownChoice,
    collapse,
    contract,
    prepare,
    refine,
    resample,
    skeletonize,
    to_skeleton,
)
from lbskel.contraction.cycle_classes import tunnels_missed
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.surface_queries import Surface
from lbskel.pipeline import passes, profiling
from lbskel.pipeline.assembly import MISSING
from lbskel.refinement.containment import segments_outside
from lbskel.shapes import porous_block, tube
from lbskel.shapes.hard import oblique_cross
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.resampling import space_evenly

STAGES = ["prune spurs", "merge junctions", "recenter", "extend tips", "reroute inside", "map vertices", "score"]


class _Late(Deadline):
    """A deadline that passes once, when a stage has begun."""

    def __init__(self, began, stage):
        super().__init__()
        object.__setattr__(self, "began", began)
        object.__setattr__(self, "stage", stage)

    def check(self):
        if self.began[-1] == self.stage:
            self.began.append("cut short")
            raise OutOfTime


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_is_cut_short_where_its_time_is_over(tripod, monkeypatch, stage):
    """The time is over as soon as the stage has begun; all other stages have time."""
    began = []
    for deadline in ("deadline", "grace"):
        monkeypatch.setattr(profiling.StageTimer, deadline, property(lambda self: _Late(began, stage)))
    skeleton = skeletonize(tripod, on_stage=began.append)
    assert began.index("cut short") == began.index(stage) + 1
    assert is_whole(skeleton, tripod)
    assert skeleton.report["notes"][-1].endswith(f"left out: {stage} ({MISSING[stage]})")


def test_without_time_for_what_is_needed_the_first_body_is_a_node(ring, monkeypatch):
    monkeypatch.setattr(profiling, "GRACE_SECONDS", 0.0)
    two = joined(ring, moved(ring, 10.0))
    skeleton = skeletonize(two, time_limit=1e-6)
    report = skeleton.report
    assert (len(skeleton.nodes), len(skeleton.edges)) == (1, 0)
    assert np.linalg.norm(skeleton.nodes - [[0, 0, 0], [10.0, 0, 0]], axis=1).min() < 1e-9
    assert skeleton.node_of_vertex.tolist() == [0] * len(two.vertices)
    assert report["passed"] is False
    assert report["score"]["verdict"] == "not measured"
    assert set(report["score"]["measures"]) == set(skeletonize(ring).report["score"]["measures"])
    assert "no time was left for 1 component" in report["notes"]
    for stage in ("prepare bodies", "collapse", "score"):
        assert f"{stage} ({MISSING[stage]})" in report["notes"][-1]


def test_a_skeleton_without_the_map_of_the_proxy_is_refused(ring):
    [body] = prepare(ring).bodies
    loose = Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1])
    with pytest.raises(
        MeshError, match=r"the skeleton maps 0 vertices to its nodes, .* give the skeleton that to_skel"
    ):
        refine(loose, body)


def test_a_pass_that_moves_a_cycle_off_its_tunnel_is_taken_back(ring, monkeypatch):
    """In place of the pass that centers nodes, one draws the whole cycle together within one side of the ring."""
    (body,) = prepare(ring).bodies
    collapsed = to_skeleton(collapse(contract(body.proxy.mesh)))
    drawn = []

    def draw_together(skeleton, surface):
        node = skeleton.nodes[0]
        drawn.append(
            Skeleton(node + 0.01 * (skeleton.nodes - node), skeleton.edges, skeleton.radii, skeleton.node_of_vertex)
        )
        return drawn[-1]

    monkeypatch.setattr(passes, "recenter", draw_together)
    refined = refine(collapsed, body)
    assert [tunnels_missed(s.nodes, s.edges, body.mesh) for s in (*drawn, refined)] == [1, 0]


def test_evenly_spaced_nodes_stay_inside_a_bent_tube():
    """A quarter of a thin ring whose radii are given as that of the ring: nodes at that distance would cut it."""
    angle = np.linspace(0, np.pi / 2, 41)
    arc = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    surface = Surface(tube(arc, 0.1))
    curve = Skeleton(0.995 * arc[1:-1], np.stack([np.arange(38), np.arange(1, 39)], axis=1), np.full(39, 1.0))
    cut = resample(curve, spacing=1.0)
    assert segments_outside(cut.nodes, cut.edges, surface).any()
    spaced = space_evenly(curve, 1.0, partial(passes._must_stay, surface=surface))
    assert len(cut.nodes) < len(spaced.nodes)
    assert not segments_outside(spaced.nodes, spaced.edges, surface).any()


def test_a_lost_limb_is_grown_with_even_spacing_before_nodes_are_centered(tripod, monkeypatch):
    seen, merged = [], passes._with_merged_junctions
    monkeypatch.setattr(
        passes,
        "_with_merged_junctions",
        lambda skeleton, surface: contract_branches(whole := merged(skeleton, surface), whole.end_branches[:1]),
    )
    monkeypatch.setattr(passes, "recenter", lambda skeleton, _: seen.append(skeleton) or skeleton)
    skeletonize(tripod)
    (given,) = seen
    assert (len(given.tips), len(given.junctions)) == (3, 1)
    for branch in given.end_branches:  # pieces of a path are alike but for rounding their number
        lengths = np.linalg.norm(np.diff(given.nodes[branch], axis=0), axis=1)
        assert lengths.max() < 1.5 * lengths.min()


def test_junctions_that_are_moved_to_one_place_are_one():
    skeleton = skeletonize(oblique_cross().mesh)
    assert skeleton.degrees[skeleton.junctions].tolist() == [4]


def test_the_skeleton_of_a_porous_block_goes_around_all_its_tunnels_inside():
    """Contraction leaves the block, and where it is thick, edges inside pass tunnels on their other side."""
    skeleton = skeletonize(porous_block(12, filled=0.6, seed=1))
    measures = skeleton.report["score"]["measures"]
    assert (skeleton.cycle_rank, measures["tunnels_missed"]) == (8, 0)
    assert measures["inside_fraction"] > 0.95  # 0.988; 0.91 where a pass is taken back as a whole


def test_a_skeleton_that_lies_elsewhere_and_anchors_of_another_kind_are_refused(rod):
    (body,) = prepare(rod).bodies
    skeleton = to_skeleton(collapse(contract(body.proxy.mesh)))
    with pytest.raises(MeshError, match=r"elsewhere than the body, .* contract body.proxy.mesh"):
        refine(replace(skeleton, nodes=skeleton.nodes + 100), body)
    with pytest.raises(UnknownChoice, match="anchors must be those that resolve_anchors"):
        refine(skeleton, body, anchors=[0])
