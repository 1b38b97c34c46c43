"""Measures of boundaries of parts: a straight one, a zigzag, and the sign of the turn."""

import numpy as np
import pytest

from benchmarks.part_boundaries import boundary_measures
from lbskel.shapes import sphere, torus


def test_a_zigzag_is_more_ragged_than_a_circle_along_edges():
    ring = torus(1.0, 0.3, 64, 32)
    angle = np.arctan2(*ring.vertices[ring.faces].mean(axis=1)[:, 1::-1].T)
    straight = (angle > 0.01).astype(np.int64)  # two circles around the tube, along edges
    zigzag = straight ^ (np.arange(len(angle)) % 5 == 0) * (np.abs(angle) < 0.2)
    assert boundary_measures(ring, straight)["raggedness"] == pytest.approx(1.0, abs=0.1)
    assert boundary_measures(ring, zigzag)["raggedness"] > 1.3


def test_turns_are_negative_on_a_ball_and_positive_inside_a_ring():
    ball = sphere(3)
    half = (ball.vertices[ball.faces].mean(axis=1)[:, 2] > 0).astype(np.int64)
    assert boundary_measures(ball, half)["turn, degrees"] < 0
    ring = torus(1.0, 0.3, 64, 32)
    angle = np.arctan2(*ring.vertices[ring.faces].mean(axis=1)[:, 1::-1].T)
    found = boundary_measures(ring, (angle > 0.01).astype(np.int64))
    assert found["turn, degrees"] == pytest.approx(0, abs=2.0)  # around the tube: inwards at the hole, outwards outside
    assert boundary_measures(ball, np.zeros(len(ball.faces), dtype=np.int64)) == {}


def test_a_part_of_one_face_has_no_curve_around_it():
    ball = sphere(3)
    found = boundary_measures(ball, (np.arange(len(ball.faces)) == 0).astype(np.int64))
    assert found["raggedness"] is None
    assert found["turn, degrees"] < 0
