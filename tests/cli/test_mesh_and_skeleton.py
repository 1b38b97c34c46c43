"""The input of commands on a mesh and its skeleton."""


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
