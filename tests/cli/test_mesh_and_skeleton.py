"""The input of commands on a mesh and its skeleton."""

import pytest


def test_a_skeleton_from_a_file_gives_the_same_table(here):
    assert here("skeletonize", "rod.off", "-o", "rod.npz", "--quiet")[0] == 0
    made, read = here("branches", "rod.off"), here("branches", "rod.off", "--skeleton", "rod.npz")
    assert made == read
    assert len(made[1]) == 2


def test_a_skeleton_without_the_map_is_refused(here):
    here("skeletonize", "rod.off", "-o", "rod.swc", "--quiet")
    code, out, err = here("branches", "rod.off", "--skeleton", "rod.swc")
    assert (code, out) == (2, [])
    assert "rod.swc: maps 0 vertices to its nodes, and rod.off has 152; write the skeleton" in err[0]


def test_a_skeleton_that_fails_its_score_is_used_with_a_warning(here):
    code, out, err = here("branches", "rod.off", "--time-limit", "1e-9")
    assert (code, len(out)) == (0, 2)
    assert err == ["lbskel: warning: the skeleton of rod.off fails its score; lbskel skeletonize tells which measures"]


@pytest.mark.parametrize(
    ("given", "option"),
    [("--min-branch-ratio 8", "min-branch-ratio"), ("--nodes 9", "nodes"), ("--anchor 3", "anchor")],
)
def test_options_that_do_nothing_to_a_given_skeleton_are_refused(here, given, option):
    here("skeletonize", "rod.off", "-o", "rod.npz", "--quiet")
    code, out, err = here("branches", "rod.off", "--skeleton", "rod.npz", *given.split())
    assert (code, out) == (2, [])
    assert f"--{option} has no effect on a skeleton that is made already" in err[0]


def test_a_page_takes_the_options_with_which_it_repeats_the_contraction(here):
    here("skeletonize", "rod.off", "-o", "rod.npz", "--quiet")
    shown = ("segment", "rod.off", "-o", "parts.ply", "--html", "a.html", "--skeleton", "rod.npz")
    assert here(*shown, "--simplify", "none", "--quiet")[0] == 0
    assert "--simplify has no effect" in here("branches", *shown[1:2], *shown[6:], "--simplify", "none")[2][0]
