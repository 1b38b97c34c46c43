"""The passes on one body, and what is left of them where their time is over."""

import numpy as np
import pytest
from helpers import is_whole, joined, moved

from lbskel import Skeleton, collapse, contract, prepare, refine, skeletonize, to_skeleton
from lbskel.contraction.homology import tunnels_missed
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.pipeline import passes, profiling
from lbskel.pipeline.assembly import MISSING

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
    assert "no time was left for 1 components" in report["notes"]
    for stage in ("prepare bodies", "collapse", "score"):
        assert f"{stage} ({MISSING[stage]})" in report["notes"][-1]


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
    assert [tunnels_missed(s.nodes, s.edges, body.mesh) for s in (*drawn, refined)] == [1, 1, 0]
