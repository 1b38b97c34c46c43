"""Lines of branches: they point to their junction, from the sections next to it."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.refinement import branch_lines as module
from lbskel.refinement.branch_lines import N_SECTIONS, branch_lines, nearest_points, with_chords
from lbskel.refinement.centerlines import SectionCenters


@pytest.fixture
def cross():
    """Three arms of eight nodes from a junction, along x, y and z; the first two nodes of each have no section."""
    arms = [np.arange(1, 9)[:, None] * axis for axis in np.eye(3)]
    nodes = np.concatenate([np.zeros((1, 3)), *arms])
    edges = [[0 if k == 0 else 8 * arm + k, 8 * arm + k + 1] for arm in range(3) for k in range(8)]
    skeleton = Skeleton(nodes, edges, np.full(len(nodes), 0.5))
    return skeleton, SectionCenters(np.linalg.norm(nodes, axis=1) > 2.5, nodes)


def test_a_line_goes_through_the_sections_next_to_the_junction(cross):
    skeleton, centers = cross
    bent = centers.positions + 0.3 * np.eye(3)[[1]] * (np.arange(25) == 3 + N_SECTIONS)[:, None]  # beyond these
    lines = branch_lines(skeleton, SectionCenters(centers.is_known, bent))
    assert (lines.junctions == 0).all()
    order = np.argsort(lines.starts @ [1, 2, 3])
    assert np.allclose(lines.starts[order], 3 * np.eye(3))
    assert np.allclose(lines.means[order], (3 + (N_SECTIONS - 1) / 2) * np.eye(3))
    assert np.allclose(lines.directions[order], -np.eye(3))


def test_the_line_of_a_bent_branch_is_its_tangent(cross):
    """A parabola, whose tangent at the first section is along x; a line fitted to all five has slope 0.2."""
    skeleton, centers = cross
    bent = np.array(centers.positions)
    bent[1:9, 1] = 0.05 * (bent[1:9, 0] - 3) ** 2
    lines = branch_lines(skeleton, SectionCenters(centers.is_known, bent))
    along_x = np.flatnonzero(lines.starts[:, 0] > 1)
    # the parabola is fitted by its arc length, which exceeds x by up to 2 %
    assert lines.directions[along_x] == pytest.approx(np.array([[-1, 0, 0]]), abs=0.02)
    assert np.cross(lines.means - lines.starts, lines.directions)[along_x] == pytest.approx(np.zeros((1, 3)), abs=0.02)


def test_noise_turns_the_lines_of_straight_branches_less_than_parabolas(cross, monkeypatch):
    skeleton, centers = cross

    def turn():
        """Root mean square of the sines of 900 lines through sections that noise has moved."""
        rng = np.random.default_rng(0)
        noisy = (centers.positions + rng.normal(scale=0.05, size=(25, 3)) for _ in range(300))
        lines = [branch_lines(skeleton, SectionCenters(centers.is_known, positions)) for positions in noisy]
        sines = [np.cross(each.directions, np.sign(each.starts.round())) for each in lines]
        return np.linalg.norm(sines) / np.sqrt(900)

    shrunk = turn()
    monkeypatch.setattr(module, "_share_of_bend", lambda explained, residuals: np.ones_like(explained))
    # 0.63 here; the share that is left of a bend of noise, (1 - 1 / F) with F around 1, is zero in half of the cases
    assert shrunk < 0.7 * turn()


def test_the_spacing_of_sections_along_a_bent_branch_does_not_turn_its_line(cross):
    skeleton, centers = cross
    nodes = np.array(centers.positions)
    nodes[3:8, 0] = [3, 3.2, 4.4, 4.8, 7]
    nodes[1:9, 1] = 0.01 * (nodes[1:9, 0] - 3) ** 2
    lines = branch_lines(skeleton, SectionCenters(centers.is_known, nodes))
    along_x = np.flatnonzero(lines.starts[:, 0] > 1)
    # the arc length exceeds x by up to 0.1 %
    assert lines.directions[along_x] == pytest.approx(np.array([[-1, 0, 0]]), abs=1e-3)


@pytest.mark.parametrize("gap", [0.0, 1e-12])
@pytest.mark.parametrize("n_first", [1, 2, 3, 4])
def test_lines_through_sections_at_two_places_point_from_one_to_the_other(cross, n_first, gap):
    skeleton, centers = cross
    nodes = np.array(centers.positions)
    first, second = np.array([3.1, 0.2, -0.3]), np.array([3.7, 0.5, 0.4])
    nodes[3:8] = np.where(np.arange(5)[:, None] < n_first, first, second) + gap * np.arange(5)[:, None]
    lines = branch_lines(skeleton, SectionCenters(centers.is_known, nodes))
    line = np.flatnonzero(lines.starts[:, 0] > 1)
    expected = (first - second) / np.linalg.norm(first - second)
    assert lines.directions[line] == pytest.approx(expected[None], abs=1e-6)


@pytest.mark.parametrize("size", [2.0**-400, 2.0**400])
def test_lines_do_not_depend_on_the_size(cross, size):
    skeleton, centers = cross
    bent = np.array(centers.positions)
    bent[1:9, 1] = 0.05 * (bent[1:9, 0] - 3) ** 2
    one, other = (branch_lines(skeleton, SectionCenters(centers.is_known, scale * bent)) for scale in (1.0, size))
    assert other.directions == pytest.approx(one.directions, abs=1e-12)
    assert other.means / size == pytest.approx(one.means, abs=1e-12)


def test_a_loop_at_one_junction_is_no_branch_between_two():
    t = np.pi / 2 * np.arange(4)
    nodes = np.concatenate([np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), [[2, 0, 0], [3, 0, 0]]])
    skeleton = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [4, 5]], np.full(6, 0.1))
    one, two = (SectionCenters(np.isin(np.arange(6), known), nodes) for known in ([2], [1, 3]))
    assert len(branch_lines(skeleton, one).junctions) == 0
    lines = branch_lines(skeleton, two)
    assert lines.junctions.tolist() == [0, 0]
    loop = skeleton.branches[lines.branches[0]]
    first, last = nodes[loop[1]], nodes[loop[-2]]
    assert lines.starts == pytest.approx(np.where(lines.is_first[:, None], first, last))


def test_a_branch_with_one_section_has_no_line(cross):
    """Nor has an end branch where branches between junctions need one."""
    skeleton, centers = cross
    is_known = centers.is_known & ~np.isin(np.arange(25), range(4, 9))
    for with_single in (True, False):
        lines = branch_lines(skeleton, SectionCenters(is_known, centers.positions), with_single=with_single)
        assert len(lines.junctions) == 2


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_single_section_between_junctions_has_the_direction_of_the_skeleton(is_reversed):
    """A bar of three nodes along x, whose ends are junctions; its section is centered one below the middle node."""
    nodes = np.array(
        [[-2, 0, 0], [-1, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], *([x, y, 0] for x in (-2, 2) for y in (-1, 1))]
    )
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [0, 5], [0, 6], [4, 7], [4, 8]])
    if is_reversed:
        nodes, edges = nodes[::-1], 8 - edges
    positions = np.where((nodes == 0).all(axis=1)[:, None], [0, 0, -1], nodes)
    skeleton = Skeleton(nodes, edges, np.full(9, 0.5))
    centers = SectionCenters((nodes == 0).all(axis=1), positions)
    assert len(branch_lines(skeleton, centers).junctions) == 0
    lines = branch_lines(skeleton, centers, with_single=True)
    assert sorted(nodes[lines.junctions, 0]) == [-2, 2]
    assert np.array_equal(lines.directions, np.sign(nodes[lines.junctions]))
    assert np.array_equal(lines.starts, [[0, 0, -1]] * 2)
    assert np.array_equal(lines.means, lines.starts)


def test_lines_that_meet_have_one_nearest_point(cross):
    lines = branch_lines(*cross)
    meeting = nearest_points(lines, np.zeros(3, dtype=int), np.array([[0.2, 0.1, 0.3]]), np.array([0.5]))
    # the weight of the anchor is a fiftieth squared, relative to about a third squared
    assert np.abs(meeting).max() < 0.3 * (0.02 / 0.3) ** 2 * 3


def test_branches_between_junctions_that_have_no_line_get_their_chord():
    """Two junctions with two arms each; the branch between them is bent, and only one arm has sections."""
    arms = [[0, 1, 0], [0, -1, 0], [3, 1, 0], [3, -1, 0]]
    sections = np.array([0, 1, 0]) + np.arange(1, 5)[:, None] * [0, 0.3, 0]
    nodes = np.array([[0, 0, 0], [3, 0, 0], [1.5, 0.5, 0], *arms, *sections], dtype=float)
    edges = [[0, 2], [2, 1], [0, 3], [0, 4], [1, 5], [1, 6], [3, 7], [7, 8], [8, 9], [9, 10]]
    skeleton = Skeleton(nodes, edges, np.ones(len(nodes)))
    lines = branch_lines(skeleton, SectionCenters(np.isin(np.arange(len(nodes)), [3, 7, 8, 9]), nodes))
    assert lines.junctions.tolist() == [0]
    more = with_chords(lines, skeleton)
    assert more.junctions[0] == 0
    assert np.array_equal(more.directions[0], lines.directions[0])
    assert sorted(more.junctions[1:].tolist()) == [0, 1]
    for junction, other in ((0, 1), (1, 0)):
        [row] = 1 + np.flatnonzero(more.junctions[1:] == junction)
        assert np.array_equal(more.starts[row], nodes[other])
        assert np.array_equal(more.means[row], nodes[other])
        assert np.allclose(more.directions[row], [np.sign(nodes[junction, 0] - nodes[other, 0]), 0, 0])
        assert skeleton.branches[more.branches[row]][0 if more.is_first[row] else -1] == junction
    # a branch with lines at both ends gets none: a second call adds nothing
    assert len(with_chords(more, skeleton).junctions) == len(more.junctions)
