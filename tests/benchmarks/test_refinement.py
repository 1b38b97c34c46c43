"""The benchmark of refinement: a graph is judged by its tips, junctions and cycles, and each pass can be left out."""

from inspect import Parameter, signature

import numpy as np
import pytest

import lbskel
from benchmarks.refinement import BOUNDS, HELD_OUT, PASSES, TUNED, _turn, measured, replaced
from lbskel.pipeline import passes
from lbskel.shapes import make
from lbskel.shapes.hard import HARD_SHAPES


def test_both_sets_have_every_kind_with_other_parameters():
    assert set(TUNED) == set(HELD_OUT) == set(HARD_SHAPES)
    assert all(HELD_OUT[name] != TUNED[name] for name in HARD_SHAPES)


def test_the_axis_itself_is_right_and_with_a_spike_is_not():
    truth = make("tripod", n_vertices=500).truth
    own = measured(truth, truth)
    assert own["graph right"]
    assert own["accuracy"] == pytest.approx(0, abs=1e-9)
    tip = truth.tips[0]
    spiked = lbskel.Skeleton(
        np.vstack([truth.nodes, truth.nodes[truth.neighbors[tip][0]] + 0.5]),
        np.vstack([truth.edges, [truth.neighbors[tip][0], len(truth.nodes)]]),
        np.append(truth.radii, 0.1),
    )
    assert not measured(spiked, truth)["graph right"]


@pytest.mark.parametrize("name", PASSES)
def test_a_pass_is_left_out_only_inside_the_block(name):
    before = {target: _value(target) for target in PASSES[name]}
    with replaced(name):
        assert all(_value(target) is not before[target] for target in before)
    assert {target: _value(target) for target in before} == before


STAND_INS = [each for stand_ins in PASSES.values() for each in stand_ins.items() if callable(each[1])]


@pytest.mark.parametrize(("target", "stand_in"), STAND_INS, ids=[target for target, _ in STAND_INS])
def test_what_stands_in_for_a_pass_takes_its_arguments(target, stand_in):
    parameters = signature(_value(target)).parameters.values()
    named = {each.name: None for each in parameters if each.kind is Parameter.KEYWORD_ONLY}
    signature(stand_in).bind(*[None] * (len(parameters) - len(named)), **named)


@pytest.mark.parametrize("name", BOUNDS)
def test_a_bound_is_not_that_of_the_code(name):
    before = {target: _value(target) for target in BOUNDS[name]}
    with replaced(name):
        assert any(not np.array_equal(_value(target), before[target]) for target in before)
    assert all(_value(target) is before[target] for target in before)


def _value(target):
    """What a dotted name of a module's attribute refers to now."""
    module, attribute = target.rsplit(".", 1)
    return getattr(__import__(module, fromlist=[attribute]), attribute)


def test_the_passes_call_what_is_left_out():
    assert callable(passes.refine)
    shape = make("octopus", n_vertices=800)
    with replaced("fit tubes"):
        raw = lbskel.skeletonize(shape.mesh)
    assert (
        measured(raw, shape.truth)["accuracy"] > 2 * measured(lbskel.skeletonize(shape.mesh), shape.truth)["accuracy"]
    )


@pytest.mark.parametrize("angle", [0, 40, 130])
def test_the_turn_of_a_zigzag_is_its_angle(angle):
    headings = np.radians(angle) * (np.arange(12) % 2)
    steps = np.stack([np.cos(headings), np.sin(headings), 0 * headings], axis=1)
    nodes = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    zigzag = lbskel.Skeleton(nodes, np.stack([np.arange(12), np.arange(1, 13)], axis=1), np.ones(13))
    assert _turn(zigzag) == pytest.approx(angle, abs=1e-5)
    assert _turn(lbskel.Skeleton(nodes[:2], [[0, 1]], np.ones(2))) == 0
